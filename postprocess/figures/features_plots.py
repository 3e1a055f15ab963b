"""Bars of a study of features: what each part adds to the time loop."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from postprocess.figures.rows import bars, heights, intervals, row_plot
from postprocess.figures.svg.areas import Span
from postprocess.figures.svg.chart import Chart, draw_chart
from postprocess.figures.svg.marks import Mark, Words
from postprocess.figures.svg.plot import Axis

WIDTH, ROW, BAR = 480.0, 22.0, 0.6


def draw_ratios(ratios: Mapping[str, Any]) -> Chart:
    """A bar from 1 to each ratio, on a logarithmic axis, the largest on top; a line from its `low` to its `high`.

    ratios: by name, time of a loop over that of the loop without the part, with attributes median, low, high.
    """
    caption = "Time of a step with the part over that without it, and its 95 % interval; 1 is no cost"
    names = sorted(ratios, key=lambda name: -ratios[name].median)
    values = np.array([ratios[name].median for name in names])
    ends = np.array([(ratios[name].low, ratios[name].high) for name in names])
    rows, low, high = heights(names), 0.95 * min(0.9, *ends[:, 0]), max(1.2, *ends[:, 1])
    ones = np.stack([np.ones_like(values), values], axis=-1)
    marks: list[Mark] = [
        bars("times the loop without it", rows, ones, "fe", values.tolist(), names, BAR),
        intervals(rows, ends),
        Span("", 1.0, 1.0),
    ]
    shown = [f"{value:.3f}" if value < 2.0 else f"{value:.3g}" for value in values]
    marks += [
        Words(text, max(1.0, right), row, (6.0, 3.5))
        for text, (_, right), row in zip(shown, ends, rows, strict=True)
    ]
    x = Axis("times the loop without the part", low, high * (high / low) ** 0.2, is_log=True)
    return draw_chart("features", caption, (row_plot(names, marks, ROW),), x, width=WIDTH)
