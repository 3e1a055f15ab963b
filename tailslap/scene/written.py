"""Scenes as text: one as it was run."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from tailslap.scene.vary import Source


def scene_text(source: Source) -> str:
    """The scene file that gives this run: the file as it is, or where keys were changed, all that was given."""
    if not source.changed:
        return source.text
    title = source.text.partition("\n")[0]
    changed = f"# changed: {', '.join(sorted(source.changed))}"
    return "\n".join([*([title] if title.startswith("#") else []), changed, *_lines(source.given)]) + "\n"


def _lines(tables: Mapping[str, Any]) -> list[str]:
    lines = [
        f"{key} = {toml_value(value)}" for key, value in tables.items() if not isinstance(value, Mapping)
    ]
    for name, table in tables.items():
        if isinstance(table, Mapping):
            lines += ["", f"[{name}]", *_lines(table)]
    return lines


def toml_value(value: Any) -> str:
    """A value as TOML writes it."""
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(toml_value, value))}]"
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str | bool) else repr(value)
