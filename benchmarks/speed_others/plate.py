"""The plate that every code runs, and how each is timed. Needs NumPy alone.

The plate lies along the wall, unstrained, and moves as a rigid body; its corner at the origin stays on the wall,
y = 0, and slides along it without friction. Each code runs it by explicit central differences with row-sum masses.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass

import numpy as np

CHECKED_STEPS = 200
"""Steps from the start to the instant at which the codes' far corners are compared."""


@dataclass(frozen=True)
class Plate:
    """Size [m], elements along and across, material (SI), rigid motion of the start [rad/s, m/s], time step [s]."""

    elements: tuple[int, int]
    time_step: float
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

    def nodes(self) -> np.ndarray:
        """Reference positions [m], row by row, shape (nodes, 2)."""
        x = np.linspace(-self.length, 0.0, self.elements[0] + 1)
        y = np.linspace(0.0, self.width, self.elements[1] + 1)
        return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)

    def quads(self) -> np.ndarray:
        """Nodes of each element, counter-clockwise, shape (elements, 4)."""
        along, across = self.elements
        first = (np.arange(across)[:, None] * (along + 1) + np.arange(along)).ravel()
        return np.stack([first, first + 1, first + along + 2, first + along + 1], axis=1)

    def velocities(self) -> np.ndarray:
        """Velocities [m/s] of the start, shape (nodes, 2)."""
        x, y = self.nodes().T
        return np.stack([self.speed - self.omega * y, self.omega * x], axis=1)


def to_text(plate: Plate) -> str:
    """The plate as the one argument of a script in this folder."""
    return json.dumps(asdict(plate))


def from_argument() -> Plate:
    """The plate that this script was started for."""
    given = json.loads(sys.argv[1])
    return Plate(**given | {"elements": tuple(given["elements"])})


def update_rates(
    advance: Callable[[int], object], elements: int, batches: int = 5, seconds: float = 0.1
) -> list[float]:
    """Element updates a second in each of several batches of about this many seconds."""
    began = time.perf_counter()
    advance(10)
    steps = 10 * max(1, round(seconds / (time.perf_counter() - began)))
    rates = []
    for _ in range(batches):
        began = time.perf_counter()
        advance(steps)
        rates.append(elements * steps / (time.perf_counter() - began))
    return rates


def report(
    plate: Plate,
    version: str,
    model: str,
    advance: Callable[[int], object],
    far_corner: Callable[[], tuple[float, float]],
) -> None:
    """Advance to the instant of comparison, time what follows, and print one line of JSON."""
    advance(CHECKED_STEPS)
    far = list(map(float, far_corner()))
    rates = update_rates(advance, plate.count)
    print(json.dumps({"version": version, "model": model, "far_corner": far, "rates": rates}), flush=True)
