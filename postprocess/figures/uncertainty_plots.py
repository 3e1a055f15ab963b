"""Plots of an uncertainty study, as SVG text that goes into a page as it is: histogram, sensitivity."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from postprocess.figures.style import FE, RIGID, Curve, drawn, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

SIZE = (5.2, 3.3)
LIGHT, DARK, MARK = "#a9c3dd", FE, "#5b6570"


def draw_histogram(
    edges: Floats, counts: Floats, percentiles: Sequence[tuple[int, float]], scene_value: float
) -> Curve:
    """The distribution of the peak force, in kN: counts between edges [N], percentiles and the scene's own value."""
    caption = "Peak force of the combinations: share of them in each bar"
    with style():
        figure, axes = _axes(0.13, 0.16, 0.84, 0.74)
        share = 100.0 * counts / counts.sum()
        axes.stairs(share, edges / 1e3, fill=True, color=LIGHT)
        axes.margins(x=0.0)
        top = 1.12 * float(share.max())
        axes.set_ylim(0.0, top)
        for percent, force in percentiles:
            axes.axvline(force / 1e3, color=DARK, linewidth=1.0, linestyle="--")
            axes.annotate(
                f"{percent} %", (force / 1e3, top), (3, -10), textcoords="offset points", color=DARK
            )
        axes.axvline(scene_value / 1e3, color=RIGID, linewidth=1.8)
        figure.text(0.13, 0.935, "━ the scene's own values", color=RIGID, fontweight="bold")
        axes.set_xlabel("peak force [kN]")
        axes.set_ylabel("share [%]")
        return drawn(figure, "histogram", caption, "Distribution")


def draw_sensitivity(inputs: Sequence[Any], of: str = "the peak force", name: str = "sensitivity") -> Curve:
    """Bars of the first-order and total indices of inputs, the first on top, with their intervals.

    Each input has `key`, `first_order`, `total`, and their intervals, `first_order_interval` and `total_interval`.
    """
    caption = f"Share of the variance of {of} that comes from each input, and its 95 % interval"
    with style():
        figure, axes = _axes(0.27, 0.16, 0.69, 0.74)
        places = np.arange(len(inputs))[::-1]
        bars = (("first_order", 0.19, DARK), ("total", -0.19, LIGHT))
        for name, shift, colour in bars:
            values = [getattr(item, name) for item in inputs]
            interval = np.transpose([getattr(item, f"{name}_interval") for item in inputs])
            axes.barh(places + shift, values, height=0.36, color=colour)
            axes.hlines(places + shift, *interval, color=MARK, linewidth=1.4)
        axes.set_yticks(places, [item.key for item in inputs])
        axes.set_xlim(left=min(0.0, *(item.first_order_interval[0] for item in inputs)))
        axes.grid(axis="y", visible=False)
        axes.set_xlabel("Sobol index")
        figure.text(0.27, 0.935, "━ alone", color=DARK, fontweight="bold")
        figure.text(0.43, 0.935, "━ with interactions", color="#6f95bb", fontweight="bold")
        return drawn(figure, name, caption, "Sensitivity")


def _axes(left: float, low: float, width: float, height: float) -> tuple["Figure", "Axes"]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=SIZE)
    axes = figure.add_axes((left, low, width, height))
    axes.tick_params(length=2.5)
    return figure, axes
