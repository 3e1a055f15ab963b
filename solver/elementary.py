"""Floats and arrays alike: types, conversion, and elementary functions under one set of names.

One scalar solution must cost microseconds, and 100 000 of them must be one call. So the formulas are
written once, with the functions of `functions(...)`: those of `math` for floats, of NumPy for arrays.
"""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from solver.errors import RigidBodyError

Array = NDArray[np.float64]
Number = float | Array
V = TypeVar("V", bound=Number)

_COMMON = ("sin", "cos", "sqrt", "exp", "expm1", "hypot", "isfinite")


def _where(condition: bool, yes: float, no: float) -> float:
    return yes if condition else no


_SCALAR = SimpleNamespace(**{name: getattr(math, name) for name in _COMMON})
_SCALAR.atan2, _SCALAR.atanh = math.atan2, math.atanh
_SCALAR.maximum, _SCALAR.minimum, _SCALAR.where = max, min, _where

_ARRAY = SimpleNamespace(**{name: getattr(np, name) for name in _COMMON})
_ARRAY.atan2, _ARRAY.atanh = np.arctan2, np.arctanh
_ARRAY.maximum, _ARRAY.minimum, _ARRAY.where = np.maximum, np.minimum, np.where


def functions(*values: Any) -> Any:
    """The elementary functions for these values: those of `math` if all are floats, of NumPy if not."""
    for value in values:
        if not isinstance(value, float):
            return _ARRAY
    return _SCALAR


def number(key: str, value: ArrayLike) -> Any:
    """`value` as a float, or as an array of floats; raises RigidBodyError under the name `key`."""
    if type(value) is float:
        return value
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        allowed = "a number, or an array of numbers"
        raise RigidBodyError(key, repr(value), "it is not a number", allowed) from error
    return array if array.ndim else array.item()
