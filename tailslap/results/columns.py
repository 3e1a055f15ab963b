"""Columns of the histories in a result folder: name, SI unit, meaning; of both calculations."""

from __future__ import annotations

from collections.abc import Iterable

from fem.explicit.columns import COLUMNS, IMPACT_COLUMNS, Column

ENERGY_ERROR = Column("energy_error", "J", meaning="what the energy balance leaves unaccounted for")


def corner_columns() -> dict[str, Column]:
    """Columns of a run with a constrained corner, those from outside the program among them."""
    t = Column("t", "s", meaning="time since the start of Stage 2")
    return {column.name: column for column in (t, *COLUMNS.values(), ENERGY_ERROR)}


def impact_columns() -> dict[str, Column]:
    """Columns of a whole impact."""
    return IMPACT_COLUMNS | {ENERGY_ERROR.name: ENERGY_ERROR}


def column_units(names: Iterable[str]) -> dict[str, str]:
    """SI units of the columns of either calculation that have one of these names."""
    known = impact_columns() | corner_columns()
    return {name: known[name].unit for name in names if name in known}
