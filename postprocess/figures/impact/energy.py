"""What becomes of the kinetic energy, as layers over time."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from postprocess.figures.curves import STRETCHES
from postprocess.figures.impact.strikes import StrikeMark, shade_strikes
from postprocess.figures.style import Curve, drawn, style

Floats = NDArray[np.float64]

SIZE, PLACE = (7.4, 3.5), (0.085, 0.135, 0.7, 0.795)
COLOURS = ("#8a1c3b", "#dd8a1d", "#7c97b4", "#2a9d63", "#8d6bb5", "#5b6570")
GIVEN = "#1b1f24"


def draw_energies(
    t: Floats, kinetic: Floats, parts: Mapping[str, Floats], strikes: Sequence[StrikeMark] = ()
) -> Curve:
    """What the motion gave up, as a line, and below it what it went into, layer upon layer; in kJ.

    t [s], kinetic and each of `parts` [J], shape (n,): crush lost, friction, damping, crush stored, strain and so on,
    the first at the bottom. Where layers and line part, the balance is open.
    """
    from matplotlib.figure import Figure

    caption = "Energy that the motion gave up (line), and what it went into (layers)"
    shown = np.unique(np.linspace(0, t.size - 1, 2 * STRETCHES).astype(int))
    layers = {label: values[shown] / 1e3 for label, values in parts.items() if np.any(values)}
    with style():
        figure = Figure(figsize=SIZE)
        axes = figure.add_axes(PLACE)
        stack = axes.stackplot(
            t[shown], *layers.values(), labels=layers, colors=COLOURS, alpha=0.75, linewidth=0
        )
        (line,) = axes.plot(t[shown], (kinetic[0] - kinetic[shown]) / 1e3, color=GIVEN, linewidth=1.3)
        line.set_label("given up")
        shade_strikes(axes, strikes)
        axes.set(xlabel="t [s]", ylabel="energy [kJ]", xlim=(t[0], t[-1]))
        axes.set_ylim(bottom=min(0.0, axes.dataLim.y0))
        axes.tick_params(length=2.5)
        handles = [line, *reversed(stack)]
        axes.legend(handles=handles, loc="center left", bbox_to_anchor=(1.01, 0.5), fontsize=8, frameon=False)
        return drawn(figure, "energies", caption, "Energy")
