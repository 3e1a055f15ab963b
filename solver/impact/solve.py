"""Whole impacts of rigid vehicles on a wall that only pushes: one or a million, in steps of one length.

The step is taken from the stiffest contact, the turning and the tolerance; what it leaves of error is stated from a run
at twice the step, and where that is more than the tolerance, which doubles with it, the step is halved.

Strikes are found in the sampled forces.
"""

import math
from collections.abc import Mapping
from dataclasses import astuple, dataclass
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fem.machine_code.compiled import OnCompile, compile_once, ignore_compiling
from solver import rules
from solver.impact import train as vehicles
from solver.impact.step import SHORTEST, STRIKE, SUMS, UNIT, Timing, Train, advance, workspace
from solver.impact.train import CORNERS, ImpactState, ImpactVehicle, WallContact, train_of
from solver.rules import Array, Gate, Number, RigidBodyError, number


@dataclass(frozen=True)
class Strike:
    """One strike: a corner, or its half of each side, is pressed on, until it is off the wall for as long.

    Attributes
    ----------
    corner : str
        One of `CORNERS`.
    start, end : float
        [s]; `end` is that of the motion where the strike goes on.
    peak_force : float
        Greatest normal force [N].
    impulse : float
        Of the normal force [N s].
    impulse_tangential : float
        Of the friction on the vehicle along +X [N s].
    point_of_attack : float
        Distance behind the front, along the side, mean weighted with the normal force [m].
    position : float
        The same along the wall, X [m].
    energy_absorbed : float
        Net work of the normal forces on the crush [J].
    friction_work : float
        On the vehicle [J].
    """

    corner: str
    start: float
    end: float
    peak_force: float
    impulse: float
    impulse_tangential: float = math.nan
    point_of_attack: float = math.nan
    position: float = math.nan
    energy_absorbed: float = math.nan
    friction_work: float = math.nan

    @property
    def duration(self) -> float:
        """From start to end [s]."""
        return self.end - self.start

    @property
    def mean_force(self) -> float:
        """Impulse over duration [N]."""
        return self.impulse / self.duration


def is_over(start: Any, end: Any, now: Any) -> Any:
    """True if a strike that began at `start` and last pressed at `end` is over at `now`, all [s]: the corner has been
    off the wall for as long as its strike has lasted. Where it hops, as a plate does, hops are one strike; else a gap
    that a mesh opens or closes would tell how many there are."""
    return now - end >= np.maximum(SHORTEST, end - start)


def strikes_of(
    t: Array,
    force_by_corner: Mapping[str, Array],
    tangential_by_corner: Mapping[str, Array] | None = None,
    station_by_corner: Mapping[str, Array] | None = None,
    position_by_corner: Mapping[str, Array] | None = None,
) -> tuple[Strike, ...]:
    """Strikes from sampled forces, by the rule of the rigid impact.

    Every sample is the mean over an interval, the increment of the impulse over the time between two instants, so that
    impulses are exact. The start lies within the first interval with a force where a straight rise would put it that
    has the means of that interval and the next, and the end likewise; the peak is that of the parabola with the means
    of the highest sample and its neighbours.

    Parameters
    ----------
    t : ndarray, shape (n + 1,)
        Instants [s].
    force_by_corner : dict of ndarray, shape (n,)
        Mean normal forces of each corner [N].
    tangential_by_corner : dict of ndarray, shape (n,), or None
        The same along the wall, on the vehicle [N].
    station_by_corner, position_by_corner : dict of ndarray, shape (n,), or None
        Points of attack, behind the front and along the wall [m].

    Returns
    -------
    tuple of Strike
        In order of time; what was not given is NaN.
    """
    tangential, station = tangential_by_corner or {}, station_by_corner or {}
    found = []
    for corner, force in force_by_corner.items():
        beside = [values.get(corner) for values in (tangential, station, position_by_corner or {})]
        intervals = _pressed(np.asarray(t), np.asarray(force))
        found += [_sampled(corner, np.asarray(t), np.asarray(force), run, beside) for run in intervals]
    return tuple(sorted(found, key=lambda strike: strike.start))


def _pressed(t: Array, force: Array) -> list[tuple[int, int]]:
    """Runs of samples with a force, first and last + 1; those of one strike as one."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], force > 0.0, [0]]))).reshape(-1, 2)
    runs: list[tuple[int, int]] = []
    for first, last in edges:
        if runs and not is_over(t[runs[-1][0]], t[runs[-1][1]], t[first]):
            runs[-1] = (runs[-1][0], int(last))
        else:
            runs.append((int(first), int(last)))
    return runs


def _sampled(corner: str, t: Array, force: Array, run: tuple[int, int], beside: list[Array | None]) -> Strike:
    part = slice(*run)
    step = np.diff(t[run[0] : run[1] + 1])
    push = force[part] * step
    start = t[run[0] + 1] - _pressed_fraction(force[part]) * step[0]
    end = t[run[1] - 1] + _pressed_fraction(force[part][::-1]) * step[-1]
    tangential, station, position = (None if v is None else np.asarray(v)[part] for v in beside)
    along = math.nan if tangential is None else float(tangential @ step)
    means = [math.nan if v is None else float(v @ push) / float(push.sum()) for v in (station, position)]
    peak = _parabola_peak(t, force, run)
    return Strike(corner, float(start), float(end), peak, float(push.sum()), along, *means)


def _pressed_fraction(force: Array) -> float:
    """Fraction of the first interval that is under force: u^2/(2 u + 1) = F1/F2 for a straight rise."""
    if force.size < 2 or force[0] >= force[1] / 3.0:
        return 1.0
    ratio = float(force[0] / force[1])
    return ratio + math.sqrt(ratio * (ratio + 1.0))


def _parabola_peak(t: Array, force: Array, run: tuple[int, int]) -> float:
    """Peak of the parabola that has the three highest samples' means; the highest sample where there are not three."""
    k = run[0] + int(np.argmax(force[slice(*run)]))
    if k <= run[0] or k >= run[1] - 1:
        return float(force[k])
    edges = t[k - 1 : k + 3] - t[k]
    impulse = np.concatenate([[0.0], np.cumsum(force[k - 1 : k + 2] * np.diff(edges))])
    cubic = np.polyfit(edges, impulse, 3)  # of the impulse; its slope is the force
    if cubic[0] >= 0.0:
        return float(force[k])
    top = float(np.clip(-cubic[1] / (3.0 * cubic[0]), edges[0], edges[3]))
    return float(np.polyval(np.polyder(cubic), top))


TOLERANCE = 1e-5
"""Error of peaks, impulses and spin of one impact by which the step is chosen."""

MANY = 4e-3
"""Error by which the step of many impacts at once is chosen."""

PHASE, TURN = 0.7, 0.025
"""The step, over the tolerance's root: of the stiffest oscillation's radian, and of that times size over speed."""

REFUSED = 1e-3
"""Error, or ten times the tolerance, at which there is no answer."""

LONGEST_RUN, STEP_COST, POINT_COST = 4.0, 3e-7, 2e-8
"""Seconds that an impact may take at most, and about what a step and a point of it cost."""

MOST_ROWS = 1_000_000
MOST_STRIKES = 64
"""Strikes of one impact for which there is room at first."""


class Trajectories(NamedTuple):
    """Motions of n trains.

    Attributes
    ----------
    end : ndarray, shape (n,)
        How far each was followed [s].
    state : ndarray, shape (n, units, 6)
        There, in the order of `step.UNIT`.
    strikes : ndarray, shape (n, strikes, columns)
        In the order of their starts, columns as of `step.STRIKE`; NaN where there is none.
    rows : ndarray, shape (n, rows, columns)
        Columns as of `step.UNIT` of each unit and `step.SUMS`; undefined behind the end.
    interval : ndarray, shape (n,)
        Between rows [s].
    step : ndarray, shape (n,)
        [s].
    error : ndarray, shape (n,)
        Largest relative change of the first two peaks and impulses, and of the spin at the end, against twice the step.
    """

    end: Array
    state: Array
    strikes: Array
    rows: Array
    interval: Array
    step: Array
    error: Array


def solve_trains(
    train: Train,
    state: Array,
    *,
    step: float | None = None,
    end: float | None = None,
    interval: float | None = None,
    after_second: float = 0.1,
    longest: float = 5.0,
    tolerance: float = TOLERANCE,
    strikes: int = 2,
    on_compile: OnCompile = ignore_compiling,
) -> Trajectories:
    """Whole impacts of rigid trains.

    Parameters
    ----------
    train : Train
        n samples.
    state : ndarray, shape (n, units, 6)
        At the start, in the order of `step.UNIT` [m, rad, m/s, rad/s]; hinges closed.
    step : float or None
        [s]; None: chosen by the tolerance.
    end : float or None
        How far to follow the motion [s]; None: `after_second` after the first two strikes, and without a second until
        nothing can touch any more, but for `after_second` at least.
    interval : float or None
        Between rows [s]; 0: every step, or what `MOST_ROWS` allow; None: no rows.
    after_second, longest : float
        [s]; with end None: how far at most.
    tolerance : float
        Of peaks, impulses and spin, by which the step is chosen [-].
    strikes : int
        For how many there is room.
    on_compile : callable
        Called when code is compiled, see `fem.machine_code.compiled.compile_once`.

    Returns
    -------
    Trajectories
        With their errors.

    Raises
    ------
    RigidBodyError
        Where the steps become too short, or what they leave of error too large.
    """
    most = int(LONGEST_RUN / (STEP_COST + POINT_COST * train.unit.size))
    latest = longest if end is None else end
    rate, turning = _rates(train, state)
    h = PHASE * math.sqrt(tolerance) / np.maximum(rate, turning / TURN)
    if step is not None:
        h = np.full(len(state), step)
    h = np.maximum(h, latest / most)  # coarser, and finer then, as far as the end that is found allows
    whole = interval or latest
    h = whole / np.ceil(whole / h)

    def run(chosen: NDArray[np.int64], h: Array, interval: float | None) -> Trajectories:
        few = Train(*(v if v.ndim == 1 else np.ascontiguousarray(v[..., chosen]) for v in train))
        return _run(few, state[chosen], h, end, interval, after_second, longest, most, strikes, on_compile)

    chosen = np.arange(len(state))
    found = run(chosen, h, interval)
    error = _difference(found, run(chosen, 2.0 * h, None), turning)
    while step is None:
        rough = ~(error <= tolerance * h / found.step)
        chosen = np.flatnonzero(rough & (2.0 * found.end <= most * found.step))
        if not chosen.size:
            break
        finer = run(chosen, 0.5 * found.step[chosen], interval)
        coarse = Trajectories(*(value[chosen] for value in found))
        error[chosen] = _difference(finer, coarse, turning[chosen])
        if len(chosen) == len(found.end):
            found = finer
            continue
        for old, new in zip(found, finer, strict=True):
            old[chosen] = new
    bad = ~(error <= max(REFUSED, 10.0 * tolerance))
    if bad.any() and step is None:
        i = int(np.argmax(bad))
        place = f" at index {i}" if len(bad) > 1 else ""
        why = f"steps of {found.step[i]:.2g} s leave an error of {error[i]:.2g}{place}"
        raise RigidBodyError("contact", "this law", why, "a smaller stiffness or friction")
    return found._replace(error=error)


def _rates(train: Train, state: Array) -> tuple[Array, Array]:
    """The stiffest oscillation on loading, and speed over size [1/s], shape (n,)."""
    reach2, stiffness = np.zeros_like(train.mass), np.zeros_like(train.mass)
    np.maximum.at(reach2, train.unit, train.along**2 + train.across**2)
    np.add.at(stiffness, train.unit, 0.5 * train.stiffness)  # two corners and one side at once
    rate = np.sqrt((stiffness * (1.0 / train.mass + reach2 / train.inertia)).max(axis=0))
    velocity = np.moveaxis(state[..., 3:], -1, 0).swapaxes(1, 2)
    turning = np.hypot(velocity[0], velocity[1]) / np.sqrt(reach2) + np.abs(velocity[2])
    return rate, np.maximum(turning.max(axis=0), 1e-300)


def _run(
    train: Train, state: Array, h: Array, end: float | None, interval: float | None,
    after: float, longest: float, most: int, strikes: int, on_compile: OnCompile,
) -> Trajectories:  # fmt: skip
    n, units = state.shape[:2]
    latest = longest if end is None else end
    stride, count = np.ones(n, dtype=np.int64), 0
    if interval is not None:
        stride[:] = np.maximum(np.rint(interval / h), np.ceil(latest / h / MOST_ROWS))
        count = math.ceil(min(float((latest / h / stride).max()), most)) + 2
    rows, found = np.empty((n, count, 6 * units + len(SUMS))), np.full((n, strikes, len(STRIKE)), np.nan)
    ends, out = np.full(n, math.inf if end is None else end), np.array(state)
    longest = latest if end is not None else longest
    clock = Timing(h, stride, ends, after, longest, most, np.full(n, np.nan), np.zeros(n, dtype=np.int64))
    given = train, out, clock, workspace(units, len(train.hitch), train.unit.size), rows, found
    compile_once(lambda: advance(*given), advance, *given, on_compile=on_compile)
    if clock.counted.max() > strikes > 2:
        room = int(clock.counted.max())
        return _run(train, state, h, end, interval, after, longest, most, room, on_compile)
    return Trajectories(clock.reached, out, found, rows, h * stride, h, np.zeros(n))


def _difference(fine: Trajectories, coarse: Trajectories, turning: Array) -> Array:
    """Largest change, of spin against its own and a tenth of speed over size; infinite where strikes differ, or
    anything is not finite."""
    one, two = fine.strikes[:, :2], coarse.strikes[:, :2]
    same = (one[..., 0] == two[..., 0]) | (np.isnan(one[..., 0]) & np.isnan(two[..., 0]))
    spin, other = fine.state[..., 5], coarse.state[..., 5]
    with np.errstate(invalid="ignore", divide="ignore"):
        changes = np.nan_to_num(np.abs(two[..., 3:5] / one[..., 3:5] - 1.0), nan=0.0).max(axis=(1, 2))
        spins = (np.abs(other - spin) / (np.abs(spin) + 0.1 * turning[:, None])).max(axis=1)
    known = np.isfinite(fine.state).all(axis=(1, 2)) & np.isfinite(fine.end + coarse.end)
    return np.where(known & same.all(axis=1), np.maximum(changes, spins), math.inf)


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


def strikes_of_rows(rows: Array, front: float, end: float) -> tuple[Strike, ...]:
    """Rows of `step.STRIKE` as strikes of a vehicle whose centre of mass is so far behind its front [m]."""
    found, known = [], (rows[:, 4] > 0.0) & (rows[:, 1] < end)
    for group, start, last, peak, impulse, along, station, place, crush, friction in rows[known]:
        means = round(front - station / impulse, 12), place / impulse
        values = start, min(last, end), peak, impulse, along, *means, crush, friction
        found.append(Strike(CORNERS[int(group) % 4], *map(float, values)))
    return tuple(sorted(found, key=lambda strike: strike.start))


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
    given = {
        "length": length, "width": width, "mass": mass, "speed": speed, "angle": angle, "stiffness": stiffness,
        "restitution": restitution, "friction": friction, "initial_force": initial_force,
    }  # fmt: skip
    shape, v = _gathered(given, centre_of_mass, yaw_inertia)
    places = vehicles.corner_places(v["centre"], v["length"], v["width"])
    stiffness, force, e, mu = (
        np.tile(v[name], (4, 1)) for name in ("stiffness", "initial_force", "restitution", "friction")
    )
    n = v["mass"].size
    train = Train(
        v["mass"][None], v["inertia"][None], np.zeros((0, n)), np.zeros((0, n)), np.zeros(4, dtype=np.int64),
        np.arange(4), places[:, 0], places[:, 1], stiffness, force, e, mu, np.zeros((1, 3, n)),
    )  # fmt: skip
    start = vehicles.touching(v["centre"], v["width"], v["angle"], v["speed"])
    found = solve_trains(
        train, np.stack(start, axis=-1)[:, None], interval=interval, after_second=after_second,
        longest=longest, tolerance=tolerance,
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


def _gathered(
    given: dict[str, Number], centre: Number | None, inertia: Number | None
) -> tuple[tuple[int, ...], dict[str, Array]]:
    """The common shape of the arguments, and flat arrays of them that have passed the rules."""
    values = {key: number(key, value) for key, value in given.items()}
    size = values["length"], values["width"], values["mass"]
    values["centre"] = 0.5 * size[0] if centre is None else number("centre_of_mass", centre)
    values["inertia"] = vehicles.uniform_inertia(*size) if inertia is None else number("yaw_inertia", inertia)
    arrays = np.broadcast_arrays(*values.values())
    v = {key: np.ravel(array).astype(float) for key, array in zip(values, arrays, strict=True)}
    size = v["length"], v["width"], v["mass"]
    vehicles.demand_body(*size, v["centre"], v["inertia"], inertia is not None)
    vehicles.demand_law(v["stiffness"], v["initial_force"], v["restitution"])
    gate = Gate()
    gate.positive(rules.SPEED, v["speed"])
    gate.demand(rules.TOUCH_ANGLE, (v["angle"] > 0.0) & (v["angle"] < math.pi / 2.0), v["angle"])
    gate.not_negative(rules.FRICTION, v["friction"])
    return arrays[0].shape, v
