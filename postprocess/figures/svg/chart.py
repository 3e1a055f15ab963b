"""A chart: plots one below the other over one x axis, with legend, ticks at round values, and units in the labels.

The text stands by itself as an SVG file, and goes into a page as it is: it has no ids, text stays text, and colours of
`PALETTE` are classes that a page may change. Lines and layers carry their values for pages that show them (`page.js`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from html import escape

import numpy as np

from postprocess.figures.svg.drawing import coloured, text_width, words
from postprocess.figures.svg.frame import BARE, Frame, drawn, framed
from postprocess.figures.svg.marks import Mark
from postprocess.figures.svg.plot import SIZE, SMALL, Axis, Plot
from postprocess.report.units import Units

FOOT, ROW = 36.0, 16.0
"""Room below the last plot, and of a row of words."""


@dataclass(frozen=True)
class Chart:
    """A drawn chart: short name, heading of the group it belongs to, caption, SVG text, width in pixels; and what it
    was drawn from, to be drawn in other units."""

    name: str
    group: str
    caption: str
    svg: str
    width: float = 0.0
    plots: tuple[Plot, ...] = field(default=(), compare=False)
    x: Axis = field(default=Axis(), compare=False)

    @property
    def is_legend(self) -> bool:
        """Whether it is the legend of several charts, and shows nothing else."""
        return bool(self.plots) and all(plot.height == 0.0 for plot in self.plots)

    def in_units(self, units: Units) -> Chart:
        """The same in other units."""
        along, x_unit = units.of(self.x.unit)
        plots = []
        for plot in self.plots:
            up, unit = units.of(plot.y.unit)
            marks = tuple(mark.scaled(along, up) for mark in plot.marks)
            plots.append(replace(plot, marks=marks, y=plot.y.scaled(up, unit)))
        made = draw_chart(
            self.name, units.said(self.caption), plots, self.x.scaled(along, x_unit), self.group, self.width
        )
        return replace(made, svg=units.said(made.svg))


def draw_chart(
    name: str, caption: str, plots: Sequence[Plot], x: Axis, group: str = "", width: float = 400.0
) -> Chart:
    """The chart as SVG text of so many pixels' width."""
    with np.errstate(all="ignore"):
        legend, top = _legend(plots[0], width)
        frames = framed(plots, x, width, top)
        parts = [legend, *map(drawn, frames), _x_axis(x, frames)]
    height = frames[-1].y.start + _foot(x)
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:.0f}" width="{width:g}" '
        f'height="{height:.0f}" role="img" aria-label="{escape(caption)}" class="chart" '
        f'font-family="system-ui, Segoe UI, DejaVu Sans, sans-serif" font-size="{SIZE:g}">'
        '<rect class="paper" width="100%" height="100%" fill="#fff"/>'
    )
    return Chart(name, group, caption, head + "".join(parts) + "</svg>", width, tuple(plots), x)


def draw_legend(
    name: str, caption: str, marks: Sequence[Mark], group: str = "", width: float = 300.0
) -> Chart:
    """A chart of nothing but the keys of these marks, for several charts that have none."""
    bare = Axis(named=())
    return draw_chart(name, caption, (Plot(tuple(marks), bare, 0.0, has_grid=False),), bare, group, width)


def _foot(x: Axis) -> float:
    """Room below the last plot."""
    rows = max((text.count("\n") for _, text in x.named or ()), default=0)
    return BARE + (FOOT - BARE - ROW) * (x.named != ()) + ROW * (bool(x.label) + rows)


def _legend(plot: Plot, width: float) -> tuple[str, float]:
    """The keys of the marks in rows above the first plot, and how much room they take."""
    shown = {mark.label: mark for mark in plot.marks if mark.label and mark.key()}
    if not (shown and plot.has_legend):
        return "", 0.0
    across, row, keys = 0.0, 0, []
    for label, mark in shown.items():
        wide = 24.0 + text_width(label, SMALL)
        if across and across + wide > width:
            across, row = 0.0, row + 1
        text = words(label, 23.0, 9.0, size=SMALL)
        place = f'<g transform="translate({across:.1f} {row * ROW + 2.0:.1f})">'
        keys.append(place + mark.key() + coloured(text, "ink") + "</g>")
        across += wide + 12.0
    return "".join(keys), (row + 1) * ROW + 2.0


def _x_axis(axis: Axis, frames: Sequence[Frame]) -> str:
    """Ticks and label below the last plot, lines of the grid in all of them."""
    last = frames[-1]
    ticks = axis.ticks(last.x, 58.0 if axis.named is None else 1.0)
    down = last.y.start + 15.0
    texts = [
        words(line, float(last.x.at(value)), down + 13.0 * row, "middle", SMALL)
        for value, text in ticks
        for row, line in enumerate(text.split("\n"))
    ]
    marks = "".join(f"M{last.x.at(value):.2f} {last.y.start:.2f}v3" for value, _ in ticks)
    label = words(axis.label, 0.5 * (last.x.start + last.x.end), last.y.start + _foot(axis) - 5.0, "middle")
    line = f'<path d="{marks}" stroke="currentColor" stroke-width="0.8"/>'
    return coloured(line, "grey") + coloured("".join(texts), "soft") + coloured(label, "ink")
