"""Whole impacts of many rigid vehicles or trains on a wall."""

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from solver import rules
from solver.conditions import Array, Gate, Number, RigidBodyError, number
from solver.impact import crush_law
from solver.impact import train as vehicles
from solver.impact.train import Train
from solver.impact.trajectories import Trajectories, solve_trains
from solver.impact.tyres import tyres_of

MANY_TOLERANCE = 4e-3
"""Tolerance by which the step of many impacts at once is chosen."""

BODY = ("length", "width", "mass", "centre_of_mass", "yaw_inertia", "hitch", "kingpin")
"""Quantities of a unit besides its crush."""

AXLE = ("position", "friction", "cornering")
"""Quantities of an axle."""


@dataclass(frozen=True)
class Impacts:
    """First strikes of many impacts.

    Attributes
    ----------
    corner : ndarray, shape (strikes, ...)
        Index of each strike into `CORNERS`, plus 4 for each unit ahead; -1 where there is no such strike [-].
    start, end : ndarray, shape (strikes, ...)
        Start and end [s]; NaN where there is no such strike.
    peak_force : ndarray, shape (strikes, ...)
        Peak of the normal force [N].
    impulse : ndarray, shape (strikes, ...)
        Impulse of the normal force [N s].
    mean_force : ndarray, shape (rows, ...)
        Total normal force [N], means since the previous instant, the first from first touch on; undefined after the
        end, and without rows if there is no interval.
    error : ndarray, shape (...)
        Largest relative change of peaks, impulses, durations and spin against twice the step [-].
    end_speed : ndarray, shape (...)
        Speed of the first unit's centre of mass at the end [m/s].
    """

    corner: NDArray[np.int64]
    start: Array
    end: Array
    peak_force: Array
    impulse: Array
    mean_force: Array
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
    stiffness: Number,
    restitution: Number = 0.0,
    friction: Number,
    initial_force: Number = 0.0,
    plateau_force: Number = math.inf,
    unloading_stiffness: Number = 0.0,
    rear: Mapping[str, Number] = MappingProxyType({}),
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
) -> Impacts:
    """Solve whole impacts of many vehicles or trains.

    Only their corners touch. Arguments broadcast.

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
    stiffness : float or ndarray
        Stiffness k of the corners [N/m].
    restitution : float or ndarray
        Restitution e [-]; 0 where the unloading stiffness is above 0.
    friction : float or ndarray
        Friction coefficient mu [-].
    initial_force, plateau_force : float or ndarray
        Initial force F0 and plateau Fy [N]; Fy is infinite for none.
    unloading_stiffness : float or ndarray
        Slope of unloading k_u [N/m]; 0: defined by the restitution.
    rear : dict
        Values that differ at the rear corners, by the names in `crush_law.LAW`; floats or ndarrays.
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
        and optionally `centre_of_mass`, `yaw_inertia`, keys of `crush_law.LAW` and `rear`.
    axles : sequence of dict
        Fields of `TyreAxle` for each axle, floats or ndarrays; the unit is a number.

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
             "yaw_inertia": yaw_inertia, "rear": rear}  # fmt: skip
    law = {"stiffness": stiffness, "initial_force": initial_force, "plateau_force": plateau_force,
           "restitution": restitution, "unloading_stiffness": unloading_stiffness}  # fmt: skip
    shared: dict[str, Any] = {"friction": friction, "speed": speed, "angle": angle}
    laws = crush_law.unit_laws([first | law, *trailers])
    bodies = ({key: unit.get(key) for key in BODY} for unit in (first, *trailers))
    roads = [{key: axle[key] for key in AXLE} for axle in axles]
    shape, (common, *flat) = _broadcast((shared, *bodies, *(law for both in laws for law in both), *roads))
    units, crush, tyres = flat[: len(laws)], flat[len(laws) : 3 * len(laws)], flat[3 * len(laws) :]
    _demand_inputs(common, units, crush)
    train, state = _trains(units, crush, common)
    sizes = (np.array([unit[key] for unit in units]) for key in ("centre_of_mass", "length"))
    numbered = [{**road, "unit": axle.get("unit", 0)} for road, axle in zip(tyres, axles, strict=True)]
    trajectories = solve_trains(
        train, state, tyres=tyres_of(train, numbered, *sizes), step=step, interval=interval, impulse_alone=True,
        after_second=after_second, longest=longest, tolerance=tolerance,
        strikes=strikes or (16 * len(units) if trailers else 2),
    )  # fmt: skip
    room = trajectories.strikes.shape[1]
    columns = np.moveaxis(trajectories.strikes, -1, 0)[:5]
    corner, start, end, peak, impulse = (value.T.reshape(room, *shape) for value in columns)
    corners = np.nan_to_num(corner, nan=-1.0).astype(np.int64)
    force = _mean_forces(trajectories, interval).reshape(-1, *shape)
    speed = np.asarray(np.hypot(*trajectories.state[:, 0, 3:5].T)).reshape(shape)
    return Impacts(corners, start, end, peak, impulse, force, trajectories.error.reshape(shape), speed)


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


def _demand_inputs(
    common: Mapping[str, Array], units: Sequence[dict[str, Array]], crush: Sequence[Mapping[str, Array]]
) -> None:
    """Complete the units and validate all inputs.

    common, units, crush: as of `_trains`. Raises RigidBodyError.
    """
    for index, unit in enumerate(units):
        table = f"trailer.{index - 1}." if index else ""
        with _naming(table):
            _complete(unit)
            crush_law.demand_law(*(crush[2 * index][key] for key in crush_law.LAW))
        with _naming(f"{table or 'contact.'}rear."):
            crush_law.demand_law(*(crush[2 * index + 1][key] for key in crush_law.LAW))
    gate, theta = Gate(), common["angle"]
    gate.positive(rules.SPEED, common["speed"])
    gate.demand(rules.TOUCH_ANGLE, (theta > 0.0) & (theta < math.pi / 2.0), theta)
    gate.not_negative(rules.FRICTION, common["friction"])


@contextmanager
def _naming(table: str) -> Iterator[None]:
    """Add the table of a unit to the key of an error."""
    try:
        yield
    except RigidBodyError as error:
        raise RigidBodyError(f"{table}{error.key}", error.value, error.why, error.allowed) from None


def _complete(unit: dict[str, Array]) -> None:
    """Set omitted centre of mass and inertia, and validate the body.

    Raises RigidBodyError.
    """
    size, is_prescribed = (unit["length"], unit["width"], unit["mass"]), "yaw_inertia" in unit
    unit.setdefault("centre_of_mass", 0.5 * size[0])
    unit.setdefault("yaw_inertia", vehicles.uniform_inertia(*size))
    vehicles.demand_body(*size, unit["centre_of_mass"], unit["yaw_inertia"], is_prescribed)


def _trains(
    units: Sequence[Mapping[str, Array]], laws: Sequence[Mapping[str, Array]], common: Mapping[str, Array]
) -> tuple[Train, Array]:
    """Return trains and their states at first touch.

    units: quantities of each; laws: of the front and the rear corners of each; common: quantities of all.
    """
    places = [vehicles.corner_places(unit["centre_of_mass"], unit["length"], unit["width"]) for unit in units]
    n, count = common["speed"].size, len(units)
    hitch, kingpin, behind = np.empty((count - 1, n)), np.empty((count - 1, n)), np.zeros((count, n))
    for i, (ahead, unit) in enumerate(pairwise(units)):
        hitch[i] = ahead["centre_of_mass"] - unit["hitch"]
        kingpin[i] = unit["centre_of_mass"] - unit["kingpin"]
        behind[i + 1] = behind[i] - hitch[i] + kingpin[i]
    front = units[0]
    state = vehicles.touching(front["centre_of_mass"], front["width"], common["angle"], common["speed"])
    state = vehicles.cleared(state, places, behind[1:]) if count > 1 else state
    along, across = np.moveaxis(np.concatenate(places), 1, 0)
    mass, inertia = (np.array([unit[key] for unit in units]) for key in ("mass", "yaw_inertia"))
    pairs = [(*laws[i : i + 2], *laws[i : i + 2]) for i in range(0, len(laws), 2)]  # in the order of CORNERS
    crush = {key: np.array([law[key] for pair in pairs for law in pair]) for key in crush_law.LAW}
    numbers = np.repeat(np.arange(count), 4), np.tile(np.arange(4), count)
    crush["friction"] = np.tile(common["friction"], (4 * count, 1))
    load = np.zeros((count, 3, n))
    train = Train(mass, inertia, hitch, kingpin, *numbers, along, across, load=load, **crush)
    return train, np.ascontiguousarray(np.moveaxis(vehicles.lined_up(state, behind[1:]), -1, 0))


def _mean_forces(trajectories: Trajectories, interval: float | None) -> Array:
    """Return mean forces between rows up to the end of each.

    Shape (rows, n).
    """
    if interval is None:
        return np.zeros((0, len(trajectories.end)))
    count = math.ceil(float(trajectories.end.max()) / interval)
    instants = interval * np.arange(count + 1)
    impulse = trajectories.rows[:, : count + 1, 0]
    over = instants >= trajectories.end[:, None] + (1.0 - 1e-9) * interval  # rows that were never written
    last = np.where(over, -math.inf, impulse)
    return np.diff(np.maximum.accumulate(last, axis=1), axis=1).T / interval
