"""The highest frequency of the plate as it is deformed and turned at an instant of the run."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from fem.discretisation.lanczos import largest_eigenpair
from fem.discretisation.model import PlateModel
from fem.explicit.impact_loop import ImpactLoop
from fem.explicit.internal_force import scratch_for, subtract_internal_forces
from fem.start.rigid_state import to_global

TOLERANCE, BASIS = 1e-4, 8
"""Residual over the eigenvalue at which Lanczos ends, and vectors that it keeps."""

STEP = 1e-5
"""Displacement of the finite difference over the element's size: its error is that part of the stiffness, about."""


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
    loop = model.loop
    root, shape = 1.0 / np.sqrt(loop.mass), positions.shape
    hold = _springs(loop)
    size = STEP * math.sqrt(float(model.discretisation.scalar.dx.sum(axis=1).min()))
    place, force = positions.copy(), np.zeros(shape)
    parts = (loop.hourglass, force, loop.table, loop.material, scratch_for(loop.table, loop.hourglass))
    subtract = subtract_internal_forces.bound(place, np.zeros(shape), None, *parts)

    def forces() -> np.ndarray:
        force[:] = 0.0
        subtract()
        return force

    before = forces().copy()

    def product(vector: np.ndarray) -> np.ndarray:
        move = root * vector.reshape(shape)
        scale = size / max(np.abs(move).max(), np.finfo(float).tiny)
        np.add(positions, scale * move, out=place)
        difference = (before - forces()) / scale
        hold(move, difference)
        return np.asarray((root * difference).ravel())

    start = _first_vector(model, positions)
    if not np.isfinite(product(start)).all():
        return math.inf
    try:
        largest, _ = largest_eigenpair(product, start, TOLERANCE, BASIS)
    except FloatingPointError:  # forces that leave the finite on the way
        return math.inf
    return math.sqrt(max(largest, 0.0))


def _first_vector(model: PlateModel, positions: np.ndarray) -> np.ndarray:
    """The mode of the highest frequency of the plate at rest, turned as the plate is, and a little of all others."""
    some = np.cos(1.7 * np.arange(positions.size)) + 0.1  # fixed, so that runs repeat to the bit
    if model.highest_mode is None:
        return some
    share, body = model.loop.mass / model.mass, model.discretisation.positions
    x, y = positions - (positions @ share)[:, None]
    r_x, r_y = (body - (body @ share)[:, None]) * share
    angle = math.atan2((r_y * x - r_x * y).sum(), (r_x * x + r_y * y).sum())
    return np.asarray((to_global(angle) @ model.highest_mode).ravel() + 1e-3 * some)


def _springs(loop: Any) -> Callable[[np.ndarray, np.ndarray], None]:
    """Adds to forces [N], shape (2, nodes), those of the corner's spring that belong to a displacement [m]; unilateral
    contact does not bound the time step."""
    if isinstance(loop, ImpactLoop):
        return lambda move, forces: None
    nodes, weights, spring = loop.corner.nodes, loop.corner.weights, loop.corner.spring

    def hold(move: np.ndarray, forces: np.ndarray) -> None:
        forces[1, nodes] += spring * (move[1, nodes] @ weights) * weights

    return hold
