"""Force on the wall over time, raw and filtered, with design forces; force over crush of each contact point."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from postprocess.figures.curves import thinned
from postprocess.figures.impact.strikes import StrikeMark, corner_colour, shade_strikes
from postprocess.figures.style import Curve, drawn, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Floats = NDArray[np.float64]

SIZE, PLACE = (7.4, 3.8), (0.085, 0.2, 0.765, 0.735)
LOOP_SIZE, LOOP_PLACE = (4.6, 3.5), (0.145, 0.135, 0.815, 0.795)
LINES: Mapping[str, tuple[str, dict[str, Any]]] = {
    "raw": ("raw", {"color": "#b9c0c8", "linewidth": 2.6}),
    "cfc180": ("CFC 180", {"color": "#2a9d63", "linewidth": 1.0}),
    "cfc60": ("CFC 60", {"color": "#14467c", "linewidth": 1.3}),
    "cutoff_60hz": ("60 Hz cut-off", {"color": "#8d6bb5", "linewidth": 1.3, "dashes": (4.0, 1.5)}),
    "mean_50ms": ("50 ms mean", {"color": "#dd8a1d", "linewidth": 2.0}),
}
"""Label and look of each curve, in the order in which they are drawn."""

LEVEL = "#8a1c3b"


def draw_forces(
    name: str,
    caption: str,
    t: Floats,
    curves: Mapping[str, Floats],
    strikes: Sequence[StrikeMark] = (),
    levels: Mapping[str, float] | None = None,
) -> Curve:
    """Curves of one force by the names of `force_curves`, shape (n,) [N], over t [s]; drawn in kN.

    levels: what a design force is called -> force [N], drawn as a line.
    """
    from matplotlib.figure import Figure

    with style():
        figure = Figure(figsize=SIZE)
        axes = figure.add_axes(PLACE)
        axes.axhline(0.0, color="#8a929b", linewidth=0.8)
        for key, (label, look) in LINES.items():
            if key in curves:
                axes.plot(*thinned(t, curves[key] / 1e3), label=label, **look)
        shade_strikes(axes, strikes)
        _draw_levels(axes, levels or {})
        axes.set(xlabel="t [s]", ylabel="force on the wall [kN]", xlim=(t[0], t[-1]))
        axes.tick_params(length=2.5)
        figure.legend(loc="lower center", ncols=len(LINES), fontsize=8, frameon=False)
        return drawn(figure, name, caption, "Force")


def draw_loops(contacts: Mapping[str, tuple[Floats, Floats]]) -> Curve:
    """Force [N] over crush [m] of each contact point by its name, shape (n,) each; drawn in kN and mm."""
    from matplotlib.figure import Figure

    caption = "Force over crush of each contact point: what a loop encloses is lost"
    with style():
        figure = Figure(figsize=LOOP_SIZE)
        axes = figure.add_axes(LOOP_PLACE)
        for label, (crush, force) in contacts.items():
            axes.plot(crush * 1e3, force / 1e3, color=corner_colour(label), linewidth=1.3, label=label)
        axes.set(xlabel="crush [mm]", ylabel="force [kN]")
        axes.margins(0.04)
        axes.set(xlim=(0.0, None), ylim=(0.0, None))
        axes.tick_params(length=2.5)
        axes.legend(loc="upper left", fontsize=8, frameon=False, labelcolor="linecolor")
        return drawn(figure, "loops", caption, "Force")


def _draw_levels(axes: "Axes", levels: Mapping[str, float]) -> None:
    """Lines across the plot, with names beside it that keep a line's distance from each other."""
    lowest, top = -np.inf, 1.08 * max([axes.dataLim.y1, *(force / 1e3 for force in levels.values())])
    axes.set_ylim(top=top)
    step = 0.1 * (top - axes.get_ylim()[0])
    for label, force in sorted(levels.items(), key=lambda item: item[1]):
        height = force / 1e3
        axes.axhline(height, color=LEVEL, linewidth=1.0, linestyle=(0, (5, 2)), zorder=1.5)
        lowest = max(height, lowest + step)
        place: dict[str, Any] = {"xycoords": ("axes fraction", "data"), "textcoords": "offset points"}
        text = f"{label}\n{height:.0f} kN"
        axes.annotate(text, (1.0, lowest), (4, 0), va="center", fontsize=7.5, color=LEVEL, **place)
