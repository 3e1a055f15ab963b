"""Rectangular plate of rigid-plastic material with its mesh geometry.

Johansen's criterion bounds the moments per length m by the strengths M+ and M- about both axes: M+ - m and M- + m are
positive semidefinite. Moments are positive where the curvature of a deflection towards the reader is positive: a wall
pushed at its top has positive moments at its base, with tension on the loaded face.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from skfem import MeshTri

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

__all__ = ["PlasticPlate"]

HELD = ("clamped", "supported")
"""Kinds of sides without deflection."""

LOCAL_EDGES = ((0, 1), (1, 2), (0, 2))
"""Ends of the edges of a triangle, in the order of `MeshTri.t2f`; nodes ascend in both, so that directions agree."""


@dataclass(frozen=True)
class PlasticPlate:
    """Rectangular plate with supports, strengths and load.

    Parameters
    ----------
    length, height : float
        Sides along x and y, from the origin [m].
    sides : dict of str to str
        Kind of the sides "left", "right", "bottom", "top": "clamped", "supported", "free", "symmetric" (an axis of
        symmetry) or "cut" (the plate goes on: free for the lower bound, clamped for the upper one).
    levels : ndarray, shape (k,)
        Heights y between which strengths are linear, lines of the mesh [m].
    strengths : ndarray, shape (4, k)
        M_xx+, M_xx-, M_yy+, M_yy- at the levels, positive [N m/m].
    line : tuple of float, optional
        Height, start and end of a line load whose total force is the unit [m].
    pressure : float
        Pressure over the plate per unit of the load factor [1/m^2].
    point : tuple of float, optional
        Place of a unit point load, a node of the mesh [m].
    beam : float
        Strength of a beam along the top side [N m].
    """

    length: float
    height: float
    sides: dict[str, str]
    levels: Floats
    strengths: Floats
    line: tuple[float, float, float] | None = None
    pressure: float = 0.0
    point: tuple[float, float] | None = None
    beam: float = 0.0

    @property
    def scale(self) -> float:
        """Largest strength, the unit of moments [N m/m]."""
        return float(max(self.strengths.max(), self.beam))

    def strengths_at(self, y: Floats) -> Floats:
        """Return the strengths at heights over the scale, shape (4, ...)."""
        return np.stack([np.interp(y, self.levels, row) for row in self.strengths]) / self.scale

    def kinds(self, mesh: MeshTri) -> NDArray[np.str_]:
        """Return the kind of each edge, "inner" within the plate."""
        x, y = middles(mesh)
        kinds = np.full(x.size, "inner", dtype="<U9")
        masks = {"left": x == 0.0, "right": x == self.length, "bottom": y == 0.0, "top": y == self.height}
        for side, mask in masks.items():
            kinds[mask] = self.sides[side]
        return kinds

    def line_forces(self, mesh: MeshTri) -> Floats:
        """Return the line load of each edge [1/m]."""
        x, y = middles(mesh)
        if self.line is None:
            return np.zeros(x.size)
        height, start, end = self.line
        along = mesh.p[1, mesh.facets].min(axis=0) == mesh.p[1, mesh.facets].max(axis=0)
        return np.where((y == height) & (x > start) & (x < end) & along, 1.0 / (end - start), 0.0)

    def loaded_node(self, mesh: MeshTri) -> int:
        """Return the node of the point load, or -1."""
        if self.point is None:
            return -1
        return int(np.argmin(np.hypot(*(mesh.p - np.array(self.point)[:, None]))))

    def top_edges(self, mesh: MeshTri) -> Indices:
        """Return the edges of the top side from left to right."""
        x, y = middles(mesh)
        top = np.flatnonzero(y == self.height)
        return top[np.argsort(x[top])]


class Geometry(NamedTuple):
    """Geometry of the triangles and of their three edges.

    areas (t,) [m^2]; gradients of the barycentric coordinates (3, 2, t) [1/m]; of each edge of a triangle, from its
    first to its second node in LOCAL_EDGES: tangents and outward normals (3, 2, t).
    """

    areas: Floats
    gradients: Floats
    tangents: Floats
    normals: Floats


def middles(mesh: MeshTri) -> Floats:
    """Return the middles of the edges, shape (2, edges) [m]."""
    return np.asarray(mesh.p[:, mesh.facets].mean(axis=1))


def lengths(mesh: MeshTri) -> Floats:
    """Return the lengths of the edges [m]."""
    ends = mesh.p[:, mesh.facets]
    return np.asarray(np.hypot(*(ends[:, 1] - ends[:, 0])))


def geometry(mesh: MeshTri) -> Geometry:
    """Return the geometry of a mesh."""
    corners = mesh.p[:, mesh.t].transpose(1, 0, 2)
    (x1, y1), (x2, y2) = corners[1] - corners[0], corners[2] - corners[0]
    doubled = x1 * y2 - y1 * x2
    of_1, of_2 = np.stack([y2, -x2]) / doubled, np.stack([-y1, x1]) / doubled
    gradients = np.stack([-of_1 - of_2, of_1, of_2])
    sides = np.stack([corners[b] - corners[a] for a, b in LOCAL_EDGES])
    tangents = sides / np.hypot(sides[:, 0], sides[:, 1])[:, None]
    outward = -np.stack([gradients[3 - a - b] for a, b in LOCAL_EDGES])
    normals = outward / np.hypot(outward[:, 0], outward[:, 1])[:, None]
    return Geometry(0.5 * np.abs(doubled), gradients, tangents, normals)


def voigt(a: Floats, b: Floats) -> Floats:
    """Return the weights of m_xx, m_yy, m_xy in a.m.b, shape (3, n)."""
    return np.stack([a[0] * b[0], a[1] * b[1], a[0] * b[1] + a[1] * b[0]])
