"""Charts of an uncertainty study: bars and bands in named rows, one below the other, histogram, one input at a time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from postprocess.svg import chart
from postprocess.svg.drawing import Floats
from postprocess.svg.marks import Boxes, Line, Mark, Span, Words, key
from postprocess.units import measure

WIDTH, WIDE, NARROW = 400.0, 480.0, 320.0

# Of the indices: name, label, place in a row, colour.
INDICES = (("first_order", "alone", 0.19, "fe"), ("total", "with interactions", -0.19, "steel"))

# Words and colour of each.
STRIKES = {1: ("first strike", "fe"), 2: ("second strike", "rigid")}

# Width and dashes of the quantities of one plot, in their order.
LOOKS = ((2.0, ""), (1.2, "5 3"), (1.2, "1 3"))

DOTS = {False: ("measured", "green"), True: ("projected by the authors", "violet")}


class InputPanel(NamedTuple):
    """Both strikes against one input, its values and the scene's own as shown.

    lines: label of the axis -> strike -> name of the quantity -> values, shape (n,).
    """

    name: str
    label: str
    values: Floats
    own: float
    logarithmic: bool
    lines: Mapping[str, Mapping[int, Mapping[str, Floats]]]


class BandBar(NamedTuple):
    """A spread: label, strike, 5, 50 and 95 %, and the scene's own value; dots: what was measured, by row, and whether
    it was projected."""

    label: str
    strike: int
    ends: tuple[float, float, float]
    own: float
    dots: Sequence[tuple[str, float, bool]] = ()


def _row_plot(names: Sequence[str], marks: Sequence[Mark], row: float) -> chart.Plot:
    """A plot of rows with these names, the first on top, whose heights are those of `_heights`; row: pixels of one."""
    named = tuple(zip(_heights(names).tolist(), names, strict=True))
    axis = chart.Axis("", -0.6, len(names) - 0.4, named=named)
    return chart.Plot(tuple(marks), axis, row * len(names) + 8.0, nearest="y", has_grid=False)


def _heights(names: Sequence[str]) -> Floats:
    """Heights of the rows, shape (n,)."""
    return np.arange(len(names), dtype=float)[::-1]


def _across(rows: Floats) -> Floats:
    """Lower and upper edges of bars about these heights, shape (n, 2)."""
    return rows[:, None] + 0.18 * np.array([-1.0, 1.0])


def draw_histogram(
    edges: Floats, counts: Floats, percentiles: Sequence[tuple[int, float]], scene_value: float
) -> chart.Chart:
    """The distribution of the peak force, in kN: counts between edges [N], percentiles and the scene's own value."""
    caption = "Peak force of the combinations: fraction of them in each bar"
    fraction, own, top = 100.0 * counts / counts.sum(), np.full(2, scene_value / 1e3), 1.12
    across = np.stack([edges[:-1], edges[1:]], axis=-1) / 1e3
    up, ends = np.stack([0.0 * fraction, fraction], axis=-1), np.array([0.0, top * float(fraction.max())])
    marks: list[Mark] = [
        Boxes("fraction", across, up, "steel", fraction.tolist(), strength=0.6),
        *(Span(f"{percent} %", force / 1e3, force / 1e3, "fe") for percent, force in percentiles),
        Line("", own, ends, "rigid", 2.0),
        key("the scene's own values", "rigid", 2.0),
    ]
    plot = chart.Plot(tuple(marks), chart.Axis("fraction [%]", *ends.tolist()), 220.0)
    x = chart.Axis("peak force [kN]", margin=0.0)
    return chart.draw_chart("histogram", caption, (plot,), x, "Distribution", WIDTH)


def draw_sensitivity(inputs: Sequence[Mapping[str, Any]], of: str = "the peak force") -> chart.Chart:
    """Bars of the first-order and total indices of inputs, the first on top, with their intervals.

    inputs: rows with `key`, `first_order`, `total`, and their intervals, `first_order_interval` and `total_interval`.
    """
    caption = f"Fraction of the variance of {of} that comes from each input, and its 95 % interval"
    names, marks = [row["key"] for row in inputs], list[Mark]()
    for index, label, shift, colour in INDICES:
        values, rows = np.array([row[index] for row in inputs]), _heights(names) + shift
        from_zero = np.stack([0.0 * values, values], axis=-1)
        marks.append(Boxes(label, from_zero, _across(rows), colour, values.tolist(), names))
        intervals = [(*row[f"{index}_interval"], np.nan) for row in inputs]
        marks.append(Line("", np.ravel(intervals), np.repeat(rows, 3), "ink", 1.4))
    plot = _row_plot(names, marks, 34.0)
    return chart.draw_chart("sensitivity", caption, (plot,), chart.Axis("Sobol index"), "Sensitivity", WIDTH)


def draw_inputs(caption: str, panels: Sequence[InputPanel]) -> list[chart.Chart]:
    """A chart an input, with a plot for each kind of quantity, and before them one of what their lines are."""
    first = next(iter(panels[0].lines.values()))
    lines = [replace(line, x=np.zeros(0), y=np.zeros(0)) for line in _lines(panels[0].values, first)]
    keys = [*lines, key("the scene's own", "grey", 1.0, "2 2")]
    words = "What the lines are; impulse and duration are drawn as the first peak of their strike"
    drawn = [chart.draw_legend("inputs-legend", words, keys, width=NARROW)]
    for panel in panels:
        own = Span("", panel.own, panel.own, "grey")
        plots = [
            chart.Plot(
                (*_lines(panel.values, strikes), own), chart.Axis(label, low=0.0), 110.0, has_legend=False
            )
            for label, strikes in panel.lines.items()
        ]
        x = chart.Axis(panel.label, is_log=panel.logarithmic, margin=0.0)
        heading = f"{caption} {panel.label.partition(' [')[0]}"
        drawn.append(chart.draw_chart(panel.name, heading, plots, x, width=NARROW))
    return drawn


def _lines(x: Floats, strikes: Mapping[int, Mapping[str, Floats]]) -> list[Line]:
    return [
        Line(f"{STRIKES[strike][0]}, {name}", x, values, STRIKES[strike][1], *look)
        for strike, quantities in strikes.items()
        for (name, values), look in zip(quantities.items(), LOOKS, strict=False)
    ]


def draw_bands(bars: Sequence[BandBar]) -> chart.Chart:
    """A bar from 5 to 95 % a peak, its median, the scene's own value, and measured forces as dots with their row."""
    caption = (
        "Peak lateral force: 5 to 95 %, median (stroke) and the scene's own value (dot); rows of the paper"
    )
    labels, marks = [bar.label for bar in bars], list[Mark]()
    placed = list(zip(_heights(labels), bars, strict=True))
    for strike, (name, colour) in STRIKES.items():
        rows = np.array([row for row, bar in placed if bar.strike == strike])
        of = [bar for bar in bars if bar.strike == strike]
        low, middle, high = np.array([bar.ends for bar in of]).T
        said = [
            f"{measure(a, 'kN', '.0f', named=False)} to {measure(c, 'kN', '.0f')}, median {measure(b, 'kN', '.0f')}"
            for a, b, c in (bar.ends for bar in of)
        ]
        ends, strokes = np.stack([low, high], axis=-1), np.array([-0.18, 0.18, np.nan]) + rows[:, None]
        marks += [
            Boxes(name, ends, _across(rows), colour, said, [bar.label for bar in of], 0.4),
            Line("", np.repeat(middle, 3), strokes.ravel(), colour, 2.2),
            Line("", np.array([bar.own for bar in of]), rows, colour, 0.0, dots=3.6),
        ]
    for projected, (name, colour) in DOTS.items():
        dots = [
            (force, row - 0.3, letter)
            for row, bar in placed
            for letter, force, was_projected in bar.dots
            if was_projected == projected
        ]
        marks += _dots(name, colour, sorted(dots, key=lambda dot: dot[0])) if dots else []
    plot = _row_plot(labels, marks, 46.0)
    return chart.draw_chart("bands", caption, (plot,), chart.Axis("peak lateral force [kN]"), width=WIDE)


def _dots(name: str, colour: str, dots: Sequence[tuple[float, float, str]]) -> list[Mark]:
    """Dots below the bars, each with its row's letter; letters stand above and below in turns."""
    x, y = (np.array(values) for values in list(zip(*dots, strict=True))[:2])
    said, at = [measure(force, "kN", ".0f") for force, _, _ in dots], [f"row {row}" for _, _, row in dots]
    letters = [
        Words(letter, force, row, (5.0, -1.0 if number % 2 else 9.0), colour=colour)
        for number, (force, row, letter) in enumerate(dots)
    ]
    return [Line(name, x, y, colour, 0.0, dots=3.4, values=said, at=at), *letters]
