"""The highest frequency of the plate as it is deformed and turned at an instant of the run."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from fem.discretisation.model import PlateModel
from fem.explicit.impact_loop import ImpactLoop
from fem.explicit.internal_force import scratch_for, subtract_internal_forces

STEP = 1e-5
"""Displacement of the finite difference over the element's size; the forces are cubic in it."""


def deformed_frequency(model: PlateModel, positions: np.ndarray) -> float:
    """Highest circular frequency of the tangent stiffness about a deformed state.

    Lanczos on differences of the internal forces themselves, with the springs by which the wall acts on it.

    Parameters
    ----------
    model : PlateModel
        The plate.
    positions : ndarray, shape (2, nodes)
        In the wall's frame [m].

    Returns
    -------
    float
        Frequency [rad/s]; infinite where the forces are not finite.
    """
    from scipy.sparse.linalg import ArpackError, LinearOperator, eigsh

    loop = model.loop
    root, shape = 1.0 / np.sqrt(loop.mass), positions.shape
    hold = _springs(loop)
    size = STEP * math.sqrt(float(model.discretisation.scalar.dx.sum(axis=1).min()))
    scratch, still = scratch_for(loop.table), np.zeros(shape)

    def forces(at: np.ndarray) -> np.ndarray:
        force = np.zeros(shape)
        subtract_internal_forces(at, still, None, loop.hourglass, force, loop.table, loop.material, scratch)
        return force

    def product(vector: np.ndarray) -> np.ndarray:
        move = root * vector.reshape(shape)
        scale = size / max(np.abs(move).max(), np.finfo(float).tiny)
        difference = (forces(positions - scale * move) - forces(positions + scale * move)) / (2.0 * scale)
        hold(move, difference)
        return np.asarray((root * difference).ravel())

    start = np.cos(1.7 * np.arange(positions.size)) + 0.1
    operator = LinearOperator((positions.size, positions.size), matvec=product, dtype=float)
    if not np.isfinite(product(start)).all():
        return math.inf
    try:
        (largest,) = eigsh(operator, k=1, which="LA", v0=start, tol=1e-4, return_eigenvectors=False)
    except ArpackError:  # forces that leave the finite on the way
        return math.inf
    return math.sqrt(max(float(largest), 0.0))


def _springs(loop: Any) -> Callable[[np.ndarray, np.ndarray], None]:
    """Adds to forces [N], shape (2, nodes), those of the corner's spring that belong to a displacement [m]; unilateral
    contact does not bound the time step."""
    if isinstance(loop, ImpactLoop):
        return lambda move, forces: None
    corner = loop.corner

    def hold(move: np.ndarray, forces: np.ndarray) -> None:
        forces[1, corner.nodes] += corner.spring * (move[1, corner.nodes] @ corner.weights) * corner.weights

    return hold
