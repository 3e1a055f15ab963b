"""Vehicles in space of tests and measurements."""

import math
from typing import Any

from solver.space import SpaceAxle, SpaceStrip, SpaceUnit, SpaceVehicle

MASS, LENGTH, WIDTH = 9979.0, 10.0, 2.438
SPEED, ANGLE = 56 * 0.44704, math.radians(15.0)
YAW = MASS * (LENGTH**2 + WIDTH**2) / 12.0


def truck_unit(**changes: Any) -> SpaceUnit:
    """Return the body of the TL-4 truck of the paper."""
    values: dict[str, Any] = {
        "length": LENGTH, "width": WIDTH, "mass": MASS, "centre_of_mass": 5.0, "centre_height": 1.35,
        "roll_inertia": 12070.0, "pitch_inertia": YAW, "yaw_inertia": YAW,
    }  # fmt: skip
    return SpaceUnit(**values | changes)


def axle(
    position: float, mass: float = 400.0, spring: float = 0.2e6, tyre: float = 0.9e6, **changes: Any
) -> SpaceAxle:
    """Return an axle of a truck."""
    values: dict[str, Any] = {"track": 1.85, "radius": 0.5, "spacing": 1.0} | changes
    return SpaceAxle(position, mass=mass, spring=spring, tyre=tyre, **values)


FAR = (SpaceStrip((0.0, 0.0), (0.5, 0.6), 4e6),)
"""A strip that does not touch a wall of the tests without contact."""


def truck(
    unit: SpaceUnit | None = None,
    friction: float = 0.65,
    restitution: float = 0.225,
    plateau: bool = True,
    **of_axles: Any,
) -> SpaceVehicle:
    """Return the truck of the shipped scene."""
    most = 1.0 if plateau else math.inf
    strips = (
        SpaceStrip((0.0, 0.0), (0.45, 0.9), 4e6, plateau=780e3 * most, restitution=restitution),
        SpaceStrip((7.2, 7.2), (0.05, 1.0), 2.1e6, plateau=395e3 * most, restitution=restitution, axle=1),
        SpaceStrip((2.6, 10.0), (1.2446, 1.2446), 1e6, plateau=40e3 * most, restitution=restitution),
        *(
            SpaceStrip((at, at), (1.2446, 2.6), 1.5e6, plateau=220e3 * most, restitution=restitution)
            for at in (2.6, 10.0)
        ),
    )
    axles = (
        axle(1.2, friction=friction, **of_axles),
        axle(7.2, 700.0, 0.35e6, 1.8e6, friction=friction, **of_axles),
    )
    return SpaceVehicle((unit or truck_unit(),), axles, strips)


def train(
    strips: tuple[SpaceStrip, ...], friction: float = 0.65, roll_centre: float = 0.6, **changes: Any
) -> SpaceVehicle:
    """Return a tractor and semitrailer, with changes of both units."""
    ahead: dict[str, Any] = {
        "length": 6.4, "width": 2.5, "mass": 8200.0, "centre_of_mass": 2.3, "centre_height": 1.1,
        "roll_inertia": 6e3, "pitch_inertia": 3e4, "yaw_inertia": 3e4,
    }  # fmt: skip
    behind: dict[str, Any] = {
        "length": 14.6, "width": 2.6, "mass": 27770.0, "centre_of_mass": 7.0, "centre_height": 1.9,
        "roll_inertia": 3.5e4, "pitch_inertia": 4.5e5, "yaw_inertia": 4.5e5,
        "hitch": 5.4, "kingpin": 0.9, "hitch_height": 1.2,
    }  # fmt: skip
    tractor, trailer = SpaceUnit(**ahead | changes), SpaceUnit(**behind | changes)
    tyres: dict[str, Any] = {"friction": friction, "roll_centre": roll_centre}
    axles = (
        axle(1.2, 500.0, 0.25e6, 1e6, **tyres),
        *(axle(at, 900.0, 0.8e6, 2e6, **tyres) for at in (4.8, 6.0)),
        *(axle(at, 900.0, 0.9e6, 2e6, unit=1, **tyres) for at in (12.2, 13.4)),
    )
    return SpaceVehicle((tractor, trailer), axles, strips)
