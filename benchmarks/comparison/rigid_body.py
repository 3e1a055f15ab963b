"""Rigid motion without friction, and the error of a mesh's masses.

Centre and inertia are arbitrary. The corner slides on the wall, phi is the angle to the wall of the line from it to the
centre, r its length, and j the moment of inertia about the centre over the mass: (j + r^2 cos^2 phi) omega^2 and the
velocity along the wall stay as they are; time and slide are quadratures over phi.
"""

from __future__ import annotations

import numpy as np
from other_codes.plate import Plate

POINTS = 40


def rigid_values(plate: Plate, centre: np.ndarray, j: float) -> np.ndarray:
    """The `QUANTITIES` of a body with this centre and inertia.

    The centre is in the body's frame [m], j in m^2.
    """
    r, gamma = float(np.hypot(*centre)), float(np.arctan2(centre[1], -centre[0]))
    first = plate.angle + gamma

    def omega(phi: np.ndarray | float) -> np.ndarray:
        return plate.omega * np.sqrt((j + (r * np.cos(first)) ** 2) / (j + (r * np.cos(phi)) ** 2))

    v_gx = plate.speed - plate.omega * r * np.sin(first)
    points, weights = np.polynomial.legendre.leggauss(POINTS)
    phi = gamma + 0.5 * plate.angle * (1.0 + points)
    spent = 0.5 * plate.angle * weights / omega(phi)
    slide = spent @ (v_gx + omega(phi) * r * np.sin(phi))
    end = float(omega(gamma))
    return np.array([spent.sum(), v_gx, -end * r * np.cos(gamma), end, slide])


def of_rectangle(plate: Plate) -> np.ndarray:
    """Of the exact body."""
    centre = np.array([-0.5 * plate.length, 0.5 * plate.width])
    return rigid_values(plate, centre, (plate.length**2 + plate.width**2) / 12.0)


def of_row_sums(plate: Plate) -> np.ndarray:
    """The same of the centre and inertia of row-sum masses."""
    masses, body = plate.masses(), plate.body()
    centre = masses @ body / masses.sum()
    return rigid_values(plate, centre, float(masses @ ((body - centre) ** 2).sum(axis=1) / masses.sum()))


def distance(values: np.ndarray, reference: np.ndarray) -> float:
    """Largest relative difference."""
    return float(np.abs(values / reference - 1.0).max())
