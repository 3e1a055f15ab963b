"""Functions and values on which compiled code depends.

Functions are known by their instructions, numbers, tuples and arrays by their content, and functions of NumPy and of
Python's library by their names. Whatever a function names is followed, through closures, modules and classes: more
than a kernel uses, so that compiled code is known to be current without translating anything.
"""

import builtins
import functools
import hashlib
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import product
from types import CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np

Choose = Callable[..., Any]
"""Function of the arguments' values that returns an implementation, or None if it has none for them."""

CHOICES: dict[object, list[tuple[Choose, bool]]] = {}
"""Choices of the implementations of generic functions, and whether their code is merged into the caller."""

Read = tuple[Callable[[Any], object], Any, object]
"""Function that reads a name, the name, and its value."""

SCALARS = (bool, int, float, complex, str, type(None), np.generic)

STANDARD, NUMPY = os.path.dirname(os.__file__) + os.sep, os.path.dirname(np.__file__) + os.sep
"""Folders of functions that are known by their names."""


class Captures:
    """Functions and values that a kernel may use, and their digest.

    root: the kernel; kinds: classes of NamedTuples among its arguments, by which laws are chosen.
    """

    def __init__(self, root: object, kinds: Iterable[type]) -> None:
        self._codes: set[CodeType] = set()
        self._places: dict[int, int] = {}
        self._values: list[Any] = []
        self._laws: list[Any] = []
        self._kinds: list[type] = []
        self._data: dict[tuple[int, int], Read] = {}
        self._objects: dict[tuple[int, int], Read] = {}
        texts = [self._text(root), *map(self._text, sorted(kinds, key=_name))]
        chosen: set[tuple[int, type]] = set()
        for value in self._values:  # to which values are added
            texts += self._lines(value)
            if value is self._values[-1]:  # laws of the classes until here, which may name others
                for laws, kind in product(self._laws, self._kinds):
                    if (id(laws), kind) not in chosen:
                        chosen.add((id(laws), kind))
                        law = laws.by_type(kind)
                        texts += self._fields(vars(law)) if law is not None else ()
        self.digest = hashlib.sha256("\n".join(texts).encode()).hexdigest()

    def are_current(self, with_functions: bool = True) -> bool:
        """Return True if the names still have the values that were read.

        Items of arrays are not compared. with_functions: False for names of data alone.
        """
        for reads in (self._data, self._objects) if with_functions else (self._data,):
            for read, name, value in reads.values():
                if read(name) is not value:
                    return False
        return True

    def _read(self, owner: Any, read: Callable[[Any], Any], name: Any) -> Any:
        value = read(name)
        reads = self._data if isinstance(value, (*SCALARS, tuple, np.ndarray)) else self._objects
        reads[id(owner), id(name)] = read, name, value
        return value

    def follows(self, function: FunctionType) -> bool:
        """Return True if a function and its captured values are among them."""
        return function.__code__ in self._codes and (not function.__closure__ or id(function) in self._places)

    def _text(self, value: Any) -> str:
        """Return the content of a value, or the number of an object."""
        value = value.__func__ if isinstance(value, staticmethod) else value
        if isinstance(value, SCALARS):
            return f"{type(value).__name__} {value!r}"
        if isinstance(value, np.ndarray):
            return f"array {value.dtype.str} {value.shape} {hashlib.sha256(value.tobytes()).hexdigest()}"
        if isinstance(value, tuple):
            return f"{self._text(type(value))}({', '.join(map(self._text, value))})"
        if id(value) not in self._places:
            self._places[id(value)] = len(self._values)
            self._values.append(value)
        return f"#{self._places[id(value)]}"

    def _fields(self, values: Mapping[str, Any]) -> Iterator[str]:
        return (f"{name} {self._text(value)}" for name, value in sorted(values.items()))

    def _lines(self, value: Any) -> Iterator[str]:
        """Yield lines on an object, which number the objects that it names."""
        yield f"{type(value).__name__} {_name(value)}"
        if hasattr(value, "py_func"):
            yield f"{value.implementation[1:]} {self._text(value.py_func)}"
        elif hasattr(value, "intrinsic"):
            yield self._text(value.intrinsic)
        elif hasattr(value, "by_type"):
            self._laws.append(value)
            if isinstance(value, dict):
                self._read(value, len, value)
                for name in value:
                    self._read(value, value.get, name)
        elif isinstance(value, type):
            self._kinds.append(value)
            yield from self._fields(getattr(value, "_field_defaults", {}))
            yield " ".join(map(str, getattr(value, "_fields", ())))
        elif isinstance(value, FunctionType) and not _is_of_library(value.__code__):
            yield from self._function(value)

    def _function(self, function: FunctionType) -> Iterator[str]:
        yield code_text(function.__code__)
        for choose, is_merged in self._read(CHOICES, CHOICES.get, function) or ():
            yield f"choice {is_merged} {self._text(choose)}"
        codes = list(nested_codes(function.__code__))
        self._codes.update(codes)
        names = dict.fromkeys(name for code in codes for name in code.co_names)
        cells = dict(zip(function.__code__.co_freevars, function.__closure__ or (), strict=True))
        for name, cell in cells.items():
            yield from self._named(name, self._read(cell, _content, cell), names, set())
        for name in names:
            for scope in (function.__globals__, vars(builtins)):
                if name in scope:
                    yield from self._named(name, self._read(scope, scope.get, name), names, set())
                    break

    def _named(self, name: str, value: Any, names: Iterable[str], above: set[int]) -> Iterator[str]:
        """Yield lines on a value.

        Those attributes of a module or class that the function may name are included.
        """
        yield f"{name} {self._text(value)}"
        if isinstance(value, ModuleType | type) and id(value) not in above:
            for owner in getattr(value, "__mro__", (value,)):
                for attribute in names:
                    if attribute in vars(owner):
                        content = self._read(owner, vars(owner).get, attribute)
                        yield from self._named(attribute, content, names, above | {id(value)})


def _name(value: Any) -> str:
    """Return module and name of an object, equal in every process."""
    named = (
        value if hasattr(value, "__qualname__") or isinstance(value, ModuleType | np.ufunc) else type(value)
    )
    name = getattr(named, "__qualname__", None) or named.__name__
    return f"{getattr(named, '__module__', '')}.{name}"


def _is_of_library(code: CodeType) -> bool:
    """Return True for code of NumPy or of Python's library."""
    file = code.co_filename
    is_standard = file.startswith(STANDARD) and "site-packages" not in file
    return is_standard or file.startswith((NUMPY, "<frozen"))


def _content(cell: Any) -> object:
    """Return the value of a variable of a closure."""
    try:
        return cell.cell_contents
    except ValueError:
        return None


def nested_codes(code: CodeType) -> Iterator[CodeType]:
    """Yield a code and those of the functions within it."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from nested_codes(constant)


@functools.cache
def code_text(code: CodeType) -> str:
    """Return the digest of a code without its place in a file."""
    constants = [
        code_text(value)
        if isinstance(value, CodeType)
        else sorted(map(repr, value))
        if isinstance(value, frozenset)
        else repr(value)
        for value in code.co_consts
    ]
    names = code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars, code.co_argcount
    return hashlib.sha256(repr((code.co_code, constants, names)).encode()).hexdigest()
