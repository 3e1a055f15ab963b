"""Nodal masses of the plate, with its exact or a prescribed inertia.

Nodal masses are row sums of the consistent mass matrix, corrected by the least relative change to the exact rigid-body
inertia.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fem.plate.properties import Inertia, ModelError

if TYPE_CHECKING:
    from skfem import CellBasis

NEWTON_STEPS = 200
"""Steps of Newton's method for the masses of a prescribed inertia.

Thirty are enough, also near the limit of the inertia that positive masses can have.
"""


def row_sum_masses(scalar: CellBasis, density: float, thickness: float) -> np.ndarray:
    """Return the row sums of the consistent mass matrix [kg], shape (nodes,)."""
    import skfem

    return density * thickness * skfem.LinearForm(lambda v, w: v).assemble(scalar)


def scaled_diagonal_masses(scalar: CellBasis, density: float, thickness: float) -> np.ndarray:
    """Return the scaled diagonal of the consistent mass matrix [kg].

    The diagonal is scaled to the plate's mass (Hinton, Rock and Zienkiewicz).
    """
    import skfem

    diagonal = skfem.BilinearForm(lambda u, v, w: u * v).assemble(scalar).diagonal()
    return np.asarray(diagonal * (density * thickness * scalar.dx.sum() / diagonal.sum()))


def exact_inertia_masses(scalar: CellBasis, density: float, thickness: float) -> np.ndarray:
    """Return nodal masses [kg] with the exact inertia of the body.

    Their shape is (nodes,). Mass, centre and second moments are exact. Row sums overstate the rotary inertia by the
    order of the squared element size. Of all corrections that make the six moments exact, this one has the least sum
    of squared relative changes: m = m_0 + m_0^2 A^T z. Elements with row sums that are not positive (tri6) start from
    the scaled diagonal instead. Raises ModelError if a mass would not stay positive, on a mesh too coarse to carry
    the moments.
    """
    masses = row_sum_masses(scalar, density, thickness)
    if masses.min() < 1e-3 * masses.mean():
        masses = scaled_diagonal_masses(scalar, density, thickness)
    middle, size = _frame(scalar)
    moments = np.array(_moments(*((scalar.doflocs - middle[:, None]) / size[:, None])))
    exact = _exact_moments(scalar) * density * thickness
    weighted = moments * masses**2
    multipliers = np.linalg.lstsq(weighted @ moments.T, exact - moments @ masses, rcond=None)[0]
    masses = masses + masses**2 * (multipliers @ moments)
    if not (masses > 0.0).all():
        coarse = "the mesh is too coarse for the exact inertia with positive nodal masses"
        raise ModelError("elements", coarse)
    if not np.allclose(moments @ masses, exact, rtol=1e-12, atol=1e-12 * exact[0]):
        raise ModelError("elements", "the mesh has too few nodes for the exact inertia")
    return masses


def prescribed_inertia_masses(positions: np.ndarray, masses: np.ndarray, inertia: Inertia) -> np.ndarray:
    """Return nodal masses [kg] of a prescribed inertia.

    Their shape is (nodes,). masses: [kg], whose sum is unchanged; corner P is the origin. Of all masses with that
    inertia the result has the greatest sum of m_0 log(m), their analytic centre, m_0 / (z . moments). It has no light
    nodes, which would shorten the time step, and exists wherever any positive masses have that inertia. Raises
    ModelError where there are none.
    """
    total, size = masses.sum(), np.ptp(positions, axis=1)
    x = (positions[0] + inertia.centre) / size[0]
    y = (positions[1] - 0.5 * size[1]) / size[0]
    moments = np.array([np.ones_like(x), x, y, x * x + y * y])
    target = np.array([1.0, 0.0, 0.0, inertia.yaw_inertia / (total * size[0] ** 2)])
    multipliers = np.array([1.0, 0.0, 0.0, 0.0])
    for _ in range(NEWTON_STEPS):
        divisors = multipliers @ moments
        centred = masses / total / divisors
        excess = moments @ centred - target
        if np.abs(excess).max() < 1e-15 * len(masses):
            break
        slopes = moments * centred / divisors
        step = np.linalg.lstsq(slopes @ moments.T, excess, rcond=None)[0]
        change = np.abs(step @ moments / divisors).max()
        multipliers += step / (1.0 + change if change > 0.25 else 1.0)  # divisors stay positive
    centred = total * centred
    if not np.allclose(moments @ centred, total * target, rtol=0.0, atol=1e-11 * total):
        raise ModelError("inertia", "no positive nodal masses have this centre of mass and yaw inertia")
    return centred


def _frame(scalar: CellBasis) -> tuple[np.ndarray, np.ndarray]:
    """Return middle and size of the mesh.

    Moments in these coordinates are of order one.
    """
    low, high = scalar.doflocs.min(axis=1), scalar.doflocs.max(axis=1)
    return (low + high) / 2.0, high - low


def _moments(x: np.ndarray, y: np.ndarray) -> list[np.ndarray]:
    """Return mass, first and second moments as functions of position."""
    return [np.ones_like(x), x, y, x * x, x * y, y * y]


def _exact_moments(scalar: CellBasis) -> np.ndarray:
    """Return the exact moments of the meshed body in `_frame`.

    Integrals over straight-sided elements are sums over their sides by Green's theorem.
    """
    middle, size = _frame(scalar)
    x, y = ((scalar.mesh.p - middle[:, None]) / size[:, None])[:, scalar.mesh.t]
    u, v = np.roll(x, -1, axis=0), np.roll(y, -1, axis=0)  # the next corners
    cross = x * v - u * y
    cross *= np.sign(cross.sum(axis=0))
    mixed = x * v + 2.0 * (x * y + u * v) + u * y
    moments = [np.full_like(x, 1.0 / 2.0), (x + u) / 6.0, (y + v) / 6.0]
    moments += [(x * x + x * u + u * u) / 12.0, mixed / 24.0, (y * y + y * v + v * v) / 12.0]
    return size.prod() * np.array([np.sum(moment * cross) for moment in moments])
