"""Vehicles in space with solid axles, and strips for contact.

Values are floats, or arrays of n samples. All masses and inertias are those of the whole vehicle.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any, NoReturn

import numpy as np

from solver import rules
from solver.conditions import Array, Gate, Number, RigidBodyError, demand, number, refusal
from solver.impact.crush_law import LAW, demand_law
from solver.impact.tyres import CORNERING
from solver.space import columns, state
from solver.space.state import Fleet
from solver.space.strips import SpaceStrip, joined, points_of
from solver.space.wall import profile_points

GYRATION = 0.45
"""Assumed radius of gyration in roll over the width."""

ROLL_STIFFNESS = 3.55e6
"""Stiffness of a fifth wheel in roll [N m/rad], of one published model of a tractor and semitrailer (GOPS)."""

OF_BODY = ("centre_height", "roll_inertia", "pitch_inertia")
"""Quantities of a unit that stand in [body] of a scene."""

OF_STRIP = {"plateau_force": "plateau", "unloading_stiffness": "unloading"}
"""Names of `SpaceStrip` for parameters of a crush law that have another one."""

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
    Gate().not_negative(rules.FORWARDS, number("speed", speed))
    theta = number("angle", angle)
    Gate().demand(rules.TOUCH_ANGLE, (theta > 0.0) & (theta < 0.5 * np.pi), theta)
    _demand_counts(vehicle)
    for table, records in (("", vehicle.units), ("axle.", vehicle.axles), ("strip.", vehicle.strips)):
        for index, record in enumerate(records):
            _demand_values(table, index, record)
    for index, strip in enumerate(vehicle.strips):
        _demand_law(index, strip)
    of_sample = (wall.height, wall.friction, speed, angle)
    n = _sample_count(vehicle, (*of_sample, *(vehicle.sensor or ())))
    further = np.array([np.broadcast_to(value, n) for value in of_sample], dtype=np.float64)
    for part in (
        vehicle,
        replace(vehicle, strips=joined(vehicle.strips)),
    ):  # a piece is refused by its number
        fleet = _filled(part, profile, further)
    return fleet


def _filled(vehicle: SpaceVehicle, profile: Array, further: Array) -> Fleet:
    """Return the arrays of a vehicle.

    further: height and friction of the wall, speed and angle, shape (4, n). Raises RigidBodyError.
    """
    n, parts = further.shape[1], (vehicle.units, vehicle.axles, vehicle.strips)
    values = columns.room_for(n, *map(len, parts))
    for table, records in zip(values[:3], parts, strict=True):
        for k, record in enumerate(records):
            ends = (value if isinstance(value, tuple) else (value,) for name, value in vars(record).items()
                    if name not in ("unit", "axle"))  # fmt: skip
            for column, value in enumerate(chain.from_iterable(ends)):
                table[:, k, column] = value
    for column, value in enumerate(vehicle.sensor or ()):
        values.sensor[:, column] = value
    tables: Any = (np.zeros((n, len(part), width)) for part, width in zip(parts, state.WIDTHS, strict=True))
    strips: Any = ((s.unit, s.axle, points_of(s)) for s in vehicle.strips)
    owners: Any = ([axle.unit for axle in vehicle.axles], *zip(*strips, strict=True))
    integers = (np.array(numbers, dtype=np.int64) for numbers in owners)
    fleet = Fleet._make([*tables, *integers, profile, *further])
    reason, sample, item, limit = columns.fill(values, fleet)
    if reason:
        _refuse(vehicle, reason, sample, item, limit, n)
    return fleet


def _refuse(vehicle: SpaceVehicle, reason: int, sample: int, item: int, limit: float, n: int) -> NoReturn:
    """Raise RigidBodyError for a vehicle that `columns.fill` refuses."""
    table, name = columns.PLACES[reason]
    key = _unit_key(item, name) if table == "units" else f"{table[:-1]}.{item}.{name}"
    value: Any = getattr(getattr(vehicle, table)[item], name)
    rule = getattr(rules, columns.REASONS[reason])._replace(key=key)
    met: Any = np.arange(n) != sample if n > 1 else False
    names = ("axles", "radius", "least", "length", "most", "stiffness")
    raise refusal(
        rule, np.max(value) if isinstance(value, tuple) else value, met, **dict.fromkeys(names, limit)
    )


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
    for index, strip in enumerate(vehicle.strips):
        of_unit = [a for a, axle in enumerate(vehicle.axles) if axle.unit == strip.unit]
        if strip.axle not in (-1, *of_unit):
            why = "the strip's unit has no axle of this number"
            raise RigidBodyError(f"strip.{index}.axle", str(strip.axle), why, ", ".join(map(str, of_unit)))


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


def _demand_law(index: int, strip: SpaceStrip) -> None:
    """Require a possible crush law of a strip.

    Raises RigidBodyError.
    """
    values = dict(zip(LAW, (getattr(strip, OF_STRIP.get(name, name)) for name in LAW), strict=True))
    try:
        demand_law(*(number(name, value) for name, value in values.items()))
    except RigidBodyError as error:
        key = f"strip.{index}.{OF_STRIP.get(error.key, error.key)}"
        raise RigidBodyError(key, error.value, error.why, error.allowed) from None


def _unit_key(index: int, name: str) -> str:
    """Return the key of a quantity of a unit in a scene."""
    if index:
        return f"trailer.{index - 1}.{name}"
    return f"{'body' if name in OF_BODY else 'vehicle'}.{name}"
