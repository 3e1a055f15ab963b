"""Displacements and lowest frequency of a large free plate by multigrid.

Conjugate gradients are preconditioned by smoothed aggregation (Vanek, Mandel and Brezina, Computing 56, 1996), with the
rigid motions as the near null space. Time and memory are proportional to the number of unknowns, where those of a
factorisation grow faster.
"""

import numpy as np
import scipy.sparse as sp

TOLERANCE, MAX_ITERATIONS = 1e-10, 300
"""Residual over the load at which conjugate gradients end, and the largest number of iterations.

15 to 45 iterations are usual, more on elements that are very long.
"""

PROLONGATION = ("jacobi", {"weighting": "local", "omega": 1.8})
"""Smoothing of the prolongation with weights by row sums, which need no eigenvalues.

Among factors from 4/3 to 2 this one takes the fewest iterations.
"""

COARSEST = 300
"""Unknowns below which a level is solved directly."""

MODE_TOLERANCE, MAX_MODE_STEPS = 1e-6, 60
"""Residual over w^2 M u at which the search for the lowest mode ends, and its largest number of steps.

The error of the frequency is proportional to the square of the residual.
"""


class NotConvergedError(ArithmeticError):
    """An iteration did not converge."""


class Multigrid:
    """Solver of K u = f for a free plate.

    Parameters
    ----------
    stiffness : sparse matrix, shape (2 nodes, 2 nodes)
        [N/m], all x unknowns and then all y.
    rigid : ndarray, shape (2 nodes, 3)
        Rigid motions of the plate.
    """

    def __init__(self, stiffness: sp.csr_matrix, rigid: np.ndarray) -> None:
        import pyamg

        unknowns = rigid.shape[0]
        self._order = np.arange(unknowns).reshape(2, -1).T.ravel()  # both unknowns of a node side by side
        blocks, rows = _by_nodes(stiffness, self._order)
        self._rigid = np.asfortranarray(np.linalg.qr(rigid[self._order])[0])
        self._levels = pyamg.smoothed_aggregation_solver(
            blocks,
            B=self._rigid,
            improve_candidates=None,
            smooth=PROLONGATION,
            max_coarse=COARSEST,
        )
        finest, *coarser = self._levels.levels
        finest.A = rows  # without blocks SciPy multiplies a third faster
        for level in coarser:
            level.A = level.A.tocsr()
        for level in (finest, *coarser)[:-1]:
            level.P, level.R = level.P.tocsr(), level.R.tocsr()

    def solve(self, load: np.ndarray, tolerance: float = TOLERANCE) -> np.ndarray:
        """Return displacements [m] under loads [N] in equilibrium.

        They are determined up to a rigid motion. Raises NotConvergedError.
        """
        from scipy.sparse.linalg import LinearOperator, cg

        stiffness = self._levels.levels[0].A
        cycle = LinearOperator(stiffness.shape, matvec=self._improved, dtype=float)
        ordered, status = cg(stiffness, load[self._order], rtol=tolerance, maxiter=MAX_ITERATIONS, M=cycle)
        if status != 0 or not np.isfinite(ordered).all():
            raise NotConvergedError(
                f"{MAX_ITERATIONS} iterations end with a residual above {tolerance:g} of the load"
            )
        placed = np.empty_like(ordered)
        placed[self._order] = ordered
        return placed

    def _improved(self, residual: np.ndarray) -> np.ndarray:
        """Return one cycle without rigid motion before and after.

        The rigid part that the coarsest level returns is rounding, divided by a stiffness that is rounding too.
        """
        return self._elastic(self._cycle(0, self._elastic(residual)))

    def _cycle(self, number: int, load: np.ndarray) -> np.ndarray:
        """Return one cycle from level `number` on, symmetric in the load."""
        from pyamg.relaxation.relaxation import gauss_seidel

        level = self._levels.levels[number]
        if level is self._levels.levels[-1]:
            return np.asarray(self._levels.coarse_solver(level.A, load))
        solution = np.zeros_like(load)
        gauss_seidel(level.A, solution, load, sweep="forward")
        solution += level.P @ self._cycle(number + 1, level.R @ (load - level.A @ solution))
        gauss_seidel(level.A, solution, load, sweep="backward")
        return solution

    def _elastic(self, values: np.ndarray) -> np.ndarray:
        """Remove the rigid motion from the unknowns."""
        return np.asarray(values - self._rigid @ (self._rigid.T @ values))

    def lowest_square(self, masses: np.ndarray, guesses: np.ndarray) -> float:
        """Return the square of the lowest elastic frequency [rad^2/s^2].

        guesses: displacements near to the mode, shape (2 nodes, n). By LOBPCG (Knyazev, SIAM J. Sci. Comput. 23,
        2001). Raises NotConvergedError.
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
            maxiter=MAX_MODE_STEPS,
            largest=False,
        )
        mode = vectors[:, 0]
        if np.linalg.norm(stiffness @ mode - square * weights * mode) > 10.0 * tolerance:
            raise NotConvergedError(f"{MAX_MODE_STEPS} steps do not find the lowest mode")
        return float(square)


def _by_nodes(stiffness: sp.csr_matrix, order: np.ndarray) -> tuple[sp.bsr_matrix, sp.csr_matrix]:
    """Return the stiffness in nodal order, with and without blocks."""
    rows, nodes = sp.csr_matrix(stiffness)[order], order.size // 2
    column = rows.indices
    is_y = column >= nodes
    column *= 2
    column -= (2 * nodes - 1) * is_y.astype(column.dtype)
    rows.has_sorted_indices = False
    return rows.tobsr((2, 2)), rows
