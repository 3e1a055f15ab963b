"""The linear stiffness of the unstrained plate, its highest frequency and the stable time step."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import scipy.sparse as sp

from fem.materials import StVenantKirchhoff


def stiffness_matrix(scalar: Any, thickness: float, material: StVenantKirchhoff) -> sp.csr_matrix:
    """Plane-stress stiffness [N/m] in the body frame, shape (2 nodes, 2 nodes): all x unknowns, then all y."""
    import skfem
    from skfem.helpers import grad

    def assemble(k: int, m: int) -> sp.csr_matrix:
        return skfem.BilinearForm(lambda u, v, w: grad(v)[k] * grad(u)[m]).assemble(scalar)

    xx, yy, xy = assemble(0, 0), assemble(1, 1), assemble(0, 1)
    coupling = material.c_12 * xy + material.c_33 * xy.T
    blocks = [
        [material.c_11 * xx + material.c_33 * yy, coupling],
        [coupling.T, material.c_11 * yy + material.c_33 * xx],
    ]
    return sp.csr_matrix(thickness * sp.bmat(blocks))


class Spectrum:
    """The plate's stiffness with the corner's spring, for its highest frequency and stable time steps.

    The spring turns in the body frame as the plate turns; it is taken in both directions, which bounds it.
    """

    def __init__(self, stiffness: sp.csr_matrix, masses: np.ndarray, corner: int, penalty: float) -> None:
        root = sp.diags(1.0 / np.sqrt(np.tile(masses, 2)))
        spring = np.zeros(2 * masses.size)
        spring[[corner, corner + masses.size]] = penalty
        self._plate = sp.csr_matrix(root @ stiffness @ root)
        self._held = sp.csr_matrix(self._plate + root @ sp.diags(spring) @ root)
        self._vector = np.cos(1.7 * np.arange(spring.size)) + 0.1  # fixed, so that runs repeat to the bit

    def highest_frequency(self) -> float:
        """Highest circular frequency [rad/s], by Lanczos."""
        return math.sqrt(self._largest(self._held))

    def stable_time_step(self, frequency: float, viscosity: float | None) -> float:
        """Largest stable step [s] of central differences, the damping force being half a step late.

        viscosity [s] times the plate's stiffness is the damping; the spring is not damped. An oscillation
        that changes sign every step stays bounded as long as dt^2 (K + K_spring) + 2 dt viscosity K has no
        eigenvalue above 4 against the masses. For one mass this is w dt = 2 (sqrt(1 + z^2) - z).
        """
        undamped = 2.0 / frequency
        if viscosity is None:
            return undamped
        from scipy.optimize import brentq

        def excess(step: float) -> float:
            return math.sqrt(self._largest(step**2 * self._held + 2.0 * step * viscosity * self._plate)) - 2.0

        ratio = 0.5 * viscosity * frequency
        all_damped = undamped * (math.sqrt(1.0 + ratio**2) - ratio)
        return float(brentq(excess, 0.999 * all_damped, 1.001 * undamped, rtol=1e-6))

    def _largest(self, matrix: sp.csr_matrix) -> float:
        from scipy.sparse.linalg import eigsh

        values, vectors = eigsh(matrix, k=1, which="LM", v0=self._vector, tol=1e-8)
        self._vector = vectors[:, 0] + 1e-3 * self._vector
        return float(values[0])
