"""Elastic displacements of the free plate: its rigid motions, the inverse of its stiffness beside them, its free modes.

    K phi = w^2 M phi        K the model's stiffness, M its lumped masses

Large plates are solved by conjugate gradients, preconditioned by smoothed aggregation (Vanek, Mandel and Brezina,
Computing 56, 1996) with the rigid motions as its near null space: time and memory go with the number of unknowns, where
those of a factorisation grow faster. The largest eigenvalues of the elastic inverse are found, on motions that are
mass-orthogonal to the rigid ones: shift-invert with the shift at zero. The three rigid modes are not in that space;
they are known exactly.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.sparse as sp

from fem.lazy import cached

if TYPE_CHECKING:
    from fem.laws.hinges import Hinges

TOLERANCE, MOST = 1e-10, 300
"""Residual over the load at which conjugate gradients end, and iterations that they may take: 15 to 45 are usual, more
on elements that are very long."""

PROLONGATION = ("jacobi", {"weighting": "local", "omega": 1.8})
"""Weights by sums of rows need no eigenvalues; of factors from 4/3 to 2 this one takes the fewest iterations."""

COARSEST = 300
"""Unknowns below which a level is solved directly."""

MODE_TOLERANCE, MODE_STEPS = 1e-6, 60
"""Residual over w^2 M u at which the search for the lowest mode ends, and its most steps: the frequency's error goes
with the square."""


class NotConvergedError(ArithmeticError):
    """The iteration came to no solution."""


class Multigrid:
    """Solver of K u = f for a free plate.

    Parameters
    ----------
    stiffness : sparse matrix, shape (2 nodes, 2 nodes)
        [N/m], all x unknowns and then all y.
    rigid : ndarray, shape (2 nodes, 3)
        Its rigid motions.
    """

    def __init__(self, stiffness: Any, rigid: np.ndarray) -> None:
        import pyamg

        unknowns = rigid.shape[0]
        self._order = np.arange(unknowns).reshape(2, -1).T.ravel()  # both unknowns of a node side by side
        blocks = sp.csr_matrix(stiffness)[self._order][:, self._order].tobsr((2, 2))
        self._rigid, _ = np.linalg.qr(rigid[self._order])
        self._levels = pyamg.smoothed_aggregation_solver(
            blocks,
            B=self._rigid,
            improve_candidates=None,
            smooth=PROLONGATION,
            max_coarse=COARSEST,
            presmoother=("gauss_seidel", {"sweep": "forward"}),  # with the other one a symmetric cycle
            postsmoother=("gauss_seidel", {"sweep": "backward"}),
        )
        *finer, coarsest = self._levels.levels
        for level in finer:  # without blocks SciPy multiplies a third faster
            level.A, level.P, level.R = (matrix.tocsr() for matrix in (level.A, level.P, level.R))
        coarsest.A = coarsest.A.tocsr()
        self._cycle = self._levels.aspreconditioner()

    def solve(self, load: np.ndarray) -> np.ndarray:
        """Displacement [m], up to a rigid motion, under loads in equilibrium [N]. Raises NotConvergedError."""
        from scipy.sparse.linalg import LinearOperator, cg

        stiffness = self._levels.levels[0].A
        cycle = LinearOperator(stiffness.shape, matvec=self._improved, dtype=float)
        ordered, status = cg(stiffness, load[self._order], rtol=TOLERANCE, maxiter=MOST, M=cycle)
        if status != 0 or not np.isfinite(ordered).all():
            raise NotConvergedError(f"{MOST} iterations leave a residual above {TOLERANCE:g} of the load")
        placed = np.empty_like(ordered)
        placed[self._order] = ordered
        return placed

    def _improved(self, residual: np.ndarray) -> np.ndarray:
        """One cycle, free of rigid motion before and after: what the coarsest level makes of it is rounding, divided
        by a stiffness that is rounding."""
        return self._elastic(self._cycle.matvec(self._elastic(residual)))

    def _elastic(self, values: np.ndarray) -> np.ndarray:
        return np.asarray(values - self._rigid @ (self._rigid.T @ values))

    def lowest_square(self, masses: np.ndarray, guesses: np.ndarray) -> float:
        """Square of the lowest elastic frequency [rad^2/s^2], from displacements near to its mode, shape (2 nodes, n),
        by LOBPCG (Knyazev, SIAM J. Sci. Comput. 23, 2001). Raises NotConvergedError.
        """
        from scipy.sparse.linalg import LinearOperator, lobpcg

        stiffness, weights = self._levels.levels[0].A, np.repeat(masses, 2)
        guesses = guesses[self._order]
        first = guesses[:, 0] @ (stiffness @ guesses[:, 0]) / (guesses[:, 0] ** 2 @ weights)
        tolerance = MODE_TOLERANCE * first * np.sqrt(masses.mean())
        (square, *_), vectors = lobpcg(
            stiffness,
            guesses,
            B=sp.diags(weights),
            M=LinearOperator(stiffness.shape, matvec=self._improved, dtype=float),
            Y=self._rigid,
            tol=tolerance,
            maxiter=MODE_STEPS,
            largest=False,
        )
        mode = vectors[:, 0]
        if np.linalg.norm(stiffness @ mode - square * weights * mode) > 10.0 * tolerance:
            raise NotConvergedError(f"{MODE_STEPS} steps do not find the lowest mode")
        return float(square)


Solve = Callable[[np.ndarray], np.ndarray]

LARGE = 40_000
"""Unknowns from which on a few loads are solved faster by multigrid than by a factorisation, its import included."""

CACHED = 4
"""Solutions that are cached: statics and the start ask for the same load."""


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

    Nothing is computed before the first load; the last solutions are cached. Above LARGE unknowns it iterates
    (`fem.plate.elastic`), and where that does not converge, as below, it factorises.

    Parameters
    ----------
    stiffness : sparse matrix, shape (2 nodes, 2 nodes)
        [N/m].
    masses : ndarray, shape (nodes,)
        [kg].
    positions : ndarray, shape (2, nodes)
        [m].
    hinges : Hinges or None
        Of a train; None for one plate.
    """

    def __init__(
        self, stiffness: Any, masses: np.ndarray, positions: np.ndarray, hinges: Hinges | None = None
    ) -> None:
        self.stiffness, self.masses, self.positions, self.hinges = stiffness, masses, positions, hinges
        self._solutions: dict[bytes, np.ndarray] = {}

    def __call__(self, load: np.ndarray) -> np.ndarray:
        """Displacement [m], shape (2 nodes,), under the load [N]."""
        key = hashlib.blake2b(load.tobytes()).digest()
        if key not in self._solutions:
            if len(self._solutions) == CACHED:
                self._solutions.pop(next(iter(self._solutions)))
            self._solutions[key] = self._solved(load)
        return self._solutions[key].copy()

    def _solved(self, load: np.ndarray) -> np.ndarray:
        if not self.is_large:
            return self.factorised(load)
        try:
            return without_rigid_motion(self.multigrid.solve(load), self.masses, self.positions)
        except NotConvergedError:
            return self.factorised(load)

    @property
    def is_large(self) -> bool:
        """True if it iterates, on large plates."""
        return 2 * self.masses.size >= LARGE and self.hinges is None

    @cached_property
    def factorised(self) -> Solve:
        """Solver by a factorisation, for many loads."""
        if self.hinges is not None:
            return hinged_solver(self.stiffness, np.tile(self.masses, 2)[:, None] * self.rigid, self.hinges)
        return elastic_solver(self.stiffness, self.masses, self.positions)

    @cached_property
    def rigid(self) -> np.ndarray:
        """Rigid motions about the centre of mass; of a train those of its units that leave the hinges closed. Shape
        (2 nodes, 3 + hinges)."""
        motions = rigid_motions(self.positions - (self.positions @ self.masses / self.masses.sum())[:, None])
        if self.hinges is None:
            return motions
        from scipy.linalg import null_space

        units = np.tile(self.hinges.unit, 2)[:, None] == np.arange(self.hinges.unit.max() + 1)
        each = (units[:, :, None] * motions[:, None, :]).reshape(len(motions), -1)
        return np.asarray(each @ null_space(gap_matrix(self.hinges) @ each))

    @cached_property
    def multigrid(self) -> Multigrid:
        """Solver by multigrid, for few loads."""
        return Multigrid(self.stiffness, rigid_motions(self.positions - self.positions.mean(axis=1)[:, None]))


@dataclass(frozen=True)
class ElasticSolver:
    """Solver of K u = f for a plate whose stiffness is that of `inverse` times the modulus [Pa]."""

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


def gap_matrix(hinges: Hinges) -> sp.csr_matrix:
    """Gaps of the hinges, all along X and then all along Y [m], over displacements; shape (2 hinges, 2 nodes)."""
    ends = hinges.weights, hinges.nodes, hinges.first
    gaps = sp.csr_matrix(ends, shape=(len(hinges.inertia), hinges.unit.size))
    return sp.block_diag([gaps, gaps], format="csr")


def hinged_solver(stiffness: Any, momenta: np.ndarray, hinges: Hinges) -> Solve:
    """Solver like `elastic_solver`, of a train: multipliers close the hinges and keep the momenta of rigid motion,
    shape (2 nodes, motions), zero."""
    from scipy.sparse.linalg import splu

    ties = sp.vstack([gap_matrix(hinges), momenta.T])
    factor = splu(sp.csc_matrix(sp.bmat([[stiffness, ties.T], [ties, None]])))

    def solve(load: np.ndarray) -> np.ndarray:
        return np.asarray(factor.solve(np.append(load, np.zeros(ties.shape[0])))[: load.size])

    return solve


@dataclass(frozen=True)
class FreeModes:
    """Elastic modes by rising frequency, and the rigid ones.

    Attributes
    ----------
    frequencies : ndarray, shape (modes,)
        [rad/s].
    shapes : ndarray, shape (modes, 2, nodes)
        Of unit modal mass, body frame [1/sqrt(kg)].
    rigid : ndarray, shape (3, 2, nodes)
        Two translations and the turn, likewise [1/sqrt(kg)]; of a train a turn more for each hinge.
    rigid_frequencies : ndarray, shape (3,)
        What the stiffness gives for them, which is rounding [rad/s].
    """

    frequencies: np.ndarray
    shapes: np.ndarray
    rigid: np.ndarray
    rigid_frequencies: np.ndarray


def most_modes(nodes: int) -> int:
    """Largest number of elastic modes that can be asked for on a mesh of so many nodes: Lanczos cannot find all."""
    return 2 * nodes - 4


def free_modes(model: Any, count: int) -> FreeModes:
    """The lowest elastic modes of the free plate.

    Parameters
    ----------
    model : PlateModel
        The plate.
    count : int
        How many.

    Returns
    -------
    FreeModes
        Frequencies and shapes.

    Raises
    ------
    ValueError
        For a count that the mesh cannot give.
    """
    elastic = model.elastic
    unit, root = plate_modes(elastic.inverse, count), math.sqrt(elastic.modulus)
    return replace(unit, frequencies=root * unit.frequencies, rigid_frequencies=root * unit.rigid_frequencies)


def plate_modes(plate: Inverse, count: int) -> FreeModes:
    """The lowest `count` elastic modes of the plate with the stiffness that is inverted here."""
    stiffness, masses = plate.stiffness, plate.masses
    nodes = masses.size
    if not 0 <= count <= most_modes(nodes):
        raise ValueError(f"{count} modes are requested; {nodes} nodes allow 0 to {most_modes(nodes)}")
    root = np.sqrt(np.tile(masses, 2))
    rigid, _ = np.linalg.qr(root[:, None] * plate.rigid)
    shapes = (rigid / root[:, None]).T
    quotients = np.abs(((stiffness @ shapes.T).T * shapes).sum(axis=1))
    values, vectors = _lowest(plate, root, rigid, count)
    return FreeModes(
        frequencies=values,
        shapes=(vectors / root[:, None]).T.reshape(count, 2, nodes),
        rigid=shapes.reshape(-1, 2, nodes),
        rigid_frequencies=np.sqrt(quotients),
    )


def lowest_frequency(elastic: ElasticSolver) -> float:
    """Lowest elastic frequency [Hz] of the plate of this solver."""
    find = _lowest_unit_frequency.__wrapped__ if elastic.inverse.is_large else _lowest_unit_frequency
    return math.sqrt(elastic.modulus) * float(find(elastic.inverse)) / (2.0 * math.pi)


@cached("first frequency")
def _lowest_unit_frequency(plate: Inverse) -> float:
    """Lowest elastic frequency with a modulus of 1 Pa [rad/s]: of a large plate by multigrid, else as `plate_modes`."""
    if plate.is_large:
        with suppress(NotConvergedError):
            return math.sqrt(plate.multigrid.lowest_square(plate.masses, _smooth(plate.positions)))
    return float(plate_modes(plate, 1).frequencies[0])


def _smooth(positions: np.ndarray) -> np.ndarray:
    """Displacements that bend the plate along its length and stretch it, shape (2 nodes, 2)."""
    x, y = (positions - positions.mean(axis=1)[:, None]) / np.ptp(positions)
    return np.array([np.concatenate([-2.0 * x * y, x**2]), np.concatenate([x * (1.0 - x**2), 0.0 * y])]).T


def _lowest(plate: Inverse, root: np.ndarray, rigid: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies [rad/s] and eigenvectors of M^-1/2 K M^-1/2 beside the rigid ones, shape (2 nodes, count)."""
    from scipy.sparse.linalg import LinearOperator, eigsh

    if not count:
        return np.zeros(0), np.zeros((root.size, 0))
    solve = plate.factorised

    def relieved(vector: np.ndarray) -> np.ndarray:
        return np.asarray(vector - rigid @ (rigid.T @ vector))

    def inverse(vector: np.ndarray) -> np.ndarray:
        return root * solve(root * relieved(vector.ravel()))

    operator = LinearOperator((root.size, root.size), matvec=inverse, dtype=float)
    first = np.cos(1.7 * np.arange(root.size)) + 0.1  # fixed, so that runs repeat to the bit
    compliances, vectors = eigsh(operator, k=count, which="LA", v0=first)
    return 1.0 / np.sqrt(compliances[::-1]), vectors[:, ::-1]
