"""The plate's highest frequency with what holds it, and the largest stable time step.

The largest eigenvalue of a symmetric operator by Lanczos with thick restarts (Wu and Simon 2000), written out, so that
it takes the same steps, and the time step has the same digits, with every version of SciPy: those of ARPACK differ by
the tolerance from one version to the next. On the assembled model it ends at a loose residual: the eigenvalue's error
goes with the residual's square over the distance to the next one, and is mostly below 1e-6 there. The time step is made
from a bound that takes the residual itself: no closer is the eigenvalue known that Lanczos has found.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from fem.laws.constraints import CornerConstraint
from fem.lazy import cached
from fem.plate.elastic import ElasticSolver, Inverse

KEPT = 1.0 / 3.0
"""Fraction of the basis that a restart retains, of the vectors of the largest eigenvalues."""

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
        raise FloatingPointError("the operator is not finite")
    rows[each + 1] = vector / length
    return length


TOLERANCE, ROUGH = 1e-4, 2e-4
"""Residual over the eigenvalue at which Lanczos ends, and where it only tells whether an angle may be above another."""

BASIS = 12
"""Lanczos vectors: more take fewer products and more time."""

LARGE = 10_000
"""Nodes from which on a spectrum is not cached."""

STEP_SETTLED = 1e-6
"""Relative change of the damped time step at which Newton's method ends."""


class Hold(NamedTuple):
    """Constraint of the corner, as the spectrum needs it.

    nodes: that the constraint acts on; across: weights of their x and then their y unknowns in the direction across
    the wall in the body frame, at each angle of the plate that is looked at; spring [N/m]; dashpot [N s/m].
    """

    nodes: tuple[int, ...]
    across: tuple[tuple[float, ...], ...]
    spring: float
    dashpot: float

    def of_modulus(self, modulus: float) -> Hold:
        """The constraint on a plate of this modulus [Pa], where this one is on a plate of unit modulus."""
        return self._replace(spring=modulus * self.spring, dashpot=math.sqrt(modulus) * self.dashpot)


FREE = Hold((), ((),), 0.0, 0.0)
"""A plate that nothing holds."""


class Peak(NamedTuple):
    """Largest eigenvalue, residual of its vector of unit length, that vector, and the angle's number."""

    value: float
    residual: float
    vector: np.ndarray
    angle: int

    @property
    def bound(self) -> float:
        """The eigenvalue is not above this."""
        return self.value + self.residual


class Spectrum:
    """Stiffness and masses of a plate, as it is held, with its highest frequency.

    Parameters
    ----------
    stiffness : sparse matrix, shape (2 nodes, 2 nodes)
        [N/m].
    masses : ndarray, shape (nodes,)
        [kg].
    hold : Hold
        How the corner is held.
    """

    def __init__(self, stiffness: Any, masses: np.ndarray, hold: Hold = FREE) -> None:
        self._stiffness, self._hold = stiffness, hold
        nodes = np.array(hold.nodes, dtype=int)
        self._held, self._across = np.concatenate([nodes, nodes + masses.size]), np.array(hold.across)
        self._root = 1.0 / np.sqrt(np.tile(masses, 2))
        self._first = np.cos(1.7 * np.arange(2 * masses.size)) + 0.1  # fixed, so that runs repeat to the bit
        self._peak = self._highest(stiffness, hold.spring, self._first)

    @property
    def frequency(self) -> float:
        """Highest circular frequency [rad/s], to about 1e-6."""
        return math.sqrt(self._peak.value)

    @property
    def bound(self) -> float:
        """A circular frequency [rad/s] that the highest is not above."""
        return math.sqrt(self._peak.bound)

    @property
    def mode(self) -> np.ndarray:
        """The mode of the highest frequency times the roots of the masses, of unit length, shape (2, nodes)."""
        return self._peak.vector.reshape(2, -1)

    def stable_time_step(self, damping: Any = None) -> float:
        """Largest stable step [s] of central differences, the damping forces being half a step late.

        damping: the plate's damping matrix [N s/m]; the dashpot is added. An oscillation that changes sign every step
        stays bounded as long as dt^2 K + 2 dt C has no eigenvalue above 4 against the masses: for one mass this is
        w dt = 2 (sqrt(1 + z^2) - z). The eigenvalue is convex in dt, so that Newton's steps come from above, and an
        excess over 4 is made good by a step shorter in proportion.
        """
        step, peak = 2.0 / self.bound, self._peak
        if damping is None and not self._hold.dashpot:
            return step
        plate = 0.0 * self._stiffness if damping is None else damping
        while True:
            matrix = step**2 * self._stiffness + 2.0 * step * plate
            spring = step**2 * self._hold.spring + 2.0 * step * self._hold.dashpot
            peak = self._highest(matrix, spring, peak.vector)
            shorter = self._step_for(peak, plate)
            if shorter > (1.0 - STEP_SETTLED) * step:
                return step * min(1.0, 4.0 / peak.bound)
            step = shorter

    def _step_for(self, peak: Peak, plate: Any) -> float:
        """The step [s] at which the motion of this vector changes sign every step without growing."""
        move, held = self._root * peak.vector, self._across[peak.angle] @ self._touching(peak.vector)
        stiffness = float(move @ (self._stiffness @ move)) + self._hold.spring * held**2
        damping = float(move @ (plate @ move)) + self._hold.dashpot * held**2
        return 4.0 / (damping + math.sqrt(damping**2 + 4.0 * stiffness))

    def _touching(self, vector: np.ndarray) -> np.ndarray:
        """Displacements of the unknowns that are held."""
        return np.asarray(self._root[self._held] * vector[self._held])

    def _highest(self, matrix: Any, spring: float, first: np.ndarray) -> Peak:
        """The largest eigenvalue over all angles; an angle that is not above another is not looked at closely."""
        best = self._largest(matrix, spring, 0, first, TOLERANCE)
        for angle in range(1, len(self._across)):
            rough = self._largest(matrix, spring, angle, best.vector, ROUGH)
            if rough.value > best.bound:
                rough = self._largest(matrix, spring, angle, rough.vector, TOLERANCE)
            best = max(best, rough, key=lambda peak: peak.bound)
        return best

    def _largest(self, matrix: Any, spring: float, angle: int, first: np.ndarray, tolerance: float) -> Peak:
        """The largest eigenvalue at an angle, from a vector near to its own."""
        unknowns, across = self._held, self._across[angle]
        pull = self._root[unknowns] * across

        def product(vector: np.ndarray) -> np.ndarray:
            force = self._root * (matrix @ (self._root * vector))
            force[unknowns] += spring * pull * (pull @ vector[unknowns])
            return np.asarray(force)

        # a vector that is orthogonal to the one sought would never find it
        start = first + 1e-3 * self._first
        value, vector = largest_eigenpair(product, start, tolerance, BASIS)
        return Peak(value, float(np.linalg.norm(product(vector) - value * vector)), vector, angle)


@dataclass(frozen=True)
class ScaledSpectrum:
    """The spectrum of a plate whose stiffness, springs included, is that of `unit` times the modulus [Pa]."""

    unit: Spectrum
    modulus: float

    @property
    def frequency(self) -> float:
        """Highest circular frequency [rad/s]."""
        return math.sqrt(self.modulus) * self.unit.frequency

    @property
    def mode(self) -> np.ndarray:
        """Mode of the highest frequency, see `Spectrum.mode`."""
        return self.unit.mode

    def stable_time_step(self, damping: Any = None) -> float:
        """Largest stable time step [s], see `Spectrum.stable_time_step`."""
        root = math.sqrt(self.modulus)
        return self.unit.stable_time_step(None if damping is None else damping / root) / root


def spectrum_of(elastic: ElasticSolver, hold: Hold = FREE) -> ScaledSpectrum:
    """The spectrum of the plate of this solver; hold: see `hold_of`."""
    plate = elastic.inverse
    find = _unit_spectrum if plate.masses.size < LARGE else _unit_spectrum.__wrapped__
    return ScaledSpectrum(find(plate, hold), elastic.modulus)


@cached("spectrum")
def _unit_spectrum(plate: Inverse, hold: Hold) -> Spectrum:
    return Spectrum(plate.stiffness, plate.masses, hold)


def hold_of(corner: CornerConstraint, angles: tuple[float, ...] = (0.0,), modulus: float = 1.0) -> Hold:
    """How this corner holds a plate of unit modulus: as it holds one of this modulus [Pa].

    angles [rad]: of the plate during its run; the constraint acts across the wall, and so turns in the body frame.
    """
    if not corner.spring:  # all angles are alike
        return FREE
    weights, nodes = corner.weights.tolist(), corner.nodes.tolist()
    turned = ((-math.sin(angle), math.cos(angle)) for angle in angles)
    across = tuple(tuple(part * weight for part in direction for weight in weights) for direction in turned)
    return Hold(
        tuple(nodes), across, _rounded(corner.spring / modulus), _rounded(corner.dashpot / math.sqrt(modulus))
    )


def _rounded(value: float) -> float:
    """To twelve digits: those in which the quotients of springs and moduli in proportion are the same."""
    return float(f"{value:.12g}")
