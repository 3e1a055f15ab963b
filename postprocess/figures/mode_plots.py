"""Pictures of the plate's modes, as SVG text that goes into a page as it is: rest outline, deformed mesh."""

import numpy as np
from numpy.typing import NDArray

from postprocess.figures.style import FE, Curve, drawn, style

Floats = NDArray[np.float64]
Integers = NDArray[np.integer]

AMPLITUDE = 0.3
"""Largest displacement as drawn, over the plate's width."""

MAX_EDGES = 3000
"""A finer mesh is drawn by its outline alone: the page stays small."""

REST, MESH = "#9aa3ad", "#8fb0d3"
WIDTH = 4.4


def draw_mode(name: str, caption: str, positions: Floats, cells: Integers, shape: Floats) -> Curve:
    """One mode: positions [m] and displacements of largest length one, shape (nodes, 2); cells (elements, corners)."""
    from matplotlib.figure import Figure
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    edges, outline = mesh_edges(cells)
    size = np.ptp(positions, axis=0)
    reach = AMPLITUDE * size.min()
    deformed = positions + reach * shape
    margin = 1.1 * reach
    low, high = positions.min(axis=0) - margin, positions.max(axis=0) + margin
    with style():
        figure = Figure(figsize=(WIDTH, WIDTH * (high - low)[1] / (high - low)[0]))
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        axes.set_axis_off()
        axes.set_xlim(low[0], high[0])
        axes.set_ylim(low[1], high[1])
        lines = [(positions[outline], REST, 0.9), (deformed[outline], FE, 1.6)]
        if len(edges) <= MAX_EDGES:
            lines.insert(1, (deformed[edges], MESH, 0.6))
        for segments, colour, width in lines:
            codes = np.tile((Path.MOVETO, Path.LINETO), len(segments))
            path = Path(segments.reshape(-1, 2), codes)
            axes.add_patch(PathPatch(path, fill=False, edgecolor=colour, linewidth=width, capstyle="round"))
        return drawn(figure, name, caption, "Shapes")


def mesh_edges(cells: Integers) -> tuple[Integers, Integers]:
    """Edges inside the mesh and on its outline, as pairs of nodes: shape (edges, 2) each."""
    pairs = np.concatenate(
        [np.stack([cells[:, i], np.roll(cells, -1, 1)[:, i]], 1) for i in range(cells.shape[1])]
    )
    edges, times = np.unique(np.sort(pairs, axis=1), axis=0, return_counts=True)
    return edges[times > 1], edges[times == 1]
