"""Fields over the plate for pictures."""

from __future__ import annotations

from typing import Any

import numpy as np


def nodal_spin(scalar: Any, positions: np.ndarray, velocities: np.ndarray) -> np.ndarray:
    """Local angular velocity [rad/s] at the corner nodes, half the curl of the velocity, shape (corner nodes,).

    positions [m], velocities [m/s]: shape (2, nodes). Evaluated at the quadrature points of the deformed plate,
    L = F' F^-1, and carried to the corner nodes by the lumped projection on linear functions: the quadratic ones of
    a triangle's corners have no integral to divide by.
    """
    import skfem

    def gradient(values: np.ndarray) -> np.ndarray:
        return np.array([scalar.interpolate(component).grad for component in values])

    deformation, rate = gradient(positions), gradient(velocities)
    inverse = np.linalg.inv(np.moveaxis(deformation, (0, 1), (-2, -1)))
    velocity_gradient = np.moveaxis(rate, (0, 1), (-2, -1)) @ inverse
    spin = 0.5 * (velocity_gradient[..., 1, 0] - velocity_gradient[..., 0, 1])
    linear = skfem.ElementQuad1() if scalar.mesh.refdom is skfem.refdom.RefQuad else skfem.ElementTriP1()
    corners = scalar.with_element(linear)
    weighted = skfem.LinearForm(lambda v, w: w.spin * v).assemble(corners, spin=spin)
    return np.asarray(weighted / skfem.LinearForm(lambda v, w: v).assemble(corners))
