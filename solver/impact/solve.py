"""Whole impacts of rigid vehicles on a wall that only pushes: one with its motion, or many with their strikes."""

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, astuple, dataclass
from itertools import pairwise
from types import MappingProxyType, SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from machine_code.compiled import OnCompile, ignore_compiling
from solver import rules
from solver.conditions import Array, Gate, Number, RigidBodyError, number, positive
from solver.impact import train as vehicles
from solver.impact.step import SUMS, UNIT
from solver.impact.strikes import Strike, corner_name, strikes_of_rows
from solver.impact.train import HitchedVehicle, ImpactState, ImpactVehicle, Train, WallContact, train_of
from solver.impact.trajectories import TOLERANCE, Trajectories, solve_trains
from solver.impact.tyres import SUMS as TYRE_SUMS
from solver.impact.tyres import Axle, tyres_of

MANY = 4e-3
"""Error by which the step of many impacts at once is chosen."""

MOST_STRIKES = 64
"""Strikes of one impact for which there is room at first."""

BODY = ("length", "width", "mass", "centre_of_mass", "yaw_inertia", "hitch", "kingpin")
"""Quantities of a unit besides its crush."""

AXLE = ("position", "friction", "cornering")
"""Quantities of an axle."""

RATES = {"x_g": "v_gx", "y_g": "v_gy"}
FORCES = {f"impulse_{name}": f"force_{name}" for name in ("normal", "tangential")}
"""Columns of rows that are integrals of another, and of which; `FORCES` of one unit, for those of each have none."""


def column_names(units: int, steered: bool = False) -> tuple[str, ...]:
    """Return the columns of the rows of so many units.

    Those of a trailer end with the unit's number, from 2 on. Behind the sums are those of each unit's impulses with its
    number, of a train alone, then with tyres those of each unit's tyres.
    """
    states = [f"{name}_{unit}" if unit > 1 else name for unit in range(1, units + 1) for name in UNIT]
    each = [f"impulse_{name}_{unit}" for unit in range(1, units + 1) for name in ("normal", "tangential")]
    ends = ("", *(f"_{unit}" for unit in range(2, units + 1)))
    tyres = [f"{name}{end}" for end in ends for name in TYRE_SUMS] if steered else []
    return (*states, *SUMS, *(each if units > 1 else ()), *tyres)


COLUMNS = column_names(1)


@dataclass(frozen=True)
class ImpactMotion:
    """One whole impact; made by `solve_impact`.

    Attributes
    ----------
    vehicle : ImpactVehicle
        As given.
    contact : WallContact
        As given.
    strikes : tuple of Strike
        In order of time.
    t_end : float
        How far the motion was followed [s].
    end : ImpactState
        The state there.
    step : float
        [s].
    error : float
        Largest relative change of the first two peaks and impulses, and of the spin, against twice the step [-].
    interval : float
        Between rows [s].
    rows : ndarray, shape (rows, columns)
        Every step, or as many as there is room for [SI]; columns as of `column_names`.
    trailers : tuple of HitchedVehicle
        As given.
    axles : tuple of Axle
        As given.
    loads : tuple of float
        Of each axle at rest [N].
    """

    vehicle: ImpactVehicle
    contact: WallContact
    strikes: tuple[Strike, ...]
    t_end: float
    end: ImpactState
    step: float
    error: float
    interval: float
    rows: Array
    trailers: tuple[HitchedVehicle, ...] = ()
    axles: tuple[Axle, ...] = ()
    loads: tuple[float, ...] = ()

    @property
    def vehicles(self) -> tuple[ImpactVehicle, ...]:
        """The vehicle and its trailers."""
        return self.vehicle, *(each.vehicle for each in self.trailers)

    def at(self, times: ArrayLike) -> SimpleNamespace:
        """The motion at given instants.

        Parameters
        ----------
        times : array_like, of any shape
            From 0 to `t_end` [s].

        Returns
        -------
        SimpleNamespace
            Arrays of the shape of `times`, forces and energies summed over the points: `t` [s]; `x_g`, `y_g`, centre of
            mass [m]; `theta`, between the wall side and the wall [rad]; `omega`, positive where it closes the angle
            [rad/s]; `v_gx`, `v_gy` [m/s]; `force_normal`, `force_tangential`, of the wall on the vehicle along +Y and
            +X [N]; `impulse_normal`, `impulse_tangential`, their integrals [N s]; `impulse_angular`, the integral of
            their moment about X = Y = 0 [N m s]; `kinetic_energy` [J]; `crush_energy_stored`, `crush_energy_lost`,
            taken up by the crush, that unloading would return and that it would not [J]; `crush_work`, of the normal
            forces on the crush, stored and lost together [J]; `friction_work`, on the vehicle, 0 or less [J]. Of a
            train the motion is that of the first vehicle, with "_2" at the end of the name that of the next and so on;
            `impulse_normal_1`, `impulse_tangential_1` are the wall's on the first alone; the others are of the train.
            With axles `tyre_work` [J], `tyre_impulse_normal`, `tyre_impulse_tangential` [N s] and
            `tyre_impulse_angular` [N m s] of the tyres on each unit, likewise.

        Raises
        ------
        RigidBodyError
            For an instant outside that range.
        """
        t = np.asarray(number("time", times), dtype=np.float64)
        Gate().demand(rules.IMPACT_TIME, (t >= 0.0) & (t <= self.t_end), t, end=self.t_end)
        k = np.minimum((t / self.interval).astype(np.int64), len(self.rows) - 2)
        s, before, after = (t / self.interval - k)[..., None], self.rows[k], self.rows[k + 1]
        value = before + s * (after - before)
        names = column_names(len(self.vehicles), bool(self.axles))
        for name, rate in _rates(len(self.vehicles)):  # by the cubic with both rates
            i, j = names.index(name), names.index(rate)
            one, two, u = before[..., j], after[..., j], s[..., 0]
            secant = after[..., i] - before[..., i]
            one, two = one * self.interval - secant, two * self.interval - secant
            value[..., i] += u * (1.0 - u) * ((1.0 - u) * one - u * two)
        found = SimpleNamespace(t=t, **dict(zip(names, np.moveaxis(value, -1, 0), strict=True)))
        found.kinetic_energy = 0.0
        for unit, vehicle in enumerate(self.vehicles):
            u, v, w = np.moveaxis(value[..., 6 * unit + 3 : 6 * unit + 6], -1, 0)
            found.kinetic_energy += 0.5 * (vehicle.mass * (u**2 + v**2) + vehicle.inertia * w**2)
        return found

    def hinge_forces(self, times: Array) -> Array:
        """Mean forces of each hinge between instants, on the vehicle ahead of it, by what all behind it gain.

        Parameters
        ----------
        times : ndarray, shape (n,)
            From 0 to `t_end`, rising [s].

        Returns
        -------
        ndarray
            Along X and Y [N], shape (hinges, 2, n - 1).
        """
        at, gained = self.at(np.minimum(times, self.t_end)), []
        for unit, each in enumerate(self.trailers, 2):
            momenta = (each.vehicle.mass * getattr(at, f"v_g{axis}_{unit}") for axis in "xy")
            pushes = [getattr(at, f"impulse_{force}_{unit}") for force in ("tangential", "normal")]
            if self.axles:
                steering = (getattr(at, f"tyre_impulse_{force}_{unit}") for force in ("tangential", "normal"))
                pushes = [wall + road for wall, road in zip(pushes, steering, strict=True)]
            gained.append([np.diff(wall - own) for own, wall in zip(momenta, pushes, strict=True)])
        found = np.reshape(gained, (-1, 2, times.size - 1)) / np.diff(times)
        return np.cumsum(found[::-1], axis=0)[::-1]

    def corner_depths(self, times: ArrayLike) -> Array:
        """Depths of the corners behind the wall at given instants.

        Parameters
        ----------
        times : array_like, of any shape
            From 0 to `t_end` [s].

        Returns
        -------
        ndarray
            In the order of `CORNERS`, below 0 in front of the wall [m], shape (4, ...).
        """
        at, size = self.at(times), (self.vehicle.front_distance, self.vehicle.length, self.vehicle.width)
        places = vehicles.corner_places(*size).reshape(4, 2, *[1] * np.ndim(times))
        return vehicles.corner_depths(places, at.y_g, at.theta)


def _rates(units: int) -> list[tuple[str, str]]:
    """Columns that are integrals of another, and of which; those of trailers too."""
    ends = ("", *(f"_{unit}" for unit in range(2, units + 1)))
    found = [(f"{name}{end}", f"{rate}{end}") for end in ends for name, rate in RATES.items()]
    return found if units > 1 else [*found, *FORCES.items()]


def solve_impact(
    vehicle: ImpactVehicle,
    contact: WallContact,
    state: ImpactState,
    end: float | None = None,
    after_second: float = 0.1,
    longest: float = 5.0,
    step: float | None = None,
    tolerance: float = TOLERANCE,
    on_compile: OnCompile = ignore_compiling,
    trailers: Sequence[HitchedVehicle] = (),
    axles: Sequence[Axle] = (),
) -> ImpactMotion:
    """The whole impact of a rigid vehicle, or of a train, any number of strikes.

    Parameters
    ----------
    vehicle : ImpactVehicle
        The vehicle.
    contact : WallContact
        Laws of its contact with the wall.
    state : ImpactState
        At the start, outside the wall or touching it.
    end : float or None
        How far to follow the motion [s]; None: `after_second` after the first two strikes, or of a train after the
        strike of its last rear, and without one until nothing can touch any more, but for `after_second` at least; and
        on until no strike is in progress.
    after_second : float
        [s].
    longest : float
        With end None: how far at most [s], be it in a strike.
    step : float or None
        [s]; None: chosen by the tolerance.
    tolerance : float
        Of peaks, impulses and spin, by which the step is chosen [-].
    on_compile : callable
        Called when code is compiled, see `machine_code.compiled.compile_once`.
    trailers : sequence of HitchedVehicle
        Behind the vehicle, in a line with it at the start.
    axles : sequence of Axle
        Axles whose tyres resist sliding across their unit.

    Returns
    -------
    ImpactMotion
        Gives the motion at any instant.

    Raises
    ------
    RigidBodyError
        For a start inside the wall, for an end that is not positive, and where the steps become too short.
    """
    for value in (end, after_second, longest, step):
        if value is not None:
            positive(rules.END, value)
    units, contacts = [vehicle, *(t.vehicle for t in trailers)], [contact, *(t.contact for t in trailers)]
    train = train_of(units, contacts, [(each.hitch, each.kingpin) for each in trailers])
    start = vehicles.lined_up(astuple(state), vehicles.distances(vehicle, trailers))
    for index, (unit, own) in enumerate(zip(units, start, strict=True)):
        places = vehicles.corner_places(unit.front_distance, unit.length, unit.width)
        for corner, value in enumerate(vehicles.corner_depths(places, own[1], own[2])):
            met, name = value <= 1e-9 * vehicle.length, corner_name(index, corner)
            Gate().demand(rules.INSIDE, met, value, name=name, depth=value)
    bodies = np.array([[unit.front_distance, unit.length] for unit in units]).T[..., None]
    tyres = tyres_of(train, [asdict(axle) for axle in axles], *bodies)
    found = solve_trains(
        train, start[None], tyres=tyres, step=step, end=end, interval=0.0, after_second=after_second,
        longest=longest, tolerance=tolerance, strikes=MOST_STRIKES, on_compile=on_compile,
    )  # fmt: skip
    reached, last = float(found.end[0]), ImpactState(*found.state[0, 0].tolist())
    strikes = strikes_of_rows(found.strikes[0], [unit.front_distance for unit in units], reached)
    if end is None:
        Gate().demand(rules.NEVER, bool(strikes), state.v_gy)
    written = math.ceil(reached / found.interval[0] * (1.0 - 1e-12)) + 1  # no row behind the end is
    rows = found.rows[0, : max(written, 2)]
    return ImpactMotion(
        vehicle, contact, strikes, reached, last, float(found.step[0]), float(found.error[0]),
        float(found.interval[0]), rows, tuple(trailers), tuple(axles),
        () if tyres is None else tuple(tyres.load[:, 0].tolist()),
    )  # fmt: skip


@dataclass(frozen=True)
class Impacts:
    """The first strikes of many impacts.

    Attributes
    ----------
    corner : ndarray, shape (strikes, ...)
        Of each strike, index into `CORNERS`, of a trailer 4 more for each unit; -1 where there is no such strike [-].
    start, end : ndarray, shape (strikes, ...)
        [s]; NaN where there is no such strike.
    peak_force : ndarray, shape (strikes, ...)
        Of the normal force [N].
    impulse : ndarray, shape (strikes, ...)
        Of the normal force [N s].
    mean_force : ndarray, shape (rows, ...)
        Total normal force [N], each row the mean since the even instant before, the first from first touch on; none
        behind the end, and no rows where no interval was asked for.
    error : ndarray, shape (...)
        Largest relative change of peaks, impulses, durations and spin against twice the step [-].
    end_speed : ndarray, shape (...)
        Of the first unit's centre of mass at the end [m/s].
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
        """From start to end [s], shape (strikes, ...)."""
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
    tolerance: float = MANY,
    strikes: int | None = None,
    trailers: Sequence[Mapping[str, Any]] = (),
    axles: Sequence[Mapping[str, Number]] = (),
) -> Impacts:
    """Whole impacts of rigid vehicles, or trains, whose corners alone touch; arguments broadcast.

    Parameters
    ----------
    length, width : float or ndarray
        L, B [m].
    mass : float or ndarray
        m [kg].
    speed : float or ndarray
        [m/s].
    angle : float or ndarray
        Between side and wall [rad].
    stiffness : float or ndarray
        k of the corners [N/m].
    restitution : float or ndarray
        e [-]; 0 where the unloading stiffness is above 0.
    friction : float or ndarray
        mu [-].
    initial_force, plateau_force : float or ndarray
        F0, Fy [N]; Fy is infinite for none.
    unloading_stiffness : float or ndarray
        k_u [N/m]; 0: defined by the restitution.
    rear : dict
        What is different at the rear corners, by the names in `train.LAW`; floats or ndarrays.
    centre_of_mass : float, ndarray or None
        Behind the front [m]; None: L/2.
    yaw_inertia : float, ndarray or None
        [kg m^2]; None: m (L^2 + B^2)/12.
    after_second : float
        Each ends so long after its second strike, or when a strike then in progress is over [s].
    longest : float
        And after this at the latest [s].
    interval : float or None
        Between the rows of the force history [s]; None: there is none.
    step : float or None
        Of all [s]; None: chosen for each by the tolerance.
    tolerance : float
        Of peaks, impulses, durations and spin, by which the step of each is chosen [-].
    strikes : int or None
        For how many there is room, and of more than two for all; None: two, of trains all.
    trailers : sequence of dict
        Of each trailer `length`, `width`, `mass`, `hitch` and `kingpin`, floats or ndarrays as of `HitchedVehicle`, and
        where it has its own `centre_of_mass`, `yaw_inertia`, keys of `train.LAW` and `rear`.
    axles : sequence of dict
        Of each axle the fields of `Axle`, floats or ndarrays; the unit a number.

    Returns
    -------
    Impacts
        Arrays of the common shape.

    Raises
    ------
    RigidBodyError
        As `solve_impact`, for the first row that has no answer.
    """
    first: dict[str, Any] = {"length": length, "width": width, "mass": mass, "centre_of_mass": centre_of_mass,
             "yaw_inertia": yaw_inertia, "rear": rear}  # fmt: skip
    law = {"stiffness": stiffness, "initial_force": initial_force, "plateau_force": plateau_force,
           "restitution": restitution, "unloading_stiffness": unloading_stiffness}  # fmt: skip
    shared: dict[str, Any] = {"friction": friction, "speed": speed, "angle": angle}
    laws = vehicles.unit_laws([first | law, *trailers])
    bodies = ({key: unit.get(key) for key in BODY} for unit in (first, *trailers))
    roads = [{key: axle[key] for key in AXLE} for axle in axles]
    tables: list[dict[str, Any]] = [
        {key: number(key, value) for key, value in table.items() if value is not None}
        for table in (shared, *bodies, *(law for both in laws for law in both), *roads)
    ]
    shape = np.broadcast_shapes(*(np.shape(value) for table in tables for value in table.values()))
    its, *flat = (
        {key: np.broadcast_to(each, shape).ravel() for key, each in table.items()} for table in tables
    )
    units, crush, tyres = flat[: len(laws)], flat[len(laws) : 3 * len(laws)], flat[3 * len(laws) :]
    for index, unit in enumerate(units):
        table = f"trailer.{index - 1}." if index else ""
        with _naming(table):
            _complete(unit)
            vehicles.demand_law(*(crush[2 * index][key] for key in vehicles.LAW))
        with _naming(f"{table or 'contact.'}rear."):
            vehicles.demand_law(*(crush[2 * index + 1][key] for key in vehicles.LAW))
    gate, theta = Gate(), its["angle"]
    gate.positive(rules.SPEED, its["speed"])
    gate.demand(rules.TOUCH_ANGLE, (theta > 0.0) & (theta < math.pi / 2.0), theta)
    gate.not_negative(rules.FRICTION, its["friction"])
    train, state = _trains(units, crush, its)
    own = (np.array([unit[key] for unit in units]) for key in ("centre_of_mass", "length"))
    numbered = [{**road, "unit": axle.get("unit", 0)} for road, axle in zip(tyres, axles, strict=True)]
    found = solve_trains(
        train, state, tyres=tyres_of(train, numbered, *own), step=step, interval=interval, impulse_alone=True,
        after_second=after_second, longest=longest, tolerance=tolerance,
        strikes=strikes or (16 * len(units) if trailers else 2),
    )  # fmt: skip
    room = found.strikes.shape[1]
    columns = np.moveaxis(found.strikes, -1, 0)[:5]
    corner, start, end, peak, impulse = (value.T.reshape(room, *shape) for value in columns)
    corners = np.nan_to_num(corner, nan=-1.0).astype(np.int64)
    force = _mean_forces(found, interval).reshape(-1, *shape)
    speed = np.asarray(np.hypot(*found.state[:, 0, 3:5].T)).reshape(shape)
    return Impacts(corners, start, end, peak, impulse, force, found.error.reshape(shape), speed)


@contextmanager
def _naming(table: str) -> Iterator[None]:
    """Name the table of a unit in what is refused."""
    try:
        yield
    except RigidBodyError as error:
        raise RigidBodyError(f"{table}{error.key}", error.given, error.why, error.allowed) from None


def _complete(unit: dict[str, Array]) -> None:
    """Set the centre of mass and the inertia that a unit leaves out, and require values that a body can have.

    Raises RigidBodyError.
    """
    size, given = (unit["length"], unit["width"], unit["mass"]), "yaw_inertia" in unit
    unit.setdefault("centre_of_mass", 0.5 * size[0])
    unit.setdefault("yaw_inertia", vehicles.uniform_inertia(*size))
    vehicles.demand_body(*size, unit["centre_of_mass"], unit["yaw_inertia"], given)


def _trains(
    units: Sequence[Mapping[str, Array]], laws: Sequence[Mapping[str, Array]], its: Mapping[str, Array]
) -> tuple[Train, Array]:
    """Return trains and their states at first touch.

    units: quantities of each; laws: of the front and the rear corners of each; its: what they have in common.
    """
    places = [vehicles.corner_places(each["centre_of_mass"], each["length"], each["width"]) for each in units]
    n, count = its["speed"].size, len(units)
    hitch, kingpin, behind = np.empty((count - 1, n)), np.empty((count - 1, n)), np.zeros((count, n))
    for i, (ahead, unit) in enumerate(pairwise(units)):
        hitch[i] = ahead["centre_of_mass"] - unit["hitch"]
        kingpin[i] = unit["centre_of_mass"] - unit["kingpin"]
        behind[i + 1] = behind[i] - hitch[i] + kingpin[i]
    front = units[0]
    state = vehicles.touching(front["centre_of_mass"], front["width"], its["angle"], its["speed"])
    state = vehicles.cleared(state, places, behind[1:]) if count > 1 else state
    along, across = np.moveaxis(np.concatenate(places), 1, 0)
    mass, inertia = (np.array([unit[key] for unit in units]) for key in ("mass", "yaw_inertia"))
    pairs = [(*laws[i : i + 2], *laws[i : i + 2]) for i in range(0, len(laws), 2)]  # in the order of CORNERS
    crush = {key: np.array([law[key] for pair in pairs for law in pair]) for key in vehicles.LAW}
    numbers = np.repeat(np.arange(count), 4), np.tile(np.arange(4), count)
    crush["friction"] = np.tile(its["friction"], (4 * count, 1))
    load = np.zeros((count, 3, n))
    train = Train(mass, inertia, hitch, kingpin, *numbers, along, across, load=load, **crush)
    return train, np.ascontiguousarray(np.moveaxis(vehicles.lined_up(state, behind[1:]), -1, 0))


def _mean_forces(found: Trajectories, interval: float | None) -> Array:
    """Mean forces between rows, shape (rows, n): none behind the end of each."""
    if interval is None:
        return np.zeros((0, len(found.end)))
    count = math.ceil(float(found.end.max()) / interval)
    instants = interval * np.arange(count + 1)
    impulse = found.rows[:, : count + 1, 0]
    over = instants >= found.end[:, None] + (1.0 - 1e-9) * interval  # rows that were never written
    last = np.where(over, -math.inf, impulse)
    return np.diff(np.maximum.accumulate(last, axis=1), axis=1).T / interval
