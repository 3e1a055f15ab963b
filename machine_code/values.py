"""Values of a kernel while it is translated.

A number is an operand of LLVM, with its value where it is a constant. Arrays and tuples have a structure that is known
while translating, and are numbers in a row in LLVM code: `leaves`. None and Python objects are not in LLVM code at all.
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple, NoReturn

import numpy as np

FLOAT, INTEGER, LOGICAL, ADDRESS = "double", "i64", "i1", "ptr"
"""LLVM's types of the operands."""

RANKS = {LOGICAL: 0, INTEGER: 1, FLOAT: 2}
"""Order of the types of numbers, of which each holds those before it."""

NAMES = {LOGICAL: "a truth value", INTEGER: "an integer", FLOAT: "a float"}

LONG = f"i{8 * np.dtype('l').itemsize}"
ITEMS = {"d": "double", "q": "i64", "l": LONG, "i": "i32", "?": "i8", "D": "{double, double}"}
"""LLVM's types of the items of arrays, by NumPy's character of the type; C's long has 32 bits on Windows.

Arithmetic of NumPy's shorter and unsigned integers and of its short floats is not that of 64 bits.
"""

EXACT = 2**53
"""Integers up to this size are floats as well."""


class TranslationError(TypeError):
    """A part of Python that kernels cannot have.

    place: file and line of the statement, where they are known.
    """

    def __init__(self, what: str, place: str = "") -> None:
        super().__init__(what)
        self.place = place

    def __str__(self) -> str:
        what = str(self.args[0])
        return f"{self.place}: a kernel cannot have {what}" if self.place else what


@dataclass(frozen=True, slots=True)
class Number:
    """Number of type `kind`.

    constant: its value if that is known.
    """

    kind: str
    operand: str
    constant: float | int | None = None


@dataclass(frozen=True, slots=True)
class Array:
    """Array with items of NumPy's type `item`.

    data: operand of the address; shape and strides: operands of integers, strides in items, "1" where items of the
    last axis lie side by side.
    """

    item: str
    data: str
    shape: tuple[str, ...]
    strides: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Record:
    """Tuple or NamedTuple of class `kind`."""

    kind: Any
    items: tuple["Value", ...]


@dataclass(frozen=True, slots=True)
class Nothing:
    """None."""


@dataclass(frozen=True, slots=True)
class Known:
    """Python object, such as a function or a module."""

    content: Any


Value = Number | Array | Record | Nothing | Known


PythonFunction = Any
"""Function of Python. As an attribute mypy would take it for a method."""


class Implementation(NamedTuple):
    """Python function that compiled code calls.

    is_merged: True to merge its code into the caller; is_compact: True for loops that are not unrolled; is_reordered:
    True for sums of any order.
    """

    function: PythonFunction
    is_merged: bool = False
    is_compact: bool = False
    is_reordered: bool = False


NOTHING = Nothing()


def integer(value: int) -> Number:
    """Return a constant integer."""
    if not -(2**63) <= value < 2**63:
        refuse(f"the integer {value}, beyond 64 bits")
    return Number(INTEGER, str(value), value)


def real(value: float) -> Number:
    """Return a constant of double precision."""
    return Number(FLOAT, f"0x{struct.unpack('<Q', struct.pack('<d', value))[0]:016X}", value)


def logical(value: bool) -> Number:
    """Return a constant truth value."""
    return Number(LOGICAL, "true" if value else "false", bool(value))


def constant(value: object) -> Value:
    """Return the value of a Python object that the code names."""
    if value is None:
        return NOTHING
    if isinstance(value, bool | np.bool_):
        return logical(bool(value))
    if isinstance(value, int | np.integer):
        return integer(int(value))
    if isinstance(value, float | np.floating):
        return real(float(value))
    if isinstance(value, complex | np.complexfloating):
        return Record(complex, (real(float(value.real)), real(float(value.imag))))
    if isinstance(value, tuple | np.ndarray):
        return Record(type(value) if isinstance(value, tuple) else tuple, tuple(map(constant, value)))
    return Known(value)


def leaves(value: Value) -> Iterator[tuple[str, str]]:
    """Yield LLVM's type and the operand of each number of a value."""
    if isinstance(value, Number):
        yield value.kind, value.operand
    elif isinstance(value, Array):
        yield ADDRESS, value.data
        for operand in (*value.shape, *(stride for stride in value.strides if stride != "1")):
            yield INTEGER, operand
    elif isinstance(value, Record):
        for item in value.items:
            yield from leaves(item)


def rebuilt(value: Value, operands: Iterator[str]) -> Value:
    """Return a value of the same structure with other operands."""
    if isinstance(value, Number):
        return Number(value.kind, next(operands))
    if isinstance(value, Array):
        data, shape = next(operands), tuple(next(operands) for _ in value.shape)
        return Array(value.item, data, shape, tuple(s if s == "1" else next(operands) for s in value.strides))
    if isinstance(value, Record):
        return Record(value.kind, tuple(rebuilt(item, operands) for item in value.items))
    return value


def structure(value: Value) -> object:
    """Return what decides about the code for a value.

    It is hashable.
    """
    if isinstance(value, Number):
        return value.kind
    if isinstance(value, Array):
        return value.item, *(stride == "1" for stride in value.strides)
    if isinstance(value, Record):
        return value.kind, *map(structure, value.items)
    return value.content if isinstance(value, Known) else None


def refuse(what: str) -> NoReturn:
    """Raise TranslationError."""
    raise TranslationError(what)


def as_number(value: Value) -> Number:
    """Return a value that has to be a number."""
    if isinstance(value, Array) and not value.shape:
        refuse("an array without dimensions")
    if not isinstance(value, Number):
        refuse(f"{type(value).__name__} where a number is needed")
    return value


def described(value: Value) -> str:
    """Return the description of a value in an error."""
    if isinstance(value, Number):
        return NAMES[value.kind]
    if isinstance(value, Array):
        return f"an array of {len(value.shape)} dimensions"
    if isinstance(value, Record):
        return f"{value.kind.__name__} of {', '.join(map(described, value.items))}"
    return "None" if isinstance(value, Nothing) else str(value.content)
