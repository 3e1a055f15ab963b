"""Log-log charts of studies: error against run time, a small plot for each line, the others behind it in grey."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from postprocess.svg.chart import Axis, Chart, Plot, draw_chart
from postprocess.svg.drawing import Floats
from postprocess.svg.marks import Line, Mark


class Series(NamedTuple):
    """A line: times [s] and errors in their order, and which passed their checks.

    joined: drawn as a line, else as marks alone; dashed: what a choice adds, not the whole error.
    """

    label: str
    times: Sequence[float]
    errors: Sequence[float]
    passed: Sequence[bool]
    joined: bool = True
    dashed: bool = False

    def mark(self, label: str, colour: str, width: float, dots: float) -> Line:
        """It as a line of a plot."""
        dashes = "5 3" if self.dashed else ""
        times, errors = np.array(self.times), np.array(self.errors)
        return Line(label, times, errors, colour, width * self.joined, dashes, dots)


def draw_precision(
    name: str,
    title: str,
    series: Sequence[Series],
    error_label: str,
    front: tuple[str, Sequence[tuple[float, float]]],
    floor: tuple[str, float],
) -> list[Chart]:
    """A plot of each line that has points, all over the same axes.

    front: label, times and errors of the Pareto front, quick to slow; floor: label, and what the truth is known to.
    """
    shown = [each for each in series if len(each.times)]
    if not shown:
        return []
    known = [floor[1]] if math.isfinite(floor[1]) and floor[1] > 0.0 else []
    x = _decades([time for each in shown for time in each.times])
    y = _decades([error for each in shown for error in each.errors] + known)
    behind: list[Mark] = [each.mark("", "steel", 0.6, 1.0) for each in shown]
    if known:
        behind.append(Line(floor[0], np.array(x), np.array(2 * known), "soft", 1.0, "1 3"))
    if front[1]:
        behind.append(_steps(*front, x[1]))
    across = Axis("time to solution, set-up included [s]", *x, is_log=True)
    up, charts = Axis(error_label, *y, is_log=True), []
    for number, each in enumerate(shown, 1):
        failed = ~np.array(each.passed)
        marks = [*behind, each.mark(each.label, "fe", 1.6, 2.6)]
        if failed.any():
            times, errors = np.array(each.times)[failed], np.array(each.errors)[failed]
            marks.append(Line("failed a check", times, errors, "red", 0.0, dots=2.6))
        caption = f"{title}: {'what one choice adds to its mesh, ' if each.dashed else ''}{each.label}"
        plot = Plot(tuple(marks), up, 170.0, nearest="xy")
        charts.append(draw_chart(f"{name}-{number}", caption, (plot,), across, "Work and precision", 330.0))
    return charts


def _decades(values: Sequence[float]) -> tuple[float, float]:
    """Powers of ten that hold all values."""
    logs: Floats = np.log10(values)
    low, high = math.floor(logs.min()), math.ceil(logs.max())
    return 10.0**low, 10.0 ** max(high, low + 1)


def _steps(label: str, front: Sequence[tuple[float, float]], end: float) -> Line:
    """Steps down the front and on to the right edge."""
    times, errors = np.array(front).T
    x, y = np.repeat(np.append(times, end), 2)[1:], np.repeat(np.append(errors, errors[-1]), 2)[:-1]
    return Line(label, x, y, "rigid", 1.6)
