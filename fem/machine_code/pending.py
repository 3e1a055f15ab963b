"""What Numba is to be told once it is imported, and of what class the functions are that it is to know."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

Replace = Callable[[Callable[..., Any], Callable[..., Any], str], None]
"""Told a generic function, what chooses the function that compiled code calls in its place, and "always" or "never":
whether that is merged into its caller."""


class Function:
    """A compiled function, which other compiled code calls by its `dispatcher`."""

    dispatcher: Any


_pending: list[tuple[Callable[..., Any], Callable[..., Any], str]] = []
_told: list[Replace] = []


def replace_in_code(generic: Callable[..., Any], choose: Callable[..., Any], inline: str) -> None:
    """Have a generic function replaced in compiled code: now, or as soon as Numba is here."""
    _pending.append((generic, choose, inline))
    for replace in _told:
        replace(generic, choose, inline)


def numba_is_here(replace: Replace) -> None:
    """Numba is imported: tell it all that has been pending."""
    for wanted in _pending:
        replace(*wanted)
    _told.append(replace)
