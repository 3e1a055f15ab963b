"""Results that runs have in common, cached by their arguments.

A cached function returns the same result for the same arguments, computed or not, and only the time depends on the
content of the cache. Large results are not cached.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from typing import TypeVar

T = TypeVar("T")

SIZE = 8
"""Results of a function that are cached, those of the latest use."""

_CACHES: dict[str, functools._lru_cache_wrapper[object]] = {}
"""Cached functions by the names of their results."""


def cached(part: str) -> Callable[[Callable[..., T]], functools._lru_cache_wrapper[T]]:
    """Decorate a function of hashable arguments to cache its last results.

    part: name of the result in messages. The function without a cache, for large results, is its `__wrapped__`.
    """

    def decorate(function: Callable[..., T]) -> functools._lru_cache_wrapper[T]:
        cache = functools.lru_cache(maxsize=SIZE)(function)
        _CACHES[part] = cache
        return cache

    return decorate


def counts() -> Mapping[str, tuple[int, int]]:
    """Return the numbers of uses and of computations of each part."""
    return {part: cache.cache_info()[:2] for part, cache in _CACHES.items()}


def reused(before: Mapping[str, tuple[int, int]]) -> list[str]:
    """Return the parts that were used and not computed since `before`.

    before: an earlier result of `counts`.
    """
    later = {part: (count, before.get(part, (0, 0))) for part, count in counts().items()}
    return [part for part, ((hits, misses), (h, m)) in later.items() if hits > h and misses == m]


def clear() -> None:
    """Empty the caches of all parts."""
    for cache in _CACHES.values():
        cache.cache_clear()
