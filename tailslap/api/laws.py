"""A user's own law in a scene: an object in the place of its name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fem.laws.constraints import CONSTRAINTS
from fem.laws.friction import FRICTION_LAWS
from fem.laws.materials import MATERIALS
from fem.plate.kinds import ELEMENT_KINDS, LUMPINGS
from fem.registry import Registry
from fem.start.start_kinds import START_KINDS
from tailslap.errors import InputError, Verbatim

REGISTRIES: dict[str, Registry[Any]] = {
    "corner.reaction": FRICTION_LAWS,
    "corner.constraint": CONSTRAINTS,
    "material.law": MATERIALS,
    "plate.element": ELEMENT_KINDS,
    "plate.lumping": LUMPINGS,
    "plate.start": START_KINDS,
}
"""Where the object behind the name of each of these keys is registered."""

_OWN = {key: frozenset(registry) for key, registry in REGISTRIES.items()}
"""Names that the program itself has registered."""


def named(changes: Mapping[str, Any]) -> dict[str, Any]:
    """The changes with names in place of objects, which are registered.

    An object takes the place of an earlier one of the same name, as when a cell of a notebook is run again, but not of
    the program's own. Raises InputError for what is no such object, or has a name of the program's own.
    """
    return {key: _named(key, value) if key in REGISTRIES else value for key, value in changes.items()}


def _named(key: str, value: Any) -> Any:
    if value is None or isinstance(value, str):
        return value
    registry = REGISTRIES[key]
    kind = type(next(iter(registry.values())))
    if not isinstance(value, kind):
        raise InputError(key, Verbatim(repr(value)), f"allowed is a name or a {kind.__name__}")
    if registry.get(value.name) is not value:
        _replace(key, registry, value)
    return value.name


def _replace(key: str, registry: Registry[Any], value: Any) -> None:
    if value.name in _OWN[key]:
        raise InputError(key, value.name, "the program has one of this name; give yours another")
    if value.name in registry:
        registry.remove(value.name)
    try:
        registry.register(value)
    except ValueError as error:
        raise InputError(key, value.name, str(error)) from None
