"""Vehicles in space with solid axles, and strips for contact.

Values are floats, or arrays of n samples. All masses and inertias are those of the whole vehicle; the sprung mass is
what remains without the axles. Springs and tyres carry the vehicle at rest with its floor level: their loads follow
from the levers of the axles, of more than two from loads that vary linearly along the unit.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from solver import rules
from solver.body import GRAVITY
from solver.conditions import Array, Gate, Number, RigidBodyError, demand, number
from solver.impact.tyres import CORNERING, axle_loads
from solver.space.state import Fleet
from solver.space.strips import SpaceStrip, joined, points_of
from solver.space.wall import profile_points

GYRATION = 0.45
"""Assumed radius of gyration in roll over the width."""

ROLL_STIFFNESS = 3.55e6
"""Stiffness of a fifth wheel in roll [N m/rad], of one published model of a tractor and semitrailer (GOPS)."""

AXLE_GYRATION = math.sqrt(1.0 / 6.0)
"""Assumed radius of gyration of an axle over the track: half of its mass in the wheels, half along the beam."""

OF_BODY = ("centre_height", "roll_inertia", "pitch_inertia")
"""Quantities of a unit that stand in [body] of a scene."""

SLACK = 1.0
"""Largest heave of an axle that is assumed where the distance from the wall is judged [m]."""

EDGE, LEAST = 0.02, 1e-4
"""Half heights within which a strip along the vehicle passes the top, and of an upright point at least [m]."""

DAMPING_RATIO, ROLL_CENTRE = 0.15, 0.6
"""Assumed damping of a spring to critical for the mass on it [-], and height of the roll centre [m]."""


@dataclass(frozen=True)
class SpaceUnit:
    """A unit of a train in space, or a single vehicle.

    Parameters
    ----------
    length, width : float or ndarray
        Length and width [m].
    mass : float or ndarray
        Mass with axles [kg].
    centre_of_mass, centre_height : float or ndarray
        Centre of the whole mass behind the front and above the ground [m].
    roll_inertia, pitch_inertia, yaw_inertia : float or ndarray
        Inertias of the whole about its centre of mass [kg m^2].
    hitch, kingpin : float or ndarray
        Distances of the hinge ahead: behind the front of the unit ahead, and behind the own front [m];
        without meaning for the first unit.
    hitch_height : float or ndarray
        Height of the hinge ahead [m].
    roll_stiffness : float or ndarray
        Stiffness in roll of the hinge ahead [N m/rad].
    """

    length: Number
    width: Number
    mass: Number
    centre_of_mass: Number
    centre_height: Number
    roll_inertia: Number
    pitch_inertia: Number
    yaw_inertia: Number
    hitch: Number = 0.0
    kingpin: Number = 0.0
    hitch_height: Number = 0.0
    roll_stiffness: Number = ROLL_STIFFNESS


@dataclass(frozen=True)
class SpaceAxle:
    """A solid axle on two tyres, under two springs with dampers.

    Parameters
    ----------
    position : float or ndarray
        Distance behind the front of its unit [m].
    track, radius : float or ndarray
        Distance between the tyres of both sides, and height of the axle at rest [m].
    mass : float or ndarray
        Mass of axle and wheels [kg].
    spring, tyre : float or ndarray
        Vertical stiffness of one side [N/m].
    spacing : float or ndarray
        Distance between the springs [m].
    damping_ratio : float or ndarray
        Damping of a spring over the critical damping of the mass that it carries [-].
    roll_centre : float or ndarray
        Height at which side force enters the body [m].
    friction, cornering : float or ndarray
        Coefficients of the tyres, see `fem.laws.contact_forces.side_force` [-].
    unit : int
        Number of its unit, from 0.
    """

    position: Number
    track: Number
    radius: Number
    mass: Number
    spring: Number
    spacing: Number
    tyre: Number
    damping_ratio: Number = DAMPING_RATIO
    roll_centre: Number = ROLL_CENTRE
    friction: Number = 0.0
    cornering: Number = CORNERING
    unit: int = 0


@dataclass(frozen=True)
class SpaceWall:
    """A wall with a profile.

    Parameters
    ----------
    height : float or ndarray
        Height of its top [m].
    profile : str or sequence of pairs
        See `profile_points`.
    friction : float or ndarray
        Friction coefficient between vehicle and wall [-].
    """

    height: Number
    profile: str | Sequence[Sequence[float]] = "vertical"
    friction: Number = 0.0


@dataclass(frozen=True)
class SpaceVehicle:
    """A vehicle or a train in space.

    Parameters
    ----------
    units : tuple of SpaceUnit
        Units from front to rear.
    axles : tuple of SpaceAxle
        Axles, at least two of the first unit, and one of each other.
    strips : tuple of SpaceStrip
        Strips, at least one.
    sensor : tuple of float or ndarray, or None
        Sensor on the centre line of the first unit: distance behind its front and height [m]; None: at the sprung
        centre of mass.
    """

    units: tuple[SpaceUnit, ...]
    axles: tuple[SpaceAxle, ...]
    strips: tuple[SpaceStrip, ...]
    sensor: tuple[Number, Number] | None = None


def fleet_of(vehicle: SpaceVehicle, wall: SpaceWall, speed: Number, angle: Number) -> Fleet:
    """Return the arrays of n vehicles for compiled code.

    All values broadcast. speed [m/s] and angle of the vehicle to the wall [rad] are those before the impact. Raises
    RigidBodyError for impossible values, with the key of the scene.
    """
    profile = profile_points(wall.profile)
    Gate().positive(rules.WALL_HEIGHT, number("height", wall.height))
    Gate().not_negative(rules.FRICTION, number("friction", wall.friction))
    _demand_counts(vehicle)
    for table, records in (("", vehicle.units), ("axle.", vehicle.axles), ("strip.", vehicle.strips)):
        for index, record in enumerate(records):
            _demand_values(table, index, record)
    of_sample = (wall.height, wall.friction, speed, angle)
    n = _sample_count(vehicle, (*of_sample, *(vehicle.sensor or ())))
    units = _columns([_unit(vehicle, index) for index in range(len(vehicle.units))], n)
    loads = _loads(vehicle, n)
    axles = _columns([_axle(vehicle, a, loads[a]) for a in range(len(vehicle.axles))], n)
    for index, strip in enumerate(vehicle.strips):
        _demand_strip(vehicle, index, vehicle.units[strip.unit])
    vehicle = replace(vehicle, strips=joined(vehicle.strips))
    strips = _columns([_strip(vehicle, k) for k in range(len(vehicle.strips))], n)
    axle_units, strip_units, strip_axles, points = (
        np.array(values, dtype=np.int64)
        for values in (
            [axle.unit for axle in vehicle.axles],
            [strip.unit for strip in vehicle.strips],
            [strip.axle for strip in vehicle.strips],
            [points_of(strip) for strip in vehicle.strips],
        )
    )
    return Fleet(
        units, axles, strips, axle_units, strip_units, strip_axles, points, profile, *_rows(of_sample, n)
    )  # fmt: skip


def _sample_count(vehicle: SpaceVehicle, further: Sequence[Number]) -> int:
    """Return the common number of samples.

    Raises RigidBodyError for arrays of different sizes.
    """
    sizes = {np.size(value) for value in further}
    for record in (*vehicle.units, *vehicle.axles, *vehicle.strips):
        for value in vars(record).values():
            sizes |= {np.size(part) for part in (value if isinstance(value, tuple) else (value,))}
    sizes -= {1}
    if len(sizes) > 1:
        raise RigidBodyError("samples", str(sorted(sizes)), "arrays have different sizes", "one size for all")
    return sizes.pop() if sizes else 1


def _rows(values: Sequence[Number], n: int) -> Array:
    """Return values of n samples, shape (values, n)."""
    return np.array([np.broadcast_to(value, n) for value in values], dtype=np.float64)


def _columns(entries: Sequence[Sequence[Number]], n: int) -> Array:
    """Return columns of entries, shape (n, entries, columns)."""
    return np.ascontiguousarray(np.moveaxis(np.array([_rows(entry, n) for entry in entries]), -1, 0))


def _demand_counts(vehicle: SpaceVehicle) -> None:
    """Require axles to stand on, and a strip. Raises RigidBodyError."""
    for index in range(len(vehicle.units)):
        count, least = sum(axle.unit == index for axle in vehicle.axles), 1 if index else 2
        if count < least:
            name = f"trailer {index}" if index else "the vehicle"
            why = f"{name} cannot stand on {count} axles"
            raise RigidBodyError("axle", f"{len(vehicle.axles)} tables", why, f"at least {least} of {name}")
    if not vehicle.strips:
        raise RigidBodyError(
            "strip", "no table", "nothing of the vehicle can touch the wall", "at least one strip"
        )


def _demand_values(table: str, index: int, record: object) -> None:
    """Require values within the bounds of their rules.

    Raises RigidBodyError.
    """
    for name, value in vars(record).items():
        rule = rules.SPACE.get(name)
        for part in value if isinstance(value, tuple) else (value,):
            if rule is None:
                continue
            key = f"{table}{index}.{name}" if table else _unit_key(index, name)
            checked = number(key, part)
            finite = True if name == "plateau" else np.isfinite(checked)
            positive = checked > 0.0 if name in rules.SPACE_POSITIVE else checked >= 0.0
            demand(rule, key, positive & finite, checked)


def _unit_key(index: int, name: str) -> str:
    """Return the key of a quantity of a unit in a scene."""
    if index:
        return f"trailer.{index - 1}.{name}"
    return f"{'body' if name in OF_BODY else 'vehicle'}.{name}"


def _loads(vehicle: SpaceVehicle, n: int) -> Array:
    """Return the loads of the axles at rest [N], shape (axles, n)."""
    units, unit = vehicle.units, np.array([axle.unit for axle in vehicle.axles])
    mass = _rows([u.mass for u in units], n)
    hitch = _rows([ahead.centre_of_mass - behind.hitch for ahead, behind in pairwise(units)], n)
    kingpin = _rows([behind.centre_of_mass - behind.kingpin for behind in units[1:]], n)
    along = _rows([units[a.unit].centre_of_mass - a.position for a in vehicle.axles], n)
    loads = axle_loads(mass, hitch, kingpin, unit, along)
    for index, axle in enumerate(vehicle.axles):
        key, length, place = f"axle.{index}.position", units[axle.unit].length, np.asarray(axle.position)
        inside = bool(np.all((place >= 0.0) & (place <= length)))
        demand(rules.AXLE, key, inside, float(np.max(place)), length=length)
        carried = loads[index] - GRAVITY * np.asarray(axle.mass)
        demand(rules.AXLE_LOAD, key, carried >= 0.0, axle.position, load=carried)
    return loads


def _sprung(vehicle: SpaceVehicle, index: int) -> tuple[Number, Number, Number]:
    """Return the sprung mass with its place and height.

    The place is ahead of the front. Raises RigidBodyError.
    """
    unit, axles = vehicle.units[index], [axle for axle in vehicle.axles if axle.unit == index]
    add = math.fsum if all(isinstance(axle.mass, float) for axle in axles) else sum
    unsprung = add([axle.mass for axle in axles])
    mass = unit.mass - unsprung
    demand(rules.SPRUNG, _unit_key(index, "mass"), mass > 0.0, unit.mass, axles=unsprung)
    place = (sum(axle.mass * axle.position for axle in axles) - unit.mass * unit.centre_of_mass) / mass
    height = (unit.mass * unit.centre_height - sum(axle.mass * axle.radius for axle in axles)) / mass
    key, centre = _unit_key(index, "centre_height"), unit.centre_height
    for axle in axles:
        demand(rules.CENTRE_ABOVE, key, centre > axle.radius, centre, radius=axle.radius)
    return mass, place, height


def _axle_inertia(axle: SpaceAxle) -> Number:
    """Return the inertia of an axle in roll and yaw [kg m^2]."""
    return axle.mass * (AXLE_GYRATION * axle.track) ** 2


def _unit(vehicle: SpaceVehicle, index: int) -> list[Number]:
    """Return the columns of a unit, see `state`. Raises RigidBodyError."""
    unit, (mass, place, height) = vehicle.units[index], _sprung(vehicle, index)
    x, z = -unit.centre_of_mass - place, unit.centre_height - height
    parts: list[tuple[Number, ...]] = [(-x, -z, mass, 0.0)]
    for axle in vehicle.axles:
        if axle.unit == index:
            at = unit.centre_of_mass - axle.position, axle.radius - unit.centre_height
            parts.append((*at, axle.mass, _axle_inertia(axle)))
    removed = {
        "roll_inertia": sum(m * dz**2 + inertia for _, dz, m, inertia in parts),
        "pitch_inertia": sum(m * (dx**2 + dz**2) for dx, dz, m, _ in parts),
        "yaw_inertia": sum(m * dx**2 + inertia for dx, _, m, inertia in parts),
    }
    for name, least in removed.items():
        value = getattr(unit, name)
        demand(rules.SPRUNG_INERTIA, _unit_key(index, name), value > least, value, least=least)
    inertias = [getattr(unit, name) - least for name, least in removed.items()]
    product = -sum(m * dx * dz for dx, dz, m, _ in parts)
    behind = vehicle.units[index + 1] if index + 1 < len(vehicle.units) else unit
    hitch = -behind.hitch - place, behind.hitch_height - height
    kingpin = -unit.kingpin - place, unit.hitch_height - height
    behind_front, up = (-place, height) if index or vehicle.sensor is None else vehicle.sensor
    reach, sensor = _reach(vehicle, index, place, height), (-behind_front - place, up - height)
    return [
        mass, *inertias, product, height, unit.mass, x, z, *hitch, *kingpin, unit.roll_stiffness, reach, *sensor,
    ]  # fmt: skip


def _reach(vehicle: SpaceVehicle, index: int, place: Number, height: Number) -> Number:
    """Return the largest distance of strips from the sprung centre [m]."""
    unit = vehicle.units[index]
    along = np.maximum(np.abs(place), np.abs(unit.length + place))
    levels = [level for strip in vehicle.strips if strip.unit == index for level in strip.height]
    up = np.max(np.broadcast_arrays(0.0, *(np.abs(level - height) for level in levels)), axis=0)
    result: Number = SLACK + np.sqrt(along**2 + up**2 + 0.25 * np.square(unit.width))
    return result


def _axle(vehicle: SpaceVehicle, index: int, load: Array) -> list[Number]:
    """Return the columns of an axle, see `state`."""
    axle = vehicle.axles[index]
    _, place, height = _sprung(vehicle, axle.unit)
    preload = 0.5 * (load - GRAVITY * np.asarray(axle.mass))
    damper = 2.0 * axle.damping_ratio * np.sqrt(axle.spring * preload / GRAVITY)
    lowest = axle.roll_centre + 0.5 * load / axle.tyre
    return [
        -axle.position - place, axle.roll_centre - height, axle.mass, _axle_inertia(axle),
        axle.roll_centre - axle.radius, lowest, 0.5 * axle.track, 0.5 * axle.spacing, axle.spring, damper, preload,
        axle.tyre, axle.friction, axle.cornering,
    ]  # fmt: skip


def _strip(vehicle: SpaceVehicle, index: int) -> list[Number]:
    """Return the columns of a strip, see `state`."""
    strip = vehicle.strips[index]
    unit, (_, place, height) = vehicle.units[strip.unit], _sprung(vehicle, strip.unit)
    base = height if strip.axle < 0 else vehicle.axles[strip.axle].roll_centre
    ends = [
        value
        for at, level in zip(strip.at, strip.height, strict=True)
        for value in (-at - place, 0.5 * unit.width - strip.inset, level - base)
    ]
    length = np.hypot(strip.at[1] - strip.at[0], strip.height[1] - strip.height[0])
    thick = np.maximum(EDGE * np.abs(strip.at[1] - strip.at[0]) / length, LEAST)
    return [
        *ends,
        strip.stiffness,
        strip.plateau,
        np.square(strip.restitution),
        strip.unloading,
        length,
        thick,
        strip.initial_force,
        strip.hardening,
    ]


def _demand_strip(vehicle: SpaceVehicle, index: int, unit: SpaceUnit) -> None:
    """Require a strip within its unit. Raises RigidBodyError."""
    strip, key = vehicle.strips[index], f"strip.{index}"
    ends = np.array(np.broadcast_arrays(*strip.at, unit.length))
    inside = (ends[:2] >= 0.0) & (ends[:2] <= ends[2])
    demand(rules.STRIP_AT, f"{key}.at", inside, ends[:2], length=ends[2])
    low, high, most = np.broadcast_arrays(*strip.height, 3.0 * np.asarray(unit.centre_height))
    demand(rules.STRIP_HEIGHT, f"{key}.height", (high <= most) & (low <= most), high, most=most)
    demand(rules.STRIP_LENGTH, f"{key}.height", (high > low) | (ends[1] > ends[0]), high)
    half = 0.5 * np.asarray(unit.width)
    demand(rules.INSET, f"{key}.inset", strip.inset < half, strip.inset, most=half)
    hardening, stiffness, plateau = np.broadcast_arrays(strip.hardening, strip.stiffness, strip.plateau)
    rising = (hardening == 0.0) | ((hardening <= stiffness) & np.isfinite(plateau))
    demand(rules.HARDENING, f"{key}.hardening", rising, hardening, stiffness=stiffness)
    if strip.axle >= len(vehicle.axles) or (strip.axle >= 0 and vehicle.axles[strip.axle].unit != strip.unit):
        allowed = ", ".join(str(a) for a, axle in enumerate(vehicle.axles) if axle.unit == strip.unit)
        why = "the strip's unit has no axle of this number"
        raise RigidBodyError(f"{key}.axle", str(strip.axle), why, allowed)
