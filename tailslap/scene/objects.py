"""Replace objects in the changes of a scene by their names.

They are friction laws, constraints, materials, elements, lumpings and starts.
"""

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
"""Registries of the objects that these keys name."""

BUILT_IN = {key: frozenset(registry) for key, registry in REGISTRIES.items()}
"""Names registered by the program."""


def added_names() -> dict[str, set[str]]:
    """Return names by key of the objects registered in this process alone."""
    return {key: set(registry) - BUILT_IN[key] for key, registry in REGISTRIES.items()}


def named(changes: Mapping[str, object]) -> dict[str, object]:
    """Return changes by dotted key, with names in place of objects.

    Nested tables are flattened. An object is registered; it replaces an earlier one of the same name, but not one of
    the program. Raises InputError for an object of another type or with a name of the program.
    """
    flat: dict[str, object] = {}
    for key, value in changes.items():
        if isinstance(value, Mapping) and value:
            flat |= named({f"{key}.{name}": inner for name, inner in value.items()})
        else:
            flat[key] = _registered_name(key, value) if key in REGISTRIES else value
    return flat


def _registered_name(key: str, value: object) -> object:
    """Register an object and return its name.

    Texts and None are returned.
    """
    if value is None or isinstance(value, str):
        return value
    registry = REGISTRIES[key]
    kind = type(next(iter(registry.values())))
    if not isinstance(value, kind):
        raise InputError(key, Verbatim(repr(value)), f"allowed is a name or a {kind.__name__}")
    if value.name in registry and registry[value.name] is value:
        return value.name
    if value.name in BUILT_IN[key]:
        raise InputError(key, value.name, "the program has an object of this name; choose another name")
    if value.name in registry:
        registry.pop(value.name)
    try:
        registry.register(value)
    except ValueError as error:
        raise InputError(key, value.name, str(error)) from None
    return value.name
