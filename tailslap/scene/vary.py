"""Variation of scenes.

A change is a dotted key with a value in SI, a word, or None to remove the key; `parse_changes` makes changes of the
texts of the command line. Changes are plain data, as workers need them.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from tailslap.errors import InputError
from tailslap.scene import schema
from tailslap.scene.validate import validate

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


@dataclass(frozen=True)
class Source:
    """Source of a scene: its file, its tables, and the keys changed since.

    Attributes
    ----------
    text : str
        Text of the file, with changes noted at the end.
    given : dict
        Tables as in the file, with units.
    changed : frozenset of str
        Dotted keys changed since the file was read.
    """

    text: str = ""
    given: dict[str, Any] = field(default_factory=dict)
    changed: frozenset[str] = frozenset()

    @classmethod
    def of(cls, scene: schema.Scene) -> Source:
        """Source of a scene, in SI."""
        return cls(given=scene.model_dump(exclude_unset=True))


def vary(source: Source, changes: Changes) -> tuple[schema.Scene, Source]:
    """Validated scene with these changes, and its source, which notes them. Raises InputError.

    To remove a key that the scene does not have is no change.
    """
    tables, noted = changed_tables(source.given, changes)
    text = "".join(f"# changed by --set {change}\n" for change in shown(noted))
    return validate(tables), Source(source.text + text, tables, source.changed | noted.keys())


def varied(scene: schema.Scene, changes: Changes) -> schema.Scene:
    """Return the validated scene with these changes. Raises InputError."""
    return vary(Source.of(scene), changes)[0]


def value_at(scene: Any, key: str) -> Any:
    """Value of a dotted key of a scene, e.g. "trailer.0.mass" in a list of tables."""
    for name in key.split("."):
        scene = scene[int(name)] if isinstance(scene, tuple) else getattr(scene, name)
    return scene


def given_at(tables: Any, key: str) -> Any:
    """Value of a dotted key of tables as given; None without it."""
    for name in key.split("."):
        if isinstance(tables, list | tuple):
            tables = dict(enumerate(tables)).get(int(name)) if name.isdecimal() else None
        else:
            tables = tables.get(name) if isinstance(tables, Mapping) else None
    return tables


def changed_tables(given: Mapping[str, Any], changes: Changes) -> tuple[dict[str, Any], dict[str, Any]]:
    """Copy of the tables with the changes applied, and the changes that had an effect.

    A key removes its alternative of ALTERNATIVES.
    """
    tables = dict(given)
    noted = {key: value for key, value in changes.items() if _put(tables, key, value)}
    for key, other in ALTERNATIVES.items():
        if noted.get(key) is not None and other not in changes and _put(tables, other, None):
            noted[other] = None
    return tables, noted


def parse_changes(texts: Iterable[str], given: Mapping[str, Any]) -> dict[str, Any]:
    """Values by key of KEY=VALUE texts, for a scene with these tables. Raises InputError."""
    found: dict[str, Any] = {}
    for text in texts:
        key, equals, value = (part.strip() for part in text.partition("="))
        if not equals or not re.fullmatch(KEY, key):
            raise InputError("--set", text, 'allowed is KEY=VALUE, like plate.youngs_modulus="2 TPa"')
        found.pop(key, None)  # the last one counts, in its place
        found[key] = parse_value(value) if value else None
        _demand_effect(found, key, text, given)
    return found


def _demand_effect(changes: Changes, key: str, text: str, given: Mapping[str, Any]) -> None:
    """Raise InputError where the last change, given as this text, cannot be applied or removes an absent key."""
    try:
        noted = changed_tables(given, changes)[1]
    except InputError as error:
        raise InputError("--set", text, error.allowed) from None
    if key not in noted:
        allowed = "the scene does not have this key"
        raise InputError("--set", text, allowed)


def parse_value(text: str) -> Any:
    """TOML value of a text, or the text itself, whose quotes the shell has removed.

    Text with a comment or a second line is not parsed: TOML would ignore part of it.
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
    """Texts of the keys that were changed since the file was read, with their values now, in the order of the keys."""
    return [*shown({key: given_at(source.given, key) for key in sorted(source.changed)})]


def depth_exceeds(value: Any, most: int) -> bool:
    """True if tables and lists are nested deeper than `most`."""
    level = [value]
    for _ in range(most + 1):
        level = [
            inner
            for outer in level
            if isinstance(outer, Mapping | list)
            for inner in (outer.values() if isinstance(outer, Mapping) else outer)
        ]
    return bool(level)


def shown(changes: Changes) -> tuple[str, ...]:
    """Texts of the changes, as of --set."""
    return tuple(f"{key}={_shown(value)}" for key, value in changes.items())


def _shown(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    return str(list(value)) if isinstance(value, tuple) else str(value)


def _put(tables: Any, key: str, value: Any) -> bool:
    """Apply a change, copying the tables that contain it. Returns True if it has an effect."""
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


def _lists_tables(value: Any) -> bool:
    return isinstance(value, list | tuple) and bool(value) and isinstance(value[0], Mapping)


def _place(tables: Any, name: str, key: str, value: Any) -> Any:
    """Name of a key of a table, or number of a table of a list."""
    if not isinstance(tables, list):
        return name
    if not name.isdecimal() or int(name) >= len(tables):
        raise InputError(key, value, f"tables of a list are numbered; allowed are 0 to {len(tables) - 1}")
    return int(name)
