"""Nodal masses: row sums, moved by the least relative change to the exact rigid-body inertia."""

from __future__ import annotations

from typing import Any

import numpy as np

from fem.discretisation.properties import Inertia, ModelError

MOMENTS = (
    lambda x, y: np.ones_like(x),
    lambda x, y: x,
    lambda x, y: y,
    lambda x, y: x * x,
    lambda x, y: x * y,
    lambda x, y: y * y,
)
"""Mass, first and second moments, as functions of position."""


def row_sum_masses(scalar: Any, density: float, thickness: float) -> np.ndarray:
    """Row sums of the consistent mass matrix [kg], shape (nodes,)."""
    import skfem

    return density * thickness * skfem.LinearForm(lambda v, w: v).assemble(scalar)


def scaled_diagonal_masses(scalar: Any, density: float, thickness: float) -> np.ndarray:
    """Diagonal of the consistent mass matrix, scaled to the plate's mass (Hinton, Rock and Zienkiewicz) [kg]."""
    import skfem

    diagonal = skfem.BilinearForm(lambda u, v, w: u * v).assemble(scalar).diagonal()
    return np.asarray(diagonal * (density * thickness * scalar.dx.sum() / diagonal.sum()))


def exact_inertia_masses(scalar: Any, density: float, thickness: float) -> np.ndarray:
    """Masses [kg] with the exact mass, centre and second moments of the meshed body, shape (nodes,).

    Row sums overstate the rotary inertia by the order of the squared element size. Of all corrections that
    make the six moments exact, this has the least sum of squared relative changes: m = m_0 + m_0^2 A^T z.
    Elements with row sums that are not positive (tri6) start from the scaled diagonal instead.
    Raises ModelError if a mass would not stay positive (a mesh too coarse to carry the moments).
    """
    masses = row_sum_masses(scalar, density, thickness)
    if masses.min() < 1e-3 * masses.mean():
        masses = scaled_diagonal_masses(scalar, density, thickness)
    moments = np.array([moment(*_scaled(scalar)) for moment in MOMENTS])
    exact = _exact_moments(scalar) * density * thickness
    weighted = moments * masses**2
    multipliers = np.linalg.lstsq(weighted @ moments.T, exact - moments @ masses, rcond=None)[0]
    masses = masses + masses**2 * (multipliers @ moments)
    if not (masses > 0.0).all():
        raise ModelError(
            "elements", "the mesh is too coarse to carry the exact inertia with positive nodal masses"
        )
    if not np.allclose(moments @ masses, exact, rtol=1e-12, atol=1e-12 * exact[0]):
        raise ModelError("elements", "the mesh has too few nodes to carry the exact inertia")
    return masses


def given_inertia_masses(positions: np.ndarray, masses: np.ndarray, inertia: Inertia) -> np.ndarray:
    """Masses [kg] with their own sum, and this centre and yaw inertia, shape (nodes,); corner P is the origin.

    Of all such masses those of the greatest entropy beside the given ones, m exp(z . moments): they are positive, and
    there are some wherever any positive masses have that inertia. Raises ModelError where there are none.
    """
    total, size = masses.sum(), np.ptp(positions, axis=1)
    x = (positions[0] + inertia.centre) / size[0]
    y = (positions[1] - 0.5 * size[1]) / size[0]
    moments = np.array([np.ones_like(x), x, y, x * x + y * y])
    wanted = np.array([1.0, 0.0, 0.0, inertia.yaw_inertia / (total * size[0] ** 2)])
    multipliers = np.zeros(4)
    for _ in range(NEWTON_STEPS):
        tilted = masses / total * np.exp(multipliers @ moments)
        excess = moments @ tilted - wanted
        if np.abs(excess).max() < 1e-15 * len(masses):
            break
        step = np.linalg.lstsq((moments * tilted) @ moments.T, excess, rcond=None)[0]
        multipliers -= step / max(1.0, np.abs(step).max() / 2.0)
    tilted = total * tilted
    if not np.allclose(moments @ tilted, total * wanted, rtol=0.0, atol=1e-11 * total) or tilted.min() <= 0.0:
        raise ModelError("inertia", "no positive nodal masses have this centre of mass and yaw inertia")
    return tilted


NEWTON_STEPS = 200
"""For the masses of a given inertia; ten are enough but near the limit of what any masses can have."""


def _frame(scalar: Any) -> tuple[np.ndarray, np.ndarray]:
    """Middle and size of the mesh: moments in these coordinates are of order one."""
    low, high = scalar.doflocs.min(axis=1), scalar.doflocs.max(axis=1)
    return (low + high) / 2.0, high - low


def _scaled(scalar: Any) -> np.ndarray:
    middle, size = _frame(scalar)
    return (scalar.doflocs - middle[:, None]) / size[:, None]


def _exact_moments(scalar: Any) -> np.ndarray:
    from skfem.quadrature import get_quadrature

    middle, size = _frame(scalar)
    points, weights = get_quadrature(scalar.elem, 4)
    volumes = np.abs(scalar.mapping.detDF(points)) * weights
    x = (np.asarray(scalar.mapping.F(points)) - middle[:, None, None]) / size[:, None, None]
    return np.array([np.sum(moment(*x) * volumes) for moment in MOMENTS])
