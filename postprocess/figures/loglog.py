"""Charts of studies on logarithmic axes: error against run time, a small plot for each line with the others behind
it in grey; sizes over the first frequency of a plate, stiff plates on the left."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import cycle
from typing import NamedTuple

import numpy as np

from postprocess.figures import rows
from postprocess.svg import chart
from postprocess.svg.drawing import Floats
from postprocess.svg.marks import Level, Line, Mark, Span, key

LINE, RINGS, DOTS = "line", "rings", "dots"
COLOURS = ("fe", "rigid", "green", "difference", "violet", "soft")
WIDTH = 480.0


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
        """Line of a plot with these values."""
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
) -> list[chart.Chart]:
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
    across = chart.Axis("time to solution, set-up included [s]", *x, is_log=True)
    up, charts = chart.Axis(error_label, *y, is_log=True), []
    for number, each in enumerate(shown, 1):
        failed = ~np.array(each.passed)
        marks = [*behind, each.mark(each.label, "fe", 1.6, 2.6)]
        if failed.any():
            times, errors = np.array(each.times)[failed], np.array(each.errors)[failed]
            marks.append(Line("failed a check", times, errors, "red", 0.0, dots=2.6))
        caption = f"{title}: {'what one choice adds to its mesh, ' if each.dashed else ''}{each.label}"
        plot = chart.Plot(tuple(marks), up, 170.0, nearest="xy")
        charts.append(
            chart.draw_chart(f"{name}-{number}", caption, (plot,), across, "Work and precision", 330.0)
        )
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


class SweepLine(NamedTuple):
    """A quantity's size at each frequency, and its error, drawn thin and dashed, where it has one.

    NaN is not drawn. form: LINE with marks; RINGS around the marks of a line that follows; DOTS for what is no
    measurement. passed: which of its runs did, where that is not what the axis says.
    """

    label: str
    values: Sequence[float]
    errors: Sequence[float] = ()
    form: str = LINE
    passed: Sequence[bool] = ()


class SweepAxis(NamedTuple):
    """First frequencies [Hz] from stiff to soft, which of the runs passed, and the scene's own frequency."""

    frequencies: Sequence[float]
    passed: Sequence[bool]
    own: float


def draw_sweep(
    name: str, axis: SweepAxis, lines: Sequence[SweepLine], label: str, caption: str, levels: Sequence[float]
) -> chart.Chart:
    """The lines, in per cent, and levels, sizes that are marked; red where a run failed its checks, plates that failed
    shaded half-way to their neighbours."""
    frequencies = np.array(axis.frequencies)
    half = np.sqrt(frequencies[0] / frequencies[1])
    failed = frequencies[~np.array(axis.passed)]
    marks: list[Mark] = [
        Span("" if number else "failed", frequency * half, frequency / half, "red")
        for number, frequency in enumerate(failed)
    ]
    marks += [Level("", 100.0 * level, "grey") for level in levels]
    if frequencies[-1] <= axis.own <= frequencies[0]:
        marks.append(Span("the scene's plate", axis.own, axis.own, "ink"))
    for line, colour in zip(lines, cycle(COLOURS), strict=False):
        marks += _sweep_marks(axis, line, colour)
    marks += [key("numerical error", "soft", 0.7, "4 2")] if any(line.errors for line in lines) else []
    words = "first frequency of the plate [Hz], rigid to soft"
    x = chart.Axis(words, frequencies[0] * 1.15, frequencies[-1] / 1.15, is_log=True)
    plot = chart.Plot(tuple(marks), chart.Axis(f"{label} [%]", is_log=True), 260.0)
    return chart.draw_chart(name, caption, (plot,), x, "Sweeps", WIDTH)


def _sweep_marks(axis: SweepAxis, line: SweepLine, colour: str) -> list[Mark]:
    x, values = np.array(axis.frequencies), _per_cent(line.values)
    if line.form == DOTS:
        return [Line(line.label, x, values, colour, 1.2, "1 3")]
    if line.form == RINGS:
        return [Line(line.label, x, values, colour, 0.0, dots=5.0)]
    passed = np.array(line.passed or axis.passed)
    good, bad = np.where(passed, values, np.nan), np.where(passed, np.nan, values)
    marks: list[Mark] = [Line(line.label, x, good, colour, 1.3, dots=2.4)]
    marks += [Line("failed a check", x, bad, "red", 0.0, dots=2.4)] if np.isfinite(bad).any() else []
    if line.errors:
        errors = np.where(passed, _per_cent(line.errors), np.nan)
        marks.append(Line("", x, errors, colour, 0.7, "4 2"))
    return marks


def _per_cent(values: Sequence[float]) -> Floats:
    """The values that a logarithmic axis can show, in per cent, NaN for the others."""
    found = 100.0 * np.array(values, dtype=float)
    return np.where(np.isfinite(found) & (found > 0.0), found, np.nan)


def draw_plates(
    frequencies: Sequence[float],
    passed: Sequence[bool],
    panels: Mapping[str, Mapping[int, tuple[Sequence[float], float]]],
) -> chart.Chart:
    """A plot a quantity; dashed lines: the rigid vehicle; red: plates that are not to be relied on.

    panels: by label of the axis, for each strike its values over the frequencies, and the rigid vehicle's.
    """
    f, good, plots = np.array(frequencies), np.array(passed), []
    for label, strikes in panels.items():
        marks: list[Mark] = []
        for strike, (values, rigid) in strikes.items():
            shown, (name, colour) = np.array(values, dtype=float), rows.STRIKES[strike]
            marks.append(Line(name, f, np.where(good, shown, np.nan), colour, dots=2.6))
            marks.append(Line("", f, np.full(f.shape, rigid), colour, 1.0, "5 3"))
            bad = Line("not to be relied on", f[~good], shown[~good], "red", 0.0, dots=2.6)
            marks += [] if good.all() else [bad]
        plots.append(chart.Plot(tuple(marks), chart.Axis(label, low=0.0), 120.0))
    caption = "Both strikes against the plate's first frequency; dashed: the rigid vehicle"
    x = chart.Axis("first frequency of the plate [Hz]", is_log=True)
    return chart.draw_chart("plates", caption, plots, x, width=WIDTH)
