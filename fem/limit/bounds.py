"""Bounds of the collapse load with adaptive meshes.

The difference of both bounds on a mesh is the sum of the gaps of its triangles, after Ciria, Peraire and Bonet (2008).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from fem.limit.lower import LowerBound, lower_bound
from fem.limit.plate import Floats, Indices, PlasticPlate
from fem.limit.upper import UpperBound, gaps, upper_bound

if TYPE_CHECKING:
    from skfem import MeshTri

__all__ = ["Bounds", "collapse_load"]

LEAST, MOST, REACH = 0.3, 0.85, 2.4
"""Part of the sum of the gaps whose triangles are refined, and that of the excess over the tolerance [-]."""


class Bounds(NamedTuple):
    """Proven bounds of the collapse load.

    Attributes
    ----------
    lower : LowerBound
        The largest one, and the mesh of its moments.
    upper : UpperBound
        The least one, and the mesh of its mechanism.
    """

    lower: LowerBound
    lower_mesh: MeshTri
    upper: UpperBound
    upper_mesh: MeshTri
    plate: PlasticPlate

    @property
    def width(self) -> float:
        """Difference of the bounds over the lower one, infinite without it [-]."""
        return self.upper.value / self.lower.value - 1.0 if self.lower.value > 0.0 else np.inf


def collapse_load(
    plate: PlasticPlate,
    nodes: Floats,
    triangles: Indices,
    tolerance: float,
    most: int,
    widest: float = np.inf,
) -> Bounds:
    """Compute bounds that are as narrow as a tolerance.

    Parameters
    ----------
    plate : PlasticPlate
        With its strengths and its load.
    nodes, triangles : ndarray, shape (2, n), (3, t)
        First mesh, with lines at the levels of the strengths and at the load [m].
    tolerance : float
        Largest difference over the lower bound [-].
    most : int
        Number of triangles from which on no mesh is refined.
    widest : float
        Difference on the first mesh from which on it is not refined either [-].

    Returns
    -------
    Bounds
        Wider than the tolerance where the last mesh has more triangles.

    References
    ----------
    .. [1] Ciria, Peraire and Bonet, International Journal for Numerical Methods in Engineering 75 (2008), 882-913.
    """
    from skfem import MeshTri

    mesh = MeshTri(nodes, triangles)
    lower, upper = lower_bound(plate, mesh), upper_bound(plate, mesh)
    bounds = Bounds(lower, mesh, upper, mesh, plate)
    if bounds.width >= widest:
        return bounds
    while bounds.width > tolerance and mesh.t.shape[1] < most:
        parts = gaps(mesh, upper, lower.moments)
        order = np.argsort(-parts)
        part = np.clip(REACH * (1.0 - tolerance / bounds.width), LEAST, MOST)
        mesh = mesh.refined(order[: np.searchsorted(np.cumsum(parts[order]), part * parts.sum()) + 1])
        upper = upper_bound(plate, mesh)
        if upper.value < bounds.upper.value:
            bounds = bounds._replace(upper=upper, upper_mesh=mesh)
        if bounds.width > tolerance:
            lower = lower_bound(plate, mesh)
            if lower.value > bounds.lower.value:
                bounds = bounds._replace(lower=lower, lower_mesh=mesh)
    return bounds
