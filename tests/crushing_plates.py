"""Strips of plates that crush at their corners."""

import math

from fem.laws.contact_forces import PointCrush
from fem.plate.properties import StripProperties


def corner_strips(
    length: float,
    stiffness: float,
    initial_force: float = 0.0,
    restitution: float = 1.0,
    plateau_force: float = math.inf,
    unloading_stiffness: float = 0.0,
    hardening: float = 0.0,
) -> tuple[StripProperties, StripProperties]:
    """Return front and rear of a plate, both by one law.

    length: of the plate [m].
    """
    crush = PointCrush(
        stiffness, initial_force, restitution**2, plateau_force, unloading_stiffness, hardening
    )
    return StripProperties(0.0, 0.0, 0.0, crush), StripProperties(length, length, 0.0, crush)


def layer(length: float, stiffness: float, restitution: float) -> StripProperties:
    """Return a line over a length from the front.

    length [m], stiffness [N/m per m].
    """
    return StripProperties(0.0, length, 0.0, PointCrush(stiffness, 0.0, restitution**2, math.inf, 0.0, 0.0))
