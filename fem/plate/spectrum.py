"""Highest frequency of the supported plate, and its largest stable time step.

Lanczos ends at a loose residual on the assembled model. The error of the eigenvalue is the square of the residual
over the distance to the next eigenvalue, mostly below 1e-6. The time step follows from a bound that includes the
residual itself, because Lanczos guarantees the eigenvalue no closer.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from fem.cache import cached
from fem.plate.elastic import ElasticSolver, Inverse
from fem.plate.lanczos import extend_by, fixed_vector, largest_eigenpair
from fem.plate.support import Support

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

TOLERANCE, ROUGH = 1e-4, 2e-4
"""Residual over the eigenvalue at which Lanczos ends.

The rough one is enough to decide whether the eigenvalue at an angle may be above another.
"""

BASIS = 12
"""Number of Lanczos vectors; more take fewer products and more time."""

LARGE = 10_000
"""Number of nodes from which on a plate and its spectrum are not cached."""

STEP_SETTLED = 1e-6
"""Relative change of the damped time step at which Newton's method ends."""

FREE = Support()
"""Plate without support."""


class Peak(NamedTuple):
    """Largest eigenvalue with its residual and vector.

    The vector has unit length; angle is the number of the angle.
    """

    value: float
    residual: float
    vector: np.ndarray
    angle: int

    @property
    def bound(self) -> float:
        """Upper bound of the eigenvalue."""
        return self.value + self.residual


class Spectrum:
    """Stiffness and masses of a supported plate, with its highest frequency.

    Parameters
    ----------
    stiffness : sparse matrix, shape (2 nodes, 2 nodes)
        Stiffness [N/m].
    masses : ndarray, shape (nodes,)
        Nodal masses [kg].
    support : Support
        Support of the corner.
    """

    def __init__(self, stiffness: csr_matrix, masses: np.ndarray, support: Support = FREE) -> None:
        self._stiffness, self._support = stiffness, support
        nodes = np.array(support.nodes, dtype=int)
        self._supported, self._across = np.concatenate([nodes, nodes + masses.size]), np.array(support.across)
        self._root = 1.0 / np.sqrt(np.tile(masses, 2))
        self._first = fixed_vector(2 * masses.size)
        self._peak = self._highest(stiffness, support.spring, self._first)

    @property
    def frequency(self) -> float:
        """Highest circular frequency [rad/s], to about 1e-6."""
        return math.sqrt(self._peak.value)

    @property
    def bound(self) -> float:
        """Upper bound of the highest circular frequency [rad/s]."""
        return math.sqrt(self._peak.bound)

    @property
    def mode(self) -> np.ndarray:
        """Mode of the highest frequency, of unit length, shape (2, nodes).

        It is multiplied by the square roots of the masses.
        """
        return self._peak.vector.reshape(2, -1)

    def stable_time_step(self, damping: csr_matrix | None = None) -> float:
        """Return the largest stable step [s] of central differences.

        damping: the plate's damping matrix [N s/m], to which the dashpot is added; the damping forces are half a step
        late. An oscillation that changes sign every step stays bounded as long as dt^2 K + 2 dt C has no eigenvalue
        above 4 against the masses: for one mass this is w dt = 2 (sqrt(1 + z^2) - z). The eigenvalue is convex in dt,
        so that the steps of Newton's method decrease. An excess over 4 is corrected by a step that is shorter in
        proportion.
        """
        step, peak = 2.0 / self.bound, self._peak
        if damping is None and not self._support.dashpot:
            return step
        plate = 0.0 * self._stiffness if damping is None else damping
        while True:
            matrix = step**2 * self._stiffness + 2.0 * step * plate
            spring = step**2 * self._support.spring + 2.0 * step * self._support.dashpot
            peak = self._highest(matrix, spring, peak.vector)
            shorter = self._step_for(peak, plate)
            if shorter > (1.0 - STEP_SETTLED) * step:
                return step * min(1.0, 4.0 / peak.bound)
            step = shorter

    def _step_for(self, peak: Peak, plate: csr_matrix) -> float:
        """Return the step [s] at which this vector's motion is marginally stable.

        It changes sign every step without growing.
        """
        motion = self._root * peak.vector
        deflection = self._across[peak.angle] @ motion[self._supported]
        stiffness = float(motion @ (self._stiffness @ motion)) + self._support.spring * deflection**2
        damping = float(motion @ (plate @ motion)) + self._support.dashpot * deflection**2
        return 4.0 / (damping + math.sqrt(damping**2 + 4.0 * stiffness))

    def _highest(self, matrix: csr_matrix, spring: float, first: np.ndarray) -> Peak:
        """Return the largest eigenvalue over all angles.

        Angles with a rough eigenvalue below another one are not examined closely.
        """
        best = self._largest(matrix, spring, 0, first, TOLERANCE)
        for angle in range(1, len(self._across)):
            rough = self._largest(matrix, spring, angle, best.vector, ROUGH)
            if rough.value > best.bound:
                rough = self._largest(matrix, spring, angle, rough.vector, TOLERANCE)
            best = max(best, rough, key=lambda peak: peak.bound)
        return best

    def _largest(
        self, matrix: csr_matrix, spring: float, angle: int, first: np.ndarray, tolerance: float
    ) -> Peak:
        """Return the largest eigenvalue at an angle.

        first: a vector near to the eigenvector.
        """
        unknowns, across = self._supported, self._across[angle]
        direction = self._root[unknowns] * across

        def product(vector: np.ndarray) -> np.ndarray:
            force = self._root * (matrix @ (self._root * vector))
            force[unknowns] += spring * direction * (direction @ vector[unknowns])
            return np.asarray(force)

        # a vector orthogonal to the eigenvector would not converge to it
        start = first + 1e-3 * self._first
        value, vector = largest_eigenpair(extend_by(product), start, tolerance, BASIS)
        return Peak(value, float(np.linalg.norm(product(vector) - value * vector)), vector, angle)


@dataclass(frozen=True)
class ScaledSpectrum:
    """Spectrum of a plate of any Young's modulus.

    Its stiffness, springs included, is that of `unit` times the modulus [Pa].
    """

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

    def stable_time_step(self, damping: csr_matrix | None = None) -> float:
        """Return the largest stable time step [s].

        See `Spectrum.stable_time_step`.
        """
        root = math.sqrt(self.modulus)
        return self.unit.stable_time_step(None if damping is None else damping / root) / root


def spectrum_of(elastic: ElasticSolver, support: Support = FREE) -> ScaledSpectrum:
    """Return the spectrum of the plate of this solver.

    support: see `support.corner_support`.
    """
    plate = elastic.inverse
    unit_spectrum = _unit_spectrum if plate.masses.size < LARGE else _unit_spectrum.__wrapped__
    return ScaledSpectrum(unit_spectrum(plate, support), elastic.modulus)


@cached
def _unit_spectrum(plate: Inverse, support: Support) -> Spectrum:
    return Spectrum(plate.stiffness, plate.masses, support)
