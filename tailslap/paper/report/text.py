"""Numbers as the tables print them."""

from __future__ import annotations

from collections.abc import Callable

from postprocess.pages.paper_page import DIFFERENT, PRINTED, Column
from tailslap.paper.method import Cell


def fixed(decimals: int, scale: float = 1.0) -> Callable[[float], str]:
    """How a value is printed: so many decimals, after division by `scale`."""
    return lambda value: _unsigned_zero(f"{value / scale:.{decimals}f}")


def percent(share: float, decimals: int = 3) -> str:
    """A relative difference with its sign, or with none where it rounds to zero."""
    return _unsigned_zero(f"{100.0 * share:+.{decimals}f}") + " %"


def cells(cell: Cell, show: Callable[[float], str], decimals: int = 3, printed: str = "") -> tuple[str, ...]:
    """Printed, computed, difference; `printed`, if given, is the text of the printed value."""
    return printed or show(cell.printed), show(cell.computed), percent(cell.difference, decimals)


def columns(group: str = "") -> tuple[Column, ...]:
    """The headings of `cells`."""
    return Column("printed", PRINTED, group), *shared(group)


def shared(*groups: str) -> tuple[Column, ...]:
    """The headings of computed values and differences, group by group, which share a printed column."""
    return tuple(
        column
        for group in groups
        for column in (Column("computed", group=group), Column("diff.", DIFFERENT, group))
    )


def _unsigned_zero(text: str) -> str:
    return text if float(text) else text.lstrip("+-")
