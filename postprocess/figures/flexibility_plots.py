"""Sweeps from stiff to soft: sizes over the first frequency, logarithmic, stiff plates on the left."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import cycle

import numpy as np

from postprocess.svg.chart import Axis, Chart, Plot, draw_chart
from postprocess.svg.drawing import Floats
from postprocess.svg.marks import Level, Line, Mark, Span, key

LINE, RINGS, DOTS = "line", "rings", "dots"
COLOURS = ("fe", "rigid", "green", "difference", "violet", "soft")
X_LABEL = "first frequency of the plate [Hz], rigid to soft"
WIDTH = 480.0


@dataclass(frozen=True)
class SweepLine:
    """A quantity's size at each frequency, and its error, drawn thin and dashed, where it has one.

    NaN is not drawn. form: LINE with marks; RINGS around the marks of a line that follows; DOTS for what is no
    measurement. passed: which of its runs did, where that is not what the axis says.
    """

    label: str
    values: Sequence[float]
    errors: Sequence[float] = ()
    form: str = LINE
    passed: Sequence[bool] = ()


@dataclass(frozen=True)
class SweepAxis:
    """First frequencies [Hz] from stiff to soft, which of the runs passed, and the scene's own frequency."""

    frequencies: Sequence[float]
    passed: Sequence[bool]
    own: float


def draw_sweep(
    name: str, axis: SweepAxis, lines: Sequence[SweepLine], label: str, caption: str, levels: Sequence[float]
) -> Chart:
    """The lines, in per cent; red where a run failed its checks, plates that failed shaded; levels: sizes that are
    marked."""
    marks = _backdrop(axis, levels)
    for line, colour in zip(lines, cycle(COLOURS), strict=False):
        marks += _line(axis, line, colour)
    marks += [key("numerical error", "soft", 0.7, "4 2")] if any(line.errors for line in lines) else []
    x = Axis(X_LABEL, axis.frequencies[0] * 1.15, axis.frequencies[-1] / 1.15, is_log=True)
    plot = Plot(tuple(marks), Axis(f"{label} [%]", is_log=True), 260.0)
    return draw_chart(name, caption, (plot,), x, "Sweeps", WIDTH)


def _line(axis: SweepAxis, line: SweepLine, colour: str) -> list[Mark]:
    x, values, passed = (
        np.array(axis.frequencies),
        _drawable(line.values),
        np.array(line.passed or axis.passed),
    )
    if line.form == DOTS:
        return [Line(line.label, x, values, colour, 1.2, "1 3")]
    if line.form == RINGS:
        return [Line(line.label, x, values, colour, 0.0, dots=5.0)]
    good, bad = np.where(passed, values, np.nan), np.where(passed, np.nan, values)
    marks: list[Mark] = [Line(line.label, x, good, colour, 1.3, dots=2.4)]
    marks += [Line("failed a check", x, bad, "red", 0.0, dots=2.4)] if np.isfinite(bad).any() else []
    if line.errors:
        errors = np.where(passed, _drawable(line.errors), np.nan)
        marks.append(Line("", x, errors, colour, 0.7, "4 2"))
    return marks


def _drawable(values: Sequence[float]) -> Floats:
    """The values that a logarithmic axis can show, in per cent, NaN for the others."""
    found = 100.0 * np.array(values, dtype=float)
    return np.where(np.isfinite(found) & (found > 0.0), found, np.nan)


def _backdrop(axis: SweepAxis, levels: Sequence[float]) -> list[Mark]:
    """Failed frequencies shaded half-way to their neighbours, levels, and the scene's own frequency."""
    frequencies = np.array(axis.frequencies)
    half = np.sqrt(frequencies[0] / frequencies[1])
    failed = frequencies[~np.array(axis.passed)]
    marks: list[Mark] = [
        Span("" if number else "failed", frequency * half, frequency / half, "red")
        for number, frequency in enumerate(failed)
    ]
    marks += [Level("", 100.0 * level, "grey") for level in levels]
    if axis.frequencies[-1] <= axis.own <= axis.frequencies[0]:
        marks.append(Span("the scene's plate", axis.own, axis.own, "ink"))
    return marks
