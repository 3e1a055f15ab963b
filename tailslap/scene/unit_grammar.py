"""Units as a scene may write them: names, joined by products and quotients, each with an integer power of up to 9.

    unit    = first { join factor }        first = factor | "1" join factor
    join    = "*" | "/" | blank            factor = name [ ("^" | "**") [ "-" ] digit ]

Anything else is no unit. Text is cut into factors here, and only names go on to Pint: its own parser evaluates
expressions, and "m**(9**9**9)" would never end.
"""

from __future__ import annotations

import re
from typing import NamedTuple

MAX_LENGTH = 80
"""Characters of a unit."""

NAME = r"[A-Za-zµμΩÅ°%][A-Za-zµμΩÅ°_]{0,39}"
FACTOR = re.compile(rf"({NAME})(?:\s*(?:\^|\*\*)\s*(-?[1-9]))?")
JOIN = re.compile(r"\s*([*/])\s*(?!\*)|\s+")
RECIPROCAL = re.compile(r"1\s*(?=/)")


class Factor(NamedTuple):
    """A name and the power that it has in the unit, 1 to 9 or -9 to -1."""

    name: str
    power: int


def unit_factors(text: str) -> tuple[Factor, ...]:
    """The factors of a unit. Raises ValueError for text that is none."""
    if len(text) > MAX_LENGTH:
        raise ValueError("too long")
    at, factors, sign = 0, [], 1
    if match := RECIPROCAL.match(text):
        at, sign = _join(text, match.end())
    while True:
        match = FACTOR.match(text, at)
        if not match:
            raise ValueError("no name of a unit")
        factors.append(Factor(match[1], sign * int(match[2] or 1)))
        if match.end() == len(text):
            return tuple(factors)
        at, sign = _join(text, match.end())


def _join(text: str, at: int) -> tuple[int, int]:
    """Where the next factor begins, and the sign of its power."""
    match = JOIN.match(text, at)
    if not match:
        raise ValueError("no product")
    return match.end(), -1 if match[1] == "/" else 1
