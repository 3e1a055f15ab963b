"""Charts of studies.

Bars and bands in named rows, histogram. On logarithmic axes: error over run time, one line per
method; sizes over the first frequency of a plate, stiff plates on the left.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import cycle
from typing import Any, NamedTuple

import numpy as np

from postprocess.svg import chart
from postprocess.svg.areas import Boxes, Span
from postprocess.svg.marks import SMALL, Level, Line, Mark, Name, Words, key, line_style, text_width
from postprocess.svg.scales import Floats, Range, Scale
from postprocess.units import measure

# Indices: name, label, place in a row, colour.
INDICES = (("first_order", "alone", 0.19, "fe"), ("total", "with interactions", -0.19, "steel"))

# Label and colour of each strike, and of predictions by whether the published value lies in the band.
STRIKES = {1: ("first strike", "fe"), 2: ("second strike", "rigid")}
INSIDE = {True: ("published value in the band", "green"), False: ("outside", "difference")}

COLOURS = ("fe", "rigid", "green", "difference", "violet", "soft")
"""Colours of lines in order."""

PRECISION_HEIGHT = 460.0
"""Height of the work-precision diagram [pixels]."""


class BandBar(NamedTuple):
    """Band of samples in a row.

    kind: strike, or whether the published value lies in the band; ends: 5, 50 and 95 %; nominal: value of the scene.
    """

    label: str
    kind: int
    ends: tuple[float, ...]
    nominal: float = math.nan


def row_plot(names: Sequence[str], marks: Sequence[Mark], row: float) -> chart.Plot:
    """Return a plot of named rows, the first on top.

    row: height of one [pixels].
    """
    named = tuple(zip(row_heights(names).tolist(), names, strict=True))
    axis = chart.Axis("", -0.6, len(names) - 0.4, named=named)
    return chart.Plot(tuple(marks), axis, row * len(names) + 8.0, nearest="y", has_grid=False)


def row_heights(names: Sequence[object]) -> Floats:
    """Return the heights of the rows, shape (n,)."""
    return np.arange(len(names), dtype=float)[::-1]


def _across(rows: Floats) -> Floats:
    """Return the edges of bars about these heights, shape (n, 2)."""
    return rows[:, None] + 0.18 * np.array([-1.0, 1.0])


def draw_histogram(
    edges: Floats, counts: Floats, percentiles: Sequence[tuple[int, float]], scene_value: float
) -> chart.Chart:
    """Draw the distribution of peak forces in kN.

    counts between edges [N], percentiles, and the value of the scene.
    """
    caption = "Peak force of the combinations: fraction of them in each bar"
    fraction, scene_kn, top = 100.0 * counts / counts.sum(), np.full(2, scene_value / 1e3), 1.12
    across = np.stack([edges[:-1], edges[1:]], axis=-1) / 1e3
    up, ends = np.stack([0.0 * fraction, fraction], axis=-1), np.array([0.0, top * float(fraction.max())])
    marks: list[Mark] = [
        Boxes("fraction", across, up, "steel", fraction.tolist(), strength=0.6),
        *(Span(f"{percent} %", force / 1e3, force / 1e3, "fe") for percent, force in percentiles),
        Line("", scene_kn, ends, "rigid", 2.0),
        key("the scene's own values", "rigid", 2.0),
    ]
    plot = chart.Plot(tuple(marks), chart.Axis("fraction [%]", *ends.tolist()), 220.0)
    x = chart.Axis("peak force [kN]", margin=0.0)
    return chart.Chart("histogram", caption, (plot,), x, "Distribution", chart.FULL)


def draw_sensitivity(inputs: Sequence[Mapping[str, Any]], of: str = "the peak force") -> chart.Chart:
    """Draw first-order and total indices as bars.

    inputs: rows with `key`, `first_order`, `total`, and their intervals, `first_order_interval` and `total_interval`;
    the first is on top.
    """
    caption = f"Fraction of the variance of {of} due to each input, with its 95 % interval"
    names, marks = [row["key"] for row in inputs], list[Mark]()
    for index, label, shift, colour in INDICES:
        values, rows = np.array([row[index] for row in inputs]), row_heights(names) + shift
        from_zero = np.stack([0.0 * values, values], axis=-1)
        marks.append(Boxes(label, from_zero, _across(rows), colour, values.tolist(), names))
        intervals = [(*row[f"{index}_interval"], np.nan) for row in inputs]
        marks.append(Line("", np.ravel(intervals), np.repeat(rows, 3), "ink", 1.4))
    plot = row_plot(names, marks, 34.0)
    return chart.Chart("sensitivity", caption, (plot,), chart.Axis("Sobol index"), "Sensitivity", chart.HALF)


def draw_bands(bars: Sequence[BandBar]) -> chart.Chart:
    """Draw the spread of peaks as bars from 5 to 95 %.

    With their medians and the values of the scene.
    """

    def text(low: float, middle: float, high: float) -> str:
        span = f"{measure(low, 'kN', '.0f', named=False)} to {measure(high, 'kN', '.0f')}"
        return f"{span}, median {measure(middle, 'kN', '.0f')}"

    caption = "Peak lateral force: 5 to 95 %, median (stroke) and value of the scene (dot)"
    marks = [mark for strike, style in STRIKES.items() for mark in _bands(bars, strike, *style, text)]
    plot = row_plot([bar.label for bar in bars], marks, 46.0)
    return chart.Chart("bands", caption, (plot,), chart.Axis("peak lateral force [kN]"), width=chart.FULL)


def draw_ratios(bars: Sequence[BandBar]) -> chart.Chart:
    """Draw bands of predictions over published values."""
    caption = (
        "Predicted over published: 5 to 95 % and median (stroke) of each row; the published value is at 1"
    )
    text = "{0:.2f} to {2:.2f}, median {1:.2f}".format
    marks = [mark for inside, style in INSIDE.items() for mark in _bands(bars, inside, *style, text)]
    plot = row_plot([bar.label for bar in bars], [*marks, Span("", 1.0, 1.0, "ink")], 30.0)
    axis = chart.Axis("predicted over published", is_log=True)
    return chart.Chart("validation", caption, (plot,), axis, width=chart.FULL)


def _bands(
    bars: Sequence[BandBar], kind: int, name: str, colour: str, text: Callable[..., str]
) -> list[Mark]:
    """Return bars of a kind with strokes at medians.

    Nominal values are dots. text: of the ends of a band.
    """
    placed = [(row, bar) for row, bar in zip(row_heights(bars), bars, strict=True) if bar.kind == kind]
    if not placed:
        return []
    rows, chosen = np.array([row for row, _ in placed]), [bar for _, bar in placed]
    low, middle, high = np.array([bar.ends for bar in chosen]).T
    texts, labels = [text(*bar.ends) for bar in chosen], [bar.label for bar in chosen]
    strokes, nominal = np.array([-0.18, 0.18, np.nan]) + rows[:, None], [bar.nominal for bar in chosen]
    dots = [] if np.isnan(nominal).all() else [Line("", np.array(nominal), rows, colour, 0.0, dots=3.6)]
    return [
        Boxes(name, np.stack([low, high], axis=-1), _across(rows), colour, texts, labels, 0.4),
        Line("", np.repeat(middle, 3), strokes.ravel(), colour, 2.2),
        *dots,
    ]


class Series(NamedTuple):
    """Line of one method.

    Times [s] and errors in order, whether checks passed, and names of the points, for example their meshes.
    """

    label: str
    times: Sequence[float]
    errors: Sequence[float]
    passed: Sequence[bool]
    points: Sequence[str] = ()


def draw_precision(
    name: str,
    title: str,
    series: Sequence[Series],
    error_label: str,
    front: tuple[str, Sequence[tuple[float, float]]],
    floor: tuple[str, float],
) -> list[chart.Chart]:
    """Draw a work-precision diagram, with a line for each method.

    Without points there is none. front: label, times and errors of the Pareto front, quick to slow; floor: label and
    error of the reference.
    """
    drawn_series = [method for method in series if len(method.times)]
    if not drawn_series:
        return []
    reference = [floor[1]] if math.isfinite(floor[1]) and floor[1] > 0.0 else []
    x = _decades([time for method in drawn_series for time in method.times])
    y = _decades([error for method in drawn_series for error in method.errors] + reference)
    marks: list[Mark] = []
    if reference:
        marks.append(Line(floor[0], np.array(x), np.array(2 * reference), "soft", 1.2, "1 3"))
    if front[1]:
        marks.append(_steps(*front, x[1]))
    for number, (method, colour) in enumerate(zip(drawn_series, cycle(COLOURS), strict=False)):
        times, errors, failed = np.array(method.times), np.array(method.errors), ~np.array(method.passed)
        dashes = line_style(number)["dashes"]
        marks.append(Line(method.label, times, errors, colour, 1.5, dashes, 3.0, at=method.points))
        if failed.any():
            marks.append(Line("failed a check", times[failed], errors[failed], "red", 0.0, dots=3.0))
    across = chart.Axis("time to solution, set-up included [s]", *x, is_log=True)
    named, up = (*marks, *_end_names(drawn_series, x, y)), chart.Axis(error_label, *y, is_log=True)
    plot = chart.Plot(named, up, PRECISION_HEIGHT, nearest="xy", is_wide=True)
    return [chart.Chart(name, title, (plot,), across, "Work and precision", chart.FULL)]


def _end_names(series: Sequence[Series], x: Range, y: Range) -> list[Words]:
    """Return names of lines beside their last points.

    Names near the right edge stand on the left; all are shifted until none overlap.
    """
    across = Scale(*x, 0.0, chart.FULL - 70.0, is_log=True)
    up, placed, drawn = Scale(*y, PRECISION_HEIGHT, 0.0, is_log=True), list[Name](), []
    for method, colour in zip(series, cycle(COLOURS), strict=False):
        time, error = method.times[-1], method.errors[-1]
        end, height = float(across.at(time)), float(up.at(error))
        is_left = end + text_width(method.label, SMALL) + 14.0 > across.end
        anchor, beside = ("end", -8.0) if is_left else ("start", 8.0)
        shifts = [sign * 12.0 * step + 3.5 for step in range(1 * is_left, 20) for sign in (-1.0, 1.0)]
        names = [Name(method.label, end + beside, height + shift, anchor) for shift in shifts]
        inside = [name for name in names if 11.0 < name.y < PRECISION_HEIGHT]
        name = next((name for name in inside if not any(map(name.overlaps, placed))), names[-1])
        placed.append(name)
        drawn.append(Words(method.label, time, error, (beside, name.y - height), anchor, colour))
    return drawn


def _decades(values: Sequence[float]) -> tuple[float, float]:
    """Return powers of ten that enclose all values."""
    logs: Floats = np.log10(values)
    low, high = math.floor(logs.min()), math.ceil(logs.max())
    return 10.0**low, 10.0 ** max(high, low + 1)


def _steps(label: str, front: Sequence[tuple[float, float]], end: float) -> Line:
    """Return the front as steps, continued to the right edge."""
    times, errors = np.array(front).T
    x, y = np.repeat(np.append(times, end), 2)[1:], np.repeat(np.append(errors, errors[-1]), 2)[:-1]
    return Line(label, x, y, "grid", 6.0)


class SweepLine(NamedTuple):
    """Size of a quantity at each frequency.

    errors: drawn thin and dashed; NaN is not drawn. passed: outcome of its runs, where it differs from that of the
    axis.
    """

    label: str
    values: Sequence[float]
    errors: Sequence[float] = ()
    passed: Sequence[bool] = ()


class SweepAxis(NamedTuple):
    """First frequencies [Hz] from stiff to soft.

    passed: outcome of the runs; nominal: frequency of the scene.
    """

    frequencies: Sequence[float]
    passed: Sequence[bool]
    nominal: float


def draw_sweep(
    name: str,
    axis: SweepAxis,
    lines: Sequence[SweepLine],
    label: str,
    caption: str,
    levels: Sequence[float],
    width: float = chart.HALF,
) -> chart.Chart:
    """Draw percentages over the first frequency.

    levels: sizes marked by lines. Runs that failed a check are red, and their plates are shaded up to the midpoints
    to their neighbours.
    """
    frequencies = np.array(axis.frequencies)
    half = np.sqrt(frequencies[0] / frequencies[1])
    failed = frequencies[~np.array(axis.passed)]
    marks: list[Mark] = [
        Span("" if number else "failed", frequency * half, frequency / half, "red")
        for number, frequency in enumerate(failed)
    ]
    marks += [Level("", 100.0 * level, "grey") for level in levels]
    if frequencies[-1] <= axis.nominal <= frequencies[0]:
        marks.append(Span("the scene's plate", axis.nominal, axis.nominal, "ink"))
    for number, (line, colour) in enumerate(zip(lines, cycle(COLOURS), strict=False)):
        marks += _sweep_marks(axis, line, colour, number)
    marks += [key("numerical error", "soft", 0.7, "4 2")] if any(line.errors for line in lines) else []
    heading = "first frequency of the plate [Hz], rigid to soft"
    x = chart.Axis(heading, frequencies[0] * 1.15, frequencies[-1] / 1.15, is_log=True)
    plot = chart.Plot(tuple(marks), chart.Axis(f"{label} [%]", is_log=True), 260.0)
    return chart.Chart(name, caption, (plot,), x, "Sweeps", width)


def _sweep_marks(axis: SweepAxis, line: SweepLine, colour: str, number: int) -> list[Mark]:
    x, values = np.array(axis.frequencies), _per_cent(line.values)
    passed = np.array(line.passed or axis.passed)
    good, bad = np.where(passed, values, np.nan), np.where(passed, np.nan, values)
    marks: list[Mark] = [Line(line.label, x, good, colour, **line_style(number), dots=2.4)]
    marks += [Line("failed a check", x, bad, "red", 0.0, dots=2.4)] if np.isfinite(bad).any() else []
    if line.errors:
        errors = np.where(passed, _per_cent(line.errors), np.nan)
        marks.append(Line("numerical error", x, errors, colour, 0.7, "4 2"))
    return marks


def _per_cent(values: Sequence[float]) -> Floats:
    """Return positive values in per cent, otherwise NaN."""
    percentages = 100.0 * np.array(values, dtype=float)
    return np.where(np.isfinite(percentages) & (percentages > 0.0), percentages, np.nan)
