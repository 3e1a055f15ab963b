"""Registries: what a scene may name, and the one object behind each name.

An extension is one frozen object, registered once, in the file that defines it. Nothing here needs Numba: the kernels
of a law are plain functions, and `fem.machine_code.compiled` compiles them when a loop with that law is built.
"""

import marshal
from collections.abc import Callable, Iterator
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

    constants: a NamedTuple, by whose type the kernels are chosen; the type of None for a law without code. inlined:
    fields whose kernels must be merged into the loop that calls them. helpers: plain functions that the kernels call.
    variants: the same law with other constants, which no scene names.
    """

    name: str
    constants: type
    inlined: tuple[str, ...] = ()
    helpers: tuple[Callable[..., Any], ...] = ()
    variants: tuple[Any, ...] = ()


PACKAGE = Path(__file__).resolve().parent

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
        super().register(entry)
        _tell_watchers(entry)
        return entry

    def remove(self, name: str) -> L:
        """Take a law out again. Raises KeyError for a name that is not there."""
        law = super().remove(name)
        _tell_watchers(law)
        return law

    def of(self, constants: object) -> L:
        """The law that these constants belong to. Raises TypeError for constants of none."""
        law = self.by_type(type(constants))
        if law is None:
            raise TypeError(f"no {self.what} has constants of {type(constants).__name__}")
        return law

    def by_type(self, kind: type | None) -> L | None:
        """The law with constants of this type, or None."""
        return next((law for law in self.laws if law.constants is kind), None)

    @property
    def laws(self) -> Iterator[L]:
        """All laws, variants included."""
        for law in self.values():
            yield from (law, *law.variants)


_REGISTRIES: list[LawRegistry[Any]] = []
_WATCHERS: list[Callable[[], None]] = []


def watch(callback: Callable[[], None]) -> None:
    """Have a callback called whenever a law from outside this package is registered or taken out."""
    _WATCHERS.append(callback)


def outside_sources() -> tuple[bytes, ...]:
    """Sources of the laws from outside this package: compiled code depends on them too."""
    functions = [f for registry in _REGISTRIES for law in registry.values() for f in _outside(law)]
    return tuple(sorted({source_of(function) for function in functions}))


def _tell_watchers(law: Law) -> None:
    for callback in _WATCHERS if _outside(law) else ():
        callback()


def _outside(law: Law) -> list[FunctionType]:
    """Kernels and helpers of a law that are written outside this package."""
    values = [value for each in (law, *law.variants) for value in (*vars(each).values(), *each.helpers)]
    functions = [value for value in values if isinstance(value, FunctionType)]
    return [f for f in functions if PACKAGE not in Path(f.__code__.co_filename).resolve().parents]


def source_of(function: Any) -> bytes:
    """The file that a function is written in; its bytecode where there is none."""
    try:
        return Path(function.__code__.co_filename).read_bytes()
    except OSError:
        return marshal.dumps(function.__code__)
