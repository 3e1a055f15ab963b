"""Second-order cone programs, solved by Clarabel."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

Floats = NDArray[np.float64]

TOLERANCE = 1e-6
"""Relative gap and residual at which the solver stops; bounds do not rest on it [-]."""


def minimum(
    cost: Floats,
    equal: tuple[sparse.csc_matrix, Floats],
    nonnegative: tuple[sparse.csc_matrix, Floats],
    cones: tuple[sparse.csc_matrix, Floats],
) -> Floats:
    """Return the x of least cost, which a certificate has to prove.

    Pairs (A, b) mean b - A x is zero, is not negative, and consists of triples (s, u, v) with s >= sqrt(u^2 + v^2).
    x is NaN where the solver ends without a point.
    """
    import clarabel

    pairs = (equal, nonnegative, cones)
    rows = [matrix.shape[0] for matrix, _ in pairs]
    kinds: Sequence[object] = [
        clarabel.ZeroConeT(rows[0]),
        clarabel.NonnegativeConeT(rows[1]),
        *[clarabel.SecondOrderConeT(3)] * (rows[2] // 3),
    ]
    settings = clarabel.DefaultSettings()
    settings.verbose, settings.presolve_enable, settings.max_threads = False, False, 1
    settings.direct_solve_method, settings.iterative_refinement_enable = "qdldl", False
    settings.tol_gap_rel = settings.tol_gap_abs = settings.tol_feas = TOLERANCE
    matrix = sparse.vstack([matrix for matrix, _ in pairs], format="csc")
    right = np.concatenate([values for _, values in pairs])
    quadratic = sparse.csc_matrix((cost.size, cost.size))
    solution = clarabel.DefaultSolver(quadratic, cost, matrix, right, kinds, settings).solve()
    values = np.array(solution.x)
    return values if np.isfinite(values).all() and np.abs(values).max() > 0.0 else np.full(cost.size, np.nan)
