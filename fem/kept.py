"""Parts of models that many runs share, kept in the process by what they depend on.

A function that is `kept` gives the same result for the same arguments, computed or not: nothing but time depends on
what happens to be there. Large parts are not kept.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from typing import Any

MOST = 8
"""Results of a function that are kept, the last ones used."""

_PARTS: dict[str, Any] = {}


def kept(part: str) -> Callable[[Callable[..., Any]], Any]:
    """Decorator of a function of hashable arguments: its last results are kept. Its `__wrapped__` keeps nothing, for
    parts that are large.

    part: what it makes, for people.
    """

    def decorate(function: Callable[..., Any]) -> Any:
        _PARTS[part] = functools.lru_cache(maxsize=MOST)(function)
        return _PARTS[part]

    return decorate


def looks() -> Mapping[str, tuple[int, int]]:
    """How often each part was found, and how often it was made."""
    return {part: keeping.cache_info()[:2] for part, keeping in _PARTS.items()}


def reused(before: Mapping[str, tuple[int, int]]) -> list[str]:
    """Parts that were found, and not made, since `before`, an earlier `looks()`."""
    since = {part: (now, before.get(part, (0, 0))) for part, now in looks().items()}
    return [part for part, ((found, made), (f, m)) in since.items() if found > f and made == m]


def forget() -> None:
    """Let everything go."""
    for keeping in _PARTS.values():
        keeping.cache_clear()
