"""Bars of a study of features as inline SVG: what each part adds to the time loop."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from postprocess.figures.style import FE, Curve, drawn, style
from postprocess.figures.uncertainty_plots import MARK

WIDTH, MARGIN, BAR = 9.6, 0.75, 0.27
"""Inches: the picture's width, the space above and below the bars, the height of a bar's line."""


def draw_ratios(ratios: Mapping[str, Any]) -> Curve:
    """A bar from 1 to each ratio, on a logarithmic axis, the largest on top; a line from its `low` to its `high`.

    ratios: by name, time of a loop over that of the loop without the part, with attributes median, low, high.
    """
    from matplotlib.figure import Figure
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    caption = "Time of a step with the part over that without it, and its 95 % interval; 1 is no cost"
    names = sorted(ratios, key=lambda name: -ratios[name].median)
    bars, places = [ratios[name] for name in names], np.arange(len(ratios))[::-1]
    lows, high = [bar.low for bar in bars], max(1.2, *(bar.high for bar in bars))
    with style():
        height = MARGIN + BAR * len(ratios)
        figure = Figure(figsize=(WIDTH, height))
        axes = figure.add_axes((0.2, 0.5 / height, 0.7, 1.0 - MARGIN / height))
        axes.barh(places, [bar.median - 1.0 for bar in bars], left=1.0, height=0.6, color=FE)
        axes.hlines(places, lows, [bar.high for bar in bars], color=MARK, linewidth=2.2)
        axes.axvline(1.0, color=MARK, linewidth=1.0)
        axes.set_xscale("log")
        axes.set_xlim(0.95 * min(0.9, *lows), 1.08 * high)
        axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.set_yticks(places, names)
        axes.tick_params(length=2.5)
        axes.grid(axis="y", visible=False)
        for place, bar in zip(places, bars, strict=True):
            axes.annotate(
                f"{bar.median:.3f}" if bar.median < 2 else f"{bar.median:.3g}",
                (1.0, place),
                (8, 0),
                xycoords=("axes fraction", "data"),
                textcoords="offset points",
                va="center",
            )
        axes.set_xlabel("times the loop without the part")
        return drawn(figure, "features", caption)
