"""Error against run time on logarithmic axes: a small plot for each line, the others behind it in grey."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from postprocess.figures.svg.chart import Chart, draw_chart
from postprocess.figures.svg.marks import Line, Mark
from postprocess.figures.svg.plot import Axis, Plot

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Series:
    """A line: times [s] and errors in their order, and which passed their checks.

    joined: drawn as a line, else as marks alone; dashed: what a choice adds, not the whole error.
    """

    label: str
    times: Sequence[float]
    errors: Sequence[float]
    passed: Sequence[bool]
    joined: bool = True
    dashed: bool = False

    @property
    def points(self) -> Floats:
        """Times and errors, shape (n, 2)."""
        return np.array([self.times, self.errors], dtype=float).T

    def line(self, label: str, colour: str, width: float, dots: float) -> Line:
        """It as a mark."""
        dashes = "5 3" if self.dashed else ""
        points = self.points
        return Line(label, points[:, 0], points[:, 1], colour, width * self.joined, dashes, dots)


@dataclass(frozen=True)
class Diagram:
    """A panel. front: times and errors of the Pareto front, quick to slow; floor: what the truth is known to, with its
    words."""

    name: str
    title: str
    series: Sequence[Series]
    front: Sequence[tuple[float, float]]
    front_label: str
    floor: float
    floor_label: str
    error_label: str


def draw_precision(diagram: Diagram) -> list[Chart]:
    """A plot of each line that has points, all over the same axes."""
    shown = [series for series in diagram.series if len(series.times)]
    if not shown:
        return []
    points = np.concatenate([series.points for series in shown])
    floor = [diagram.floor] if math.isfinite(diagram.floor) and diagram.floor > 0.0 else []
    x, y = (_axis(values) for values in (points[:, 0], np.append(points[:, 1], floor)))
    behind: list[Mark] = [series.line("", "steel", 0.6, 1.0) for series in shown]
    if floor:
        behind.append(Line(diagram.floor_label, np.array(x), np.array(2 * floor), "soft", 1.0, "1 3"))
    behind += _front(diagram, x[1])
    across, up = (Axis(low=low, high=high, is_log=True) for low, high in (x, y))
    return [_chart(diagram, number, series, behind, across, up) for number, series in enumerate(shown, 1)]


def _chart(
    diagram: Diagram, number: int, series: Series, behind: list[Mark], across: Axis, up: Axis
) -> Chart:
    failed = ~np.array(series.passed)
    points = series.points[failed]
    marks = [*behind, series.line(series.label, "fe", 1.6, 2.6)]
    marks += (
        [Line("failed a check", points[:, 0], points[:, 1], "red", 0.0, dots=2.6)] if failed.any() else []
    )
    adds = "what one choice adds to its mesh, " if series.dashed else ""
    caption = f"{diagram.title}: {adds}{series.label}"
    plot = Plot(tuple(marks), up.named_as(diagram.error_label), 170.0, nearest="xy")
    along = across.named_as("time to solution, set-up included [s]")
    return draw_chart(f"{diagram.name}-{number}", caption, (plot,), along, "Work and precision", 330.0)


def _axis(values: Floats) -> tuple[float, float]:
    """Powers of ten that hold all values."""
    logs = np.log10(values)
    low, high = math.floor(logs.min()), math.ceil(logs.max())
    return 10.0**low, 10.0 ** max(high, low + 1)


def _front(diagram: Diagram, end: float) -> list[Mark]:
    """Steps down the front and on to the right edge."""
    if not diagram.front:
        return []
    times, errors = np.array(diagram.front).T
    x, y = np.repeat(np.append(times, end), 2)[1:], np.repeat(np.append(errors, errors[-1]), 2)[:-1]
    return [Line(diagram.front_label, x, y, "rigid", 1.6)]
