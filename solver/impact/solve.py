"""Whole impact of a rigid vehicle or train on a wall."""

from collections.abc import Sequence
from dataclasses import asdict, astuple, dataclass
from types import SimpleNamespace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from machine_code.compiled import OnCompile, ignore_compiling
from solver import rules
from solver.conditions import Array, Gate, number, positive
from solver.impact import train as vehicles
from solver.impact.instants import interpolate, last_interval
from solver.impact.state import SUMS, UNIT
from solver.impact.strikes import Strike, strikes_of_rows
from solver.impact.strips import WallContact, awaited, group_names
from solver.impact.train import HitchedVehicle, ImpactState, ImpactVehicle, Train, train_of
from solver.impact.trajectories import TOLERANCE, solve_trains
from solver.impact.tyres import SUMS as TYRE_SUMS
from solver.impact.tyres import TyreAxle, Tyres, tyres_of

MOST_STRIKES = 64
"""Initial capacity for strikes of one impact."""

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
        Laws of its contact with the wall.
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
        Time between rows [s].
    rows : ndarray, shape (rows, columns)
        All steps, or as many as memory allows [SI]; columns as of `column_names`.
    trailers : tuple of HitchedVehicle
        Trailers behind the vehicle.
    axles : tuple of TyreAxle
        Axles with tyres.
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
        units, value = len(self.vehicles), np.empty((*t.shape, self.rows.shape[1]))
        names = column_names(units, bool(self.axles))
        columns = value.reshape(-1, value.shape[-1])
        joined = rate_columns(units, names)
        interpolate(self.rows, self.interval, self.t_end, *joined, t.ravel(), columns, t.size)
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
        motion, changes = self.at(np.minimum(times, self.t_end)), []
        for unit, trailer in enumerate(self.trailers, 2):
            momenta = (trailer.vehicle.mass * getattr(motion, f"v_g{axis}_{unit}") for axis in "xy")
            impulses = [getattr(motion, f"impulse_{force}_{unit}") for force in ("tangential", "normal")]
            if self.axles:
                names = (f"tyre_impulse_{force}_{unit}" for force in ("tangential", "normal"))
                impulses = [wall + getattr(motion, name) for wall, name in zip(impulses, names, strict=True)]
            pairs = zip(impulses, momenta, strict=True)
            changes.append([np.diff(impulse - momentum) for impulse, momentum in pairs])
        increments = np.reshape(changes, (-1, 2, times.size - 1)) / np.diff(times)
        return np.cumsum(increments[::-1], axis=0)[::-1]

    @property
    def lengths(self) -> tuple[float, ...]:
        """Lengths of the units [m]."""
        return tuple(vehicle.length for vehicle in self.vehicles)

    def contact_depths(self, times: ArrayLike) -> Array:
        """Return depths of the first unit's points behind the wall.

        Parameters
        ----------
        times : array_like, of any shape
            From 0 to `t_end` [s].

        Returns
        -------
        ndarray
            In the order of its groups, negative in front of the wall [m], shape (points, ...).
        """
        at, train = self.at(times), train_of(self.vehicles, self.contact)
        along, across = (
            values[train.unit == 0].reshape(-1, *[1] * np.ndim(times))
            for values in (train.along, train.across)
        )
        return vehicles.point_depths(along, across, at.y_g, at.theta)


def rate_columns(units: int, names: Sequence[str]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the places of columns that are integrals, and of their rates."""
    ends = ("", *(f"_{unit}" for unit in range(2, units + 1)))
    rates = {f"{name}{end}": f"{rate}{end}" for end in ends for name, rate in RATES.items()}
    rates |= {} if units > 1 else FORCES
    integrals, columns = np.array([[*map(names.index, pair)] for pair in rates.items()]).T.copy()
    return integrals, columns


def loads_at_rest(
    vehicle: ImpactVehicle,
    contact: WallContact,
    trailers: Sequence[HitchedVehicle] = (),
    axles: Sequence[TyreAxle] = (),
) -> tuple[float, ...]:
    """Return the load of each axle at rest [N].

    Arguments as of `solve_impact`. Raises RigidBodyError for axles that cannot carry their unit.
    """
    return tuple(_on_tyres(vehicle, contact, trailers, axles)[1].load[:, 0].tolist())


def _on_tyres(
    vehicle: ImpactVehicle,
    contact: WallContact,
    trailers: Sequence[HitchedVehicle] = (),
    axles: Sequence[TyreAxle] = (),
) -> tuple[Train, Tyres]:
    """Return the arrays of a train and of its tyres."""
    units = [vehicle, *(trailer.vehicle for trailer in trailers)]
    train = train_of(units, contact, [(trailer.hitch, trailer.kingpin) for trailer in trailers])
    bodies = np.array([[unit.front_distance, unit.length] for unit in units]).T[..., None]
    return train, tyres_of(train, [asdict(axle) for axle in axles], *bodies)


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
        Laws of contact with the wall, of its trailers too.
    state : ImpactState
        At the start, outside the wall or touching it.
    end : float or None
        End of the motion [s]. None: `after_second` after the first two strikes, of a train, or with more strips than
        two, after that of its last rear; without these when contact is no longer possible, `after_second` at the
        earliest; and not before the end of a strike in progress.
    after_second : float
        See `end` [s].
    longest : float
        Latest end without `end` [s], even within a strike.
    step : float or None
        Time step [s]; None: chosen by the tolerance.
    tolerance : float
        Tolerance of peaks, impulses and spin, by which the step is chosen; it doubles with each further halving, and
        the error says what is reached [-].
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
    units = vehicle, *(trailer.vehicle for trailer in trailers)
    train, tyres = _on_tyres(vehicle, contact, trailers, axles)
    names = group_names(contact, [unit.length for unit in units])
    start = vehicles.lined_up(astuple(state), vehicles.distances(vehicle, trailers))
    placed = start[train.unit]
    depths = vehicles.point_depths(train.along[:, 0], train.across[:, 0], placed[:, 1], placed[:, 2])
    for group, value in zip(train.group, depths.tolist(), strict=True):
        Gate().demand(rules.INSIDE, value <= 1e-9 * vehicle.length, value, name=names[group], depth=value)
    trajectories = solve_trains(
        train, start[None], tyres=tyres, step=step, end=end, interval=0.0, after_second=after_second,
        awaited=awaited(contact, [unit.length for unit in units]), longest=longest, tolerance=tolerance,
        strikes=MOST_STRIKES, on_compile=on_compile,
    )  # fmt: skip
    reached, last = float(trajectories.end[0]), ImpactState(*trajectories.state[0, 0].tolist())
    fronts = [units[train.unit[train.group == group][0]].front_distance for group in range(len(names))]
    strikes = strikes_of_rows(trajectories.strikes[0], names, fronts, reached)
    if end is None:
        Gate().demand(rules.NEVER, bool(strikes), state.v_gy)
    written = (
        last_interval.py_func(float(trajectories.interval[0]), reached) + 2
    )  # no rows exist after the end
    rows = trajectories.rows[0, :written]
    return ImpactMotion(
        vehicle, contact, strikes, reached, last, float(trajectories.step[0]), float(trajectories.error[0]),
        float(trajectories.interval[0]), rows, tuple(trailers), tuple(axles),
    )  # fmt: skip
