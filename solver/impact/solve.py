"""Whole impacts of rigid vehicles on a wall.

The wall only pushes. One impact is solved with its motion, or many with their strikes.
"""

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
from solver.impact.tyres import TyreAxle, tyres_of

MANY_TOLERANCE = 4e-3
"""Tolerance by which the step of many impacts at once is chosen."""

MOST_STRIKES = 64
"""Initial capacity for strikes of one impact."""

BODY = ("length", "width", "mass", "centre_of_mass", "yaw_inertia", "hitch", "kingpin")
"""Quantities of a unit besides its crush."""

AXLE = ("position", "friction", "cornering")
"""Quantities of an axle."""

RATES = {"x_g": "v_gx", "y_g": "v_gy"}
FORCES = {f"impulse_{name}": f"force_{name}" for name in ("normal", "tangential")}
"""Rates of columns that are integrals. `FORCES` apply to a single unit; those of each unit are not recorded."""


def column_names(units: int, steered: bool = False) -> tuple[str, ...]:
    """Return the columns of rows of this number of units.

    Those of a trailer end with the unit's number, from 2 on. After the sums follow, for a train alone, the impulses of
    each unit with its number, then with tyres those of each unit's tyres.
    """
    states = [f"{name}_{unit}" if unit > 1 else name for unit in range(1, units + 1) for name in UNIT]
    impulses = [f"impulse_{name}_{unit}" for unit in range(1, units + 1) for name in ("normal", "tangential")]
    ends = ("", *(f"_{unit}" for unit in range(2, units + 1)))
    tyres = [f"{name}{end}" for end in ends for name in TYRE_SUMS] if steered else []
    return (*states, *SUMS, *(impulses if units > 1 else ()), *tyres)


@dataclass(frozen=True)
class ImpactMotion:
    """Whole impact, a result of `solve_impact`.

    Attributes
    ----------
    vehicle : ImpactVehicle
        The vehicle.
    contact : WallContact
        Laws of its contact.
    strikes : tuple of Strike
        In order of time.
    t_end : float
        End of the motion [s].
    end : ImpactState
        State at the end.
    step : float
        Time step [s].
    error : float
        Largest relative change of the first two peaks and impulses, and of the spin, against twice the step [-].
    interval : float
        Between rows [s].
    rows : ndarray, shape (rows, columns)
        All steps, or as many as memory allows [SI]; columns as of `column_names`.
    trailers : tuple of HitchedVehicle
        Trailers behind the vehicle.
    axles : tuple of TyreAxle
        Axles with tyres.
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
    axles: tuple[TyreAxle, ...] = ()
    loads: tuple[float, ...] = ()

    @property
    def vehicles(self) -> tuple[ImpactVehicle, ...]:
        """Vehicle and trailers."""
        return self.vehicle, *(trailer.vehicle for trailer in self.trailers)

    def at(self, times: ArrayLike) -> SimpleNamespace:
        """Return the motion at these instants.

        Parameters
        ----------
        times : array_like, of any shape
            From 0 to `t_end` [s].

        Returns
        -------
        SimpleNamespace
            Arrays of the shape of `times`, forces and energies summed over the points: `t` [s]; `x_g`, `y_g`, centre of
            mass [m]; `theta`, between the wall side and the wall [rad]; `omega` [rad/s], positive as the rear rotates
            towards the wall; `v_gx`, `v_gy` [m/s]; `force_normal`, `force_tangential`, of the wall on the vehicle along
            +Y and +X [N]; `impulse_normal`, `impulse_tangential`, their integrals [N s]; `impulse_angular`, the
            integral of their moment about X = Y = 0 [N m s]; `kinetic_energy` [J]; `crush_energy_stored`,
            `crush_energy_lost`, absorbed by the crush, which unloading would return and which it would not [J];
            `crush_work`, of the normal
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
        values = SimpleNamespace(t=t, **dict(zip(names, np.moveaxis(value, -1, 0), strict=True)))
        values.kinetic_energy = 0.0
        for unit, vehicle in enumerate(self.vehicles):
            u, v, w = np.moveaxis(value[..., 6 * unit + 3 : 6 * unit + 6], -1, 0)
            values.kinetic_energy += 0.5 * (vehicle.mass * (u**2 + v**2) + vehicle.inertia * w**2)
        return values

    def hinge_forces(self, times: Array) -> Array:
        """Return the mean forces of hinges between instants.

        They act on the vehicle ahead, and follow from the momentum of all units behind.

        Parameters
        ----------
        times : ndarray, shape (n,)
            From 0 to `t_end`, increasing [s].

        Returns
        -------
        ndarray
            Along X and Y [N], shape (hinges, 2, n - 1).
        """
        at, changes = self.at(np.minimum(times, self.t_end)), []
        for unit, trailer in enumerate(self.trailers, 2):
            momenta = (trailer.vehicle.mass * getattr(at, f"v_g{axis}_{unit}") for axis in "xy")
            pushes = [getattr(at, f"impulse_{force}_{unit}") for force in ("tangential", "normal")]
            if self.axles:
                steering = (getattr(at, f"tyre_impulse_{force}_{unit}") for force in ("tangential", "normal"))
                pushes = [wall + road for wall, road in zip(pushes, steering, strict=True)]
            changes.append([np.diff(wall - momentum) for momentum, wall in zip(momenta, pushes, strict=True)])
        increments = np.reshape(changes, (-1, 2, times.size - 1)) / np.diff(times)
        return np.cumsum(increments[::-1], axis=0)[::-1]

    def corner_depths(self, times: ArrayLike) -> Array:
        """Return depths of the corners behind the wall.

        Parameters
        ----------
        times : array_like, of any shape
            From 0 to `t_end` [s].

        Returns
        -------
        ndarray
            In the order of `CORNERS`, negative in front of the wall [m], shape (4, ...).
        """
        at, size = self.at(times), (self.vehicle.front_distance, self.vehicle.length, self.vehicle.width)
        places = vehicles.corner_places(*size).reshape(4, 2, *[1] * np.ndim(times))
        return vehicles.corner_depths(places, at.y_g, at.theta)


def _rates(units: int) -> list[tuple[str, str]]:
    """Return columns that are integrals, with their rates.

    Those of trailers are included.
    """
    ends = ("", *(f"_{unit}" for unit in range(2, units + 1)))
    integrals = [(f"{name}{end}", f"{rate}{end}") for end in ends for name, rate in RATES.items()]
    return integrals if units > 1 else [*integrals, *FORCES.items()]


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
    axles: Sequence[TyreAxle] = (),
) -> ImpactMotion:
    """Solve the whole impact of a rigid vehicle or train.

    Parameters
    ----------
    vehicle : ImpactVehicle
        The vehicle.
    contact : WallContact
        Laws of its contact with the wall.
    state : ImpactState
        At the start, outside the wall or touching it.
    end : float or None
        End of the motion [s]. None: `after_second` after the first two strikes, for a train after that of its last
        rear; without these when contact is no longer possible, `after_second` at the earliest; and not before the end
        of a strike in progress.
    after_second : float
        See `end` [s].
    longest : float
        Latest end without `end` [s], even within a strike.
    step : float or None
        Time step [s]; None: chosen by the tolerance.
    tolerance : float
        Of peaks, impulses and spin, by which the step is chosen [-].
    on_compile : callable
        Called when code is compiled, see `machine_code.compiled.compile_once`.
    trailers : sequence of HitchedVehicle
        Trailers behind the vehicle, in line with it at the start.
    axles : sequence of TyreAxle
        Axles whose tyres resist sliding across their unit.

    Returns
    -------
    ImpactMotion
        Motion at any instant.

    Raises
    ------
    RigidBodyError
        For a start inside the wall, for an end that is not positive, and where the steps become too short.
    """
    for value in (end, after_second, longest, step):
        if value is not None:
            positive(rules.END, value)
    units, contacts = [vehicle, *(t.vehicle for t in trailers)], [contact, *(t.contact for t in trailers)]
    train = train_of(units, contacts, [(trailer.hitch, trailer.kingpin) for trailer in trailers])
    start = vehicles.lined_up(astuple(state), vehicles.distances(vehicle, trailers))
    for index, (unit, placed) in enumerate(zip(units, start, strict=True)):
        places = vehicles.corner_places(unit.front_distance, unit.length, unit.width)
        for corner, value in enumerate(vehicles.corner_depths(places, placed[1], placed[2])):
            met, name = value <= 1e-9 * vehicle.length, corner_name(index, corner)
            Gate().demand(rules.INSIDE, met, value, name=name, depth=value)
    bodies = np.array([[unit.front_distance, unit.length] for unit in units]).T[..., None]
    tyres = tyres_of(train, [asdict(axle) for axle in axles], *bodies)
    trajectories = solve_trains(
        train, start[None], tyres=tyres, step=step, end=end, interval=0.0, after_second=after_second,
        longest=longest, tolerance=tolerance, strikes=MOST_STRIKES, on_compile=on_compile,
    )  # fmt: skip
    reached, last = float(trajectories.end[0]), ImpactState(*trajectories.state[0, 0].tolist())
    strikes = strikes_of_rows(trajectories.strikes[0], [unit.front_distance for unit in units], reached)
    if end is None:
        Gate().demand(rules.NEVER, bool(strikes), state.v_gy)
    written = math.ceil(reached / trajectories.interval[0] * (1.0 - 1e-12)) + 1  # no rows exist after the end
    rows = trajectories.rows[0, : max(written, 2)]
    return ImpactMotion(
        vehicle, contact, strikes, reached, last, float(trajectories.step[0]), float(trajectories.error[0]),
        float(trajectories.interval[0]), rows, tuple(trailers), tuple(axles),
        () if tyres is None else tuple(tyres.load[:, 0].tolist()),
    )  # fmt: skip


@dataclass(frozen=True)
class Impacts:
    """First strikes of many impacts.

    Attributes
    ----------
    corner : ndarray, shape (strikes, ...)
        Index of each strike into `CORNERS`, plus 4 for each unit ahead; -1 where there is no such strike [-].
    start, end : ndarray, shape (strikes, ...)
        [s]; NaN where there is no such strike.
    peak_force : ndarray, shape (strikes, ...)
        Of the normal force [N].
    impulse : ndarray, shape (strikes, ...)
        Of the normal force [N s].
    mean_force : ndarray, shape (rows, ...)
        Total normal force [N], means since the previous instant, the first from first touch on; undefined after the
        end, and without rows if there is no interval.
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
        Values that differ at the rear corners, by the names in `train.LAW`; floats or ndarrays.
    centre_of_mass : float, ndarray or None
        Behind the front [m]; None: L/2.
    yaw_inertia : float, ndarray or None
        [kg m^2]; None: m (L^2 + B^2)/12.
    after_second : float
        Time from the second strike to the end of each [s]; a strike then in progress is completed.
    longest : float
        Latest end [s].
    interval : float or None
        Time between the rows of the force history [s]; None: no history.
    step : float or None
        Time step of all [s]; None: chosen for each by the tolerance.
    tolerance : float
        Of peaks, impulses, durations and spin, by which the step of each is chosen [-].
    strikes : int or None
        Number of strikes in the result, extended to all if it is above two; None: two, of trains all.
    trailers : sequence of dict
        Of each trailer `length`, `width`, `mass`, `hitch` and `kingpin`, floats or ndarrays as of `HitchedVehicle`, and
        optionally `centre_of_mass`, `yaw_inertia`, keys of `train.LAW` and `rear`.
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
    laws = vehicles.unit_laws([first | law, *trailers])
    bodies = ({key: unit.get(key) for key in BODY} for unit in (first, *trailers))
    roads = [{key: axle[key] for key in AXLE} for axle in axles]
    tables: list[dict[str, Any]] = [
        {key: number(key, value) for key, value in table.items() if value is not None}
        for table in (shared, *bodies, *(law for both in laws for law in both), *roads)
    ]
    shape = np.broadcast_shapes(*(np.shape(value) for table in tables for value in table.values()))
    common, *flat = (
        {key: np.broadcast_to(quantity, shape).ravel() for key, quantity in table.items()} for table in tables
    )
    units, crush, tyres = flat[: len(laws)], flat[len(laws) : 3 * len(laws)], flat[3 * len(laws) :]
    for index, unit in enumerate(units):
        table = f"trailer.{index - 1}." if index else ""
        with _naming(table):
            _complete(unit)
            vehicles.demand_law(*(crush[2 * index][key] for key in vehicles.LAW))
        with _naming(f"{table or 'contact.'}rear."):
            vehicles.demand_law(*(crush[2 * index + 1][key] for key in vehicles.LAW))
    gate, theta = Gate(), common["angle"]
    gate.positive(rules.SPEED, common["speed"])
    gate.demand(rules.TOUCH_ANGLE, (theta > 0.0) & (theta < math.pi / 2.0), theta)
    gate.not_negative(rules.FRICTION, common["friction"])
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
    crush = {key: np.array([law[key] for pair in pairs for law in pair]) for key in vehicles.LAW}
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
