"""Vehicles in space that several tests use."""

import math

from solver.space import SpaceAxle, SpaceUnit, SpaceVehicle, Strip

MASS, LENGTH, WIDTH = 9979.0, 10.0, 2.438
SPEED, ANGLE = 56 * 0.44704, math.radians(15.0)
YAW = MASS * (LENGTH**2 + WIDTH**2) / 12.0


def truck_unit(**changes):
    """Return the body of the TL-4 truck of the paper."""
    values = {
        "length": LENGTH, "width": WIDTH, "mass": MASS, "centre_of_mass": 5.0, "centre_height": 1.35,
        "roll_inertia": 12070.0, "pitch_inertia": YAW, "yaw_inertia": YAW,
    }  # fmt: skip
    return SpaceUnit(**values | changes)


def axle(position, mass=400.0, spring=0.2e6, tyre=0.9e6, **changes):
    """Return an axle of a truck."""
    values = {"track": 1.85, "radius": 0.5, "spacing": 1.0} | changes
    return SpaceAxle(position, mass=mass, spring=spring, tyre=tyre, **values)


FAR = (Strip((0.0, 0.0), (0.5, 0.6), 4e6),)
"""A strip that does not touch a wall of the tests without contact."""


def truck(unit=None, friction=0.65, restitution=0.225, plateau=True, **of_axles):
    """Return the truck of the shipped scene."""
    most = 1.0 if plateau else math.inf
    strips = (
        Strip((0.0, 0.0), (0.45, 0.9), 4e6, plateau=780e3 * most, restitution=restitution),
        Strip((7.2, 7.2), (0.05, 1.0), 2.1e6, plateau=395e3 * most, restitution=restitution, axle=1),
        Strip((2.6, 10.0), (1.2446, 1.2446), 1e6, plateau=40e3 * most, restitution=restitution),
        Strip((10.0, 10.0), (1.2446, 2.6), 1.5e6, plateau=220e3 * most, restitution=restitution),
    )
    axles = (
        axle(1.2, friction=friction, **of_axles),
        axle(7.2, 700.0, 0.35e6, 1.8e6, friction=friction, **of_axles),
    )
    return SpaceVehicle((unit or truck_unit(),), axles, strips)
