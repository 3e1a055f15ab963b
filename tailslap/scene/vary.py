"""The one way to vary a scene: dotted keys with typed values, validated as a scene file is.

Text of the command line becomes values once, in `parse_changes`; from there on a change is a value in SI, a word, or
None for a key that is taken out. Changes are plain data and travel to workers as they are.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from tailslap.errors import InputError
from tailslap.scene.schema import Scene
from tailslap.scene.validate import validate

KEY = r"[^.\s]{1,80}(\.[^.\s]{1,80}){0,3}"
"""A dotted key on the command line, as a regular expression."""

LOOSE_NUMBER = re.compile(r"[+-]?([0-9]+\.|\.[0-9]+)([eE][+-]?[0-9]+)?")
"""Numbers like .5 and 10., which TOML does not have."""

MAX_TEXT = 1000
"""Characters of a value on the command line."""

Changes = Mapping[str, Any]
"""Values by dotted key, in the order in which they are put in; None takes the key, or a whole table, out."""


@dataclass(frozen=True)
class Source:
    """Origin of a scene: its file, the tables as given, the keys changed since.

    Attributes
    ----------
    text : str
        The file's, changes noted at the end.
    given : dict
        What was given for each table and key, units included.
    changed : frozenset of str
        Dotted keys changed since the file was read.
    """

    text: str = ""
    given: dict[str, Any] = field(default_factory=dict)
    changed: frozenset[str] = frozenset()

    @classmethod
    def of(cls, scene: Scene) -> Source:
        """A source of what the scene's keys say, in SI."""
        return cls(given=scene.model_dump(exclude_unset=True))


def vary(source: Source, changes: Changes) -> tuple[Scene, Source]:
    """The validated scene with these changes, and its source, which notes them. Raises InputError.

    A key that the scene does not give may be taken out: nothing is noted then.
    """
    tables, noted = changed_tables(source.given, changes)
    text = "".join(f"# changed by --set {change}\n" for change in shown(noted))
    return validate(tables), Source(source.text + text, tables, source.changed | noted.keys())


def varied(scene: Scene, changes: Changes) -> Scene:
    """Return the validated scene with these changes. Raises InputError."""
    return vary(Source.of(scene), changes)[0]


def changed_tables(given: Mapping[str, Any], changes: Changes) -> tuple[dict[str, Any], dict[str, Any]]:
    """The tables with the changes put in, the given ones left alone; and those that changed anything."""
    tables = dict(given)
    noted = {key: value for key, value in changes.items() if _put(tables, key, value)}
    return tables, noted


def parse_changes(texts: Iterable[str], given: Mapping[str, Any]) -> dict[str, Any]:
    """Values by key of KEY=VALUE texts, for a scene that gives these tables. Raises InputError."""
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
    """Raise InputError where the last change, typed as this text, cannot be put in, or takes out what is not there."""
    try:
        noted = changed_tables(given, changes)[1]
    except InputError as error:
        raise InputError("--set", text, error.allowed) from None
    if key not in noted:
        allowed = "the scene does not give this key: there is nothing to take out"
        raise InputError("--set", text, allowed)


def parse_value(text: str) -> Any:
    """A TOML value if it is one, else the text itself, for the shell has taken its quotes.

    Text with a comment or a second line is no value: part of it would be dropped without a word.
    """
    if re.search(r"[#\r\n]", text) or len(text) > MAX_TEXT:
        return text
    if LOOSE_NUMBER.fullmatch(text):
        return float(text)
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except (ValueError, RecursionError):
        return text


def depth_exceeds(value: Any, most: int) -> bool:
    """True if tables and lists are nested deeper than this."""
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
    """The changes as --set takes them."""
    return tuple(f"{key}={_shown(value)}" for key, value in changes.items())


def _shown(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    return str(list(value)) if isinstance(value, tuple) else str(value)


def _put(tables: dict[str, Any], key: str, value: Any) -> bool:
    """Put a value in, tables on the way to it copied; whether that changes anything."""
    *path, last = key.split(".")
    for name in path:
        inner = tables.get(name, {})
        if not isinstance(inner, Mapping):
            raise InputError(key, value, f'"{name}" is a value, not a table')
        if value is None and name not in tables:
            return False
        tables[name] = tables = dict(inner)
    if value is None:
        return tables.pop(last, None) is not None
    tables[last] = value
    return True
