"""Sources on which compiled code depends beside that of its own package."""

import marshal
from collections.abc import Callable, Iterable
from pathlib import Path
from types import FunctionType
from typing import Any

PACKAGES = ("machine_code", "fem")
"""Packages whose sources are in every digest, because compiled code anywhere may contain theirs."""

REGISTERED: list[Callable[[], Iterable[Any]]] = []
"""Functions that return the values of registered laws, plain functions among them."""


def outside_sources() -> tuple[bytes, ...]:
    """Return the sources of registered functions outside the packages.

    They are kernels and helpers of laws, which are merged into compiled code.
    """
    values = (value for values_of_laws in REGISTERED for value in values_of_laws())
    functions = (value for value in values if isinstance(value, FunctionType))
    outside = (f for f in functions if str(f.__module__).partition(".")[0] not in PACKAGES)
    return tuple(sorted({source_of(function) for function in outside}))


def source_of(function: Any) -> bytes:
    """Return the source file of a function, else its bytecode."""
    try:
        return Path(function.__code__.co_filename).read_bytes()
    except OSError:
        return marshal.dumps(function.__code__)
