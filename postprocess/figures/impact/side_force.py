"""Contact force along the vehicle's side over time, as cells."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from postprocess.figures.impact.forces import START, WIDE
from postprocess.figures.impact.strikes import StrikeMark, shaded
from postprocess.svg.chart import Axis, Chart, Plot, draw_chart
from postprocess.svg.drawing import Floats
from postprocess.svg.marks import Boxes, Shades

COLUMNS = 240
"""Columns of cells at most; each is the largest force of its time."""


def draw_side_force(
    t: Floats, distances: Floats, force: Floats, unit: str, strikes: Sequence[StrikeMark] = ()
) -> Chart:
    """Force at each distance from the front and instant, the largest darkest; nothing where there is none.

    t [s], shape (n,), even; distances of the nodes [m], rising from 0, shape (k,); force, shape (n, k), in `unit`, for
    example "kN" of each node or "kN/m".
    """
    caption = "Contact force along the side that faces the wall, over time"
    edges = np.concatenate([distances[:1], 0.5 * (distances[1:] + distances[:-1]), distances[-1:]])
    starts = np.unique(np.linspace(0, t.size, min(COLUMNS, t.size), endpoint=False).astype(int))
    table, times = np.maximum.reduceat(force, starts, axis=0), np.append(t[starts], t[-1])
    column, row = np.nonzero(table > 0.0)
    pressed, shades = table[column, row], Shades(float(table.max()) or 1.0, 0.0)
    cells = Boxes(
        "force",
        np.stack([times[column], times[column + 1]], axis=-1),
        np.stack([edges[row], edges[row + 1]], axis=-1),
        shades.colours(pressed),
        [f"{value:.4g} {unit}" for value in pressed],
        [f"{time:.4g} s; {place:.4g} m" for time, place in zip(times[column], distances[row], strict=True)],
    )
    x = replace(START, high=float(t[-1]))
    y = Axis("distance from the front [m]", low=float(edges[-1]), high=float(edges[0]))
    plot = Plot((*shades.keys(unit), cells, *shaded(strikes)), y, 200.0, nearest="xy", has_grid=False)
    return draw_chart("side-force", caption, (plot,), x, "Force", WIDE)
