"""The linear stiffness of the unstrained plate, its highest frequency and the stable time step."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import scipy.sparse as sp

from fem.corner import Corner
from fem.elements import ElementTable, Hourglass


def stiffness_matrix(scalar: Any, thickness: float, moduli: Any) -> sp.csr_matrix:
    """Plane-stress stiffness [N/m] in the body frame, shape (2 nodes, 2 nodes): all x unknowns, then all y.

    moduli: anything with c_11, c_12, c_33: a `StVenantKirchhoff` [Pa], or a `Viscosity` [Pa s] for a damping matrix.
    """
    import skfem
    from skfem.helpers import grad

    def assemble(k: int, m: int) -> sp.csr_matrix:
        return skfem.BilinearForm(lambda u, v, w: grad(v)[k] * grad(u)[m]).assemble(scalar)

    xx, yy, xy = assemble(0, 0), assemble(1, 1), assemble(0, 1)
    coupling = moduli.c_12 * xy + moduli.c_33 * xy.T
    blocks = [
        [moduli.c_11 * xx + moduli.c_33 * yy, coupling],
        [coupling.T, moduli.c_11 * yy + moduli.c_33 * xx],
    ]
    return sp.csr_matrix(thickness * sp.bmat(blocks))


class Spectrum:
    """The plate's stiffness with the corner's hold, for its highest frequency and stable time steps.

    The hold turns in the body frame as the plate turns; it is taken in both directions, which bounds it.
    """

    def __init__(self, stiffness: sp.csr_matrix, masses: np.ndarray, corner: Corner) -> None:
        self._root = sp.diags(1.0 / np.sqrt(np.tile(masses, 2)))
        self._shape = _both_directions(corner, masses.size)
        spring = getattr(corner.hold, "stiffness", 0.0)
        self._held = self._scaled(stiffness + spring * self._shape)
        self._dashpot = getattr(corner.hold, "damping", 0.0)
        self._vector = np.cos(1.7 * np.arange(2 * masses.size)) + 0.1  # fixed, so that runs repeat to the bit

    def highest_frequency(self) -> float:
        """Highest circular frequency [rad/s], by Lanczos."""
        return math.sqrt(self._largest(self._held))

    def stable_time_step(self, frequency: float, damping: sp.csr_matrix | None) -> float:
        """Largest stable step [s] of central differences, the damping forces being half a step late.

        damping: the plate's damping matrix [N s/m]; the hold's dashpot is added. An oscillation that changes
        sign every step stays bounded as long as dt^2 K + 2 dt C has no eigenvalue above 4 against the masses.
        For one mass this is w dt = 2 (sqrt(1 + z^2) - z).
        """
        undamped = 2.0 / frequency
        if damping is None and not self._dashpot:
            return undamped
        from scipy.optimize import brentq

        matrix = self._dashpot * self._shape if damping is None else damping + self._dashpot * self._shape
        scaled = self._scaled(matrix)

        def excess(step: float) -> float:
            return math.sqrt(self._largest(step**2 * self._held + 2.0 * step * scaled)) - 2.0

        ratio = 0.5 * self._largest(scaled) / frequency
        least = undamped * (math.sqrt(1.0 + ratio**2) - ratio)
        return float(brentq(excess, 0.999 * least, 1.001 * undamped, rtol=1e-6))

    def _scaled(self, matrix: sp.csr_matrix) -> sp.csr_matrix:
        return sp.csr_matrix(self._root @ matrix @ self._root)

    def _largest(self, matrix: sp.csr_matrix) -> float:
        from scipy.sparse.linalg import eigsh

        values, vectors = eigsh(matrix, k=1, which="LM", v0=self._vector, tol=1e-8)
        self._vector = vectors[:, 0] + 1e-3 * self._vector
        return float(values[0])


def _both_directions(corner: Corner, nodes: int) -> sp.csr_matrix:
    """w w^T in x and in y for the corner's weights w."""
    shape = sp.csr_matrix((corner.weights, (corner.nodes, np.zeros_like(corner.nodes))), shape=(nodes, 1))
    block = shape @ shape.T
    return sp.csr_matrix(sp.block_diag([block, block]))


def hourglass_matrix(table: ElementTable, hourglass: Hourglass, nodes: int) -> sp.csr_matrix:
    """Stiffness [N/m] of the hourglass control, shape (2 nodes, 2 nodes)."""
    elements = table.connectivity.shape[1]
    vectors = np.broadcast_to(hourglass.vectors, (hourglass.vectors.shape[0], elements))
    columns = np.broadcast_to(np.arange(elements), vectors.shape)
    gather = sp.csr_matrix(
        (vectors.ravel(), (table.connectivity.ravel(), columns.ravel())), shape=(nodes, elements)
    )
    block = gather @ sp.diags(np.broadcast_to(hourglass.stiffness, elements)) @ gather.T
    return sp.csr_matrix(sp.block_diag([block, block]))
