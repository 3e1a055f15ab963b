"""Registries of objects that a scene may name.

An extension is one frozen object, registered once, in the file that defines it. The kernels of a law are plain
functions, and `machine_code.compiled` compiles them when a loop with that law is built.
"""

from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

from machine_code.captures import Captures

T = TypeVar("T", bound="Named")

L = TypeVar("L", bound="Law")

_LAWS: list[dict[str, Any]] = []
"""Registries of laws."""


class Named(Protocol):
    """Object with a name in a scene, a file or a report."""

    @property
    def name(self) -> str:
        """Name of the object."""


@dataclass(frozen=True, kw_only=True)
class Law:
    """A law of compiled code.

    Fields that are functions of its constants are its kernels.

    Attributes
    ----------
    name : str
        In a scene.
    constants : type
        NamedTuple of the kernels' constants, by whose type the kernels are chosen; the type of None for a law without
        code.
    inlined : tuple of str
        Fields whose kernels must be merged into the loop that calls them.
    """

    name: str
    constants: type
    inlined: tuple[str, ...] = ()


class Registry(dict[str, T]):
    """Objects by name, in order of registration."""

    def __init__(self, what: str) -> None:
        super().__init__()
        self.what = what

    def register(self, entry: T) -> T:
        """Add an object and return it.

        Raises ValueError for a registered name.
        """
        if entry.name in self:
            raise ValueError(f'the {self.what} "{entry.name}" is registered already')
        self[entry.name] = entry
        return entry

    @property
    def expected(self) -> str:
        """Names as a choice, "'a', 'b' or 'c'"."""
        *earlier, last = map(repr, self)
        return f"{', '.join(earlier)} or {last}" if earlier else last


class LawRegistry(Registry[L]):
    """Laws of compiled code by name and by type of constants."""

    def __init__(self, what: str) -> None:
        super().__init__(what)
        _LAWS.append(self)

    def register(self, entry: L) -> L:
        """Add a law and return it.

        Raises ValueError for a registered name or type of constants.
        """
        if self.by_type(entry.constants):
            raise ValueError(f"the {self.what} of {entry.constants.__name__} is registered already")
        return super().register(entry)

    def of(self, constants: object) -> L:
        """Return the law of these constants.

        Raises TypeError for constants of no law.
        """
        law = self.by_type(type(constants))
        if law is None:
            raise TypeError(f"no {self.what} has constants of {type(constants).__name__}")
        return law

    def by_type(self, kind: type | None) -> L | None:
        """Return the law with constants of this type, or None."""
        return next((law for law in self.values() if law.constants is kind), None)


def digest_of_laws() -> str:
    """Return the digest of all registered laws and their captured values."""
    fields = (value for laws in _LAWS for law in laws.values() for value in vars(law).values())
    return Captures(tuple(filter(callable, fields)), ()).digest
