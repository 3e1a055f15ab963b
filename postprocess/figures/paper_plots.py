"""Plots of published figures: computed motions as lines, printed points as marks."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from postprocess.figures.curves import LEFT, History, finish_curve, make_sheet, thinned
from postprocess.figures.panels import COMPARED
from postprocess.figures.style import DIFFERENCE, FE, RIGID, Curve, style

Points = tuple[tuple[float, float], ...]

LINES: dict[str, dict[str, Any]] = {
    "━": {"color": RIGID, "linewidth": 3.2},
    "╌": {"color": FE, "linewidth": 1.4, "dashes": (3.0, 2.0)},
}
MARKS: dict[str, dict[str, Any]] = {
    "●": {"color": "#1b1f24", "marker": "o", "markersize": 5.5},
    "◆": {"color": DIFFERENCE, "marker": "D", "markersize": 5.0},
}
"""How the first and the second motion, or kind of mark, is drawn, by the sign that stands for it in the legend."""


def draw_figures(
    captions: Mapping[str, str], courses: Mapping[str, History], marks: Mapping[str, Mapping[str, Points]]
) -> tuple[Curve, ...]:
    """One plot for each quantity of `captions` (name of a column -> caption), in that order.

    courses: name of a motion, two at most -> its columns, SI, with the instants "t" [s]; marks: quantity ->
    what they are called, two kinds at most -> printed points (t, value).
    """
    with style():
        return tuple(_draw(name, captions[name], courses, marks[name]) for name in captions)


def _draw(name: str, caption: str, courses: Mapping[str, History], marks: Mapping[str, Points]) -> Curve:
    panel = next(panel for panel in COMPARED if panel.name == name)
    sheet = make_sheet((0.16, 0.74))
    (axes,) = sheet.axes
    axes.set_ylabel(f"{panel.symbol} [{panel.unit}]")
    legend = []
    for (label, columns), (sign, line) in zip(courses.items(), LINES.items(), strict=False):
        axes.plot(*thinned(columns["t"], columns[name]), **line)
        legend.append((f"{sign} {label}", line["color"]))
    for (label, points), (sign, mark) in zip(marks.items(), MARKS.items(), strict=False):
        if points:
            axes.plot(*np.transpose(points), linestyle="none", clip_on=False, zorder=4, **mark)
            legend.append((f"{sign} {label}", mark["color"]))
    x = LEFT
    for label, colour in legend:
        sheet.figure.text(x, 0.93, label, color=colour, fontweight="bold")
        x += 0.02 + 0.0195 * len(label)
    return finish_curve(sheet, replace(panel, caption=caption), ())
