"""Elastic displacements of the free plate under loads in equilibrium.

The inverse of the stiffness acts on displacements without rigid motion. Large plates are solved by multigrid, others
by a factorisation.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp

from fem.plate.multigrid import TOLERANCE, Multigrid, NotConvergedError

if TYPE_CHECKING:
    from fem.laws.hinges import Hinges

Solve = Callable[[np.ndarray], np.ndarray]
"""Function of a load [N], shape (2 nodes,), that returns displacements [m]."""

LARGE = 40_000
"""Unknowns from which on multigrid, its import included, is faster for a few loads."""

CACHED = 4
"""Solutions that are cached, because statics and the start need the same load."""


def rigid_motions(body: np.ndarray) -> np.ndarray:
    """Return displacements of two translations and a unit rotation about the origin.

    body: positions [m], shape (2, nodes). The result has shape (2 nodes, 3), numbered as the stiffness, all x and
    then all y.
    """
    nodes = body.shape[1]
    rigid = np.zeros((2 * nodes, 3))
    rigid[:nodes, 0] = rigid[nodes:, 1] = 1.0
    rigid[:nodes, 2], rigid[nodes:, 2] = -body[1], body[0]
    return rigid


class Inverse:
    """Solver of K u = f for a few loads in equilibrium.

    The displacements have no mass-weighted rigid motion. Nothing is computed before the first load, and the last
    solutions are cached. Above LARGE unknowns multigrid iterates; where it does not converge, and for fewer unknowns,
    the matrix is factorised.

    Parameters
    ----------
    stiffness : sparse matrix, shape (2 nodes, 2 nodes)
        [N/m].
    masses : ndarray, shape (nodes,)
        Nodal masses [kg].
    positions : ndarray, shape (2, nodes)
        Positions of the nodes [m].
    hinges : Hinges or None
        Hinges of a train; None for one plate.
    """

    def __init__(
        self,
        stiffness: sp.csr_matrix,
        masses: np.ndarray,
        positions: np.ndarray,
        hinges: Hinges | None = None,
    ) -> None:
        self.stiffness, self.masses, self.positions, self.hinges = stiffness, masses, positions, hinges
        self._solutions: dict[bytes, np.ndarray] = {}

    def __call__(self, load: np.ndarray, tolerance: float = TOLERANCE) -> np.ndarray:
        """Return the displacement [m], shape (2 nodes,), under the load [N].

        tolerance: residual over the load at which multigrid ends.
        """
        key = hashlib.blake2b(load.tobytes() + repr(tolerance).encode()).digest()
        if key not in self._solutions:
            if len(self._solutions) == CACHED:
                self._solutions.pop(next(iter(self._solutions)))
            self._solutions[key] = self._solved(load, tolerance)
        return self._solutions[key].copy()

    def _solved(self, load: np.ndarray, tolerance: float) -> np.ndarray:
        if not self.is_large:
            return self.factorised(load)
        try:
            return without_rigid_motion(self.multigrid.solve(load, tolerance), self.masses, self.positions)
        except NotConvergedError:
            return self.factorised(load)

    @property
    def is_large(self) -> bool:
        """True for large plates, solved by iteration."""
        return 2 * self.masses.size >= LARGE and self.hinges is None

    @cached_property
    def factorised(self) -> Solve:
        """Solver by a factorisation, for many loads."""
        if self.hinges is not None:
            momenta = np.tile(self.masses, 2)[:, None] * self.rigid
            return hinged_solver(self.stiffness, momenta, self.positions, self.unit_motions, self.hinges)
        return elastic_solver(self.stiffness, self.masses, self.positions)

    @cached_property
    def rigid(self) -> np.ndarray:
        """Rigid motions about the centre of mass.

        Their shape is (2 nodes, 3 + hinges). Those of a train are the motions of its units that close the hinges.
        """
        if self.hinges is None:
            return self.unit_motions
        from scipy.linalg import null_space

        return np.asarray(self.unit_motions @ null_space(gap_matrix(self.hinges) @ self.unit_motions))

    @cached_property
    def unit_motions(self) -> np.ndarray:
        """Rigid motions of each unit about the centre of mass of all.

        Their shape is (2 nodes, 3 units).
        """
        motions = rigid_motions(self.positions - (self.positions @ self.masses / self.masses.sum())[:, None])
        if self.hinges is None:
            return motions
        units = np.tile(self.hinges.unit, 2)[:, None] == np.arange(self.hinges.unit.max() + 1)
        return (units[:, :, None] * motions[:, None, :]).reshape(len(motions), -1)

    @cached_property
    def multigrid(self) -> Multigrid:
        """Solver by multigrid, for few loads."""
        return Multigrid(self.stiffness, rigid_motions(self.positions - self.positions.mean(axis=1)[:, None]))


@dataclass(frozen=True)
class ElasticSolver:
    """Solver of the static displacement u by K u = f.

    The stiffness K is that of `inverse` times Young's modulus [Pa].
    """

    inverse: Inverse
    modulus: float

    def __call__(self, load: np.ndarray, tolerance: float = TOLERANCE) -> np.ndarray:
        """Return the displacement [m], shape (2 nodes,), under the load [N].

        tolerance: see `Inverse`.
        """
        return self.inverse(load, tolerance) / self.modulus


def without_rigid_motion(displacement: np.ndarray, masses: np.ndarray, body: np.ndarray) -> np.ndarray:
    """Return a displacement [m], shape (2 nodes,), without its rigid motion.

    The rigid motion is the one that fits it best in the mass-weighted sense.
    """
    rigid = rigid_motions(body)
    weighted = rigid * np.tile(masses, 2)[:, None]
    motion = np.linalg.solve(rigid.T @ weighted, weighted.T @ displacement)
    return np.asarray(displacement - rigid @ motion)


def elastic_solver(stiffness: sp.csr_matrix, masses: np.ndarray, body: np.ndarray) -> Solve:
    """Return a solver of K u = f by a factorisation.

    stiffness [N/m], shape (2 nodes, 2 nodes); masses [kg], shape (nodes,); body: positions [m], shape (2, nodes). The
    load f must be in equilibrium, and u has no mass-weighted rigid motion, which is removed afterwards.
    """
    supported = _supported_solver(stiffness, body, [np.arange(body.shape[1])])
    return lambda load: without_rigid_motion(supported(load), masses, body)


def _supported_solver(stiffness: sp.csr_matrix, body: np.ndarray, units: Sequence[np.ndarray]) -> Solve:
    """Return a solver of K u = f on statically determinate supports.

    units: nodes of each plate. Three unknowns of each are fixed, both of one node and one of the node farthest from it.
    They carry no force under a load in equilibrium, and the remaining matrix is sparse and definite.
    """
    from scipy.sparse.linalg import splu

    nodes, fixed = body.shape[1], list[int]()
    for unit in units:
        from_first = np.abs(body[:, unit] - body[:, unit[:1]])
        far = int((from_first**2).sum(axis=0).argmax())
        across = int(from_first[:, far].argmin())
        fixed += [unit[0], nodes + unit[0], across * nodes + unit[far]]
    free = np.delete(np.arange(2 * nodes), fixed)
    reduced = sp.csc_matrix(stiffness)[free][:, free]
    factor = splu(reduced, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})

    def solve(load: np.ndarray) -> np.ndarray:
        displacement = np.zeros(2 * nodes)
        displacement[free] = factor.solve(load[free])
        return displacement

    return solve


def gap_matrix(hinges: Hinges) -> sp.csr_matrix:
    """Return the matrix of hinge gaps [m] over displacements.

    Its shape is (2 hinges, 2 nodes), all gaps along X and then all along Y.
    """
    ends = hinges.weights, hinges.nodes, hinges.first
    gaps = sp.csr_matrix(ends, shape=(len(hinges.inertia), hinges.unit.size))
    return sp.block_diag([gaps, gaps], format="csr")


def hinged_solver(
    stiffness: sp.csr_matrix, momenta: np.ndarray, body: np.ndarray, motions: np.ndarray, hinges: Hinges
) -> Solve:
    """Return a solver like `elastic_solver` for a train.

    Forces in the hinges and forces in proportion to the momenta of rigid motion, shape (2 nodes, motions), hold each
    unit in equilibrium. Rigid motions of the units, shape (2 nodes, 3 units), then close the hinges and make these
    momenta zero: there are as many of them as forces. body: positions [m], shape (2, nodes).
    """
    units = [np.flatnonzero(hinges.unit == unit) for unit in range(hinges.unit.max() + 1)]
    supported = _supported_solver(stiffness, body, units)
    forces = np.hstack([gap_matrix(hinges).toarray().T, momenta])
    work = motions.T @ forces

    def solve(load: np.ndarray) -> np.ndarray:
        displacement = supported(load - forces @ np.linalg.solve(work, motions.T @ load))
        return np.asarray(displacement - motions @ np.linalg.solve(work.T, forces.T @ displacement))

    return solve
