"""Natural frequencies of free beams in longitudinal motion and in bending.

The beam is the plate seen from its side: length L, depth B in the plane, thickness t across. It bends in the plane.
"""

import math
from dataclasses import dataclass

import numpy as np

POLYNOMIALS = 24
"""Terms of the Ritz solution in each unknown.

The lowest ten frequencies are then exact to ten digits.
"""


@dataclass(frozen=True)
class Beam:
    """Dimensions and material of a beam.

    length and depth [m], Young's modulus [Pa], Poisson's ratio [-], density [kg/m^3]. Frequencies do not depend on
    its thickness.
    """

    length: float
    depth: float
    youngs_modulus: float
    poissons_ratio: float
    density: float

    @property
    def wave_speed(self) -> float:
        """Speed of longitudinal waves in a thin strip, sqrt(E / rho) [m/s]."""
        return math.sqrt(self.youngs_modulus / self.density)

    @property
    def shear_coefficient(self) -> float:
        """Shear coefficient of a rectangle.

        5 (1 + nu) / (6 + 5 nu), Kaneko 1975, J. Phys. D 8, 1927.
        """
        return 5.0 * (1.0 + self.poissons_ratio) / (6.0 + 5.0 * self.poissons_ratio)


def longitudinal_frequencies(beam: Beam, count: int) -> np.ndarray:
    """Return the longitudinal frequencies [Hz], shape (count,).

    They are n c / (2 L), n = 1, 2, ...
    """
    return np.arange(1, count + 1) * beam.wave_speed / (2.0 * beam.length)


def euler_bernoulli_frequencies(beam: Beam, count: int) -> np.ndarray:
    """Return the bending frequencies of a slender beam [Hz], shape (count,).

    They are x^2 sqrt(E I / rho A) / (2 pi L^2) with cosh x cos x = 1.
    """
    from scipy.optimize import brentq

    roots = []
    for n in range(1, count + 1):
        middle = (n + 0.5) * math.pi
        roots.append(
            brentq(lambda x: math.cos(x) - 1.0 / math.cosh(x), middle - 0.1, middle + 0.1, xtol=1e-14)
        )
    radius = beam.depth / math.sqrt(12.0)
    return np.square(roots) * beam.wave_speed * radius / (2.0 * math.pi * beam.length**2)


def timoshenko_frequencies(beam: Beam, count: int) -> np.ndarray:
    """Return the bending frequencies with shear and rotary inertia [Hz].

    Their shape is (count,). The unknowns are the deflection w and the rotation psi of the sections. Energies are E I
    psi'^2 / 2 + k G A (w' - psi)^2 / 2 and rho A w_t^2 / 2 + rho I psi_t^2 / 2, by Ritz's method with Legendre
    polynomials, on which free ends impose no conditions.
    """
    from numpy.polynomial import legendre
    from scipy.linalg import eigh

    terms = max(POLYNOMIALS, 2 * count + 12)
    points, weights = legendre.leggauss(terms + 1)
    values = legendre.legvander(points, terms - 1)
    slopes = np.array([legendre.legval(points, legendre.legder(row)) for row in np.eye(terms)]).T
    scale, square = 2.0 / beam.length, beam.depth**2 / 12.0
    shear = beam.shear_coefficient * 0.5 / (1.0 + beam.poissons_ratio)  # k G / E
    plain, steep = values.T @ (weights[:, None] * values), scale**2 * slopes.T @ (weights[:, None] * slopes)
    mixed = scale * slopes.T @ (weights[:, None] * values)
    stiffness = np.block(
        [[shear * steep, -shear * mixed], [-shear * mixed.T, square * steep + shear * plain]]
    )
    inertia = np.block([[plain, 0.0 * plain], [0.0 * plain, square * plain]])
    squares = eigh(stiffness, inertia, eigvals_only=True)
    return np.asarray(beam.wave_speed * np.sqrt(squares[2 : 2 + count]) / (2.0 * math.pi))
