"""Charts of named rows: bars along x, and intervals, one below the other."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from postprocess.svg.chart import Axis, Plot
from postprocess.svg.drawing import Floats
from postprocess.svg.marks import Boxes, Line, Mark

ROW = 34.0
"""Pixels of a row."""


def row_plot(names: Sequence[str], marks: Sequence[Mark], row: float = ROW) -> Plot:
    """A plot of rows with these names, the first on top, whose heights are those of `heights`."""
    named = tuple(zip(heights(names).tolist(), names, strict=True))
    axis = Axis("", -0.6, len(names) - 0.4, named=named)
    return Plot(tuple(marks), axis, row * len(names) + 8.0, nearest="y", has_grid=False)


def heights(names: Sequence[str]) -> Floats:
    """Where the rows are, shape (n,)."""
    return np.arange(len(names), dtype=float)[::-1]


def bars(
    label: str,
    rows: Floats,
    ends: Floats,
    colour: str,
    values: Sequence[Any],
    at: Sequence[str],
    thick: float,
    strength: float = 1.0,
) -> Boxes:
    """Bars between ends, shape (n, 2), about heights, shape (n,), so many rows thick."""
    across = rows[:, None] + 0.5 * thick * np.array([-1.0, 1.0])
    return Boxes(label, ends, across, colour, values, at, strength)


def intervals(rows: Floats, ends: Floats) -> Line:
    """Lines from end to end, shape (n, 2), at heights, shape (n,)."""
    x = np.column_stack([ends, np.full(len(ends), np.nan)])
    return Line("", x.ravel(), np.repeat(rows, 3), "ink", 1.4)
