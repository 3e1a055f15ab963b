"""Large plates: conjugate gradients, preconditioned by smoothed aggregation (Vanek, Mandel and Brezina, Computing 56,
1996) with the rigid motions as its near null space. Time and memory go with the number of unknowns, where those of a
factorisation grow faster.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp

TOLERANCE, MOST = 1e-10, 300
"""Residual over the load at which conjugate gradients end, and iterations that they may take: 15 to 45 are usual, more
on elements that are very long."""

SWEEPS = {"presmoother": "forward", "postsmoother": "backward"}
"""Of Gauss and Seidel; together they make a symmetric cycle."""

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
            **{name: ("gauss_seidel", {"sweep": sweep}) for name, sweep in SWEEPS.items()},
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
        return self._in_order(ordered)

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

    def _in_order(self, values: np.ndarray) -> np.ndarray:
        placed = np.empty_like(values)
        placed[self._order] = values
        return placed
