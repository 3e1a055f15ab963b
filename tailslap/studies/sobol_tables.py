"""Columns and texts of Sobol indices in reports."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from postprocess.report.tables import Column
from tailslap.campaign.input_ranges import Range
from tailslap.campaign.records import Record
from tailslap.campaign.sampling import GROUPS

INPUTS = (Column("key", "Input"), Column("range", "Range", form=str), Column("origin", "Source"))
"""Columns of `input_rows`."""

INTERVAL = "95 %"
"""Heading of the intervals of indices."""

INDEX_METHOD = (
    "Sobol indices are fractions of the variance due to an input: without (first order) and with its interactions "
    f"(total). The 95 % confidence intervals are from {GROUPS} groups of samples (jackknife, Student's t); "
    "upper limits include one further sample with the largest change due to any input."
)
"""Explanation of the indices."""


def input_rows(ranges: Iterable[Range], sources: Sequence[Record]) -> list[Record]:
    """Return inputs with their indices, largest first.

    sources: rows of `sampling.index_rows`. Without any the inputs have ranges alone, in their order.
    """
    words = [(item, *item.in_words()) for item in ranges]
    rows = {i.key: {"key": i.key, "range": r, "origin": i.origin, "value": value} for i, r, value in words}
    ordered = sorted(sources, key=lambda row: -row["total"])
    return [rows[row["key"]] | row for row in ordered] or [*rows.values()]


def index_column(key: str, label: str, form: str = ".3f", group: str = "") -> Column:
    """Return the column of an index with its interval below."""
    interval = Column(f"{key}_interval", "", form=lambda ends: interval_in_words(ends, form))
    return Column(key, label, form=form, below=interval, group=group)


def interval_in_words(ends: tuple[float, float], form: str) -> str:
    """Return the ends of an interval in words."""
    return " to ".join(format(end, form) for end in ends)


def with_intervals(heads: Iterable[Column]) -> tuple[Column, ...]:
    """Return the columns with intervals beside them, for a terminal."""
    pairs = ((head, head.below and replace(head.below, label=INTERVAL, group=head.group)) for head in heads)
    return tuple(column for pair in pairs for column in pair if column)


def main_source(source: Mapping[str, Any]) -> str:
    """Return the input with the largest total index, in words."""
    return (
        f"{source['key']} (total Sobol index {source['total']:.2f}, 95 % interval "
        f"{interval_in_words(source['total_interval'], '.2f')})"
    )


def index_columns() -> tuple[Column, ...]:
    """Return the columns of both indices."""
    return index_column("first_order", "First-order index"), index_column("total", "Total index")
