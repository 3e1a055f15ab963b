"""Elastic displacements of the free plate: its rigid motions, and the inverse of its stiffness beside them."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.sparse as sp

if TYPE_CHECKING:
    from fem.start.multigrid import Multigrid

Solve = Callable[[np.ndarray], np.ndarray]

LARGE = 40_000
"""Unknowns from which on a few loads are solved faster by multigrid than by a factorisation, its import included."""

KEPT = 4
"""Solutions that are kept: statics and the start ask for the same load."""


def rigid_motions(body: np.ndarray) -> np.ndarray:
    """Displacements of two translations and a turn of one radian about the origin, shape (2 nodes, 3).

    body: positions [m], shape (2, nodes). Unknowns are numbered as in the stiffness: all x, then all y.
    """
    nodes = body.shape[1]
    rigid = np.zeros((2 * nodes, 3))
    rigid[:nodes, 0] = rigid[nodes:, 1] = 1.0
    rigid[:nodes, 2], rigid[nodes:, 2] = -body[1], body[0]
    return rigid


class Inverse:
    """Solver of K u = f for a few loads in equilibrium, with u free of mass-weighted rigid motion.

    Nothing is computed before the first load; the last solutions are kept. Above LARGE unknowns it iterates
    (`fem.start.multigrid`), and where that does not converge, as below, it factorises.

    Parameters
    ----------
    stiffness : sparse matrix, shape (2 nodes, 2 nodes)
        [N/m].
    masses : ndarray, shape (nodes,)
        [kg].
    positions : ndarray, shape (2, nodes)
        [m].
    """

    def __init__(self, stiffness: Any, masses: np.ndarray, positions: np.ndarray) -> None:
        self.stiffness, self.masses, self.positions = stiffness, masses, positions
        self._solutions: dict[bytes, np.ndarray] = {}

    def __call__(self, load: np.ndarray) -> np.ndarray:
        """Displacement [m], shape (2 nodes,), under the load [N]."""
        key = hashlib.blake2b(load.tobytes()).digest()
        if key not in self._solutions:
            if len(self._solutions) == KEPT:
                self._solutions.pop(next(iter(self._solutions)))
            self._solutions[key] = self._solved(load)
        return self._solutions[key].copy()

    def _solved(self, load: np.ndarray) -> np.ndarray:
        if not self.is_large:
            return self.factorised(load)
        from fem.start.multigrid import NotConvergedError

        try:
            return without_rigid_motion(self.multigrid.solve(load), self.masses, self.positions)
        except NotConvergedError:
            return self.factorised(load)

    @property
    def is_large(self) -> bool:
        """Whether it iterates."""
        return 2 * self.masses.size >= LARGE

    @cached_property
    def factorised(self) -> Solve:
        """The same by a factorisation, for many loads."""
        return elastic_solver(self.stiffness, self.masses, self.positions)

    @cached_property
    def multigrid(self) -> Multigrid:
        """The iteration."""
        from fem.start.multigrid import Multigrid

        return Multigrid(self.stiffness, rigid_motions(self.positions - self.positions.mean(axis=1)[:, None]))


@dataclass(frozen=True)
class ElasticSolver:
    """The same of a plate whose stiffness is that of `inverse` times the modulus [Pa]."""

    inverse: Inverse
    modulus: float

    def __call__(self, load: np.ndarray) -> np.ndarray:
        """Displacement [m], shape (2 nodes,), under the load [N]."""
        return self.inverse(load) / self.modulus


def without_rigid_motion(displacement: np.ndarray, masses: np.ndarray, body: np.ndarray) -> np.ndarray:
    """The displacement [m], shape (2 nodes,), less the rigid motion that fits it best in the mass-weighted sense."""
    rigid = rigid_motions(body)
    weighted = rigid * np.tile(masses, 2)[:, None]
    motion = np.linalg.solve(rigid.T @ weighted, weighted.T @ displacement)
    return np.asarray(displacement - rigid @ motion)


def elastic_solver(stiffness: Any, masses: np.ndarray, body: np.ndarray) -> Solve:
    """Solver of K u = f by a factorisation, with u free of mass-weighted rigid motion; f must be in equilibrium.

    stiffness [N/m], shape (2 nodes, 2 nodes); masses [kg], shape (nodes,); body: positions [m], shape (2, nodes).
    Three unknowns are fixed, a node's two and one of the node farthest from it, which carry no force then; the
    matrix left is sparse and definite. The rigid motion is taken out afterwards.
    """
    from scipy.sparse.linalg import splu

    nodes = body.shape[1]
    from_first = np.abs(body - body[:, :1])
    far = int((from_first**2).sum(axis=0).argmax())
    across = int(from_first[:, far].argmin())
    free = np.delete(np.arange(2 * nodes), [0, nodes, across * nodes + far])
    reduced = sp.csc_matrix(stiffness)[free][:, free]
    factor = splu(reduced, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})

    def solve(load: np.ndarray) -> np.ndarray:
        displacement = np.zeros(2 * nodes)
        displacement[free] = factor.solve(load[free])
        return without_rigid_motion(displacement, masses, body)

    return solve
