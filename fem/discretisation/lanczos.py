"""The largest eigenvalue of a symmetric operator: Lanczos with thick restarts (Wu and Simon 2000).

Written out, so that it takes the same steps, and the time step has the same digits, with every version of SciPy: those
of ARPACK differ by the tolerance from one version to the next.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

KEPT = 1.0 / 3.0
"""Share of the basis that a restart keeps, of the vectors of the largest eigenvalues."""

SETTLED = 0.01
"""Part of the tolerance that the value may have grown by since the last restart: where it still grows, it is near an
eigenvalue that is not the largest."""

MAX_RESTARTS = 1000
"""Restarts after which it ends, and the residual tells how close it came."""


def largest_eigenpair(
    product: Callable[[np.ndarray], np.ndarray], first: np.ndarray, tolerance: float, basis: int
) -> tuple[float, np.ndarray]:
    """The largest eigenvalue and its vector.

    Parameters
    ----------
    product : callable
        The operator on a vector, shape (n,).
    first : ndarray, shape (n,)
        What the search begins with.
    tolerance : float
        Residual over the eigenvalue at which it ends.
    basis : int
        Vectors that are kept, at least 4; fewer where there are not so many.

    Returns
    -------
    value : float
        The eigenvalue.
    vector : ndarray, shape (n,)
        Of unit length.

    Raises
    ------
    FloatingPointError
        Where the operator does not stay finite.
    """
    basis = min(basis, first.size)
    rows, projected = np.empty((basis + 1, first.size)), np.zeros((basis, basis))
    rows[0], used, before = first / np.linalg.norm(first), 0, -math.inf
    for _ in range(MAX_RESTARTS):
        for each in range(used, basis):
            length = _extend(product, rows, projected, each)
            if length == 0.0:  # what there is contains the rest
                basis = each + 1
                break
        values, mixed = np.linalg.eigh(projected[:basis, :basis])
        small, settled = tolerance * abs(values[-1]), SETTLED * tolerance * abs(values[-1])
        close = length * abs(mixed[-1, -1]) <= small and values[-1] - before <= settled
        if close or length == 0.0 or basis == first.size:
            break
        before = values[-1]
        used = max(1, round(KEPT * basis))
        rows[:used], rows[used] = mixed[:, -used:].T @ rows[:basis], rows[basis]
        projected[:] = np.diag(np.concatenate([values[-used:], np.zeros(basis - used)]))
    vector = mixed[:, -1] @ rows[:basis]
    return float(values[-1]), vector / np.linalg.norm(vector)


def _extend(
    product: Callable[[np.ndarray], np.ndarray], rows: np.ndarray, projected: np.ndarray, each: int
) -> float:
    """Make row `each` + 1 of the operator on row `each`, across all before; the length of what was new in it."""
    vector, before = product(rows[each]), rows[: each + 1]
    size = float(np.linalg.norm(vector))
    overlap = before @ vector
    vector = vector - overlap @ before
    again = before @ vector  # once is not enough against rounding
    vector -= again @ before
    projected[each, : each + 1] = projected[: each + 1, each] = overlap + again
    length = float(np.linalg.norm(vector))
    if length <= 1e-14 * size:
        return 0.0
    if not math.isfinite(length):
        raise FloatingPointError("the operator does not stay finite")
    rows[each + 1] = vector / length
    return length
