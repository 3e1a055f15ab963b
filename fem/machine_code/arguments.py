"""Arguments of a kernel as its machine code takes them: numbers and addresses in a row.

Numba's own layout: an array is two addresses of its owner, which none is needed of here, its size, the size of an item,
the address of the data, then shape and strides; tuples and NamedTuples are what is in them, in turn.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

FLOAT, INTEGER, LOGICAL, ADDRESS = "d", "q", "b", "P"
"""Codes of the `struct` module for what a kernel takes and returns."""

NUMBERS: dict[type, str] = {
    float: FLOAT,
    np.float64: FLOAT,
    int: INTEGER,
    np.int64: INTEGER,
    bool: LOGICAL,
    np.bool_: LOGICAL,
}
LAST_INTEGER = 2**63

Call = Callable[[list[Any]], Any]
"""Calls machine code with the values of its arguments in a row."""


class UnknownTypeError(TypeError):
    """An argument of a type whose layout is not known here."""


class Prepared:
    """An argument laid out once for many calls; arrays in it must stay where they are."""

    def __init__(self, value: Any) -> None:
        self.value = value
        self.kinds, self.values = flattened((value,))


def flattened(arguments: tuple[Any, ...]) -> tuple[tuple[Any, ...], list[Any]]:
    """The types of the arguments, by which machine code is found, and their values in a row.

    Raises UnknownTypeError for other than floats, integers, logicals, arrays of them, None, and tuples of these.
    """
    kinds: list[Any] = []
    values: list[Any] = []
    for argument in arguments:
        _add(argument, kinds, values)
    return tuple(kinds), values


def _add(value: Any, kinds: list[Any], values: list[Any]) -> None:
    kind = type(value)
    if kind is np.ndarray:
        _add_array(value, kinds, values)
    elif (code := NUMBERS.get(kind)) and (code != INTEGER or -LAST_INTEGER <= value < LAST_INTEGER):
        kinds.append(code)
        values.append(value)
    elif value is None:
        kinds.append(None)
        values.append(None)
    elif kind is Prepared:
        kinds += value.kinds
        values += value.values
    elif isinstance(value, tuple):
        kinds.append((kind, len(value)))
        for item in value:
            _add(item, kinds, values)
    else:
        raise UnknownTypeError(kind)


def _add_array(array: np.ndarray, kinds: list[Any], values: list[Any]) -> None:
    flags, dtype = array.flags, array.dtype
    if dtype.kind not in "fciub" or not dtype.isnative or not flags.aligned:
        raise UnknownTypeError(dtype)
    layout = "C" if flags.c_contiguous else "F" if flags.f_contiguous else "A"
    kinds.append((dtype.char, array.ndim, layout, flags.writeable))
    address = array.__array_interface__["data"][0]
    values += (None, None, array.size, dtype.itemsize, address, *array.shape, *array.strides)


def codes(kind: Any) -> str:
    """The codes of the values of an argument of this type, in a row."""
    if kind is None:
        return ADDRESS
    if isinstance(kind, str):
        return kind
    if len(kind) == 2:
        return ""
    return 2 * ADDRESS + 2 * INTEGER + ADDRESS + 2 * kind[1] * INTEGER


def spelled(kind: Any) -> str:
    """The type in words that are the same in every process."""
    if isinstance(kind, tuple) and len(kind) == 2:
        return f"{kind[0].__module__}.{kind[0].__qualname__}/{kind[1]}"
    return str(kind)
