"""Charts of plots one below the other over one x axis.

A chart is SVG text that stands alone as a file: it has no ids, text remains text, and colours of `PALETTE` are classes
that a page may redefine. On a page it has the texts of both systems of units over the same curves. `page.js` makes a
table of the samples of each mark with a label: it reads the values of lines from their paths.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from html import escape
from typing import Literal

import numpy as np

from postprocess.svg import marks, scales
from postprocess.svg.areas import Span
from postprocess.svg.marks import SMALL, Level, Line, Mark, Name, found_ranges
from postprocess.svg.motion import MOTION, Cursor, Moving
from postprocess.units import MEASURE, SI, US, Units

SIZE = 12.0
"""Size of letters in labels [pixels]."""

FULL, HALF, PART = 1072.0, 520.0, 340.0
"""Widths of a chart alone, of one of two and of one of three side by side [pixels]."""

HEAD, LEFT, RIGHT, BARE = 26.0, 40.0, 12.0, 4.0
"""Room above a plot, about left and right of the plots, and beside a bare axis [pixels]."""

WIDEST = "−0.0"
"""Widest text of the ticks of a plot of equal scales, whose height is not known before."""

FOOT, ROW, GAP = 36.0, 16.0, 12.0
"""Room below the last plot, per row of words, and between keys [pixels]."""


@dataclass(frozen=True)
class Axis:
    """Axis with its label and unit.

    low, high: ends, by default those of the data; named: ticks with their texts, which may be none, instead of round
    ones.
    """

    label: str = ""
    low: float | None = None
    high: float | None = None
    is_log: bool = False
    margin: float = 0.05
    named: tuple[tuple[float, str], ...] | None = None

    def scale(self, data: tuple[float, float]) -> scales.Scale:
        """Return the scale that covers the data."""
        low, high = scales.fitted(*data, self.margin, self.is_log)
        low = low if self.low is None else self.low
        high = high if self.high is None else self.high
        return scales.Scale(low, high if high != low else low + 1.0, is_log=self.is_log)

    @property
    def unit(self) -> str:
        """Unit in brackets after the label."""
        return self.label.partition("[")[2].rstrip("]")

    def in_units(self, scale: scales.Scale, units: Units) -> tuple[str, scales.Scale]:
        """Return label and scale with values in other units."""
        factor, unit = units.of(self.unit)
        label = self.label.replace(f"[{self.unit}]", f"[{unit}]")
        return label, replace(scale, low=factor * scale.low, high=factor * scale.high)

    def ticks(self, scale: scales.Scale, room: float, units: Units) -> list[tuple[float, str]]:
        """Return places and texts of ticks at round values.

        room: pixels for one of them.
        """
        if self.named is not None:
            low, high = sorted((scale.low, scale.high))
            return [(float(scale.at(value)), text) for value, text in self.named if low <= value <= high]
        _, scale = self.in_units(scale, units)
        values = scale.ticks(max(2, int(abs(scale.end - scale.start) / room)))
        return list(zip(scale.at(values).tolist(), scales.tick_texts(values, self.is_log), strict=True))


@dataclass(frozen=True)
class Plot:
    """Marks in a frame, if there are ticks.

    height: of the frame, None for equal scales of both axes; nearest: axes along which the pointer selects points;
    is_wide: at least as wide on pages, because it contains words.
    """

    marks: tuple[Mark, ...]
    y: Axis = Axis()
    height: float | None = 190.0
    nearest: Literal["x", "y", "xy"] = "x"
    has_grid: bool = True
    has_legend: bool = True
    is_wide: bool = False


@dataclass(frozen=True)
class Frame:
    """Plot with placed scales."""

    plot: Plot
    x: scales.Scale
    y: scales.Scale

    @cached_property
    def marks(self) -> str:
        """SVG elements of the marks, the same in all units."""
        return "".join(mark.draw(self.x, self.y) for mark in self.plot.marks)

    def ticks(self, units: Units) -> list[tuple[float, str]]:
        """Return places and texts of the ticks of y."""
        return self.plot.y.ticks(self.y, 26.0, units)


def framed(plots: Sequence[Plot], x: Axis, width: float, top: float) -> list[Frame]:
    """Stack plots over a common x axis.

    top: of the first one.
    """
    ranges = [found_ranges(plot.marks) for plot in plots]
    x_scale = x.scale((min(a for (a, _), _ in ranges), max(b for (_, b), _ in ranges)))
    plots = [_in_rows(plot, replace(x_scale, start=LEFT, end=width - RIGHT)) for plot in plots]
    scales = [_below_names(plot, plot.y.scale(y)) for plot, (_, y) in zip(plots, ranges, strict=True)]
    sized = [
        replace(scale, start=200.0 if plot.height is None else plot.height, end=0.0)
        for scale, plot in zip(scales, plots, strict=True)
    ]
    texts = [
        WIDEST if plot.height is None else text
        for plot, scale in zip(plots, sized, strict=True)
        for units in (SI, US)
        for _, text in plot.y.ticks(scale, 26.0, units)
    ]
    start = 8.0 + max((marks.text_width(text, SMALL) for text in texts), default=0.0)
    x_scale = replace(x_scale, start=start, end=width - RIGHT)
    frames = []
    for plot, scale in zip(plots, sized, strict=True):
        ratio = abs((scale.high - scale.low) / (x_scale.high - x_scale.low))
        height = (x_scale.end - x_scale.start) * ratio if plot.height is None else plot.height
        top += HEAD if plot.y.label else BARE
        frames.append(Frame(plot, x_scale, replace(scale, start=top + height, end=top)))
        top += height
    return frames


def _in_rows(plot: Plot, x: scales.Scale) -> Plot:
    """Return a plot with names of spans in free rows.

    x: its scale across, with the place of the plot to a few pixels.
    """
    up, names, rows = scales.Scale(0.0, 1.0), list[Name](), list[Mark]()
    for mark in plot.marks:
        if isinstance(mark, Span):
            while any(name.overlaps(set_name) for name in mark.names(x, up) for set_name in names):
                mark = replace(mark, row=mark.row + 1)
            names += mark.names(x, up)
        rows.append(mark)
    return replace(plot, marks=tuple(rows))


def _below_names(plot: Plot, scale: scales.Scale) -> scales.Scale:
    """Extend a scale so that names of spans are above all curves."""
    spans = [mark for mark in plot.marks if isinstance(mark, Span) and mark.label]
    rows = max((mark.row + 1 for mark in spans), default=0)
    rows += any(isinstance(mark, Level) for mark in plot.marks)
    if plot.height is None or scale.is_log or not rows:
        return scale
    part = (SMALL * rows + 3.0) / plot.height
    return replace(scale, high=scale.high + (scale.high - scale.low) * part / (1.0 - part))


Systems = Sequence[Units]
"""Systems of units of a drawing; a page shows one of them at a time."""


def in_systems(systems: Systems, draw: Callable[[Units], str]) -> str:
    """Return a part in all systems of units.

    Equal parts are drawn once; the others have the name of their system as class.
    """
    texts = {units.name: draw(units) for units in systems}
    if len(set(texts.values())) == 1:
        return f"<g>{texts[systems[0].name]}</g>"
    return "".join(f'<g class="{name}">{text}</g>' for name, text in texts.items())


def drawn(frame: Frame, across: Axis, systems: Systems) -> str:
    """Return grid, marks, box and y axis."""
    x, y, plot = frame.x, frame.y, frame.plot
    width, height = x.end - x.start, y.start - y.end
    box = f'x="{x.start:.2f}" y="{y.end:.2f}" width="{width:.2f}" height="{height:.2f}" fill="none"'
    attributes = {
        "box": f"{x.start:.2f} {y.end:.2f} {x.end:.2f} {y.start:.2f}",
        "scales": f"{_kind(x, across)} {_kind(y, plot.y)}",
        "nearest": plot.nearest,
        "fixed": "equal" if plot.height is None else "wide" * plot.is_wide,
    }
    data = " ".join(f'data-{name}="{value}"' for name, value in attributes.items())
    parts = [
        f'<g class="plot" {data}>',
        in_systems(systems, lambda units: _y_axis(frame, units)),
        f'<g class="marks">{frame.marks}</g>',
        _stroked(f'<rect class="frame" {box}', "grey") if frame.ticks(SI) else "",
        in_systems(systems, lambda units: f'<g class="beside">{_level_names(frame, units)}</g>'),
    ]
    return "".join(parts) + "</g>"


def _y_axis(frame: Frame, units: Units) -> str:
    """Return grid, ticks and label."""
    x, ticks = frame.x, frame.ticks(units)
    label, scale = frame.plot.y.in_units(frame.y, units)
    grid = "".join(f"M{x.start:.2f} {place:.2f}H{x.end:.2f}" for place, _ in ticks)
    return (
        f'<g class="y-axis" {_ends(label, scale)}>'
        + (_stroked(f'<path class="rows" d="{grid}"', "grid") if frame.plot.has_grid else "")
        + _ticks([marks.words(text, x.start - 5.0, place + 4.0, "end", SMALL) for place, text in ticks])
        + marks.coloured(marks.words(label, 0.0, frame.y.end - 10.0), "ink")
        + "</g>"
    )


def _ends(label: str, scale: scales.Scale) -> str:
    return f'data-label="{escape(label)}" data-ends="{scale.low:.10g} {scale.high:.10g}"'


def _ticks(texts: Sequence[str]) -> str:
    return f'<g class="ticks">{marks.coloured("".join(texts), "soft")}</g>'


def _kind(scale: scales.Scale, axis: Axis) -> str:
    return "named" if axis.named is not None else "log" if scale.is_log else "linear"


def _stroked(opening: str, colour: str) -> str:
    return marks.coloured(f'{opening} stroke="currentColor" stroke-width="0.8"/>', colour)


def _level_names(frame: Frame, units: Units) -> str:
    """Return the names of levels at the right end of their lines.

    They are above or below the line, and left of other names that they would cover.
    """
    levels = [mark for mark in frame.plot.marks if isinstance(mark, Level)]
    factor, unit = units.of(frame.plot.y.unit)
    placed, drawn = [name for mark in frame.plot.marks for name in mark.names(frame.x, frame.y)], []
    for level in sorted(levels, key=lambda level: -level.value):
        text = " ".join(filter(None, (level.label, f"{factor * level.value:.4g}", unit)))
        line = float(frame.y.at(level.value))
        ends = sorted((frame.x.end - 4.0, *(name.ends[0] - 8.0 for name in placed)), reverse=True)
        sides = [down for down in (line - 3.0, line + SMALL) if frame.y.end + 8.0 < down <= frame.y.start]
        names = [Name(text, end, down, "end") for end in ends for down in sides or [line - 3.0]]
        name = next(name for name in names if not any(map(name.overlaps, placed)))
        placed.append(name)
        drawn.append(f'<g data-at="{line:.2f}">{marks.coloured(name.draw(marks.HALO), level.colour)}</g>')
    return "".join(drawn)


@dataclass(frozen=True)
class Chart:
    """Plots one below the other over one x axis, drawn on demand.

    name: of its file; group: heading over several charts; width: [pixels]; units: of its texts.
    """

    name: str
    caption: str
    plots: Sequence[Plot]
    x: Axis
    group: str = ""
    width: float = PART
    units: Units = field(default=SI, compare=False)

    def _repr_svg_(self) -> str:
        return self.svg

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Chart) and self.svg == other.svg

    __hash__ = None  # type: ignore[assignment]

    @cached_property
    def svg(self) -> str:
        """Drawing that stands alone."""
        return self._drawn((self.units,))

    @cached_property
    def layout(self) -> tuple[str, float, list[Frame]]:
        """Legend, its height, and the plots, the same in all units."""
        legend, top = _legend(self.plots[0], self.width)
        return legend, top, framed(self.plots, self.x, self.width, top)

    @property
    def on_page(self) -> str:
        """Drawing with the texts of both systems of units."""
        return self._drawn((self.units, US if self.units is SI else SI))

    @property
    def is_legend(self) -> bool:
        """True if it contains only a legend."""
        return all(plot.height == 0.0 for plot in self.plots)

    @property
    def is_moving(self) -> bool:
        """True if the chart is animated."""
        return any(isinstance(mark, Moving | Cursor) for plot in self.plots for mark in plot.marks)

    def in_units(self, units: Units) -> Chart:
        """Return the chart in other units, this one where they change nothing."""
        caption = units.rendered(self.caption)
        is_same = units is self.units and caption == self.caption
        return self if is_same else replace(self, units=units, caption=caption)

    def _drawn(self, systems: Systems) -> str:
        """Return SVG text with axes in several systems of units."""
        with np.errstate(all="ignore"):
            legend, top, frames = self.layout
            body = "".join(drawn(frame, self.x, systems) for frame in frames)
            body += in_systems(systems, lambda units: _x_axis(self.x, frames, units))
        height = frames[-1].y.start + _foot(self.x)
        caption = self.units.rendered(self.caption, "\N{NO-BREAK SPACE}")
        head = (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {self.width:g} {height:.0f}" '
            f'width="{self.width:g}" height="{height:.0f}" role="img" aria-label="{escape(caption)}" class="chart" '
            f'data-top="{top:g}" font-family="system-ui, Segoe UI, DejaVu Sans, sans-serif" font-size="{SIZE:g}">'
            '<rect class="paper" width="100%" height="100%" fill="#fff"/>'
        )
        head += f"<style>{MOTION}</style>" if self.is_moving else ""
        return _with_measures(f"{head}{legend}{body}</svg>", systems)


def _with_measures(svg: str, systems: Systems) -> str:
    """Return a drawing with its measures in all systems of units."""

    def spans(match: re.Match[str]) -> str:
        texts = {units.name: units.rendered(match[0], "\N{NO-BREAK SPACE}") for units in systems}
        if len(set(texts.values())) == 1:
            return texts[systems[0].name]
        return "".join(f'<tspan class="{name}">{text}</tspan>' for name, text in texts.items())

    return MEASURE.sub(spans, svg)


def draw_legend(name: str, caption: str, marks: Sequence[Mark], group: str = "") -> Chart:
    """Draw the keys of marks as one legend of several charts."""
    bare = Axis(named=())
    return Chart(name, caption, (Plot(tuple(marks), bare, 0.0, has_grid=False),), bare, group, PART)


def _foot(x: Axis) -> float:
    """Return the room below the last plot."""
    rows = max((text.count("\n") for _, text in x.named or ()), default=0)
    return BARE + (FOOT - BARE - ROW) * (x.named != ()) + ROW * (bool(x.label) + rows)


def _legend(plot: Plot, width: float) -> tuple[str, float]:
    """Return the legend of a plot and its height."""
    labelled_marks = {mark.label: mark for mark in plot.marks if mark.label and mark.key()}
    if not (labelled_marks and plot.has_legend):
        return "", 0.0
    across, row, keys = 0.0, 0, []
    for label, mark in labelled_marks.items():
        is_shown = not isinstance(mark, Line) or mark.is_shown
        wide = marks.KEY + 6.0 + marks.text_width(label, SMALL)
        if across and across + wide > width and is_shown:
            across, row = 0.0, row + 1
        text = marks.words(label, marks.KEY + 5.0, 9.0, size=SMALL)
        place = f'transform="translate({across:.1f} {row * ROW + 2.0:.1f})"'
        hidden = "" if is_shown else ' style="display:none"'
        key = f'<g class="key" {marks.labelled(label)}data-width="{wide:.1f}" {place}{hidden}>'
        keys.append(key + mark.key() + marks.coloured(text, "ink") + "</g>")
        across += (wide + GAP) * is_shown
    return "".join(keys), (row + 1) * ROW + 2.0


def _x_axis(axis: Axis, frames: Sequence[Frame], units: Units) -> str:
    """Return ticks and label below the last plot."""
    last = frames[-1]
    label, scale = axis.in_units(last.x, units)
    ticks = axis.ticks(last.x, 58.0 if axis.named is None else 1.0, units)
    down = last.y.start + 15.0
    texts = [
        marks.words(line, place, down + 13.0 * row, "middle", SMALL)
        for place, text in ticks
        for row, line in enumerate(text.split("\n"))
    ]
    notches = "".join(f"M{place:.2f} {last.y.start:.2f}v3" for place, _ in ticks)
    title = marks.words(label, 0.5 * (scale.start + scale.end), last.y.start + _foot(axis) - 5.0, "middle")
    drawn = _stroked(f'<path d="{notches}"', "grey") + _ticks(texts) + marks.coloured(title, "ink")
    return f'<g class="x-axis" {_ends(label, scale)}>{drawn}</g>'
