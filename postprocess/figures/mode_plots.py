"""The plate's modes: outline at rest, deformed mesh."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from postprocess.svg.chart import Axis, Chart, Plot, draw_chart
from postprocess.svg.drawing import Floats
from postprocess.svg.marks import Line

Integers = NDArray[np.integer]

AMPLITUDE = 0.3
"""Largest displacement as drawn, over the plate's width."""

MAX_EDGES = 3000
"""A finer mesh is drawn by its outline alone: the page stays small."""


def draw_mode(name: str, caption: str, positions: Floats, cells: Integers, shape: Floats) -> Chart:
    """One mode: positions [m] and displacements of largest length one, shape (nodes, 2); cells (elements, corners).
    Pages show the length of the displacement on the outline."""
    edges, outline = mesh_edges(cells)
    reach = AMPLITUDE * np.ptp(positions, axis=0).min()
    deformed, sizes = positions + reach * shape, np.linalg.norm(shape, axis=1)
    nodes = np.unique(outline)
    marks = (
        _segments(positions, outline, "grey", 0.9),
        *([_segments(deformed, edges, "steel", 0.6)] if len(edges) <= MAX_EDGES else []),
        _segments(deformed, outline, "fe", 1.6),
        Line(
            "displacement",
            deformed[nodes, 0],
            deformed[nodes, 1],
            width=0.0,
            values=sizes[nodes].tolist(),
            at=[f"{x:.3g} m; {y:.3g} m" for x, y in positions[nodes]],
        ),
    )
    (left, low), (right, high) = positions.min(axis=0) - 1.1 * reach, positions.max(axis=0) + 1.1 * reach
    x, y = Axis(low=left, high=right, named=()), Axis(low=low, high=high, named=())
    plot = Plot(marks, y, None, nearest="xy", has_grid=False, has_legend=False)
    return draw_chart(name, caption, (plot,), x, "Shapes", 400.0)


def _segments(places: Floats, pairs: Integers, colour: str, width: float) -> Line:
    """Straight lines between pairs of places."""
    ends = np.pad(places[pairs], ((0, 0), (0, 1), (0, 0)), constant_values=np.nan)
    return Line("", ends[..., 0].ravel(), ends[..., 1].ravel(), colour, width)


def mesh_edges(cells: Integers) -> tuple[Integers, Integers]:
    """Edges inside the mesh and on its outline, as pairs of nodes: shape (edges, 2) each."""
    pairs = np.concatenate(
        [np.stack([cells[:, i], np.roll(cells, -1, 1)[:, i]], 1) for i in range(cells.shape[1])]
    )
    edges, times = np.unique(np.sort(pairs, axis=1), axis=0, return_counts=True)
    return edges[times > 1], edges[times == 1]
