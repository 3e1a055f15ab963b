"""Work-precision diagrams as SVG text: error against run time on logarithmic axes, a colour and mark a group."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from postprocess.curves import Curve
from postprocess.figures import style, svg_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SIZE = (7.4, 4.9)
BAND = "#c9ced4"
MARKS = "oosDv^<>pPX*hd8sov"
COLOURS = (
    *("#1b1f24", "#dd8a1d", "#2a9d63", "#e2574c", "#8d6bb5", "#17a2b8", "#14467c", "#d6459b", "#5b6570"),
    *("#7fb800", "#0072bd", "#a2142f", "#4dbeee", "#edb120", "#77ac30", "#b07aa1", "#8c6d31", "#9c755f"),
)

Points = Sequence[tuple[float, float, float]]


@dataclass(frozen=True)
class Diagram:
    """Each group's points (time [s], median time [s], error), joined in their order, and the Pareto front's.

    order: names of all groups there are, so that a group has its colour and mark in every diagram.
    """

    name: str
    groups: Mapping[str, Points]
    front: Sequence[tuple[float, float]]
    order: Sequence[str]
    time_label: str
    error_label: str


def draw_precision(diagram: Diagram) -> Curve:
    """The diagram; a thin line reaches from each point, the fastest time, to the median."""
    from matplotlib.figure import Figure

    caption = f"{diagram.error_label} over {diagram.time_label}: the fastest of several, thin lines reach to the median"
    with style(diagram.name):
        figure = Figure(figsize=SIZE)
        axes = figure.add_axes((0.1, 0.11, 0.64, 0.86))
        axes.set_xscale("log")
        axes.set_yscale("log")
        _draw_front(axes, diagram.front)
        for group, points in diagram.groups.items():
            _draw_group(axes, group, points, diagram.order.index(group))
        axes.margins(x=0.06, y=0.05)
        axes.set_xlabel(f"{diagram.time_label} [s]")
        axes.set_ylabel(diagram.error_label)
        axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), fontsize=8, frameon=False)
        return Curve(diagram.name, "Work and precision", caption, svg_text(figure, diagram.name, caption))


def _draw_front(axes: "Axes", front: Sequence[tuple[float, float]]) -> None:
    if front:
        times, errors = np.array(front).T
        axes.step(times, errors, where="post", color=BAND, linewidth=7, solid_capstyle="round", zorder=1)


def _draw_group(axes: "Axes", group: str, points: Points, number: int) -> None:
    colour, mark = COLOURS[number % len(COLOURS)], MARKS[number % len(MARKS)]
    times, medians, errors = np.array(points).T
    axes.hlines(errors, times, medians, color=colour, linewidth=0.8, alpha=0.6)
    axes.plot(times, errors, color=colour, marker=mark, markersize=4.5, linewidth=0.9, label=group, zorder=3)
