"""Charts of a study of strikes: both strikes against each input, as bands, and against flexibility."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from postprocess.figures.rows import bars, heights, row_plot
from postprocess.svg.chart import Axis, Chart, Plot, draw_chart, draw_legend
from postprocess.svg.drawing import Floats
from postprocess.svg.marks import Line, Mark, Span, Words, key

COLOURS = {1: "fe", 2: "rigid"}
"""Of the first and the second strike."""

NAMES = {1: "first strike", 2: "second strike"}
LOOKS = ((2.0, ""), (1.2, "5 3"), (1.2, "1 3"))
"""Width and dashes of the quantities of one plot, in their order."""

DOTS = {False: ("measured", "green"), True: ("projected by the authors", "violet")}
OWN, WIDTH, NARROW = "the scene's own", 480.0, 320.0


@dataclass(frozen=True)
class InputPanel:
    """Both strikes against one input, its values and the scene's own as shown.

    lines: label of the axis -> strike -> name of the quantity -> values, shape (n,).
    """

    name: str
    label: str
    values: Floats
    own: float
    logarithmic: bool
    lines: Mapping[str, Mapping[int, Mapping[str, Floats]]]


@dataclass(frozen=True)
class BandBar:
    """A spread: label, strike, 5, 50 and 95 %, and the scene's own value; dots: what was measured, by row, and whether
    it was projected."""

    label: str
    strike: int
    ends: tuple[float, float, float]
    own: float
    dots: Sequence[tuple[str, float, bool]] = ()


@dataclass(frozen=True)
class PlatePanel:
    """A quantity of both strikes over the frequencies, and the rigid vehicle's."""

    label: str
    values: Mapping[int, Sequence[float]]
    rigid: Mapping[int, float]


def draw_inputs(caption: str, panels: Sequence[InputPanel]) -> list[Chart]:
    """A chart an input, with a plot for each kind of quantity, and before them one of what their lines are."""
    drawn = [_input_chart(caption, panel) for panel in panels]
    first = next(iter(panels[0].lines.values()))
    lines = [replace(line, x=np.zeros(0), y=np.zeros(0)) for line in _lines(panels[0].values, first)]
    caption = "What the lines are; impulse and duration are drawn as the first peak of their strike"
    keys = [*lines, key(OWN, "grey", 1.0, "2 2")]
    return [draw_legend("inputs-legend", caption, keys, width=NARROW), *drawn]


def _input_chart(caption: str, panel: InputPanel) -> Chart:
    plots = [
        Plot(
            (*_lines(panel.values, strikes), Span("", panel.own, panel.own, "grey")),
            Axis(label, low=0.0),
            110.0,
            has_legend=False,
        )
        for label, strikes in panel.lines.items()
    ]
    x = Axis(panel.label, is_log=panel.logarithmic, margin=0.0)
    return draw_chart(panel.name, f"{caption} {panel.label.partition(' [')[0]}", plots, x, width=NARROW)


def _lines(x: Floats, strikes: Mapping[int, Mapping[str, Floats]]) -> list[Line]:
    return [
        Line(f"{NAMES[strike]}, {name}", x, values, COLOURS[strike], *look)
        for strike, quantities in strikes.items()
        for (name, values), look in zip(quantities.items(), LOOKS, strict=False)
    ]


def draw_bands(all_bars: Sequence[BandBar]) -> Chart:
    """A bar from 5 to 95 % a peak, its median, the scene's own value, and measured forces as dots with their row."""
    caption = (
        "Peak lateral force: 5 to 95 %, median (stroke) and the scene's own value (dot); rows of the paper"
    )
    labels = [bar.label for bar in all_bars]
    marks: list[Mark] = []
    for strike, name in NAMES.items():
        own = [(row, bar) for row, bar in zip(heights(labels), all_bars, strict=True) if bar.strike == strike]
        marks += _bands(name, COLOURS[strike], np.array([row for row, _ in own]), [bar for _, bar in own])
    dots = [(dot, row) for row, bar in zip(heights(labels), all_bars, strict=True) for dot in bar.dots]
    for projected, (name, colour) in DOTS.items():
        found = [(dot, row - 0.3) for dot, row in dots if dot[2] == projected]
        marks += _dots(name, colour, found) if found else []
    return draw_chart(
        "bands", caption, (row_plot(labels, marks, 46.0),), Axis("peak lateral force [kN]"), width=WIDTH
    )


def _bands(name: str, colour: str, rows: Floats, of: Sequence[BandBar]) -> list[Mark]:
    low, middle, high = np.array([bar.ends for bar in of]).T
    said = [f"{a:.0f} to {c:.0f} kN, median {b:.0f} kN" for a, b, c in (bar.ends for bar in of)]
    band = bars(
        name, rows, np.stack([low, high], axis=-1), colour, said, [bar.label for bar in of], 0.36, 0.4
    )
    strokes = np.array([-0.18, 0.18, np.nan]) + rows[:, None]
    own = np.array([bar.own for bar in of])
    return [
        band,
        Line("", np.repeat(middle, 3), strokes.ravel(), colour, 2.2),
        Line("", own, rows, colour, 0.0, dots=3.6),
    ]


def _dots(name: str, colour: str, found: Sequence[tuple[tuple[str, float, bool], float]]) -> list[Mark]:
    """Dots below the bars, each with its row's letter; letters stand above and below in turns."""
    ordered = sorted(found, key=lambda each: each[0][1])
    x, y = np.array([(dot[1], row) for dot, row in ordered]).T
    said, at = [f"{dot[1]:.0f} kN" for dot, _ in ordered], [f"row {dot[0]}" for dot, _ in ordered]
    letters = [
        Words(dot[0], dot[1], row, (5.0, -1.0 if number % 2 else 9.0), colour=colour)
        for number, (dot, row) in enumerate(ordered)
    ]
    return [Line(name, x, y, colour, 0.0, dots=3.4, values=said, at=at), *letters]


def draw_plates(frequencies: Sequence[float], passed: Sequence[bool], panels: Sequence[PlatePanel]) -> Chart:
    """A plot a quantity; dashed lines: the rigid vehicle; red: plates that are not to be relied on."""
    caption = "Both strikes against the plate's first frequency; dashed: the rigid vehicle"
    good, f = np.array(passed), np.array(frequencies)
    plots = [Plot(tuple(_plate_marks(f, good, panel)), Axis(panel.label, low=0.0), 120.0) for panel in panels]
    x = Axis("first frequency of the plate [Hz]", is_log=True)
    return draw_chart("plates", caption, plots, x, width=WIDTH)


def _plate_marks(f: Floats, good: Any, panel: PlatePanel) -> list[Mark]:
    marks: list[Mark] = []
    for strike, values in panel.values.items():
        shown, colour = np.array(values, dtype=float), COLOURS[strike]
        rigid = np.full(f.shape, panel.rigid[strike])
        marks.append(Line(NAMES[strike], f, np.where(good, shown, np.nan), colour, dots=2.6))
        marks.append(Line("", f, rigid, colour, 1.0, "5 3"))
        bad = Line("not to be relied on", f[~good], shown[~good], "red", 0.0, dots=2.6)
        marks += [] if good.all() else [bad]
    return marks
