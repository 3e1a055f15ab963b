"""The ranges that inputs have unless the user gives others.

MASH 2016: speed and angle of any test, and the inertial mass of its two light vehicles, as printed beside the
measured values of crash tests 612541-01-1 to -4 in National Academies (2024), doi 10.17226/27896, chapters 12, 13,
18 and 19. The tolerances of its trucks' masses were not found published, so their masses do not vary by default.
Friction, restitution and the duration of the strike: assumed, wide enough for the values of the paper's tables.
"""

from __future__ import annotations

from typing import NamedTuple

from tailslap.scene.schema import Scene

MILE_PER_HOUR, DEGREE, POUND = 0.44704, 0.017453292519943295, 0.45359237

LIGHT_VEHICLES = {"1100C": (2420.0, 55.0), "2270P": (5000.0, 110.0)}
"""MASH's name: inertial mass and its tolerance [lb]."""


class Limits(NamedTuple):
    """The ends of a range [SI], and where it comes from."""

    lower: float
    upper: float
    origin: str


def default_limits(scene: Scene) -> dict[str, Limits]:
    """The range of each key that varies by default, where the scene has the key."""
    limits = {"strike.duration": Limits(0.08, 0.18, "assumed"), **_mass(scene.vehicle.mass)}
    if scene.impact:
        limits |= {
            "impact.friction": Limits(0.3, 0.6, "assumed"),
            "impact.restitution": Limits(0.0, 0.4, "assumed"),
            "impact.speed": _about(scene.impact.speed, 2.5 * MILE_PER_HOUR, "± 2.5 mph, MASH"),
            "impact.angle": _about(scene.impact.angle, 1.5 * DEGREE, "± 1.5 deg, MASH"),
        }
    return limits


def _mass(mass: float) -> dict[str, Limits]:
    """The range of the vehicle's mass [kg], if it is that of a vehicle whose tolerance is known."""
    for name, (pounds, tolerance) in LIGHT_VEHICLES.items():
        if abs(mass - pounds * POUND) <= tolerance * POUND:
            return {"vehicle.mass": _about(mass, tolerance * POUND, f"± {tolerance:g} lb, MASH {name}")}
    return {}


def _about(value: float, tolerance: float, origin: str) -> Limits:
    return Limits(value - tolerance, value + tolerance, origin)
