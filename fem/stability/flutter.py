"""Growth by friction, by the Nyquist criterion on the linearised plate.

The tangential force follows the normal one, R = slope N, so the corner's stiffness is not symmetric: k (n + slope t)
n^T with n and t the directions across and along the wall. Pairs of modes can then take energy from the sliding motion
and grow. In the free plate's modes, of squares w_j^2 and residues a_j = (n phi_j) ((n + slope t) phi_j), this is an
update of rank one, and the growing motions exp(s t) are the roots with Re s > 0 of

f(s) = 1 / k + sum_j a_j / (w_j^2 + s^2)

The number of roots that grow faster than a rate is the number of turns of f about zero along Re s = rate; no root is
computed. Stiffness-proportional damping b K reduces the rate of a mode of frequency w by b w^2 / 2, which curves that
line.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fem.cache import cached
from fem.laws.friction import friction_slope
from fem.model.plate_model import PlateModel
from fem.plate.elastic import Inverse
from fem.plate.properties import RigidStart
from fem.start.inertia_relief import to_global
from machine_code.compiled import compact, compiled, reordered

MAX_UNKNOWNS = 1200
"""Largest number of unknowns whose modes are computed.

Above it they cost more than many runs, and a coarser mesh of the same plate is used instead.
"""

INSTANTS = 9
"""Angles between the start and zero at which the model is linearised."""

HARMLESS = 5.0
"""Exponent of growth during the run that has no visible effect.

After inertia relief the ripple is 1e-6 to 1e-7 of the reaction.
"""

RATE_RATIO = math.sqrt(2.0)
"""Ratio of successive trial rates."""


class CornerModes(NamedTuple):
    """Modes of the free plate as they act at the corner.

    squares: of the circular frequencies, shape (modes,), the rigid motions as one with zero first. corner: motion of
    the corner in each mode of unit modal mass [1/sqrt(kg)], in the body frame, shape (2, modes).
    """

    squares: np.ndarray
    corner: np.ndarray


@dataclass(frozen=True)
class Flutter:
    """Growth by friction.

    Attributes
    ----------
    rate : float
        Upper bound of the growth rate of all modes [1/s]; 0 where none reaches the harmless rate.
    growth : float
        Largest exponent over the run [-].
    lowest : float
        Elastic frequency of the free plate [rad/s]; 0 without analysis.
    """

    rate: float
    growth: float
    lowest: float = 0.0


def predict_flutter(
    model: PlateModel, start: RigidStart, duration: float, viscous: float = 0.0, harmless: float = HARMLESS
) -> Flutter:
    """Return the growth over a run.

    Parameters
    ----------
    model : PlateModel
        The plate.
    start : RigidStart
        Motion of the rigid body.
    duration : float
        Duration of the run [s].
    viscous : float
        Rate that damping takes off a mode over its frequency squared [s], see `viscous_rate`.
    harmless : float
        Exponent of growth below which rates are not resolved [-].

    Returns
    -------
    Flutter
        The fastest growth.
    """
    slope = friction_slope(model.parameters.friction, start.corner_speed)
    if slope == 0.0:
        return Flutter(0.0, 0.0)  # a symmetric stiffness has no growth
    modes, corner, rates = corner_modes(model), model.parameters.corner, np.empty(INSTANTS)
    squares = np.append(0.0, modes.squares[3:])  # rigid motions have no stiffness
    residues = residues_at(modes, np.linspace(start.angle, 0.0, INSTANTS), slope)
    least_rates(squares, residues, corner.stiffness, corner.dashpot, viscous, harmless / duration, rates)
    growth = float(np.trapezoid(rates, dx=duration / (INSTANTS - 1)))
    return Flutter(float(rates.max()), growth, math.sqrt(modes.squares[3]))


def viscous_rate(model: PlateModel) -> float:
    """Return the damping rate of viscosity over squared frequency [s].

    It is that of any mode. The bulk part is neglected.
    """
    viscosity = model.parameters.viscosity
    return 0.0 if viscosity is None else 0.5 * viscosity.c_33 / model.tangent_moduli.c_33


def corner_modes(model: PlateModel) -> CornerModes:
    """Return all modes of the free plate at the corner."""
    corner, nodes = model.parameters.corner, model.parameters.mass.size
    squares, shapes = _unit_modes(model.elastic.inverse)
    corner_motion = np.einsum("n,inm->im", corner.weights, shapes.reshape(2, nodes, -1)[:, corner.nodes])
    return CornerModes(model.elastic.modulus * squares, corner_motion)


def residues_at(modes: CornerModes, angles: Sequence[float] | np.ndarray, slope: float) -> np.ndarray:
    """Return the residues at the plate's angles [rad], shape (angles, modes).

    The rigid motions are one mode, the first. slope: of friction over the reaction.
    """
    along, across = np.einsum("aij,jm->iam", [to_global(angle) for angle in angles], modes.corner)
    residues = across * (across + slope * along)
    return np.hstack([residues[:, :3].sum(axis=1, keepdims=True), residues[:, 3:]])


@cached
def _unit_modes(plate: Inverse) -> tuple[np.ndarray, np.ndarray]:
    """Return the squares [rad^2/s^2] and shapes of all modes of a plate.

    The shapes have unit modal mass, shape (2 nodes, modes).
    """
    root = 1.0 / np.sqrt(np.tile(plate.masses, 2))
    squares, shapes = np.linalg.eigh(root[:, None] * plate.stiffness.toarray() * root)
    return np.maximum(squares, 0.0), root[:, None] * shapes


@compiled
def least_rates(squares, residues, stiffness, dashpot, viscous, least, rates):
    """Fill the least trial rates [1/s] above those of all modes.

    There is one for each angle, 0 where that is the first one. residues: see `residues_at`; others as in
    `growing_modes`.
    """
    for place in range(rates.size):
        rates[place] = _least_rate(squares, residues[place], stiffness, dashpot, viscous, least)


@compact
def _least_rate(squares, residues, stiffness, dashpot, viscous, least):
    top = 1.5 * highest_mode(squares, residues, stiffness)
    first, last, rate = 0, 0, least
    while rate < top:  # no mode outgrows the last rate
        rate *= RATE_RATIO
        last += 1
    middle = first
    while first < last:  # bisection, after the first rate
        if growing_modes(squares, residues, stiffness, dashpot, viscous, _trial_rate(least, middle), top):
            first = middle + 1
        else:
            last = middle
        middle = (first + last) // 2
    return _trial_rate(least, first) if first > 0 else 0.0


@compact
def _trial_rate(least, number):
    rate = least
    for _ in range(number):
        rate *= RATE_RATIO
    return rate


@compact
def highest_mode(squares, residues, stiffness):
    """Return a frequency [rad/s] above all modes of the constrained plate."""
    spring = 0.0
    if np.isfinite(stiffness):
        for residue in range(residues.size):
            spring += stiffness * abs(residues[residue])
    return math.sqrt(squares[squares.size - 1] + spring)


@compiled
def growing_modes(squares, residues, stiffness, dashpot, viscous, rate, top):
    """Return the number of roots that grow faster than `rate` [1/s].

    An oscillation has two. viscous: damping of the modes. The line is followed from the real axis up to `top` [rad/s]
    in steps in which f turns by less than a radian, or of a hundredth of the distance to the poles. Between poles a
    step is half the distance to the next one, so that the number of steps depends on the number of modes alone.
    squares: rising, the first zero.
    """
    exact = not np.isfinite(stiffness)
    step, frequency, turned, above = 2.0 * rate, 0.0, 0.0, 0
    before_real, before_imaginary = _response(squares, residues, stiffness, dashpot, exact, rate, 0.0)
    while frequency < top:
        later = frequency + step
        ahead = rate + viscous * later * later
        f_real, f_imaginary = _response(squares, residues, stiffness, dashpot, exact, ahead, later)
        turn = math.atan2(
            f_imaginary * before_real - f_real * before_imaginary,
            f_real * before_real + f_imaginary * before_imaginary,
        )
        if abs(turn) > 1.0 and step > 0.01 * rate:
            step *= 0.5
            continue
        turned, frequency, before_real, before_imaginary = turned + turn, later, f_real, f_imaginary
        while above < squares.size and squares[above] <= frequency * frequency:
            above += 1
        gap = frequency - math.sqrt(squares[above - 1])
        if above < squares.size:
            gap = min(gap, math.sqrt(squares[above]) - frequency)
        step = min(max(2.0 * ahead, 0.5 * gap), 1.5 * step)
    # Far out f is real and positive, or where the constraint is exact s^2 f is.
    turned -= math.atan2(before_imaginary, before_real)
    return round(abs(turned) / math.pi)


@reordered
def _response(squares, residues, stiffness, dashpot, exact, real, imaginary):
    """Return both parts of f(s) at s = real + i imaginary.

    For an exact constraint it is s^2 f(s).
    """
    p, q = real * real - imaginary * imaginary, 2.0 * real * imaginary
    f_real = f_imaginary = 0.0
    for mode in range(squares.size):
        distance = squares[mode] + p
        fraction = residues[mode] / (distance * distance + q * q)
        f_real += distance * fraction
        f_imaginary -= q * fraction
    if exact:
        return f_real * p - f_imaginary * q, f_real * q + f_imaginary * p
    c, d = stiffness + dashpot * real, dashpot * imaginary
    size = c * c + d * d
    return f_real + c / size, f_imaginary - d / size
