"""Whole impacts of rigid vehicles on a wall that only pushes: one with its motion, or many with their strikes."""

import math
from dataclasses import astuple, dataclass
from types import SimpleNamespace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fem.machine_code.compiled import OnCompile, ignore_compiling
from solver import rules
from solver.impact import train as vehicles
from solver.impact.step import SUMS, UNIT
from solver.impact.strikes import Strike, strikes_of_rows
from solver.impact.train import CORNERS, ImpactState, ImpactVehicle, Train, WallContact, train_of
from solver.impact.trajectories import TOLERANCE, Trajectories, solve_trains
from solver.rules import Array, Gate, Number, number

MANY = 4e-3
"""Error by which the step of many impacts at once is chosen."""

MOST_STRIKES = 64
"""Strikes of one impact for which there is room at first."""

COLUMNS = (*UNIT, *SUMS)
RATES = {"x_g": "v_gx", "y_g": "v_gy"}
RATES |= {f"impulse_{name}": f"force_{name}" for name in ("normal", "tangential")}
"""Columns of rows and, of those that are integrals of another, of which."""


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
        Every step, or as many as there is room for [SI]; columns as of `COLUMNS`.
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
            forces on the crush, stored and lost together [J]; `friction_work`, on the vehicle, 0 or less [J].

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
        for name, rate in RATES.items():  # by the cubic with both rates
            i, j = COLUMNS.index(name), COLUMNS.index(rate)
            one, two, u = before[..., j], after[..., j], s[..., 0]
            secant = after[..., i] - before[..., i]
            one, two = one * self.interval - secant, two * self.interval - secant
            value[..., i] += u * (1.0 - u) * ((1.0 - u) * one - u * two)
        found = SimpleNamespace(t=t, **dict(zip(COLUMNS, np.moveaxis(value, -1, 0), strict=True)))
        moving = self.vehicle.mass * (found.v_gx**2 + found.v_gy**2)
        found.kinetic_energy = 0.5 * (moving + self.vehicle.inertia * found.omega**2)
        return found

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
        at = self.at(times)
        return corner_depths(train_of([self.vehicle], self.contact), at.y_g, at.theta)


def corner_depths(train: Train, y_g: Array, theta: Array) -> Array:
    """Depths of the corners of the first unit of the first train behind the wall [m], shape (4, ...)."""
    along, across = (value[:4, 0].reshape(4, *[1] * np.ndim(theta)) for value in (train.along, train.across))
    return -(y_g + across * np.cos(theta) - along * np.sin(theta))


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
) -> ImpactMotion:
    """The whole impact of a rigid vehicle, any number of strikes.

    Parameters
    ----------
    vehicle : ImpactVehicle
        The vehicle.
    contact : WallContact
        Laws of its contact with the wall.
    state : ImpactState
        At the start, outside the wall or touching it.
    end : float or None
        How far to follow the motion [s]; None: `after_second` after the first two strikes, and without a second until
        nothing can touch any more, but for `after_second` at least.
    after_second : float
        [s].
    longest : float
        With end None: how far at most [s].
    step : float or None
        [s]; None: chosen by the tolerance.
    tolerance : float
        Of peaks, impulses and spin, by which the step is chosen [-].
    on_compile : callable
        Called when code is compiled, see `fem.machine_code.compiled.compile_once`.

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
            rules.positive(rules.END, value)
    train, start = train_of([vehicle], contact), np.array(astuple(state))
    depth = corner_depths(train, np.array(state.y_g), np.array(state.theta))
    for name, value in zip(CORNERS, depth, strict=True):
        Gate().demand(rules.INSIDE, value <= 1e-9 * vehicle.length, value, name=name, depth=value)
    found = solve_trains(
        train, start.reshape(1, 1, 6), step=step, end=end, interval=0.0, after_second=after_second,
        longest=longest, tolerance=tolerance, strikes=MOST_STRIKES, on_compile=on_compile,
    )  # fmt: skip
    reached, last = float(found.end[0]), ImpactState(*found.state[0, 0].tolist())
    strikes = strikes_of_rows(found.strikes[0], vehicle.front_distance, reached)
    if end is None:
        Gate().demand(rules.NEVER, bool(strikes), state.v_gy)
    written = math.ceil(reached / found.interval[0] * (1.0 - 1e-12)) + 1  # no row behind the end is
    rows = found.rows[0, : max(written, 2)]
    return ImpactMotion(
        vehicle, contact, strikes, reached, last, float(found.step[0]), float(found.error[0]),
        float(found.interval[0]), rows,
    )  # fmt: skip


@dataclass(frozen=True)
class Impacts:
    """The first two strikes of many impacts.

    Attributes
    ----------
    corner : ndarray, shape (2, ...)
        Of each strike, index into `CORNERS`; -1 where there is no such strike [-].
    start, duration : ndarray, shape (2, ...)
        [s]; NaN where there is no such strike.
    peak_force : ndarray, shape (2, ...)
        Of the normal force [N].
    impulse : ndarray, shape (2, ...)
        Of the normal force [N s].
    mean_force : ndarray, shape (rows, ...)
        Total normal force [N], each row the mean since the even instant before, the first from first touch on; none
        behind the end, and no rows where no interval was asked for.
    error : ndarray, shape (...)
        Largest relative change of peaks, impulses and spin against twice the step [-].
    """

    corner: NDArray[np.int64]
    start: Array
    duration: Array
    peak_force: Array
    impulse: Array
    mean_force: Array
    error: Array


def solve_impacts(
    *,
    length: Number,
    width: Number,
    mass: Number,
    speed: Number,
    angle: Number,
    stiffness: Number,
    restitution: Number,
    friction: Number,
    initial_force: Number = 0.0,
    centre_of_mass: Number | None = None,
    yaw_inertia: Number | None = None,
    after_second: float = 0.1,
    longest: float = 5.0,
    interval: float | None = None,
    tolerance: float = MANY,
) -> Impacts:
    """Whole impacts of rigid vehicles whose corners alone touch; arguments broadcast.

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
        e [-].
    friction : float or ndarray
        mu [-].
    initial_force : float or ndarray
        F0 [N].
    centre_of_mass : float, ndarray or None
        Behind the front [m]; None: L/2.
    yaw_inertia : float, ndarray or None
        [kg m^2]; None: m (L^2 + B^2)/12.
    after_second : float
        Each ends so long after its second strike [s].
    longest : float
        And after this at the latest [s].
    interval : float or None
        Between the rows of the force history [s]; None: there is none.
    tolerance : float
        Of peaks, impulses and spin, by which the step of each is chosen [-].

    Returns
    -------
    Impacts
        Arrays of the common shape.

    Raises
    ------
    RigidBodyError
        As `solve_impact`, for the first row that has no answer.
    """
    size = number("length", length), number("width", width), number("mass", mass)
    centre = 0.5 * size[0] if centre_of_mass is None else number("centre_of_mass", centre_of_mass)
    inertia = vehicles.uniform_inertia(*size) if yaw_inertia is None else number("yaw_inertia", yaw_inertia)
    forces = number("stiffness", stiffness), number("initial_force", initial_force)
    ratios = number("restitution", restitution), number("friction", friction)
    motion = number("speed", speed), number("angle", angle)
    arrays = np.broadcast_arrays(*size, centre, inertia, *forces, *ratios, *motion)
    shape, flat = arrays[0].shape, (np.ravel(array).astype(float) for array in arrays)
    long, wide, m, a, i, k, force, e, mu, v, theta = flat
    vehicles.demand_body(long, wide, m, a, i, yaw_inertia is not None)
    vehicles.demand_law(k, force, e)
    gate = Gate()
    gate.positive(rules.SPEED, v)
    gate.demand(rules.TOUCH_ANGLE, (theta > 0.0) & (theta < math.pi / 2.0), theta)
    gate.not_negative(rules.FRICTION, mu)
    places, none = vehicles.corner_places(a, long, wide), np.zeros((0, m.size))
    k, force, e, mu = (np.tile(each, (4, 1)) for each in (k, force, e, mu))
    train = Train(
        m[None], i[None], none, none, np.zeros(4, dtype=np.int64), np.arange(4), places[:, 0], places[:, 1],
        k, force, e, mu, np.zeros((1, 3, m.size)),
    )  # fmt: skip
    found = solve_trains(
        train, np.stack(vehicles.touching(a, wide, theta, v), axis=-1)[:, None], interval=interval,
        after_second=after_second, longest=longest, tolerance=tolerance,
    )  # fmt: skip
    corner, first, last, peak, impulse = (
        value.T.reshape(2, *shape) for value in np.moveaxis(found.strikes, -1, 0)[:5]
    )
    corners = np.nan_to_num(corner, nan=-1.0).astype(np.int64)
    force = _mean_forces(found, interval).reshape(-1, *shape)
    return Impacts(corners, first, last - first, peak, impulse, force, found.error.reshape(shape))


def _mean_forces(found: Trajectories, interval: float | None) -> Array:
    """Mean forces between rows, shape (rows, n): none behind the end of each."""
    if interval is None:
        return np.zeros((0, len(found.end)))
    count = math.ceil(float(found.end.max()) / interval)
    column, instants = COLUMNS.index("impulse_normal"), interval * np.arange(count + 1)
    impulse = found.rows[:, : count + 1, column]
    over = instants >= found.end[:, None] + (1.0 - 1e-9) * interval  # rows that were never written
    last = np.where(over, -math.inf, impulse)
    return np.diff(np.maximum.accumulate(last, axis=1), axis=1).T / interval
