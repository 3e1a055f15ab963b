"""Rows of a table as lines across parallel scales, one a column."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from postprocess.svg.chart import Axis, Chart, Plot, draw_chart
from postprocess.svg.marks import Line, Mark, Shades, Words
from postprocess.svg.scale import Scale, power_text

Values = NDArray[Any]

WIDTH, TICKS = 940.0, 4


@dataclass(frozen=True)
class Scaled:
    """A scale: label, the rows' values and heights from 0 to 1, and ticks with their heights."""

    label: str
    values: Values
    heights: Values
    ticks: Sequence[tuple[float, str]]

    def rows(self, part: slice) -> Scaled:
        """The same scale for a part of the rows."""
        return replace(self, values=self.values[part], heights=self.heights[part])


def scaled(label: str, values: Values, is_log: bool) -> Scaled:
    """A scale from the smallest to the largest of numbers, or with a place for each word."""
    if not np.issubdtype(values.dtype, np.number):
        names = list(dict.fromkeys(values.tolist()))
        places = {word: (i + 0.5) / len(names) for i, word in enumerate(names)}
        heights = np.array([places[word] for word in values])
        return Scaled(label, values, heights, [(place, word) for word, place in places.items()])
    known = np.unique(values[np.isfinite(values)]).astype(float)
    if known.size < 2:
        return Scaled(label, values, 0.5 + 0.0 * values, [(0.5, power_text(value)) for value in known])
    scale = Scale(float(known[0]), float(known[-1]), is_log=is_log)
    ticks = [(float(scale.at(tick)), power_text(tick)) for tick in scale.ticks(TICKS)]
    return Scaled(label, values, np.asarray(scale.at(values)), ticks)


def draw_lines(
    caption: str, scales: Sequence[Scaled], behind: Sequence[Scaled], chosen: Values, failed: Values
) -> Chart:
    """A line a row, in the colour of its place on the last scale, red where it failed; pages show values and rows.

    behind: scales just before the last one, whose lines are drawn below the others; chosen: numbers of the rows drawn;
    failed: of all rows.
    """
    heights = np.array([scale.heights for scale in scales])
    shown = chosen[np.isfinite(heights[:, chosen]).all(axis=0)]
    lines = _lines(heights[:, shown], failed[shown])
    if behind:
        before = np.arange(len(scales))[-1 - len(behind) : -1]
        below = np.array([scale.heights for scale in behind])[:, shown]
        lines.insert(0, _across(before, below, "rigid", 2.2))
    axes = [mark for place, scale in enumerate(scales) for mark in _scale_marks(place, scale)]
    labels = [scale.label.replace(".", ".\n").replace(" [", "\n[") for scale in scales]
    x = Axis(low=-0.15, high=len(scales) - 0.4, named=tuple(enumerate(labels)))
    y = Axis(low=-0.04, high=1.04, named=())
    marks = (*lines, *axes, _points(scales, shown))
    plot = Plot(marks, y, 330.0, nearest="xy", has_grid=False, has_legend=False)
    return draw_chart("parallels", caption, (plot,), x, "All keys side by side", WIDTH)


def _lines(heights: Values, failed: Values) -> list[Mark]:
    """The rows' lines, shape of heights (scales, rows)."""
    colours = np.where(failed, "red", Shades(0.0, 1.0).colours(heights[-1]))
    places = np.arange(len(heights))
    return [_across(places, heights[:, colours == one], one, 0.9) for one in dict.fromkeys(colours.tolist())]


def _across(places: Values, heights: Values, colour: str, width: float) -> Line:
    """Lines through heights, shape (places, rows), one after the other."""
    gap = np.full((1, heights.shape[1]), np.nan)
    x = np.tile(np.append(places, np.nan), heights.shape[1])
    return Line("", x, np.concatenate([heights, gap]).T.ravel(), colour, width)


def _scale_marks(place: int, scale: Scaled) -> list[Mark]:
    line = Line("", np.full(2, float(place)), np.array([0.0, 1.0]), "grey", 0.8)
    return [line, *(Words(text, place, height, (4.0, 3.5)) for height, text in scale.ticks)]


def _points(scales: Sequence[Scaled], shown: Values) -> Line:
    """What pages show of each row where it meets a scale."""
    places, heights, said, at = [], [], [], []
    for place, scale in enumerate(scales):
        places += [float(place)] * len(shown)
        heights += scale.heights[shown].tolist()
        said += [value if isinstance(value, str) else f"{value:.5g}" for value in scale.values[shown]]
        at += [f"run {row}, {scale.label}" for row in shown]
    return Line("value", np.array(places), np.array(heights), width=0.0, values=said, at=at)
