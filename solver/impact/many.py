"""Whole impacts of many rigid vehicles or trains on a wall."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from solver import rules
from solver.conditions import Array, Gate, Number, RigidBodyError, number
from solver.impact import train as vehicles
from solver.impact.crush_law import LAW, CrushLaw
from solver.impact.strips import Strip, WallContact, awaited, points_of
from solver.impact.train import Train
from solver.impact.trajectories import Trajectories, solve_trains
from solver.impact.tyres import AXLE, tyres_of

MANY_TOLERANCE = 4e-3
"""Tolerance by which the step of many impacts at once is chosen."""

BODY = ("length", "width", "mass", "centre_of_mass", "yaw_inertia", "hitch", "kingpin")
"""Quantities of a unit besides its crush."""


@dataclass(frozen=True)
class Impacts:
    """First strikes of many impacts.

    Attributes
    ----------
    group : ndarray, shape (strikes, ...)
        Group of each strike, an index into `group_names`; -1 where there is no such strike [-].
    start, end : ndarray, shape (strikes, ...)
        Start and end [s]; NaN where there is no such strike.
    peak_force : ndarray, shape (strikes, ...)
        Peak of the normal force [N].
    impulse : ndarray, shape (strikes, ...)
        Impulse of the normal force [N s].
    mean_force : ndarray, shape (rows, ...)
        Total normal force [N], means since the previous instant, the first from first touch on; undefined after the
        end, and without rows if there is no interval.
    acceleration : ndarray, shape (rows, ...)
        Acceleration of the sensor away from the wall [m/s^2], likewise; without rows if there is no sensor.
    error : ndarray, shape (...)
        Largest relative change of peaks, impulses, durations and spin against twice the step [-].
    end_speed : ndarray, shape (...)
        Speed of the first unit's centre of mass at the end [m/s].
    """

    group: NDArray[np.int64]
    start: Array
    end: Array
    peak_force: Array
    impulse: Array
    mean_force: Array
    acceleration: Array
    error: Array
    end_speed: Array

    @property
    def duration(self) -> Array:
        """Duration of each strike [s], shape (strikes, ...)."""
        return self.end - self.start


def solve_impacts(
    *,
    length: Number,
    width: Number,
    mass: Number,
    speed: Number,
    angle: Number,
    contact: WallContact,
    centre_of_mass: Number | None = None,
    yaw_inertia: Number | None = None,
    after_second: float = 0.1,
    longest: float = 5.0,
    interval: float | None = None,
    step: float | None = None,
    tolerance: float = MANY_TOLERANCE,
    strikes: int | None = None,
    trailers: Sequence[Mapping[str, Any]] = (),
    axles: Sequence[Mapping[str, Number]] = (),
    sensor: Number | None = None,
) -> Impacts:
    """Solve whole impacts of many vehicles or trains.

    Arguments broadcast.

    Parameters
    ----------
    length, width : float or ndarray
        Length L and width B [m].
    mass : float or ndarray
        Mass m [kg].
    speed : float or ndarray
        Speed before the impact [m/s].
    angle : float or ndarray
        Angle between side and wall [rad].
    contact : WallContact
        Laws of contact, of floats or ndarrays.
    centre_of_mass : float, ndarray or None
        Distance behind the front [m]; None: L/2.
    yaw_inertia : float, ndarray or None
        Inertia about the centre of mass [kg m^2]; None: m (L^2 + B^2)/12.
    after_second : float
        Time from the second strike to the end of each [s]; a strike then in progress is completed.
    longest : float
        Latest end [s].
    interval : float or None
        Time between the rows of the force history [s]; None: no history.
    step : float or None
        Time step of all [s]; None: chosen for each by the tolerance.
    tolerance : float
        Tolerance of peaks, impulses, durations and spin, by which each step is chosen [-].
    strikes : int or None
        Number of strikes in the result, extended to all if it is above two; None: two, of trains all.
    trailers : sequence of dict
        For each trailer `length`, `width`, `mass`, `hitch` and `kingpin`, floats or ndarrays as of `HitchedVehicle`,
        and optionally `centre_of_mass`, `yaw_inertia`.
    axles : sequence of dict
        Fields of `TyreAxle` for each axle, floats or ndarrays; the unit is a number.
    sensor : float, ndarray or None
        Place of a sensor on the centre line of the first unit behind its front [m], if any.

    Returns
    -------
    Impacts
        Arrays of the common shape.

    Raises
    ------
    RigidBodyError
        As `solve_impact`, for the first row without a solution.
    """
    first: dict[str, Any] = {"length": length, "width": width, "mass": mass, "centre_of_mass": centre_of_mass,
             "yaw_inertia": yaw_inertia}  # fmt: skip
    shared: dict[str, Any] = {"speed": speed, "angle": angle, "sensor": sensor}
    bodies = [{key: unit.get(key) for key in BODY} for unit in (first, *trailers)]
    roads = [{key: axle[key] for key in AXLE} for axle in axles]
    laws = dict[str, Number]()
    _mapped(contact, lambda value: laws.setdefault(str(len(laws)), value))
    shape, (common, _, *flat) = _broadcast((shared, laws, *bodies, *roads))
    units, tyre_axles = flat[: len(bodies)], flat[len(bodies) :]
    contact = _mapped(contact, lambda value: np.broadcast_to(value, shape).ravel())
    _demand_inputs(common, units)
    train, state = _trains(units, contact, common)
    sizes = (np.array([unit[key] for unit in units]) for key in ("centre_of_mass", "length"))
    numbered = [{**road, "unit": axle.get("unit", 0)} for road, axle in zip(tyre_axles, axles, strict=True)]
    lengths = [unit["length"] for unit in units]
    place = None if sensor is None else units[0]["centre_of_mass"] - common["sensor"]
    trajectories = solve_trains(
        train, state, tyres=tyres_of(train, numbered, *sizes), step=step, interval=interval, impulse_alone=True,
        sensor=place, after_second=after_second, awaited=awaited(contact, lengths), longest=longest,
        tolerance=tolerance, strikes=strikes or (2 if awaited(contact, lengths) < 0 else 16 * len(units)),
    )  # fmt: skip
    room = trajectories.strikes.shape[1]
    columns = np.moveaxis(trajectories.strikes, -1, 0)[:5]
    group, start, end, peak, impulse = (value.T.reshape(room, *shape) for value in columns)
    groups = np.nan_to_num(group, nan=-1.0).astype(np.int64)
    force, acceleration = (rows.reshape(-1, *shape) for rows in _means_of_rows(trajectories, interval))
    speed = np.asarray(np.hypot(*trajectories.state[:, 0, 3:5].T)).reshape(shape)
    error = trajectories.error.reshape(shape)
    return Impacts(groups, start, end, peak, impulse, force, acceleration, error, speed)


def _mapped(contact: WallContact, change: Callable[[Number], Number]) -> WallContact:
    """Return a contact with each of its numbers changed."""

    def law(one: CrushLaw) -> CrushLaw:
        return CrushLaw(**{key: change(getattr(one, key)) for key in LAW})

    strips = tuple(
        Strip((change(strip.at[0]), change(strip.at[1])), law(strip.law), change(strip.inset), strip.unit)
        for strip in contact.strips
    )
    return WallContact(contact.crush and law(contact.crush), change(contact.friction), strips)


def _broadcast(tables: Sequence[Mapping[str, Any]]) -> tuple[tuple[int, ...], list[dict[str, Array]]]:
    """Return the common shape and all quantities, of shape (n,).

    Quantities that are None are omitted.
    """
    numbers = [
        {key: number(key, value) for key, value in table.items() if value is not None} for table in tables
    ]
    shape = np.broadcast_shapes(*(np.shape(value) for table in numbers for value in table.values()))
    flat = [
        {key: np.broadcast_to(quantity, shape).ravel() for key, quantity in table.items()}
        for table in numbers
    ]
    return shape, flat


def _demand_inputs(common: Mapping[str, Array], units: Sequence[dict[str, Array]]) -> None:
    """Complete the units and validate all inputs but the laws.

    common, units: as of `_trains`. Raises RigidBodyError.
    """
    for index, unit in enumerate(units):
        try:
            _complete(unit)
        except RigidBodyError as error:
            table = f"trailer.{index - 1}." if index else ""
            raise RigidBodyError(f"{table}{error.key}", error.value, error.why, error.allowed) from None
    gate, theta = Gate(), common["angle"]
    gate.positive(rules.SPEED, common["speed"])
    gate.demand(rules.TOUCH_ANGLE, (theta > 0.0) & (theta < math.pi / 2.0), theta)


def _complete(unit: dict[str, Array]) -> None:
    """Set omitted centre of mass and inertia, and validate the body.

    Raises RigidBodyError.
    """
    size, is_prescribed = (unit["length"], unit["width"], unit["mass"]), "yaw_inertia" in unit
    unit.setdefault("centre_of_mass", 0.5 * size[0])
    unit.setdefault("yaw_inertia", vehicles.uniform_inertia(*size))
    vehicles.demand_body(*size, unit["centre_of_mass"], unit["yaw_inertia"], is_prescribed)


def _trains(
    units: Sequence[Mapping[str, Array]], contact: WallContact, common: Mapping[str, Array]
) -> tuple[Train, Array]:
    """Return trains and their states at first touch.

    units: quantities of each; common: quantities of all.
    """
    n, count = common["speed"].size, len(units)
    hitch, kingpin, behind = np.empty((count - 1, n)), np.empty((count - 1, n)), np.zeros((count, n))
    for i, (ahead, unit) in enumerate(pairwise(units)):
        hitch[i] = ahead["centre_of_mass"] - unit["hitch"]
        kingpin[i] = unit["centre_of_mass"] - unit["kingpin"]
        behind[i + 1] = behind[i] - hitch[i] + kingpin[i]
    sizes = (np.array([unit[key] for unit in units]) for key in ("length", "width", "centre_of_mass"))
    points = points_of(contact, *sizes)
    front = units[0]
    state = vehicles.touching(front["centre_of_mass"], front["width"], common["angle"], common["speed"])
    state = vehicles.cleared(state, points, behind[1:])
    mass, inertia = (np.array([unit[key] for unit in units]) for key in ("mass", "yaw_inertia"))
    train = vehicles.assembled(mass, inertia, hitch, kingpin, points, contact.friction)
    return train, np.ascontiguousarray(np.moveaxis(vehicles.lined_up(state, behind[1:]), -1, 0))


def _means_of_rows(trajectories: Trajectories, interval: float | None) -> tuple[Array, ...]:
    """Return mean forces and accelerations between rows.

    Shape (rows, n), up to the end of each; without rows where there are none.
    """
    if interval is None:
        return np.zeros((0, len(trajectories.end))), np.zeros((0, len(trajectories.end)))
    count = math.ceil(float(trajectories.end.max()) / interval)
    rows = trajectories.rows[:, : count + 1]
    over = interval * np.arange(count + 1) >= trajectories.end[:, None] + (1.0 - 1e-9) * interval
    last = np.argmax(over, axis=1) - 1  # later rows were never written
    last = np.where(over.any(axis=1), last, count)[:, None]
    written = np.minimum(np.arange(count + 1), last)
    means = (
        np.diff(np.take_along_axis(rows[..., k], written, axis=1), axis=1).T / interval
        for k in range(rows.shape[2])
    )
    return (*means, np.zeros((0, len(trajectories.end))))[:2]
