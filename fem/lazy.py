"""Things that are made late or once: modules loaded with the first name of them, and parts of models that many runs
share, cached in the process by what they depend on.

A function that is `cached` gives the same result for the same arguments, computed or not: nothing but time depends on
what happens to be there. Large parts are not cached.
"""

import functools
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from typing import Any


def lazily(
    package: str, modules: Mapping[str, str]
) -> tuple[list[str], Callable[[str], Any], Callable[[], list[str]]]:
    """`__all__`, `__getattr__` and `__dir__` of a package (PEP 562), from the names of its modules and the public names
    in each.

    A module is loaded when a name of it is asked for.
    """
    home = {name: module for module, names in modules.items() for name in names.split()}

    def attribute(name: str) -> Any:
        if name not in home:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return getattr(import_module(f"{package}.{home[name]}"), name)

    return (
        sorted(home),
        attribute,
        lambda: sorted(home),
    )


@contextmanager
def unseen(*modules: str) -> Iterator[None]:
    """Import as if these modules were not installed; those that are loaded already stay."""
    hidden = [module for module in modules if module not in sys.modules]
    for module in hidden:
        sys.modules[module] = None  # type: ignore[assignment]
    try:
        yield
    finally:
        for module in hidden:
            del sys.modules[module]


MOST = 8
"""Results of a function that are cached, the last ones used."""

_PARTS: dict[str, Any] = {}


def cached(part: str) -> Callable[[Callable[..., Any]], Any]:
    """Decorator of a function of hashable arguments: its last results are cached. Its `__wrapped__` caches nothing,
    for parts that are large.

    part: what it makes, for people.
    """

    def decorate(function: Callable[..., Any]) -> Any:
        _PARTS[part] = functools.lru_cache(maxsize=MOST)(function)
        return _PARTS[part]

    return decorate


def looks() -> Mapping[str, tuple[int, int]]:
    """Counts, by part, of how often it was found in the cache, and how often it was made."""
    return {part: keeping.cache_info()[:2] for part, keeping in _PARTS.items()}


def reused(before: Mapping[str, tuple[int, int]]) -> list[str]:
    """Parts that were found, and not made, since `before`, an earlier `looks()`."""
    since = {part: (now, before.get(part, (0, 0))) for part, now in looks().items()}
    return [part for part, ((found, made), (f, m)) in since.items() if found > f and made == m]


def forget() -> None:
    """Empty the caches of all parts."""
    for keeping in _PARTS.values():
        keeping.cache_clear()
