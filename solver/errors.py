"""What the rigid-body theory refuses, and how it says so."""

from __future__ import annotations

from dataclasses import fields
from typing import Any, NamedTuple

import numpy as np


class RigidBodyError(ValueError):
    """An input for which the rigid-body equations have no answer; `str()` is a sentence made of all attributes.

    Attributes
    ----------
    key : str
        Name of the input to change.
    given : object
        Its value.
    why : str
        Why it cannot have that value.
    allowed : str
        What it may be.
    """

    def __init__(self, key: str, given: Any, why: str, allowed: str) -> None:
        super().__init__(key, given, why, allowed)
        self.key, self.given, self.why, self.allowed = key, given, why, allowed

    def __str__(self) -> str:
        return f"{self.key} is {self.given}, but {self.why}; allowed: {self.allowed}."


class Rule(NamedTuple):
    """A condition in words; `why` and `allowed` are templates for the details of the row that fails."""

    key: str
    why: str
    allowed: str


def choose(key: str, given: str, options: tuple[str, ...]) -> str:
    """`given`, if it is one of `options`; raises RigidBodyError if not."""
    if given in options:
        return given
    names = ", ".join(f'"{option}"' for option in options)
    raise RigidBodyError(key, repr(given), "there is no such choice", f"one of {names}")


def holds(met: Any) -> bool:
    """Whether a condition, a bool or an array of them, is met throughout."""
    return met is True or (met is not False and bool(np.all(met)))


class Gate:
    """The conditions that inputs must meet, checked in turn; each is a bool or an array of them.

    With invalid="raise" the first condition that fails raises RigidBodyError for the first row where it
    does. With invalid="nan" the rows are noted in `ok`, and `filled` puts NaN there.
    """

    def __init__(self, invalid: str = "raise") -> None:
        self.fill = choose("invalid", invalid, ("raise", "nan")) == "nan"
        self.ok: Any = True

    def demand(self, rule: Rule, met: Any, given: Any, **details: Any) -> None:
        """Require that `met` holds for the value `given`."""
        if holds(met):
            return
        if not self.fill:
            raise _refusal(rule, met, given, details)
        self.ok = self.ok & met

    def safe(self, *values: Any) -> tuple[Any, ...]:
        """The values, with a harmless number in the rows that have failed."""
        return values if self.ok is True else tuple(np.where(self.ok, value, 0.5)[()] for value in values)

    def filled(self, record: Any) -> Any:
        """The record, with NaN in the rows that have failed."""
        if self.ok is True:
            return record
        values = (getattr(record, field.name) for field in fields(record))
        return type(record)(*(np.where(self.ok, value, np.nan)[()] for value in values))


def _refusal(rule: Rule, met: Any, given: Any, details: dict[str, Any]) -> RigidBodyError:
    met, given, *arrays = np.broadcast_arrays(met, given, *details.values())
    index = tuple(int(i) for i in np.argwhere(~met)[0])
    value = given[index].item()
    values = {name: array[index] for name, array in zip(details, arrays, strict=True)}
    why = rule.why.format(**values) if np.isfinite(value) else "it is not a finite number"
    place = f" at index {index if len(index) > 1 else index[0]}" if index else ""
    return RigidBodyError(rule.key, f"{value:.10g}{place}", why, rule.allowed.format(**values))
