"""Rectangles of triangles with lines at given heights."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from meshes.rectangle import gmsh_model

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


def banded_rectangle(
    length: float,
    heights: Sequence[float],
    breaks: Mapping[float, Sequence[float]],
    size: Callable[[float, float], float],
) -> tuple[Floats, Indices]:
    """Mesh a rectangle by triangles whose edges follow horizontal lines.

    length: along x from the origin [m]; heights: of the lines, first and last those of the sides [m]; breaks: places of
    nodes by height of their line [m]; size: of triangles at a place [m]. Returns nodes (2, n) and triangles (3, t).
    """
    with gmsh_model("bands") as gmsh:
        geometry = gmsh.model.geo
        rows = []
        for y in heights:
            places = sorted({0.0, length, *breaks.get(y, ())})
            points = [geometry.addPoint(x, y, 0.0, size(x, y)) for x in places]
            lines = [geometry.addLine(*pair) for pair in pairwise(points)]
            rows.append((points[0], points[-1], lines))
        ends = pairwise(rows)
        sides = [[geometry.addLine(low[k], high[k]) for k in (0, 1)] for low, high in ends]
        for (start, end), (*_, low), (*_, high) in zip(sides, rows, rows[1:], strict=False):
            loop = geometry.addCurveLoop([*low, end, *(-line for line in reversed(high)), -start])
            geometry.addPlaneSurface([loop])
        geometry.synchronize()
        gmsh.model.mesh.generate(2)
        tags, points, _ = gmsh.model.mesh.getNodes()
        triangles = gmsh.model.mesh.getElementsByType(2)[1]
    number = np.empty(int(tags.max()) + 1, dtype=int)
    number[tags] = np.arange(tags.size)
    nodes = np.ascontiguousarray(points.reshape(-1, 3)[:, :2].T)
    all_lines = {0.0, length}.union(*breaks.values()), set(heights)
    return _on_lines(nodes, length, all_lines), np.ascontiguousarray(
        number[triangles.astype(int)].reshape(-1, 3).T
    )


def _on_lines(nodes: Floats, length: float, lines: tuple[set[float], set[float]]) -> Floats:
    """Return the nodes with those near a line on it."""
    nodes = nodes.copy()
    for row, places in zip(nodes, lines, strict=True):
        for place in places:
            row[np.abs(row - place) < 1e-9 * length] = place
    return nodes
