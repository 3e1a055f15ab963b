"""Tables that are declared once.

The columns describe the form of an entry, the rows are the records. Terminal, page, CSV and JSON show the same table.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from postprocess.units import SI, Units, number, shown

Form = str | Callable[[Any], str]

MANY, LONG = 9, 105
"""Columns, and letters of their headings with gaps, that fit side by side."""


@dataclass(frozen=True)
class Column:
    """Table column with the form of its entries.

    Parameters
    ----------
    key : str
        Name of the entry, with dots for nested entries; also its name in files.
    label, unit : str
        Heading and its unit.
    form : str or callable
        Format specification of a number, or a function that returns the text; "" for words, aligned left.
    style : str
        "strong", "soft", or "whole" for words in one line, on pages.
    group : str
        Heading over several neighbours.
    below : Column, optional
        Shown in small letters below the entry, on pages alone.
    unit_key : str
        Key of the entry with the unit, if it differs between records.
    is_unit : bool
        Whether the entries are units.
    units : Units
        System of units in which values are shown.
    """

    key: str
    label: str
    unit: str = ""
    form: Form = ""
    style: str = ""
    group: str = ""
    below: Column | None = None
    unit_key: str = ""
    is_unit: bool = False
    units: Units = SI

    @property
    def heading(self) -> str:
        """Label with its unit."""
        return f"{self.label} [{self.shown_unit}]" if self.unit else self.label

    @property
    def shown_unit(self) -> str:
        """Unit of all entries in the chosen units."""
        return self.units.of(self.unit)[1]

    def value(self, record: object) -> Any:
        """Return the entry of a record.

        The record is a mapping, whose keys may have dots, an object or a tuple. The entry is None where one of
        several levels is None.
        """
        return _looked_up(record, self.key)

    def text(self, record: object) -> str:
        """Return the entry as text."""
        text = self._text(record)
        return self.units.rendered(text)

    def _text(self, record: object) -> str:
        value = self.value(record)
        if self.is_unit:
            return self.units.of(value)[1]
        factor, _ = self.units.of(_looked_up(record, self.unit_key) if self.unit_key else self.unit)
        if factor != 1.0 and isinstance(value, int | float):
            value = factor * value
        if callable(self.form):
            return self.form(value) if value is not None else number(value)
        return shown(value, self.form) if self.form else number(value)


def _looked_up(record: object, key: str) -> Any:
    if isinstance(record, Mapping) and key in record:
        return record[key]
    for name in key.split("."):
        record = _entry(record, name)
    return record


def _entry(record: Any, name: str) -> Any:
    if record is None:
        return None
    if isinstance(record, Mapping):
        return record[name]
    return record[int(name)] if name.isdigit() else getattr(record, name)


@dataclass(frozen=True)
class Table:
    """Columns and records.

    marks: style of rows by their number, "failed" or "marked"; notes: sentences below the table.
    """

    columns: tuple[Column, ...]
    rows: Sequence[Any]
    title: str = ""
    notes: tuple[str, ...] = ()
    marks: Mapping[int, str] = field(default_factory=dict)

    @property
    def groups(self) -> tuple[tuple[str, int], ...]:
        """Headings above the columns, and the columns that each spans.

        There are none if no column has a group.
        """
        spans: list[tuple[str, int]] = []
        for column in self.columns:
            if spans and spans[-1][0] == column.group:
                spans[-1] = (column.group, spans[-1][1] + 1)
            else:
                spans.append((column.group, 1))
        return tuple(spans) if any(name for name, _ in spans) else ()

    @property
    def is_wide(self) -> bool:
        """True if a page sets its headings in smaller letters."""
        return len(self.columns) > MANY or sum(len(column.heading) + 2 for column in self.columns) > LONG

    def mark(self, row: int) -> str:
        """Return the style of a row."""
        return self.marks.get(row, "")

    def in_units(self, units: Units) -> Table:
        """Return the table in other units."""
        below = [column.below and replace(column.below, units=units) for column in self.columns]
        pairs = zip(self.columns, below, strict=True)
        columns = tuple(replace(column, units=units, below=detail) for column, detail in pairs)
        notes = tuple(units.rendered(note) for note in self.notes)
        return replace(self, columns=columns, title=units.rendered(self.title), notes=notes)

    def records(self) -> list[dict[str, object]]:
        """Return the entries by key, as JSON and other files contain them."""
        return [{column.key: column.value(row) for column in self.columns} for row in self.rows]


def columns(
    labels: Mapping[str, str],
    unit: str = "",
    form: Form = "",
    style: str = "",
    group: str = "",
    unit_key: str = "",
) -> tuple[Column, ...]:
    """Return columns of one form from their labels by key."""
    return tuple(
        Column(key, label, unit, form, style, group, unit_key=unit_key) for key, label in labels.items()
    )


def listed(rows: Sequence[Mapping[str, object]]) -> Table:
    """Return a table of flat mappings with the same keys, for files."""
    return Table(tuple(Column(key, key) for key in rows[0]), rows)


def pairs(
    entries: Mapping[str, object] | Sequence[tuple[object, ...]], title: str = "", notes: tuple[str, ...] = ()
) -> Table:
    """Tabulate names and values without headings.

    It has a column of units if there are any.
    """
    lines = [(*line, "")[:3] for line in (entries.items() if isinstance(entries, Mapping) else entries)]
    value = Column("value", "", form=lambda value: number(value, 5), style="strong", unit_key="unit")
    columns = (Column("what", ""), value, Column("unit", "", is_unit=True))
    used = columns if any(unit for *_, unit in lines) else columns[:2]
    return Table(
        used, [dict(zip(("what", "value", "unit"), line, strict=True)) for line in lines], title, notes
    )
