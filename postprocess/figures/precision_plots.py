"""Work-precision diagrams as SVG text: error against run time on logarithmic axes, lines named where they end."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import cycle
from typing import TYPE_CHECKING, Any

import numpy as np

from postprocess.contours.labels import Label, write_labels
from postprocess.figures.label_spots import Box, Floats
from postprocess.figures.style import SUPERSCRIPTS, Curve, drawn, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SIZE, PLACE = (7.4, 5.2), (0.1, 0.1, 0.88, 0.83)
FRONT, TEXT, DASHED = "#c3c8cf", "#30363d", (0, (4, 2))
COLOURS = (
    *("#1b1f24", "#b8690f", "#1f7f50", "#c23b32", "#7652a0", "#0e7c8c", "#14467c", "#b53682", "#5b6570"),
    *("#8c6d31", "#3d6fb6", "#a2142f"),
)
MARKS = "o^Ds>vPp<hd*"
MAX_TICKS = 8


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


def draw_precision(diagram: Diagram) -> Curve:
    """The diagram as a figure of its own."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    caption = f"{diagram.title}: {diagram.error_label[0].lower()}{diagram.error_label[1:]} over run time"
    with style():
        figure = Figure(figsize=SIZE)
        FigureCanvasAgg(figure)  # measures the labels
        draw_panel(figure.add_axes(PLACE), diagram)
        return drawn(figure, diagram.name, caption, "Work and precision")


def draw_panel(axes: "Axes", diagram: Diagram) -> None:
    """The diagram in these axes, whose place in the figure must be final."""
    marked = zip(cycle(COLOURS), cycle(MARKS), diagram.series)
    drawn = [(series, colour, mark) for colour, mark, series in marked if len(series.times)]
    for series, colour, mark in drawn:
        _draw_series(axes, series, colour, mark)
    axes.set(xscale="log", yscale="log", xlabel="time to solution [s], set-up included")
    axes.set_ylabel(diagram.error_label)
    axes.set_title(diagram.title, loc="left", fontsize=9.5, fontweight="bold", color=TEXT)
    if not drawn:
        return
    lines = [series.points for series, *_ in drawn]
    _powers_of_ten(axes, np.concatenate(lines), diagram.floor)
    front = _draw_front(axes, diagram.front)
    floor = np.array([(x, diagram.floor) for x in axes.get_xlim()])
    taken = [_legend(axes, diagram), *_draw_floor(axes, diagram)]
    write_labels(axes, [_label(series, colour) for series, colour, _ in drawn], [front, floor, *lines], taken)


def _draw_series(axes: "Axes", series: Series, colour: str, mark: str) -> None:
    (times, errors), passed = series.points.T, np.array(series.passed)
    if series.joined:
        form = DASHED if series.dashed else "-"
        axes.plot(times, errors, color=colour, linewidth=1.2, linestyle=form, zorder=3)
    face = "white" if series.dashed else colour
    axes.plot(times[passed], errors[passed], mark, color=colour, mfc=face, markersize=4.5, zorder=4)
    axes.plot(times[~passed], errors[~passed], "x", color=colour, markersize=6, markeredgewidth=1.5, zorder=4)


def _label(series: Series, colour: str) -> Label:
    """At an end of a line; of marks alone, at the slowest or the quickest."""
    points = series.points if series.joined else series.points[np.argsort(series.times, kind="stable")]
    return Label(series.label, colour, [tuple(points[-1]), tuple(points[0])])


def _draw_front(axes: "Axes", front: Sequence[tuple[float, float]]) -> Floats:
    """Steps from the top of the axes down the front and on to their right edge; returns their corners."""
    if not front:
        return np.zeros((0, 2))
    times, errors = np.array(front).T
    x, y = np.append(times, axes.get_xlim()[1]), np.append(errors, errors[-1])
    axes.step(x, y, where="post", color=FRONT, linewidth=4.0, zorder=1)
    return np.column_stack([np.repeat(x, 2)[1:], np.repeat(y, 2)[:-1]])


def _powers_of_ten(axes: "Axes", points: Floats, floor: float) -> None:
    """Limits with room for the labels, and ticks at powers of ten alone, so many apart that they do not crowd."""
    x, y = np.log10(points).T
    y = np.append(y, math.log10(floor)) if floor > 0.0 else y
    for axis, logs, room in ((axes.xaxis, x, 0.06), (axes.yaxis, y, 0.1)):
        size = max(1.0, float(np.ptp(logs)))
        low, high = float(logs.min()) - room * size, float(logs.max()) + 0.1 * size
        high = max(high, math.ceil(low) + 2.0)  # three ticks at least
        every = max(1, math.ceil((high - low) / MAX_TICKS))
        exponents = [n for n in range(math.ceil(low), math.floor(high) + 1) if n % every == 0]
        texts = [f"10{str(n).translate(SUPERSCRIPTS)}" for n in exponents]
        axis.set_ticks([10.0**n for n in exponents], texts)
        axis.set_ticks([], minor=True)
        axes.set(**{f"{axis.axis_name}lim": (10.0**low, 10.0**high)})


def _legend(axes: "Axes", diagram: Diagram) -> Box:
    """The few things that are no line's name; returns its box in pixels."""
    from matplotlib.lines import Line2D

    mark: dict[str, Any] = {"color": TEXT, "marker": "o", "markersize": 4.5, "linestyle": "none"}
    failed = not all(all(series.passed) for series in diagram.series)
    choices = any(series.dashed for series in diagram.series)
    entries = (
        (diagram.front, diagram.front_label, {"color": FRONT, "linewidth": 4.0}),
        (True, "passed", mark),
        (failed, "failed a check", mark | {"marker": "x", "markersize": 6}),
        (choices, "what one choice adds to its mesh", mark | {"linestyle": DASHED, "mfc": "white"}),
    )
    handles = [Line2D([], [], label=label, **form) for shown, label, form in entries if shown]
    legend = axes.legend(handles=handles, loc="best", fontsize=8, framealpha=1.0, edgecolor="#d7dbe0")
    return Box(*legend.get_window_extent().extents)


def _draw_floor(axes: "Axes", diagram: Diagram) -> list[Box]:
    """A dotted line at what the truth is known to, and its words; the box of these in pixels."""
    if not (math.isfinite(diagram.floor) and diagram.floor > 0.0):
        return []
    axes.axhline(diagram.floor, color=TEXT, linewidth=0.9, linestyle=":", zorder=2)
    beside: dict[str, Any] = {
        "xycoords": ("axes fraction", "data"),
        "textcoords": "offset points",
        "va": "top",
    }
    text = axes.annotate(
        diagram.floor_label, (0.0, diagram.floor), (4, -3), fontsize=7.5, color=TEXT, **beside
    )
    return [Box(*text.get_window_extent().extents)]
