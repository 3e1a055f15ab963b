"""Objects in place of their names in the changes of a scene: friction laws, constraints, materials and so on."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fem.laws import constraints, friction, materials
from fem.plate import kinds
from fem.registry import Registry
from fem.start import start_kinds
from tailslap.errors import InputError, Verbatim

REGISTRIES: dict[str, Registry[Any]] = {
    "corner.reaction": friction.FRICTION_LAWS,
    "corner.constraint": constraints.CONSTRAINTS,
    "material.law": materials.MATERIALS,
    "plate.element": kinds.ELEMENT_KINDS,
    "plate.lumping": kinds.LUMPINGS,
    "plate.start": start_kinds.START_KINDS,
}
"""Registries of the objects named by these keys."""

_OWN = {key: frozenset(registry) for key, registry in REGISTRIES.items()}
"""Names registered by the program."""


def own_names() -> dict[str, set[str]]:
    """Names by key of the objects that this process alone has registered."""
    return {key: set(registry) - _OWN[key] for key, registry in REGISTRIES.items()}


def named(changes: Mapping[str, Any]) -> dict[str, Any]:
    """Changes by dotted key, with nested tables flattened and objects registered and replaced by their names.

    An object replaces an earlier one of the same name, but not one of the program. Raises InputError for an object of
    another type or with a name of the program.
    """
    found: dict[str, Any] = {}
    for key, value in changes.items():
        if isinstance(value, Mapping) and value:
            found |= named({f"{key}.{name}": inner for name, inner in value.items()})
        else:
            found[key] = _named(key, value) if key in REGISTRIES else value
    return found


def _named(key: str, value: Any) -> Any:
    if value is None or isinstance(value, str):
        return value
    registry = REGISTRIES[key]
    kind: Any = type(next(iter(registry.values())))
    if not isinstance(value, kind):
        raise InputError(key, Verbatim(repr(value)), f"allowed is a name or a {kind.__name__}")
    if value.name in registry and registry[value.name] is value:
        return value.name
    if value.name in _OWN[key]:
        raise InputError(key, value.name, "the program has an object of this name; choose another name")
    if value.name in registry:
        registry.remove(value.name)
    try:
        registry.register(value)
    except ValueError as error:
        raise InputError(key, value.name, str(error)) from None
    return value.name
