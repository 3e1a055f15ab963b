"""Elastic displacements of the free plate: its rigid motions, and the inverse of its stiffness beside them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy.sparse as sp


def rigid_motions(body: np.ndarray) -> np.ndarray:
    """Displacements of two translations and a turn of one radian about the origin, shape (2 nodes, 3).

    body: positions [m], shape (2, nodes). Unknowns are numbered as in the stiffness: all x, then all y.
    """
    nodes = body.shape[1]
    rigid = np.zeros((2 * nodes, 3))
    rigid[:nodes, 0] = rigid[nodes:, 1] = 1.0
    rigid[:nodes, 2], rigid[nodes:, 2] = -body[1], body[0]
    return rigid


def elastic_solver(
    stiffness: Any, masses: np.ndarray, body: np.ndarray
) -> Callable[[np.ndarray], np.ndarray]:
    """Solver of K u = f with u free of mass-weighted rigid motion; f must be in equilibrium.

    stiffness [N/m], shape (2 nodes, 2 nodes); masses [kg], shape (nodes,); body: positions [m], shape (2, nodes).
    Three unknowns are fixed, a node's two and one of the node farthest from it, which carry no force then; the
    matrix left is sparse and definite. The rigid motion is taken out afterwards.
    """
    from scipy.sparse.linalg import splu

    nodes = body.shape[1]
    rigid = rigid_motions(body)
    weighted = rigid * np.tile(masses, 2)[:, None]
    inertia = rigid.T @ weighted
    from_first = np.abs(body - body[:, :1])
    far = int((from_first**2).sum(axis=0).argmax())
    across = int(from_first[:, far].argmin())
    free = np.delete(np.arange(2 * nodes), [0, nodes, across * nodes + far])
    reduced = sp.csc_matrix(stiffness)[free][:, free]
    factor = splu(reduced, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})

    def solve(load: np.ndarray) -> np.ndarray:
        displacement = np.zeros(2 * nodes)
        displacement[free] = factor.solve(load[free])
        motion = np.linalg.solve(inertia, weighted.T @ displacement)
        return np.asarray(displacement - rigid @ motion)

    return solve
