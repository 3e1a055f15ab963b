"""Units that scenes are usually written in, with their factors to SI: Pint, which knows all others, takes a tenth of a
second to load.

Pound, foot and pound-force are those of the international agreement of 1959 and of standard gravity.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

from tailslap.scene.unit_grammar import Factor

FOOT, POUND, GRAVITY = 0.3048, 0.45359237, 9.80665
POUND_FORCE = POUND * GRAVITY


class Dimension(NamedTuple):
    """Powers of metre, kilogram, second and radian."""

    length: int = 0
    mass: int = 0
    time: int = 0
    angle: int = 0


LENGTH, MASS, TIME, ANGLE = Dimension(1), Dimension(0, 1), Dimension(0, 0, 1), Dimension(0, 0, 0, 1)
SPEED, FORCE, PRESSURE = Dimension(1, 0, -1), Dimension(1, 1, -2), Dimension(-1, 1, -2)
FREQUENCY = Dimension(0, 0, -1)

COMMON: dict[str, tuple[float, Dimension]] = {
    "m": (1.0, LENGTH),
    "mm": (0.001, LENGTH),
    "cm": (0.01, LENGTH),
    "km": (1000.0, LENGTH),
    "ft": (FOOT, LENGTH),
    "in": (0.0254, LENGTH),
    "kg": (1.0, MASS),
    "t": (1000.0, MASS),
    "lb": (POUND, MASS),
    "s": (1.0, TIME),
    "ms": (0.001, TIME),
    "h": (3600.0, TIME),
    "rad": (1.0, ANGLE),
    "deg": (math.pi / 180.0, ANGLE),
    "mph": (0.44704, SPEED),
    "N": (1.0, FORCE),
    "kN": (1e3, FORCE),
    "MN": (1e6, FORCE),
    "lbf": (POUND_FORCE, FORCE),
    "Pa": (1.0, PRESSURE),
    "kPa": (1e3, PRESSURE),
    "MPa": (1e6, PRESSURE),
    "GPa": (1e9, PRESSURE),
    "TPa": (1e12, PRESSURE),
    "Hz": (1.0, FREQUENCY),
    "kHz": (1e3, FREQUENCY),
}
"""Factor to SI and dimension, by name."""


def to_si(unit: Iterable[Factor]) -> tuple[float, Dimension] | None:
    """Factor to SI and dimension of a product of units; None where one of them is not common."""
    scale, powers = 1.0, [0, 0, 0, 0]
    for name, power in unit:
        if name not in COMMON:
            return None
        factor, dimension = COMMON[name]
        scale = scale * factor**power if power > 0 else scale / factor**-power
        powers = [total + power * own for total, own in zip(powers, dimension, strict=True)]
    return scale, Dimension(*powers)
