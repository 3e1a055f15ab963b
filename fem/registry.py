"""Registries: what a scene may name, and the one object behind each name.

An extension is one frozen object, registered once, in the file that defines it. Nothing here needs Numba: the kernels
of a law are plain functions, and `fem.machine_code.compiled` compiles them when a loop with that law is built.
"""

import marshal
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import FunctionType
from typing import Any, Protocol, TypeVar


class Named(Protocol):
    """Anything with a name: in a scene, a file or a report."""

    @property
    def name(self) -> str:
        """The name."""


@dataclass(frozen=True, kw_only=True)
class Law:
    """A law of compiled code: fields that are functions of its constants are its kernels.

    Attributes
    ----------
    name : str
        In a scene.
    constants : type
        NamedTuple of the kernels' constants, by whose type the kernels are chosen; the type of None for a law without
        code.
    inlined : tuple of str
        Fields whose kernels must be merged into the loop that calls them.
    helpers : tuple of callable
        Plain functions that the kernels call.
    """

    name: str
    constants: type
    inlined: tuple[str, ...] = ()
    helpers: tuple[Callable[..., Any], ...] = ()


T = TypeVar("T", bound=Named)
L = TypeVar("L", bound=Law)


class Registry(dict[str, T]):
    """Objects by their names, in the order of registration."""

    def __init__(self, what: str) -> None:
        super().__init__()
        self.what = what

    def register(self, entry: T) -> T:
        """Add an object; returns it. Raises ValueError for a name that is taken."""
        if entry.name in self:
            raise ValueError(f'the {self.what} "{entry.name}" is registered already')
        self[entry.name] = entry
        return entry

    def remove(self, name: str) -> T:
        """Take an object out again. Raises KeyError for a name that is not there."""
        return self.pop(name)

    @property
    def expected(self) -> str:
        """The names as a choice: "'a', 'b' or 'c'"."""
        *others, last = map(repr, self)
        return f"{', '.join(others)} or {last}" if others else last


class LawRegistry(Registry[L]):
    """Laws of compiled code, by name and by the type of their constants."""

    def __init__(self, what: str) -> None:
        super().__init__(what)
        _REGISTRIES.append(self)

    def register(self, entry: L) -> L:
        """Add a law; returns it. Raises ValueError for a name, or a type of constants, that is taken."""
        if self.by_type(entry.constants):
            raise ValueError(f"the {self.what} of {entry.constants.__name__} is registered already")
        return super().register(entry)

    def of(self, constants: object) -> L:
        """The law that these constants belong to. Raises TypeError for constants of none."""
        law = self.by_type(type(constants))
        if law is None:
            raise TypeError(f"no {self.what} has constants of {type(constants).__name__}")
        return law

    def by_type(self, kind: type | None) -> L | None:
        """The law with constants of this type, or None."""
        return next((law for law in self.values() if law.constants is kind), None)


_REGISTRIES: list[LawRegistry[Any]] = []


def outside_sources() -> tuple[bytes, ...]:
    """Sources of kernels and helpers from outside this package: compiled code depends on them too."""
    laws = (law for registry in _REGISTRIES for law in registry.values())
    values = (value for law in laws for value in (*vars(law).values(), *law.helpers))
    functions = (value for value in values if isinstance(value, FunctionType))
    outside = (f for f in functions if str(f.__module__).partition(".")[0] != __package__)
    return tuple(sorted({source_of(function) for function in outside}))


def source_of(function: Any) -> bytes:
    """The file that a function is written in; its bytecode where there is none."""
    try:
        return Path(function.__code__.co_filename).read_bytes()
    except OSError:
        return marshal.dumps(function.__code__)
