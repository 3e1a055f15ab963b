"""A plot with its scales in place: how much room it takes, and its SVG, from grid to names of levels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from html import escape

import numpy as np

from postprocess.figures.svg.drawing import coloured, text_width, words
from postprocess.figures.svg.marks import Level, found_ranges
from postprocess.figures.svg.plot import SMALL, Axis, Plot
from postprocess.figures.svg.scale import Scale

HEAD, RIGHT, BARE = 23.0, 12.0, 4.0
"""Room above a plot, to the right of the plots, and beside a bare axis."""


@dataclass(frozen=True)
class Frame:
    """A plot with its scales in place, and its ticks."""

    plot: Plot
    x: Scale
    y: Scale
    y_ticks: list[tuple[float, str]]


def framed(plots: Sequence[Plot], x: Axis, width: float, top: float) -> list[Frame]:
    """The plots one below the other, from `top` on, over one x axis."""
    ranges = [found_ranges(plot.marks) for plot in plots]
    scales = [plot.y.scale(y) for plot, (_, y) in zip(plots, ranges, strict=True)]
    along = x.scale((min(a for (a, _), _ in ranges), max(b for (_, b), _ in ranges)))
    sized = [
        replace(scale, start=200.0 if plot.height is None else plot.height, end=0.0)
        for scale, plot in zip(scales, plots, strict=True)
    ]
    ticks = [plot.y.ticks(scale, 26.0) for plot, scale in zip(plots, sized, strict=True)]
    left = 8.0 + max(text_width(text, SMALL) for each in ticks for _, text in each or [(0, "")])
    beside = [
        text_width(line, 10.0)
        for plot in plots
        for level in _levels(plot)
        for line in _level_lines(plot, level)
    ]
    along = replace(along, start=left, end=width - max([RIGHT, *(8.0 + long for long in beside)]))
    frames = []
    for plot, scale, marked in zip(plots, sized, ticks, strict=True):
        height = _equal_height(along, scale) if plot.height is None else plot.height
        top += HEAD if plot.y.label else BARE
        frames.append(Frame(plot, along, replace(scale, start=top + height, end=top), marked))
        top += height
    return frames


def _equal_height(x: Scale, y: Scale) -> float:
    return (x.end - x.start) * abs((y.high - y.low) / (x.high - x.low))


def drawn(frame: Frame) -> str:
    """Grid, marks, box and y axis."""
    x, y, plot = frame.x, frame.y, frame.plot
    width, height = x.end - x.start, y.start - y.end
    box = f'x="{x.start:.2f}" y="{y.end:.2f}" width="{width:.2f}" height="{height:.2f}" fill="none"'
    near = f' data-nearest="{plot.nearest}" data-y="{escape(plot.y.label)}"'
    kind = f' data-log="{int(x.is_log)}"'
    edges = (
        f'data-box="{x.start:.2f} {y.end:.2f} {x.end:.2f} {y.start:.2f}" data-x="{x.low:.7g} {x.high:.7g}"'
    )
    return (
        f'<g class="plot" {edges}{kind}{near}>'
        + (_grid(frame) if plot.has_grid else "")
        + "".join(mark.draw(x, y) for mark in plot.marks)
        + (
            coloured(f'<rect {box} stroke="currentColor" stroke-width="0.8"/>', "grey")
            if frame.y_ticks
            else ""
        )
        + _y_axis(frame)
        + _level_names(frame)
        + "</g>"
    )


def _grid(frame: Frame) -> str:
    lines = "".join(
        f"M{frame.x.start:.2f} {frame.y.at(value):.2f}H{frame.x.end:.2f}" for value, _ in frame.y_ticks
    )
    return coloured(f'<path d="{lines}" stroke="currentColor" stroke-width="0.8"/>', "grid")


def _y_axis(frame: Frame) -> str:
    texts = [
        words(text, frame.x.start - 5.0, float(frame.y.at(value)) + 4.0, "end", SMALL)
        for value, text in frame.y_ticks
    ]
    return coloured("".join(texts), "soft") + coloured(
        words(frame.plot.y.label, 0.0, frame.y.end - 7.0), "ink"
    )


def _levels(plot: Plot) -> list[Level]:
    return [mark for mark in plot.marks if isinstance(mark, Level)]


def _level_lines(plot: Plot, level: Level) -> list[str]:
    """Name, if it has one, and value of a level."""
    return [*([level.label] if level.label else []), f"{level.value:.4g} {plot.y.unit}".rstrip()]


def _level_names(frame: Frame) -> str:
    """Names of levels beside the plot, from below, each clear of the one before and none above the plot."""
    lowest, placed = np.inf, []
    for level in sorted(_levels(frame.plot), key=lambda level: level.value):
        lines = _level_lines(frame.plot, level)
        lowest = min(float(frame.y.at(level.value)) + 3.0, lowest - 12.0 * len(lines))
        placed.append((level, lines, lowest))
    lower = max(0.0, frame.y.end + 22.0 - lowest) if placed else 0.0
    drawn = [
        coloured(
            words(line, frame.x.end + 5.0, at + lower - 11.0 * (len(lines) - 1 - number), size=10.0),
            level.colour,
        )
        for level, lines, at in placed
        for number, line in enumerate(lines)
    ]
    return "".join(drawn)
