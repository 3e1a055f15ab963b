"""The linear stiffness of the unstrained plate, its highest frequency and the stable time step."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy.sparse as sp

from fem.contact.corner import Corner
from fem.discretisation.elements import ElementTable, Hourglass


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
    """The plate's stiffness with what holds it, for its highest frequency and stable time steps.

    springs [N/m], dashpots [N s/m]: matrices that are added, one pair for each position of the plate that is looked
    at; no dashpots where there are none.
    """

    def __init__(
        self,
        stiffness: sp.csr_matrix,
        masses: np.ndarray,
        springs: Sequence[sp.csr_matrix],
        dashpots: Sequence[sp.csr_matrix] = (),
    ) -> None:
        self._root = sp.diags(1.0 / np.sqrt(np.tile(masses, 2)))
        self._constrained = [self._scaled(stiffness + spring) for spring in springs]
        self._dashpots = [self._scaled(dashpot) for dashpot in dashpots]
        self._vector = np.cos(1.7 * np.arange(2 * masses.size)) + 0.1  # fixed, so that runs repeat to the bit

    def highest_frequency(self) -> float:
        """Highest circular frequency [rad/s], by Lanczos."""
        return math.sqrt(max(self._largest(k) for k in self._constrained))

    def stable_time_step(self, frequency: float, damping: sp.csr_matrix | None) -> float:
        """Largest stable step [s] of central differences, the damping forces being half a step late.

        damping: the plate's damping matrix [N s/m]; the dashpots are added. An oscillation that changes
        sign every step stays bounded as long as dt^2 K + 2 dt C has no eigenvalue above 4 against the masses.
        For one mass this is w dt = 2 (sqrt(1 + z^2) - z).
        """
        undamped = 2.0 / frequency
        if damping is None and not self._dashpots:
            return undamped
        from scipy.optimize import brentq

        plate = 0.0 * self._constrained[0] if damping is None else self._scaled(damping)
        damped = [sp.csr_matrix(plate + dashpot) for dashpot in self._dashpots] or [plate] * len(
            self._constrained
        )
        pairs = list(zip(self._constrained, damped, strict=True))

        def excess(step: float) -> float:
            return max(math.sqrt(self._largest(step**2 * k + 2.0 * step * c)) for k, c in pairs) - 2.0

        ratio = 0.5 * max(map(self._largest, damped)) / frequency
        least = undamped * (math.sqrt(1.0 + ratio**2) - ratio)
        return float(brentq(excess, 0.999 * least, 1.001 * undamped, rtol=1e-6))

    def _scaled(self, matrix: sp.csr_matrix) -> sp.csr_matrix:
        return sp.csr_matrix(self._root @ matrix @ self._root)

    def _largest(self, matrix: sp.csr_matrix) -> float:
        from scipy.sparse.linalg import eigsh

        values, vectors = eigsh(matrix, k=1, which="LM", v0=self._vector, tol=1e-8)
        self._vector = vectors[:, 0] + 1e-3 * self._vector
        return float(values[0])


def corner_spectrum(
    stiffness: sp.csr_matrix, masses: np.ndarray, corner: Corner, angles: tuple[float, ...] = (0.0,)
) -> Spectrum:
    """The spectrum of a plate whose corner is constrained.

    angles [rad]: of the plate during its run; the constraint acts across the wall, and so turns in the body frame.
    """
    # Without a spring all angles are alike.
    seen = angles if corner.spring else angles[:1]
    shapes = [_across_the_wall(corner, masses.size, angle) for angle in seen]
    dashpots = [corner.dashpot * shape for shape in shapes] if corner.dashpot else []
    return Spectrum(stiffness, masses, [corner.spring * shape for shape in shapes], dashpots)


def _across_the_wall(corner: Corner, nodes: int, angle: float) -> sp.csr_matrix:
    """w w^T for the corner's weights w in the direction across the wall, body frame, the plate at this angle."""
    columns = np.zeros_like(corner.nodes)
    shape = sp.csr_matrix((corner.weights, (corner.nodes, columns)), shape=(nodes, 1))
    across = sp.vstack([-math.sin(angle) * shape, math.cos(angle) * shape])
    return sp.csr_matrix(across @ across.T)


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
