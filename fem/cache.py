"""Results that runs have in common, cached by their arguments.

A cached function returns the same result for the same arguments, computed or not, and only the time depends on the
content of the cache. Large results are not cached.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T")

SIZE = 8
"""Results of a function that are cached, those of the latest use."""

CACHES: dict[str, functools._lru_cache_wrapper[object]] = {}
"""Cached functions by their names."""


def cached(function: Callable[..., T]) -> functools._lru_cache_wrapper[T]:
    """Cache the last results of a function of hashable arguments.

    The function without a cache, for large results, is its `__wrapped__`.
    """
    CACHES[function.__name__] = cache = functools.lru_cache(maxsize=SIZE)(function)
    return cache


def clear() -> None:
    """Empty the caches of all functions."""
    for cache in CACHES.values():
        cache.cache_clear()
