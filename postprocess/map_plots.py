"""Maps of verdicts over pairs of axes, as SVG text: one small picture a pair, a colour a verdict."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from postprocess.curves import Curve
from postprocess.figures import style, svg_text

SIZE = (2.55, 2.35)
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
    """Label of an axis and the values along it."""

    label: str
    values: Sequence[float]


def draw_map(
    name: str, across: MapAxis, up: MapAxis, verdicts: Sequence[Sequence[str]], caption: str
) -> Curve:
    """Cells of equal size, verdicts[row][column]: rows go up, columns across; every second value is written."""
    from matplotlib.colors import ListedColormap
    from matplotlib.figure import Figure

    kinds = list(COLOURS)
    table = np.array([[kinds.index(kind) for kind in row] for row in verdicts])
    with style(name):
        figure = Figure(figsize=SIZE)
        axes = figure.add_axes((0.25, 0.25, 0.72, 0.72))
        colours = ListedColormap(list(COLOURS.values()))
        axes.pcolormesh(
            table, cmap=colours, vmin=-0.5, vmax=len(kinds) - 0.5, edgecolors="white", linewidth=0.4
        )
        for axis, set_ticks in ((across, axes.set_xticks), (up, axes.set_yticks)):
            places = _places(len(axis.values))
            set_ticks([place + 0.5 for place in places], [_short(axis.values[place]) for place in places])
        axes.tick_params(length=0, labelsize=7)
        axes.tick_params(axis="x", rotation=90)
        axes.set_xlabel(across.label, fontsize=8)
        axes.set_ylabel(up.label, fontsize=8)
        axes.grid(visible=False)
        for spine in axes.spines.values():
            spine.set_visible(False)
        return Curve(name, "Maps", caption, svg_text(figure, name, caption))


def _places(count: int) -> list[int]:
    return list(range(0, count, 2 if count > 6 else 1))


def _short(value: float) -> str:
    """Two digits, without the plus and the zeros of an exponent."""
    if value == 0.0 or 1e-2 <= abs(value) < 1e4:
        return f"{value:.2g}" if abs(value) < 10.0 else f"{value:.0f}"
    mantissa, exponent = f"{value:.0e}".split("e")
    return f"{mantissa}e{int(exponent)}"
