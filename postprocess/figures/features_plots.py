"""Bars of a study of features as inline SVG: what each part adds to the time loop."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from postprocess.figures.style import FE, Curve, drawn, style
from postprocess.figures.uncertainty_plots import MARK

WIDTH, ROOM, BAR = 9.6, 0.75, 0.27
"""Inches: the picture's width, the room above and below the bars, the height of a bar's line."""


@dataclass(frozen=True)
class Bar:
    """Time of a loop over that of the loop without the part, and the ends of its interval."""

    name: str
    ratio: float
    low: float
    high: float


def draw_ratios(bars: Sequence[Bar]) -> Curve:
    """A bar from 1 to each ratio, on a logarithmic axis, the first on top; intervals as lines."""
    from matplotlib.figure import Figure
    from matplotlib.ticker import FuncFormatter, NullFormatter

    caption = "Time of a step with the part over that without it, and its 95 % interval; 1 is no cost"
    with style():
        height = ROOM + BAR * len(bars)
        figure = Figure(figsize=(WIDTH, height))
        axes = figure.add_axes((0.2, 0.5 / height, 0.7, 1.0 - ROOM / height))
        places = np.arange(len(bars))[::-1]
        ratios = np.array([bar.ratio for bar in bars])
        axes.barh(places, ratios - 1.0, left=1.0, height=0.6, color=FE)
        axes.hlines(places, [bar.low for bar in bars], [bar.high for bar in bars], color=MARK, linewidth=2.2)
        axes.axvline(1.0, color=MARK, linewidth=1.0)
        axes.set_xscale("log")
        low, high = min(0.9, *(bar.low for bar in bars)), max(1.2, *(bar.high for bar in bars))
        axes.set_xlim(0.95 * low, 1.08 * high)
        ticks = [
            x for x in (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500) if 0.95 * low <= x <= 1.08 * high
        ]
        axes.set_xticks(ticks)
        axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.set_yticks(places, [bar.name for bar in bars])
        axes.tick_params(length=2.5)
        axes.grid(axis="y", visible=False)
        for place, bar in zip(places, bars, strict=True):
            axes.annotate(
                f"{bar.ratio:.3f}" if bar.ratio < 2 else f"{bar.ratio:.3g}",
                (1.0, place),
                (8, 0),
                xycoords=("axes fraction", "data"),
                textcoords="offset points",
                va="center",
            )
        axes.set_xlabel("times the loop without the part")
        return drawn(figure, "features", caption, "What each part adds to a step")
