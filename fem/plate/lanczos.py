"""Largest eigenvalue of a symmetric operator by Lanczos with thick restarts.

The method of Wu and Simon (2000) is written out, so that it takes the same steps with every version of SciPy, and the
time step has the same digits. Results of ARPACK differ by the tolerance from one version to the next.
"""

import math
from collections.abc import Callable

import numpy as np

RESTART_FRACTION = 1.0 / 3.0
"""Fraction of the basis that a restart retains, of the largest eigenvalues."""

GROWTH_LIMIT = 0.01
"""Growth of the value since the last restart over the tolerance, below which it is accepted.

Where the value still grows, it is near an eigenvalue that is not the largest.
"""

MAX_RESTARTS = 1000
"""Largest number of restarts; the residual then states the accuracy."""

Extend = Callable[[np.ndarray, np.ndarray, int], tuple[int, float]]
"""Function that fills all rows of a basis behind the row of a number, by the operator on the row before. A row is made
orthogonal to all before, and of unit length. The function takes the rows, shape (m + 1, n), the projected operator,
shape (m, m), and that number. It returns the number of rows with a product, and the length of the orthogonal part of
the last product, 0 where the rows are an invariant subspace.
"""


def fixed_vector(size: int) -> np.ndarray:
    """Return a vector with parts of all modes, equal in every run."""
    return np.cos(1.7 * np.arange(size)) + 0.1


def largest_eigenpair(
    extend: Extend, first: np.ndarray, tolerance: float, basis: int
) -> tuple[float, np.ndarray]:
    """Return the largest eigenvalue of an operator and its vector.

    Parameters
    ----------
    extend : callable
        The operator, see `Extend` and `extend_by`.
    first : ndarray, shape (n,)
        Vector with which the search begins.
    tolerance : float
        Residual over the eigenvalue at which the search ends.
    basis : int
        Size of the basis, at least 4; smaller where the space is smaller.

    Returns
    -------
    value : float
        The eigenvalue.
    vector : ndarray, shape (n,)
        Eigenvector of unit length.

    Raises
    ------
    FloatingPointError
        Where the operator does not stay finite.
    """
    basis = min(basis, first.size)
    rows, projected = np.empty((basis + 1, first.size)), np.zeros((basis, basis))
    rows[0], used, earlier = first / np.linalg.norm(first), 0, -math.inf
    for _ in range(MAX_RESTARTS):
        basis, length = extend(rows, projected, used)
        if not math.isfinite(length):
            raise FloatingPointError("the operator is not finite")
        values, mixed = np.linalg.eigh(projected[:basis, :basis])
        limit, settled = tolerance * abs(values[-1]), GROWTH_LIMIT * tolerance * abs(values[-1])
        converged = length * abs(mixed[-1, -1]) <= limit and values[-1] - earlier <= settled
        if converged or length == 0.0 or basis == first.size:
            break
        earlier = values[-1]
        used = max(1, round(RESTART_FRACTION * basis))
        rows[:used], rows[used] = mixed[:, -used:].T @ rows[:basis], rows[basis]
        projected[:] = np.diag(np.concatenate([values[-used:], np.zeros(basis - used)]))
    vector = mixed[:, -1] @ rows[:basis]
    return float(values[-1]), vector / np.linalg.norm(vector)


def extend_by(product: Callable[[np.ndarray], np.ndarray]) -> Extend:
    """Return the extension by an operator on a vector, shape (n,)."""

    def extend(rows: np.ndarray, projected: np.ndarray, begin: int) -> tuple[int, float]:
        for row in range(begin, len(projected)):
            vector, basis = product(rows[row]), rows[: row + 1]
            size = float(np.linalg.norm(vector))
            overlap = basis @ vector
            vector = vector - overlap @ basis
            correction = basis @ vector  # a single orthogonalisation is not accurate enough
            vector -= correction @ basis
            projected[row, : row + 1] = projected[: row + 1, row] = overlap + correction
            length = float(np.linalg.norm(vector))
            if length <= 1e-14 * size:
                return row + 1, 0.0
            rows[row + 1] = vector / length
        return row + 1, length

    return extend
