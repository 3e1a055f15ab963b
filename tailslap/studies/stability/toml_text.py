"""Tables of a scene as the text of a scene file."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any


def toml_text(tables: Mapping[str, Any], title: str) -> str:
    """The text, its first line a comment; values are SI numbers, which the file may leave without a unit."""
    heads = [f"{key} = {_value(value)}" for key, value in tables.items() if not isinstance(value, dict)]
    bodies = [_table(name, table) for name, table in tables.items() if isinstance(table, dict)]
    return "\n".join([f"# {title}", *heads, *bodies]) + "\n"


def _table(name: str, table: dict[str, Any]) -> str:
    lines = [f"{key} = {_value(value)}" for key, value in table.items() if value is not None]
    return "\n".join(["", f"[{name}]", *lines])


def _value(value: Any) -> str:
    if isinstance(value, tuple | list):
        return f"[{', '.join(map(_value, value))}]"
    return json.dumps(value) if isinstance(value, str) else repr(value)
