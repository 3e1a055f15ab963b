"""Plate of all codes, with mesh, masses and results.

The plate is unstrained in rigid motion; its corner at the origin stays on the wall, y = 0, and slides along it without
friction. Only NumPy is required. Each code runs it by explicit central differences with row-sum masses.
"""

from __future__ import annotations

import json
import sys
from dataclasses import asdict, dataclass

import numpy as np
from other_codes.quadrature import points_of

QUANTITIES = ("t", "v_gx", "v_gy", "omega", "slide")
"""Compared quantities at the tail-slap [s, m/s, m/s, rad/s, m]."""


@dataclass(frozen=True)
class Plate:
    """Elements, step [s], size [m], material (SI) and rigid motion.

    The motion is in rad, rad/s and m/s. mesh: file of NumPy's with the nodes [m] in the body's frame, shape (nodes, 2),
    row by row; empty: equal rectangles.
    """

    elements: tuple[int, int]
    time_step: float
    angle: float = 0.0
    mesh: str = ""
    length: float = 10.0
    width: float = 2.438
    thickness: float = 0.053
    density: float = 7800.0
    youngs_modulus: float = 200e9
    poissons_ratio: float = 0.3
    omega: float = 0.707
    speed: float = 25.053

    @property
    def count(self) -> int:
        """Number of elements."""
        return self.elements[0] * self.elements[1]

    @property
    def corner(self) -> int:
        """Node at the origin."""
        return self.elements[0]

    @property
    def far(self) -> int:
        """Node at (-length, width)."""
        return self.elements[1] * (self.elements[0] + 1)

    def body(self) -> np.ndarray:
        """Nodes [m] in the body's frame, row by row, shape (nodes, 2)."""
        if self.mesh:
            return np.load(self.mesh)
        x = np.linspace(-self.length, 0.0, self.elements[0] + 1)
        y = np.linspace(0.0, self.width, self.elements[1] + 1)
        return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)

    def nodes(self) -> np.ndarray:
        """Positions [m] at the start, shape (nodes, 2)."""
        cosine, sine = np.cos(self.angle), np.sin(self.angle)
        return self.body() @ np.array([[cosine, -sine], [sine, cosine]])

    def quads(self) -> np.ndarray:
        """Nodes of each element, counter-clockwise, shape (elements, 4)."""
        along, across = self.elements
        first = (np.arange(across)[:, None] * (along + 1) + np.arange(along)).ravel()
        return np.stack([first, first + 1, first + along + 2, first + along + 1], axis=1)

    def velocities(self) -> np.ndarray:
        """Velocities [m/s] of the start, shape (nodes, 2)."""
        x, y = self.nodes().T
        return np.stack([self.speed - self.omega * y, self.omega * x], axis=1)

    def masses(self) -> np.ndarray:
        """Row sums of the mass matrix [kg], shape (nodes,)."""
        body, quads = self.body(), self.quads()
        values, _, areas = points_of(body[quads])
        masses = np.zeros(len(body))
        np.add.at(masses, quads, self.density * self.thickness * areas @ values)
        return masses


@dataclass(frozen=True)
class Reading:
    """Reads results of a plate by its masses and frame."""

    plate: Plate
    body: np.ndarray
    masses: np.ndarray

    def angle(self, positions: np.ndarray) -> float:
        """Angle [rad] of the best rigid rotation to the wall, mass-weighted."""
        arms, reference = positions - self._mean(positions), self.body - self._mean(self.body)
        cosine = self.masses @ (reference * arms).sum(axis=1)
        sine = self.masses @ (reference[:, 0] * arms[:, 1] - reference[:, 1] * arms[:, 0])
        return float(-np.arctan2(sine, cosine))

    def values(self, time: float, positions: np.ndarray, velocities: np.ndarray) -> list[float]:
        """Return the `QUANTITIES`, of momentum, angular momentum and slide of the corner."""
        arms, v_g = positions - self._mean(positions), self._mean(velocities)
        around = velocities - v_g
        spin = self.masses @ (arms[:, 0] * around[:, 1] - arms[:, 1] * around[:, 0])
        omega = spin / (self.masses @ (arms**2).sum(axis=1))
        return [float(value) for value in (time, *v_g, omega, positions[self.plate.corner, 0])]

    def _mean(self, nodal: np.ndarray) -> np.ndarray:
        return self.masses @ nodal / self.masses.sum()


def to_text(plate: Plate) -> str:
    """The plate as the first argument of a script in this folder."""
    return json.dumps(asdict(plate))


def from_argument() -> Plate:
    """The plate that this script was started for."""
    values = json.loads(sys.argv[1])
    return Plate(**values | {"elements": tuple(values["elements"])})
