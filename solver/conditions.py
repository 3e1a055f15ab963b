"""Conversion and checks of inputs, and the error that rejects them.

One scalar solution must take microseconds, and 100 000 of them must be one call. Formulas are therefore written once,
for floats and arrays, with the functions of `functions(...)`: those of `math` for floats, of NumPy for arrays.
"""

import math
from dataclasses import fields
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Array = NDArray[np.float64]

Number = float | Array

Met = bool | NDArray[np.bool_]
V = TypeVar("V", bound=Number)
Record = TypeVar("Record", bound="DataclassInstance")


def chosen(condition: bool, yes: float, no: float) -> float:
    """Return the first value where the condition holds, else the second."""
    return yes if condition else no


class Functions(NamedTuple):
    """Functions of floats by NumPy's names, for kernels too."""

    sin: Any = math.sin
    cos: Any = math.cos
    sqrt: Any = math.sqrt
    exp: Any = math.exp
    expm1: Any = math.expm1
    atan2: Any = math.atan2
    atanh: Any = math.atanh
    hypot: Any = math.hypot
    isfinite: Any = math.isfinite
    maximum: Any = max
    minimum: Any = min
    where: Any = chosen


SCALAR = Functions()


class RigidBodyError(ValueError):
    """Input for which the equations have no solution.

    `str()` is a sentence made of all attributes.

    Attributes
    ----------
    key : str
        Name of the input to change.
    value : object
        Its value.
    why : str
        Reason why the value is invalid.
    allowed : str
        Allowed values.
    """

    def __init__(self, key: str, value: object, why: str, allowed: str) -> None:
        super().__init__(key, value, why, allowed)
        self.key, self.value, self.why, self.allowed = key, value, why, allowed

    def __str__(self) -> str:
        return f"{self.key} is {self.value}, but {self.why}; allowed: {self.allowed}."


class Rule(NamedTuple):
    """Condition on an input.

    why, allowed: templates for the details of the row that violates it.
    """

    key: str
    why: str
    allowed: str


def choose(key: str, name: str, options: tuple[str, ...]) -> str:
    """Return an option, or raise RigidBodyError without it."""
    if name in options:
        return name
    names = ", ".join(f'"{option}"' for option in options)
    raise RigidBodyError(key, repr(name), "this option does not exist", f"one of {names}")


def holds(met: Met) -> bool:
    """Return True if a condition is met throughout.

    met: a bool or an array of them.
    """
    return met is True or (met is not False and bool(np.all(met)))


class Gate:
    """Checks of conditions on inputs.

    Each condition is a bool or an array of bools. With invalid="raise" the first violated condition raises
    RigidBodyError for the first row that violates it. With invalid="nan" the rows are recorded in `ok`, and `filled`
    sets them to NaN.
    """

    def __init__(self, invalid: str = "raise") -> None:
        self.fill = choose("invalid", invalid, ("raise", "nan")) == "nan"
        self.ok: Met = True

    def demand(self, rule: Rule, met: Met, value: Number, **details: Number | str) -> None:
        """Require that a condition holds for a value."""
        if holds(met):
            return
        if not self.fill:
            raise refusal(rule, value, met, **details)
        self.ok = self.ok & met

    def positive(self, rule: Rule, value: Number) -> None:
        """Require that a value is positive and finite."""
        self.demand(rule, (value > 0.0) & (value < math.inf), value)

    def not_negative(self, rule: Rule, value: Number) -> None:
        """Require a finite value of 0 or more."""
        self.demand(rule, (value >= 0.0) & (value < math.inf), value)

    def safe(self, *values: Any) -> tuple[Any, ...]:
        """Return values with a placeholder in invalid rows."""
        return values if self.ok is True else tuple(np.where(self.ok, value, 0.5)[()] for value in values)

    def filled(self, record: Record) -> Record:
        """Return a record with NaN in invalid rows."""
        if self.ok is True:
            return record
        values = (getattr(record, field.name) for field in fields(record))
        return type(record)(*(np.where(self.ok, value, np.nan)[()] for value in values))


def demand(rule: Rule, key: str, met: Met, value: Number, **details: Number | str) -> None:
    """Require that a condition holds for the value of this key.

    Raises RigidBodyError by the rule.
    """
    Gate().demand(rule._replace(key=key), met, value, **details)


def refusal(rule: Rule, values: Number, met: Met = False, **details: Number | str) -> RigidBodyError:
    """Return the error of a rule.

    It names the first value that violates it.
    """
    met, values, *arrays = np.broadcast_arrays(met, values, *details.values())
    index = tuple(int(i) for i in np.argwhere(~met)[0])
    value = values[index].item()
    row = {name: array[index] for name, array in zip(details, arrays, strict=True)}
    numbers = {name: entry for name, entry in row.items() if not isinstance(entry, str)}
    row |= {f"{name}_deg": math.degrees(number) for name, number in numbers.items()}  # of angles
    why = rule.why.format(**row) if np.isfinite(value) else "it is not a finite number"
    place = f" at index {index if len(index) > 1 else index[0]}" if met.size > 1 else ""
    return RigidBodyError(rule.key, f"{value:.10g}{place}", why, rule.allowed.format(**row))


def functions(*values: object) -> Any:
    """Return `math` if values are floats, otherwise NumPy."""
    for value in values:
        if not isinstance(value, float):
            return np
    return SCALAR


def number(key: str, value: ArrayLike) -> Any:
    """Return a value as a float, or an array of floats.

    Raises RigidBodyError under the name `key`.
    """
    if type(value) is float:
        return value
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        allowed = "a number, or an array of numbers"
        raise RigidBodyError(key, repr(value), "it is not a number", allowed) from error
    return array if array.ndim else array.item()


def one(key: str, value: ArrayLike) -> float:
    """Return a value as a float.

    Raises RigidBodyError for arrays.
    """
    scalar = number(key, value)
    if not isinstance(scalar, float):
        raise RigidBodyError(key, f"of shape {scalar.shape}", "it is an array", "a number")
    return scalar


def within(rule: Rule, value: ArrayLike, most: float) -> float:
    """Return a value as a float above 0 and below a bound.

    Raises RigidBodyError by the rule.
    """
    scalar = one(rule.key, value)
    Gate().demand(rule, 0.0 < scalar < most, scalar)
    return scalar


def positive(rule: Rule, value: ArrayLike) -> float:
    """Return a value as a positive, finite float.

    Raises RigidBodyError by the rule.
    """
    return within(rule, value, math.inf)
