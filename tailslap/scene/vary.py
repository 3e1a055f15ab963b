"""Vary scenes.

A change is a dotted key with a value in SI, a word, or None to remove the key; `parse_changes` makes changes of the
texts of the command line. Changes are plain data, as workers need them: `named` registers objects among them, which
are friction laws, constraints, materials, elements, lumpings and starts, and replaces them by their names.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeVar

from fem.laws import constraints, friction, materials
from fem.plate import kinds
from fem.registry import Registry
from fem.start import start_kinds
from tailslap.errors import InputError, Verbatim
from tailslap.scene import schema
from tailslap.scene.types import SceneTable
from tailslap.scene.validate import validate, value_in

KEY = r"[^.\s]{1,80}(\.[^.\s]{1,80}){0,3}"
"""A dotted key on the command line, as a regular expression."""

LOOSE_NUMBER = re.compile(r"[+-]?([0-9]+\.|\.[0-9]+)([eE][+-]?[0-9]+)?")
"""Numbers like .5 and 10., which are not TOML."""

MAX_TEXT = 1000
"""Characters of a value on the command line."""

ALTERNATIVES = {
    "contact.stiffness": "contact.strike_duration",
    "contact.strike_duration": "contact.stiffness",
}
"""Keys that are removed where a change sets their alternative."""

Changes = Mapping[str, Any]
"""Values by dotted key, in the order of application; None removes the key or the whole table."""

Tables = dict[str, Any]
"""Tables of a scene as in its file, with units."""

TableT = TypeVar("TableT", bound=SceneTable)

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


@dataclass(frozen=True)
class Source:
    """File, tables and changed keys of a scene.

    Attributes
    ----------
    text : str
        Text of the file, empty without one.
    tables : dict
        Tables as in the file, with units.
    changed : frozenset of str
        Dotted keys changed since the file was read.
    """

    text: str = ""
    tables: Tables = field(default_factory=dict)
    changed: frozenset[str] = frozenset()

    @classmethod
    def of(cls, scene: schema.Scene) -> Source:
        """Return the source of a scene, in SI."""
        return cls(tables=scene.model_dump(exclude_unset=True))


def vary(source: Source, changes: Changes) -> tuple[schema.Scene, Source]:
    """Return the changed scene and its source.

    The source notes the changes. The removal of a key that the scene does not have is no change. Raises InputError.
    """
    tables, noted = changed_tables(source.tables, changes)
    return validate(tables), Source(source.text, tables, source.changed | noted.keys())


def varied(scene: schema.Scene, changes: Changes) -> schema.Scene:
    """Return the validated scene with these changes.

    Raises InputError.
    """
    return vary(Source.of(scene), changes)[0]


def with_values(scene: schema.Scene, changes: Changes) -> schema.Scene:
    """Return the scene with values in SI, which are not validated.

    Lists of tables are not changed.
    """
    for key, value in changes.items():
        table, _, name = key.rpartition(".")
        if table:
            inner = getattr(scene, table) or schema.TABLES[table].model_construct()
            name, value = table, _with_value(inner, name, value)
        scene = _with_value(scene, name, value)
    return scene


def _with_value(table: TableT, name: str, value: object) -> TableT:
    """Return a table with a value, without the key for None."""
    changed = table.model_copy(update={name: value})
    if value is None:
        default = type(table).model_fields[name].default
        changed = table.model_copy(update={name: default})
        changed.model_fields_set.discard(name)
    return changed


def changed_tables(tables: Mapping[str, object], changes: Changes) -> tuple[Tables, dict[str, object]]:
    """Return a changed copy of the tables, and the changes with effect.

    A key removes its alternative of ALTERNATIVES.
    """
    changed = dict(tables)
    noted = {key: value for key, value in changes.items() if _put(changed, key, value)}
    for key, alternative in ALTERNATIVES.items():
        if noted.get(key) is not None and alternative not in changes and _put(changed, alternative, None):
            noted[alternative] = None
    return changed, noted


def parse_changes(texts: Iterable[str], tables: Mapping[str, object]) -> dict[str, object]:
    """Return the changes of KEY=VALUE texts by key.

    tables: of the scene. Raises InputError.
    """
    changes: dict[str, object] = {}
    for text in texts:
        key, equals, value = (part.strip() for part in text.partition("="))
        if not equals or not re.fullmatch(KEY, key):
            raise InputError("--set", text, 'allowed is KEY=VALUE, like plate.youngs_modulus="2 TPa"')
        changes.pop(key, None)  # the last value of a key counts, in the order of the texts
        changes[key] = parse_value(value) if value else None
        _demand_effect(changes, key, text, tables)
    return changes


def _demand_effect(changes: Changes, key: str, text: str, tables: Mapping[str, object]) -> None:
    """Raise InputError where the last change has no effect.

    Such a change cannot be applied or removes an absent key. text: of the change.
    """
    try:
        noted = changed_tables(tables, changes)[1]
    except InputError as error:
        raise InputError("--set", text, error.allowed) from None
    if key not in noted:
        allowed = "the scene does not have this key"
        raise InputError("--set", text, allowed)


def parse_value(text: str) -> object:
    """Return the TOML value of a text, or the text itself.

    The shell has removed quotes. Text with a comment or a second line is not parsed: TOML would ignore a part.
    """
    if re.search(r"[#\r\n]", text) or len(text) > MAX_TEXT:
        return text
    if LOOSE_NUMBER.fullmatch(text):
        return float(text)
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except (ValueError, RecursionError):
        return text


def changes_of(source: Source) -> list[str]:
    """Return texts of the keys changed since the file was read.

    They have the present values, in the order of the keys.
    """
    return [*shown({key: value_in(source.tables, key) for key in sorted(source.changed)})]


def shown(changes: Changes) -> tuple[str, ...]:
    """Return the changes as texts of --set."""
    return tuple(f"{key}={_value_text(value)}" for key, value in changes.items())


def _value_text(value: object) -> str:
    """Return a value as text of --set, empty for a removed key."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    return str(list(value)) if isinstance(value, tuple) else str(value)


def _put(tables: Any, key: str, value: object) -> bool:
    """Apply a change, copying the tables that contain it.

    Returns True if it has an effect.
    """
    *path, last = key.split(".")
    for name in path:
        place = _place(tables, name, key, value)
        if isinstance(tables, dict) and place not in tables:
            if value is None:
                return False
            tables[place] = {}
        inner = tables[place]
        if not isinstance(inner, Mapping) and not _lists_tables(inner):
            raise InputError(key, value, f'"{name}" is a value, not a table')
        tables[place] = tables = dict(inner) if isinstance(inner, Mapping) else list(inner)
    place = _place(tables, last, key, value)
    if value is None:
        return (tables.pop(place) if isinstance(tables, list) else tables.pop(place, None)) is not None
    tables[place] = value
    return True


def _lists_tables(value: object) -> bool:
    """Return True for a list of tables."""
    return isinstance(value, list | tuple) and bool(value) and isinstance(value[0], Mapping)


def _place(tables: object, name: str, key: str, value: object) -> Any:
    """Return the name in a table, or the number in a list."""
    if not isinstance(tables, list):
        return name
    if not name.isdecimal() or int(name) >= len(tables):
        raise InputError(key, value, f"tables of a list are numbered; allowed are 0 to {len(tables) - 1}")
    return int(name)


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
