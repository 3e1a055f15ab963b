"""Plots of published figures: computed motions as lines, printed points as marks."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from postprocess.figures.curves import TIME, History, thinned
from postprocess.figures.panels import COMPARED
from postprocess.figures.svg.chart import Chart, draw_chart
from postprocess.figures.svg.marks import Line
from postprocess.figures.svg.plot import Axis, Plot

Points = tuple[tuple[float, float], ...]

LINES: tuple[dict[str, Any], ...] = (
    {"colour": "rigid", "width": 3.2},
    {"colour": "fe", "width": 1.6, "dashes": "5 3"},
)
MARKS: tuple[dict[str, Any], ...] = (
    {"colour": "ink", "width": 0.0, "dots": 3.6},
    {"colour": "difference", "width": 0.0, "dots": 3.6},
)
"""How the first and the second motion, or kind of mark, is drawn."""


def draw_figures(
    captions: Mapping[str, str], courses: Mapping[str, History], marks: Mapping[str, Mapping[str, Points]]
) -> tuple[Chart, ...]:
    """One plot for each quantity of `captions` (name of a column -> caption), in that order.

    courses: name of a motion, two at most -> its columns, SI, with the instants "t" [s]; marks: quantity ->
    what they are called, two kinds at most -> printed points (t, value).
    """
    return tuple(_draw(name, captions[name], courses, marks[name]) for name in captions)


def _draw(name: str, caption: str, courses: Mapping[str, History], marks: Mapping[str, Points]) -> Chart:
    panel = next(panel for panel in COMPARED if panel.name == name)
    drawn = [
        Line(label, *thinned(columns["t"], columns[name]), **look)
        for (label, columns), look in zip(courses.items(), LINES, strict=False)
    ]
    drawn += [
        Line(label, *np.transpose(points), **look)
        for (label, points), look in zip(marks.items(), MARKS, strict=False)
        if points
    ]
    plot = Plot(tuple(drawn), Axis(f"{panel.symbol} [{panel.unit}]"), 200.0)
    return draw_chart(name, caption, (plot,), TIME, panel.group)
