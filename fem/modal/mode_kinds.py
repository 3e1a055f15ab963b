"""Kinds of the plate's modes, by a criterion that needs no eye; and natural frequencies of beams beside them.

symmetric about the long middle line (along it u_x even, u_y odd), by more than half of its kinetic energy:
    longitudinal    more than half of the kinetic energy is along the length
    transverse      else: the plate grows wider and narrower
else antisymmetric, as a beam bends:
    shear           more than half of the strain energy is that of shear strain
    bending         else

Beams bend, with shear and without, or stretch. The beam is the plate seen from its side: length L, depth B in the
plane, thickness t out of it. It bends in the plane.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fem.model.plate_model import PlateModel
from fem.plate.elastic import FreeModes
from fem.plate.elements import stiffness_matrix


@dataclass(frozen=True)
class ModeKinds:
    """Names of the kinds, and the fractions they follow from, shape (modes,): kinetic energy of the symmetric part and
    along the length, strain energy of shear."""

    names: tuple[str, ...]
    symmetric: np.ndarray
    along: np.ndarray
    shear: np.ndarray


def mode_kinds(model: PlateModel, modes: FreeModes, thickness: float) -> ModeKinds:
    """Kinds of the modes of this model; thickness [m]."""
    masses, shapes = model.loop.mass, modes.shapes
    mirrored = shapes[:, :, _mirror_nodes(model.discretisation.positions)]
    symmetric = 0.5 * (1.0 + (shapes[:, 0] * mirrored[:, 0] - shapes[:, 1] * mirrored[:, 1]) @ masses)
    along = shapes[:, 0] ** 2 @ masses
    moduli = model.tangent_moduli._replace(c_11=0.0, c_12=0.0)  # shear alone
    stiffness = stiffness_matrix(model.discretisation.scalar, thickness, moduli)
    flat = shapes.reshape(len(shapes), -1)
    shear = ((stiffness @ flat.T).T * flat).sum(axis=1) / modes.frequencies**2
    fractions = zip(symmetric, along, shear, strict=True)
    return ModeKinds(tuple(_name(*fraction) for fraction in fractions), symmetric, along, shear)


def _name(symmetric: float, along: float, shear: float) -> str:
    if symmetric > 0.5:
        return "longitudinal" if along > 0.5 else "transverse"
    return "shear" if shear > 0.5 else "bending"


def _mirror_nodes(positions: np.ndarray) -> np.ndarray:
    """The node nearest to each node's mirror image in the long middle line, shape (nodes,)."""
    from scipy.spatial import cKDTree

    middle = 0.5 * (positions[1].min() + positions[1].max())
    images = np.array([positions[0], 2.0 * middle - positions[1]])
    return np.asarray(cKDTree(positions.T).query(images.T)[1])


POLYNOMIALS = 24
"""Terms of the Ritz solution in each unknown: the lowest ten frequencies are then exact to ten digits."""


@dataclass(frozen=True)
class Beam:
    """Length and depth [m], Young's modulus [Pa], Poisson's ratio, density [kg/m^3]; its thickness does not matter."""

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
        """Shear coefficient of a rectangle: 5 (1 + nu) / (6 + 5 nu) (Kaneko 1975, J. Phys. D 8, 1927)."""
        return 5.0 * (1.0 + self.poissons_ratio) / (6.0 + 5.0 * self.poissons_ratio)


def longitudinal_frequencies(beam: Beam, count: int) -> np.ndarray:
    """n c / (2 L) [Hz], n = 1, 2, ..., shape (count,)."""
    return np.arange(1, count + 1) * beam.wave_speed / (2.0 * beam.length)


def euler_bernoulli_frequencies(beam: Beam, count: int) -> np.ndarray:
    """Bending of a slender beam [Hz], shape (count,): x^2 sqrt(E I / rho A) / (2 pi L^2) with cosh x cos x = 1."""
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
    """Bending with shear and rotary inertia [Hz], shape (count,): deflection w and turn psi of the sections.

    Energies E I psi'^2 / 2 + k G A (w' - psi)^2 / 2 and rho A w_t^2 / 2 + rho I psi_t^2 / 2, by Ritz's method with
    Legendre polynomials; free ends ask for nothing of them.
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
