"""VALUES of --vary as they were typed: a range, or a list. Nothing of the scene is known here."""

from __future__ import annotations

import re
from dataclasses import dataclass

from tailslap.errors import InputError
from tailslap.scene.vary import KEY

MAX_RUNS = 1_000_000
"""Runs of one sweep; above it a mistyped range is likelier than patience."""

ALLOWED = (
    "allowed is KEY=VALUES, with VALUES a:b:n, log:a:b:n or a list v1,v2,v3, like corner.friction=0:0.6:13; "
    "with --sample, a:b or log:a:b or a list"
)
BRACKETS = {"[": 1, "]": -1}
LOGARITHMIC = "log"


@dataclass(frozen=True)
class Span:
    """A range: its ends as they would stand in a scene, how many values, and whether in equal ratios."""

    lower: str
    upper: str
    count: int | None
    logarithmic: bool


@dataclass(frozen=True)
class Choices:
    """A list of values as they would stand in a scene."""

    texts: tuple[str, ...]


def split_key(varied: str) -> tuple[str, str]:
    """Key and VALUES of KEY=VALUES. Raises InputError."""
    key, _, text = (part.strip() for part in varied.partition("="))
    if not (text and re.fullmatch(KEY, key)):
        raise InputError("--vary", varied, ALLOWED)
    if key == "name":
        raise InputError(
            "--vary", varied, "a scene's name changes nothing in a run; allowed are its other keys"
        )
    return key, text


def parse_values(key: str, text: str, sampled: bool) -> Span | Choices:
    """What VALUES say; sampled: by --sample, so that a range has no count. Raises InputError."""
    parts = split_outside(text, ":")
    if len(parts) == 1:
        return _choices(key, text)
    logarithmic = parts[0] == LOGARITHMIC
    ends = parts[1:] if logarithmic else parts
    if not 2 <= len(ends) <= 3 or not all(ends):
        raise InputError(key, text, ALLOWED)
    if sampled and len(ends) == 3:
        raise InputError(key, text, "with --sample a range is a:b or log:a:b; --sample says how many")
    return Span(ends[0], ends[1], None if sampled else _count(key, text, ends), logarithmic)


def split_outside(text: str, separator: str) -> list[str]:
    """Parts of the text between separators that stand neither in brackets nor in quotes, stripped."""
    parts, depth, quote = [""], 0, ""
    for letter in text:
        if quote:
            quote = "" if letter == quote else quote
        elif letter in "\"'":
            quote = letter
        else:
            depth += BRACKETS.get(letter, 0)
        if letter == separator and not depth and not quote:
            parts.append("")
        else:
            parts[-1] += letter
    return [part.strip() for part in parts]


def _choices(key: str, text: str) -> Choices:
    texts = split_outside(text, ",")
    if not all(texts):
        raise InputError(key, text, ALLOWED)
    return Choices(tuple(texts))


def _count(key: str, text: str, ends: list[str]) -> int:
    given = ends[2] if len(ends) == 3 else ""
    if not re.fullmatch("[0-9]{1,9}", given) or int(given) < 2:
        raise InputError(key, text, "a range ends with how many values it has, a whole number from 2: a:b:n")
    return int(given)
