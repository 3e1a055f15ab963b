"""Plots of an uncertainty study, as SVG text that goes into a page as it is: histogram, sensitivity."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from postprocess.figures.curves import FE, RIGID, Curve
from postprocess.figures.style import style, svg_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

SIZE = (5.2, 3.3)
LIGHT, DARK, MARK = "#a9c3dd", FE, "#5b6570"


@dataclass(frozen=True)
class Histogram:
    """Counts between edges (one more of these) [N], the marked percentiles and the scene's own value [N]."""

    edges: Floats
    counts: Floats
    percentiles: tuple[tuple[int, float], ...]
    scene_value: float


@dataclass(frozen=True)
class Sensitivity:
    """Indices of the named inputs, shape (inputs,), and the ends of their intervals, shape (2, inputs)."""

    names: Sequence[str]
    first: Floats
    total: Floats
    first_interval: Floats
    total_interval: Floats


def draw_histogram(histogram: Histogram) -> Curve:
    """The distribution of the peak force, in kN, with its percentiles and the scene's own value."""
    caption = "Peak force of the combinations: share of them in each bar"
    with style("histogram"):
        figure, axes = _axes(0.13, 0.16, 0.84, 0.74)
        share = 100.0 * histogram.counts / histogram.counts.sum()
        axes.stairs(share, histogram.edges / 1e3, fill=True, color=LIGHT)
        axes.margins(x=0.0)
        top = 1.12 * float(share.max())
        axes.set_ylim(0.0, top)
        for percent, force in histogram.percentiles:
            axes.axvline(force / 1e3, color=DARK, linewidth=1.0, linestyle="--")
            axes.annotate(
                f"{percent} %", (force / 1e3, top), (3, -10), textcoords="offset points", color=DARK
            )
        axes.axvline(histogram.scene_value / 1e3, color=RIGID, linewidth=1.8)
        figure.text(0.13, 0.935, "━ the scene's own values", color=RIGID, fontweight="bold")
        axes.set_xlabel("peak force [kN]")
        axes.set_ylabel("share [%]")
        return Curve("histogram", "Distribution", caption, svg_text(figure, "histogram", caption))


def draw_sensitivity(sensitivity: Sensitivity) -> Curve:
    """Bars of the first-order and total indices, the first input on top, with their intervals."""
    caption = "Share of the variance of the peak force that comes from each input, and its 95 % interval"
    with style("sensitivity"):
        figure, axes = _axes(0.27, 0.16, 0.69, 0.74)
        places = np.arange(len(sensitivity.names))[::-1]
        bars = (
            (sensitivity.first, sensitivity.first_interval, 0.19, DARK),
            (sensitivity.total, sensitivity.total_interval, -0.19, LIGHT),
        )
        for values, interval, shift, colour in bars:
            axes.barh(places + shift, values, height=0.36, color=colour)
            axes.hlines(places + shift, *interval, color=MARK, linewidth=1.4)
        axes.set_yticks(places, sensitivity.names)
        axes.set_xlim(left=min(0.0, float(sensitivity.first_interval.min())))
        axes.grid(axis="y", visible=False)
        axes.set_xlabel("Sobol index")
        figure.text(0.27, 0.935, "━ alone", color=DARK, fontweight="bold")
        figure.text(0.43, 0.935, "━ with interactions", color="#6f95bb", fontweight="bold")
        return Curve("sensitivity", "Sensitivity", caption, svg_text(figure, "sensitivity", caption))


def _axes(left: float, low: float, width: float, height: float) -> tuple["Figure", "Axes"]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=SIZE)
    axes = figure.add_axes((left, low, width, height))
    axes.tick_params(length=2.5)
    return figure, axes
