"""Contact force along the vehicle's side over time, as an image."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from postprocess.figures.impact.strikes import StrikeMark, shade_strikes
from postprocess.figures.style import Curve, drawn, style

Floats = NDArray[np.float64]

SIZE, PLACE, BAR = (7.4, 3.5), (0.085, 0.135, 0.78, 0.795), (0.885, 0.135, 0.018, 0.795)
COLUMNS = 600
"""Columns of the image; each is the largest force of its time."""


def draw_side_force(
    t: Floats, distances: Floats, force: Floats, unit: str, strikes: Sequence[StrikeMark] = ()
) -> Curve:
    """Force at each distance from the front and instant; white where there is none.

    t [s], shape (n,), even; distances of the nodes [m], rising from 0, shape (k,); force, shape (n, k), in `unit`, for
    example "kN" of each node or "kN/m".
    """
    from matplotlib import colormaps
    from matplotlib.figure import Figure

    caption = "Contact force along the side that faces the wall, over time"
    edges = np.concatenate([distances[:1], 0.5 * (distances[1:] + distances[:-1]), distances[-1:]])
    starts = np.unique(np.linspace(0, t.size, min(COLUMNS, t.size), endpoint=False).astype(int))
    table = np.maximum.reduceat(force, starts, axis=0)
    colours = colormaps["viridis_r"].with_extremes(bad=(1.0, 1.0, 1.0, 0.0))
    with style():
        figure = Figure(figsize=SIZE)
        axes, bar = figure.add_axes(PLACE), figure.add_axes(BAR)
        shown = np.ma.masked_less_equal(table.T, 0.0)
        instants = np.append(t[starts], t[-1])
        image = axes.pcolormesh(instants, edges, shown, cmap=colours, vmin=0.0, rasterized=True)
        shade_strikes(axes, strikes)
        axes.set(xlabel="t [s]", ylabel="distance from the front [m]", xlim=(t[0], t[-1]))
        axes.set_ylim(edges[-1], edges[0])
        axes.grid(visible=False)
        figure.colorbar(image, cax=bar).set_label(f"force [{unit}]")
        for each in (axes, bar):
            each.tick_params(length=2.5)
        return drawn(figure, "side-force", caption, "Force")
