"""A mesh with its inner nodes moved, to show what irregular elements change."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import meshio

SEED = 7


def distorted(mesh: meshio.Mesh, share: float, elements: tuple[int, int]) -> meshio.Mesh:
    """A copy with the nodes inside the plate moved at random, the same way every time.

    Parameters
    ----------
    mesh : meshio.Mesh
        Of `plate_mesh`.
    share : float
        Largest displacement of a node, as a share of an element's length and width [-].
    elements : tuple of int
        Along and across, as the mesh was made with.

    Returns
    -------
    meshio.Mesh
        With the same cells and groups.
    """
    import meshio

    points = mesh.points.copy()
    inner = np.ones(len(points), dtype=bool)
    inner[np.unique(mesh.cells_dict["line"])] = False
    size = np.ptp(points[:, :2], axis=0) / elements
    points[inner, :2] += np.random.default_rng(SEED).uniform(-share, share, (inner.sum(), 2)) * size
    return meshio.Mesh(points, mesh.cells, cell_sets=mesh.cell_sets)
