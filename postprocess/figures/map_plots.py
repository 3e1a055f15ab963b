"""Maps of verdicts over pairs of axes, as SVG text: one small picture a pair, a colour a verdict."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from postprocess.figures.map_ticks import places, round_ticks, tick_texts
from postprocess.figures.style import Curve, drawn, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SIZE, PLACE = (2.55, 2.35), (0.25, 0.2, 0.72, 0.77)
COLOURS: Mapping[str, str] = {
    "right": "#3f9c63",
    "flexible": "#4f86c6",
    "refused": "#c9ced4",
    "caught": "#e9a23b",
    "wrong": "#c4161c",
}
"""Colours of the verdicts; all else is an error."""


@dataclass(frozen=True)
class MapAxis:
    """Label of an axis and the values along it: evenly spaced, at even ratios, or 0 and then even ratios."""

    label: str
    values: Sequence[float]


def draw_map(
    name: str, across: MapAxis, up: MapAxis, verdicts: Sequence[Sequence[str]], caption: str
) -> Curve:
    """Cells of equal size, verdicts[row][column]: rows go up, columns across; ticks at round values."""
    from matplotlib.figure import Figure

    with style():
        figure = Figure(figsize=SIZE)
        draw_cells(figure.add_axes(PLACE), across, up, verdicts)
        return drawn(figure, name, caption, "Maps")


def draw_cells(axes: "Axes", across: MapAxis, up: MapAxis, verdicts: Sequence[Sequence[str]]) -> None:
    """The map in these axes."""
    from matplotlib.colors import ListedColormap

    kinds = list(COLOURS)
    table = np.array([[kinds.index(kind) for kind in row] for row in verdicts])
    colours = ListedColormap(list(COLOURS.values()))
    axes.pcolormesh(table, cmap=colours, vmin=-0.5, vmax=len(kinds) - 0.5, edgecolors="white", linewidth=0.4)
    for axis, set_ticks in ((across, axes.set_xticks), (up, axes.set_yticks)):
        ticks = round_ticks(axis.values)
        set_ticks(places(ticks, axis.values), tick_texts(ticks))
    axes.tick_params(length=2.5, labelsize=7)
    axes.set_xlabel(across.label, fontsize=8)
    axes.set_ylabel(up.label, fontsize=8)
    axes.grid(visible=False)
    for spine in axes.spines.values():
        spine.set_visible(False)


def draw_legend(meanings: Mapping[str, str], caption: str) -> Curve:
    """A small figure with the meaning of every colour, the same for all maps."""
    from matplotlib.figure import Figure

    name = "map-legend"
    with style():
        figure = Figure(figsize=SIZE)
        axes = figure.add_axes((0.04, 0.05, 0.92, 0.9))
        write_meanings(axes, meanings, fontsize=8.0)
        return drawn(figure, name, caption, "Maps")


def write_meanings(axes: "Axes", meanings: Mapping[str, str], fontsize: float, columns: int = 1) -> None:
    """A square of each verdict's colour with its name and, below it, its meaning; column by column."""
    from matplotlib.patches import Rectangle

    axes.set_axis_off()
    rows = -(-len(meanings) // columns)
    axes.set(xlim=(0.0, columns), ylim=(-rows, 0.0))
    window = axes.get_window_extent()
    side = 0.5
    wide = side * window.height / rows / (window.width / columns)
    for number, (kind, meaning) in enumerate(meanings.items()):
        x, y = number // rows, -(number % rows) - 0.5
        axes.add_patch(Rectangle((x, y - 0.5 * side), wide, side, facecolor=COLOURS[kind]))
        axes.text(x + 1.35 * wide, y + 0.04, kind, fontsize=fontsize, fontweight="bold", va="bottom")
        axes.text(x + 1.35 * wide, y - 0.04, meaning, fontsize=fontsize - 1.0, va="top")
