"""A friction law from outside, Coulomb friction with a smooth limit.

The limit is mu sqrt(N^2 + n^2).
"""

import math
from typing import Any, NamedTuple

from fem import FRICTION_LAWS, FrictionLaw


class Smoothed(NamedTuple):
    """Coefficient, and force n [N] below which it is rounded off."""

    coefficient: float
    rounding: float = 1.0


def limit(law: Any, normal: float) -> float:
    return law.coefficient * math.sqrt(normal * normal + law.rounding * law.rounding)


def force(law: Any, normal: float, stopping: float) -> float:
    most = limit(law, normal)
    return min(max(stopping, -most), most)


def slope(law: Any, normal: float, speed: float) -> float:
    return -law.coefficient * math.copysign(1.0, normal) * math.copysign(1.0, speed)


LAW = FrictionLaw(
    name="smoothed",
    constants=Smoothed,
    force=force,
    slope=slope,
    text="smoothed Coulomb friction",
    rigid="drag",
    impulse="normal_impulse_magnitude",
)
FRICTION_LAWS.register(LAW)
