"""Flutter foreseen: the linearised plate with friction at its corner, judged by the Nyquist criterion.

The tangential force follows the normal one, R = slope N, so the corner's stiffness is not symmetric:
k (n + slope t) n^T with n and t the directions across and along the wall. Pairs of modes can then take energy from the
sliding motion and grow. In the free plate's modes, of squares w_j^2 and residues a_j = (n phi_j) ((n + slope t) phi_j),
this is an update of rank one, and the growing motions exp(s t) are the roots with Re s > 0 of

    f(s) = 1 / k + sum_j a_j / (w_j^2 + s^2)

How many grow faster than a rate is the number of turns of f about zero along Re s = rate: no root is looked for.
Stiffness-proportional damping b K takes b w^2 / 2 off the rate of a mode of frequency w, which bends that line.

Rounding moves the reaction of a stiff plate that turns slowly (`rounding_noise`): an undamped plate sums it up.
Positions are rounded at every step, each node by itself: a random displacement of half a unit in the last place of
the plate's length. It feeds energy into all modes alike, at a rate that goes with the stiffness, and the corner's
spring has its part of that energy.
"""

import bisect
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fem.laws.friction import friction_slope
from fem.lazy import cached
from fem.machine_code.compiled import compiled
from fem.model.plate_model import PlateModel
from fem.plate.elastic import Inverse
from fem.start.inertia_relief import RigidStart, to_global

MAX_UNKNOWNS = 1200
"""Above this all modes cost more than many a run; a coarser mesh of the same plate then stands in."""

INSTANTS = 9
"""Angles between the start and zero at which the model is linearised."""

HARMLESS = 5.0
"""Exponent of growth during the run that leaves no trace: after inertia relief the ripple is 1e-6 to 1e-7 of the
reaction."""

FACTOR = math.sqrt(2.0)
"""Between the rates that are tried."""


class CornerModes(NamedTuple):
    """Squares of the free plate's circular frequencies, shape (modes,), its rigid motions as one with zero first; the
    corner's motion in each mode of unit modal mass [1/sqrt(kg)], in the body frame, shape (2, modes)."""

    squares: np.ndarray
    corner: np.ndarray


@dataclass(frozen=True)
class Flutter:
    """Growth by friction.

    Attributes
    ----------
    rate : float
        No mode grows faster [1/s]; 0 where none reaches the harmless rate.
    growth : float
        Exponent over the run at most [-].
    lowest : float
        Elastic frequency of the free plate [rad/s]; 0 where nothing was to be analysed.
    """

    rate: float
    growth: float
    lowest: float = 0.0


def predict_flutter(
    model: PlateModel, start: RigidStart, duration: float, viscous: float = 0.0, harmless: float = HARMLESS
) -> Flutter:
    """Growth over a run.

    Parameters
    ----------
    model : PlateModel
        The plate.
    start : RigidStart
        Motion of the rigid body.
    duration : float
        Of the run [s].
    viscous : float
        Rate that damping takes off a mode over its frequency squared [s], see `viscous_rate`.
    harmless : float
        Exponent of growth below which nothing is told apart [-].

    Returns
    -------
    Flutter
        The fastest growth.
    """
    slope = friction_slope(model.loop.friction, start.corner_speed)
    if slope == 0.0:
        return Flutter(0.0, 0.0)  # a symmetric stiffness: no growth
    modes = corner_modes(model)
    least, rates = harmless / duration, []
    for angle in np.linspace(start.angle, 0.0, INSTANTS):
        rates.append(_rate(model, modes, angle, slope, viscous, least))
    growth = float(np.trapezoid(rates, dx=duration / (INSTANTS - 1)))
    return Flutter(max(rates), growth, math.sqrt(modes.squares[3]))


def viscous_rate(model: PlateModel) -> float:
    """Rate that the model's viscosity takes off a mode over its frequency squared [s], the bulk part left aside."""
    viscosity = model.loop.viscosity
    return 0.0 if viscosity is None else 0.5 * viscosity.c_33 / model.tangent_moduli.c_33


def corner_modes(model: PlateModel) -> CornerModes:
    """All modes of the free plate as the corner sees them."""
    corner, nodes = model.loop.corner, model.loop.mass.size
    squares, shapes = _unit_modes(model.elastic.inverse)
    moved = np.einsum("n,inm->im", corner.weights, shapes.reshape(2, nodes, -1)[:, corner.nodes])
    return CornerModes(model.elastic.modulus * squares, moved)


@cached("free modes")
def _unit_modes(plate: Inverse) -> tuple[np.ndarray, np.ndarray]:
    """Squares [rad^2/s^2] and shapes of unit modal mass, shape (2 nodes, modes), of all modes of a plate."""
    root = 1.0 / np.sqrt(np.tile(plate.masses, 2))
    squares, shapes = np.linalg.eigh(root[:, None] * plate.stiffness.toarray() * root)
    return np.maximum(squares, 0.0), root[:, None] * shapes


def _rate(
    model: PlateModel, modes: CornerModes, angle: float, slope: float, viscous: float, least: float
) -> float:
    """The least rate [1/s] of those tried that no mode outgrows at this angle; 0 if that is the first."""
    along, across = to_global(angle) @ modes.corner  # rows: directions X and Y in the body frame
    residues = across * (across + slope * along)
    residues[2] = residues[:3].sum()  # rigid motions have no stiffness
    squares, residues = modes.squares[2:], residues[2:]
    squares[0] = 0.0
    stiffness, dashpot = model.loop.corner.stiffness, model.loop.corner.dashpot
    top, tried = 1.5 * highest_mode(squares, residues, stiffness), [least]
    while tried[-1] < top:
        tried.append(tried[-1] * FACTOR)

    def outgrown_by_none(rate: float) -> bool:
        return rate >= top or not growing_modes(squares, residues, stiffness, dashpot, viscous, rate, top)

    if outgrown_by_none(least):
        return 0.0
    return tried[bisect.bisect_left(tried, True, lo=1, key=outgrown_by_none)]


def highest_mode(squares: np.ndarray, residues: np.ndarray, stiffness: float) -> float:
    """Frequency [rad/s] above which the constrained plate has no mode."""
    spring = stiffness * np.abs(residues).sum() if math.isfinite(stiffness) else 0.0
    return math.sqrt(squares[-1] + spring)


@compiled
def growing_modes(squares, residues, stiffness, dashpot, viscous, rate, top):
    """Number of roots that grow faster than `rate` [1/s] beside the damping `viscous`, two to an oscillation.

    Steps along the line from the real axis up to `top` [rad/s], each small enough for f to turn by less than a
    radian, or as small as a hundredth of the distance to the poles. Between poles steps are half as long as the way to
    the next, so that their number grows with that of the modes alone. squares: rising, the first zero.
    """
    exact = not np.isfinite(stiffness)
    step, frequency, turned, above = 2.0 * rate, 0.0, 0.0, 0
    before = _response(squares, residues, stiffness, dashpot, exact, rate, 0.0)
    while frequency < top:
        later = frequency + step
        ahead = rate + viscous * later * later
        value = _response(squares, residues, stiffness, dashpot, exact, ahead, later)
        turn = np.angle(value * before.conjugate())
        if abs(turn) > 1.0 and step > 0.01 * rate:
            step *= 0.5
            continue
        turned, frequency, before = turned + turn, later, value
        while above < squares.size and squares[above] <= frequency * frequency:
            above += 1
        gap = frequency - math.sqrt(squares[above - 1])
        if above < squares.size:
            gap = min(gap, math.sqrt(squares[above]) - frequency)
        step = min(max(2.0 * ahead, 0.5 * gap), 1.5 * step)
    # Far out f is real and positive, or where the constraint is exact s^2 f is.
    turned -= np.angle(before)
    return round(abs(turned) / math.pi)


@compiled
def _response(squares, residues, stiffness, dashpot, exact, real, imaginary):
    """f(s) at s = real + i imaginary; of an exact constraint s^2 f(s)."""
    p, q = real * real - imaginary * imaginary, 2.0 * real * imaginary
    f_real = f_imaginary = 0.0
    for mode in range(squares.size):
        distance = squares[mode] + p
        fraction = residues[mode] / (distance * distance + q * q)
        f_real += distance * fraction
        f_imaginary -= q * fraction
    value = complex(f_real, f_imaginary)
    if exact:
        return value * complex(p, q)
    return value + 1.0 / complex(stiffness + dashpot * real, dashpot * imaginary)


SEEN = 0.3
"""Ripple that is seen over that of energy shared equally by all modes, see benchmarks/rounding.py."""


@dataclass(frozen=True)
class RoundingNoise:
    """Energy that rounding feeds into the plate.

    Attributes
    ----------
    power : float
        Of the energy [W].
    reaction : float
        Ripple of the reaction for it [N/sqrt(J)].
    frequency : float
        Highest of the model [rad/s].
    """

    power: float
    reaction: float
    frequency: float

    def ripple(self, duration: float) -> float:
        """Ripple of the reaction at the end of an undamped run, root mean square.

        Parameters
        ----------
        duration : float
            Of the run [s].

        Returns
        -------
        float
            [N].
        """
        return self.reaction * math.sqrt(self.power * duration)

    def rate_for(self, ripple: float) -> float:
        """Damping of elastic velocities that keeps the ripple at this.

        Parameters
        ----------
        ripple : float
            [N].

        Returns
        -------
        float
            Rate [1/s], at most the highest frequency: above it the stable time step falls as the rate grows, and
            rounding feeds in energy as much faster.
        """
        return min(self.power * (self.reaction / ripple) ** 2, self.frequency)


def rounding_noise(model: PlateModel) -> RoundingNoise:
    """The noise of a model.

    Parameters
    ----------
    model : PlateModel
        The plate.

    Returns
    -------
    RoundingNoise
        Power and ripple.
    """
    loop, step = model.loop, model.loop.time_step
    corner = loop.corner
    moved = np.finfo(float).eps * float(np.ptp(model.discretisation.positions)) / math.sqrt(12.0)
    # Half the largest eigenvalue is a typical diagonal element of the stiffness over the mass.
    energy = 0.25 * model.mass * (model.highest_frequency * moved) ** 2
    stiffness = 1.0 / (corner.mobility * step**2) if corner.is_exact else corner.stiffness
    return RoundingNoise(energy / step, SEEN * math.sqrt(stiffness / loop.mass.size), model.highest_frequency)
