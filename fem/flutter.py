"""Flutter foreseen: the linearised plate with friction at its corner.

The tangential force follows the normal one, R = slope N, so the corner's stiffness is not symmetric:
k (n + slope t) n^T with n and t the directions across and along the wall. Pairs of modes can then exchange energy
with the sliding motion and grow. The rates are those of the undamped plate; stiffness-proportional damping
b K takes b w^2 / 2 off the rate of a mode of frequency w.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fem.corner import Exact
from fem.model import PlateModel
from fem.start import RigidStart, friction_slope, to_global

MOST_UNKNOWNS = 3200
"""Above this the dense eigenvalue problem takes over ten seconds."""

INSTANTS = 5
"""Angles between the start and zero at which the model is linearised."""

SUSPECT = 15.0
"""Exponent of growth above which ripple of a quiet start, 1e-6 to 1e-7 of the reaction, has grown to its size."""

CALM = 5.0
"""Exponent of growth that a run stands without a trace in its results."""

RATIOS = (0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)
"""Damping ratios among which the cure is sought."""


@dataclass(frozen=True)
class Flutter:
    """growth: exponent by which the fastest mode grows between start and tail-slap; frequency [rad/s]: its own
    where it is fastest; cure: the least of RATIOS that calms the run, at the model's highest frequency, or None."""

    growth: float
    frequency: float
    cure: float | None

    @property
    def expected(self) -> bool:
        """Whether the run is expected to be spoilt."""
        return self.growth > SUSPECT


def foresee_flutter(model: PlateModel, start: RigidStart, duration: float) -> Flutter | None:
    """Growth over a run of this duration [s], its damping included; None for a model too large to analyse."""
    if friction_slope(model.loop.friction, start.corner_speed) == 0.0:
        return Flutter(0.0, 0.0, None)  # a symmetric stiffness: no growth
    if 2 * model.loop.mass.size > MOST_UNKNOWNS:
        return None
    angles = np.linspace(start.angle, 0.0, INSTANTS)
    found = [_rates(model, start, angle) for angle in angles]
    fastest = max(found, key=lambda pair: pair[0].max())
    cures = (ratio for ratio in RATIOS if _growth(found, ratio / model.highest_frequency, duration) < CALM)
    return Flutter(
        _growth(found, _damped(model), duration),
        math.sqrt(fastest[1][fastest[0].argmax()]),
        next(cures, None),
    )


def _growth(found: list[tuple[np.ndarray, np.ndarray]], damped: float, duration: float) -> float:
    """Integral over the run of the largest net rate; the instants are taken as evenly spaced."""
    net = [max(0.0, float((rates - damped * squares).max())) for rates, squares in found]
    return float(np.trapezoid(net, dx=1.0 / (len(net) - 1)) * duration)


def _damped(model: PlateModel) -> float:
    """Rate that damping takes off a mode over its frequency squared [s], the bulk part left aside."""
    viscosity = model.loop.viscosity
    return 0.0 if viscosity is None else 0.5 * viscosity.c_33 / model.shear_modulus


def _rates(model: PlateModel, start: RigidStart, angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Growth rates [1/s] and squares of frequencies [rad^2/s^2] of all elastic modes at this angle."""
    corner, masses = model.loop.corner, model.loop.mass
    along, across = to_global(angle)  # rows: directions X and Y in the body frame
    spread = np.zeros(masses.size)
    spread[corner.nodes] = corner.weights
    root = 1.0 / np.sqrt(np.tile(masses, 2))
    gap = np.kron(across, spread) * root
    push = gap + friction_slope(model.loop.friction, start.corner_speed) * np.kron(along, spread) * root
    matrix = root[:, None] * model.stiffness.toarray() * root
    if isinstance(corner.hold, Exact):  # N keeps the gap's acceleration at zero
        matrix -= np.outer(push, gap @ matrix) / (gap @ push)
    else:
        matrix += corner.hold.stiffness * np.outer(push, gap)
    squares = np.linalg.eigvals(matrix)
    # Rigid motion along the wall and about the corner has no stiffness; it is no flutter.
    elastic = squares[squares.real > 1e-9 * squares.real.max()].astype(complex)
    roots = np.sqrt(-elastic)
    return np.abs(roots.real), np.maximum(roots.imag**2, np.finfo(float).tiny)
