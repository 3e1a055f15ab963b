"""Input of the vehicle in space from a scene with [body]."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from solver import space
from solver.conditions import Number
from solver.space.vehicle import (
    DAMPING_RATIO,
    GYRATION,
    ROLL_CENTRE,
    ROLL_STIFFNESS,
    fleet_of,
)
from tailslap.case.impact.rigid_input import SENSOR_HEIGHT, sensor_position
from tailslap.scene.schema import Scene, value_at


class SpaceInput(NamedTuple):
    """Arguments of the functions of `solver.space`, floats or arrays of n samples.

    speed [m/s]; angle [rad].
    """

    vehicle: space.SpaceVehicle
    wall: space.SpaceWall
    speed: Any
    angle: Any


def space_input(scene: Scene, values: Mapping[str, Number] | None = None) -> SpaceInput:
    """Return the vehicle in space of a scene with [body].

    values: replace those of the scene by dotted key, floats or of shape (n,) [SI]; inertias of the scene are in
    proportion to the mass. Raises RigidBodyError for impossible values.
    """
    values = values or {}

    def value(key: str, default: Number | None = None) -> Any:
        result = values[key] if key in values else value_at(scene, key)
        return default if result is None else result

    units = tuple(_unit(scene, number, value, values) for number in range(len(scene.units)))
    axles = tuple(_axle(scene, number, value) for number in range(len(scene.axle)))
    strips = tuple(_strip(scene, number, value) for number in range(len(scene.strip)))
    assert scene.wall
    wall = space.SpaceWall(value("wall.height"), scene.wall.profile or "vertical", value("contact.friction"))
    height = value("sensor.height", np.minimum(SENSOR_HEIGHT, units[0].centre_height))
    vehicle = space.SpaceVehicle(units, axles, strips, (sensor_position(scene, values), height))
    inputs = SpaceInput(vehicle, wall, value("impact.speed"), value("impact.angle"))
    fleet_of(*inputs)
    return inputs


def _unit(scene: Scene, number: int, value: Any, values: Mapping[str, Number]) -> space.SpaceUnit:
    """Return a unit of the train."""
    table, body = (f"trailer.{number - 1}",) * 2 if number else ("vehicle", "body")
    length, width, mass = (value(f"{table}.{name}") for name in ("length", "width", "mass"))
    scale = mass / value_at(scene, f"{table}.mass")

    def inertia(key: str, default: Number) -> Any:
        result = value(key)
        return default if result is None else result if key in values else result * scale

    yaw = inertia(f"{table}.yaw_inertia", mass * (length**2 + width**2) / 12.0)
    hinge: dict[str, Number] = {}
    if number:
        hinge = {name: value(f"{table}.{name}") for name in ("hitch", "kingpin", "hitch_height")}
        hinge["roll_stiffness"] = value(f"{table}.roll_stiffness", ROLL_STIFFNESS)
    return space.SpaceUnit(
        length, width, mass, value(f"{table}.centre_of_mass", 0.5 * length),
        value(f"{body}.centre_height", value("body.centre_height")),
        inertia(f"{body}.roll_inertia", mass * (GYRATION * width) ** 2), inertia(f"{body}.pitch_inertia", yaw), yaw,
        **hinge,
    )  # fmt: skip


def _axle(scene: Scene, number: int, value: Any) -> space.SpaceAxle:
    """Return an axle."""
    names = ("position", "track", "radius", "mass", "spring", "spacing", "tyre", "friction", "cornering")
    keys = {name: value(f"axle.{number}.{name}") for name in names}
    keys["damping_ratio"] = value(f"axle.{number}.damping_ratio", DAMPING_RATIO)
    keys["roll_centre"] = value(f"axle.{number}.roll_centre", ROLL_CENTRE)
    return space.SpaceAxle(**keys, unit=scene.axle[number].unit - 1)


def _strip(scene: Scene, number: int, value: Any) -> space.SpaceStrip:
    """Return a strip, which by default unloads by contact.restitution."""
    strip, key = scene.strip[number], f"strip.{number}"
    assert strip.height is not None
    slope = value(f"{key}.unloading_stiffness", 0.0)
    restitution = value(f"{key}.restitution", 0.0 if slope else value("contact.restitution", 0.0))
    return space.SpaceStrip(
        (value(f"{key}.at.0"), value(f"{key}.at.1")), (value(f"{key}.height.0"), value(f"{key}.height.1")),
        value(f"{key}.stiffness"), value(f"{key}.inset"), value(f"{key}.plateau", np.inf), restitution, slope,
        axle=-1 if strip.axle is None else strip.axle, unit=strip.unit - 1,
        initial_force=value(f"{key}.initial_force", 0.0), hardening=value(f"{key}.hardening", 0.0),
    )  # fmt: skip
