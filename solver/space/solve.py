"""Motions in space of vehicles striking a wall."""

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from machine_code.compiled import OnCompile, compile_once, ignore_compiling
from solver import rules
from solver.conditions import Array, Gate, Number
from solver.space import state
from solver.space.state import Clock, Fleet, SpaceWork, row_columns, workspace
from solver.space.step import advance
from solver.space.vehicle import SpaceVehicle, SpaceWall, fleet_of

OUTCOMES = ("upright", "on its side", "over the wall")
"""Outcomes by their number in compiled code."""

WINDOW, LONGEST = 0.05, 4.0
"""Duration of the mean of the design force, and latest end of a motion [s]."""

INTERVAL, MANY_INTERVAL = 1e-3, 2e-3
"""Time between rows of one motion, and of many and in the search for a wall [s]."""

PHASE, MANY_PHASE = 0.2, 0.4
"""Step times the rate of the fastest oscillation on the first attempt at one motion, and of many [rad]."""

TOLERANCE, HALVINGS, MOST_PARTS = 1e-3, 6, 4096
"""Largest error of one motion, number of halvings of its step, and most steps of an interval."""

COMPARED = {"largest_roll": 0.05, "mean_50ms": 1e3, "height": 0.05}
"""Quantities by which the error is judged, with the sizes below which their change is not relative [rad, N, m]."""

SAFETY, FORMER, UNRESOLVED, LEAST_ERROR = 2.0, 0.25, 0.1, 2e-4
"""Error over the last change by half the step; the part of the change before it that counts, as in a scheme of second
order; the change from which a step does not resolve the motion and does not count; least error of a chosen step. A
single change may be small by chance."""

NO_PUSH = np.zeros((0, 5))
"""No force besides that of the wall."""

SCAN = 0.04
"""Step of the search for the lowest wall before the bisection [m]."""


class SpaceAnswers(NamedTuple):
    """Answers of n motions, shape (n,) each.

    Attributes
    ----------
    outcome : ndarray
        Index into `OUTCOMES`.
    largest_roll, roll_time, largest_pitch, pitch_time : ndarray
        With the sign that they have then, roll positive towards the wall and pitch nose down [rad], and instants [s].
    mean_50ms, mean_time, longitudinal, vertical : ndarray
        Largest 50 ms mean of the lateral force, its end [s], and the other components of the force on the vehicle then
        [N].
    height, length : ndarray
        Height of the resultant then, and length of the uniform force with the same standard deviation along the wall
        [m].
    raw : ndarray
        Largest mean of a row [N].
    exit_speed, exit_direction, exit_yaw : ndarray
        Speed of the first unit at the last contact [m/s], its direction and the heading away from the wall [rad].
    end, last_contact : ndarray
        End and last contact [s].
    rows : ndarray
        Number of rows up to the end.
    unit_rolls : ndarray, shape (n, units)
        Largest roll of each unit [rad].
    """

    outcome: NDArray[np.int64]
    largest_roll: Array
    roll_time: Array
    largest_pitch: Array
    pitch_time: Array
    mean_50ms: Array
    mean_time: Array
    longitudinal: Array
    vertical: Array
    height: Array
    length: Array
    raw: Array
    exit_speed: Array
    exit_direction: Array
    exit_yaw: Array
    end: Array
    last_contact: Array
    rows: NDArray[np.int64]
    unit_rolls: Array


@dataclass(frozen=True)
class SpaceMotion:
    """One motion in space.

    Attributes
    ----------
    outcome : str
        One of `OUTCOMES`.
    answers : SpaceAnswers
        Answers of this motion, floats in place of arrays.
    history : dict of ndarray, shape (rows,)
        Columns by name: t and the columns of `state` [SI]; those of later units end with "_2" and so on, those of axles
        with the number of the axle from 1.
    step : float
        Time step [s].
    error : float
        Twice the last change of `COMPARED` by half the step or a quarter of the change before it, whichever is larger,
        and at least `LEAST_ERROR`; with a prescribed step twice the change against twice that; infinite where the
        outcome changes [-].
    """

    outcome: str
    answers: SpaceAnswers
    history: dict[str, Array]
    step: float
    error: float


def column_names(units: int, axles: int) -> tuple[str, ...]:
    """Return the column names of a row."""
    ends = ("", *(f"_{unit}" for unit in range(2, units + 1)))
    poses = [f"{name}{end}" for end in ends for name in state.POSE]
    wheels = [f"{name}_{axle}" for axle in range(1, axles + 1) for name in state.WHEELS]
    return (*state.FORCES, *state.WORKS, *state.ENERGIES, *poses, *wheels)


def solve_space(
    vehicle: SpaceVehicle,
    wall: SpaceWall,
    speed: float,
    angle: float,
    *,
    interval: float = INTERVAL,
    step: float | None = None,
    end: float | None = None,
    push: Array = NO_PUSH,
    tolerance: float = TOLERANCE,
    on_compile: OnCompile = ignore_compiling,
) -> SpaceMotion:
    """Solve one motion in space with its history.

    Parameters
    ----------
    vehicle, wall : SpaceVehicle, SpaceWall
        With floats.
    speed, angle : float
        Speed [m/s] and angle [rad] before the impact.
    interval : float
        Time between rows [s].
    step : float or None
        Largest step [s]; None: chosen, and halved while the error exceeds the tolerance.
    end : float or None
        End of the motion [s]; None: when the vehicle no longer leans on the wall or rolls.
    push : ndarray, shape (rows, 5)
        Force on the first unit in each interval: along, across and up [N], its place ahead of the centre of mass along
        the wall and its height [m], NaN for that of the centre.
    tolerance : float
        Tolerance by which the step is chosen [-].
    on_compile : callable
        Called when code is compiled, see `machine_code.compiled.compile_once`.

    Returns
    -------
    SpaceMotion
        Motion with its error.

    Raises
    ------
    RigidBodyError
        For impossible values, where no strip reaches the face of the wall, and where the steps become too short.
    """
    fleet = fleet_of(vehicle, wall, speed, angle)
    parts = _parts(fleet, interval, PHASE, step)

    def run(parts: NDArray[np.int64]) -> tuple[SpaceAnswers, Array]:
        return _run(fleet, interval, parts, end, push, on_compile, with_rows=True)

    coarse, last_change = (run(parts // 2)[0] if parts[0] > 1 else None), math.inf
    for _ in range(1 if step else HALVINGS + 1):
        answers, rows = run(parts)
        change = math.inf if coarse is None else _change(coarse, answers)
        error = SAFETY * max(change, FORMER * last_change if last_change < UNRESOLVED else 0.0)
        error = error if step else max(error, LEAST_ERROR)
        if error <= tolerance:
            break
        coarse, last_change, parts = answers, change, 2 * parts
    one = SpaceAnswers(*(values[0] for values in answers))
    Gate().demand(rules.NO_CONTACT, bool(one.rows), float(fleet.height[0]))
    table = rows[: int(one.rows)]
    names = column_names(fleet.units.shape[1], fleet.axles.shape[1])
    history = {"t": interval * np.arange(len(table)), **dict(zip(names, table.T, strict=True))}
    return SpaceMotion(OUTCOMES[int(one.outcome)], one, history, interval / int(parts[0]), error)


def solve_spaces(
    vehicle: SpaceVehicle, wall: SpaceWall, speed: Number, angle: Number, *, refine: int = 1
) -> SpaceAnswers:
    """Solve motions in space of n vehicles.

    Parameters
    ----------
    vehicle : SpaceVehicle
        Its values are floats or of shape (n,), as those of the next.
    wall : SpaceWall
        Wall that it strikes.
    speed, angle : float or ndarray
        Speed [m/s] and angle [rad] before the impact.
    refine : int
        Steps in place of each chosen one.

    Returns
    -------
    SpaceAnswers
        Answers of each motion.

    Raises
    ------
    RigidBodyError
        For impossible values, and where the steps become too short.
    """
    fleet = fleet_of(vehicle, wall, speed, angle)
    parts = refine * _parts(fleet, MANY_INTERVAL, MANY_PHASE, None)
    return _run(fleet, MANY_INTERVAL, parts, None, NO_PUSH, ignore_compiling, with_rows=False)[0]


def lowest_walls(
    vehicle: SpaceVehicle,
    wall: SpaceWall,
    speed: Number,
    angle: Number,
    *,
    scan: float = SCAN,
    on_compile: OnCompile = ignore_compiling,
) -> Array:
    """Return the lowest walls above which n vehicles remain upright [m].

    Walls from there up to the height of the highest centre of mass are tried in steps of `scan`.

    Parameters
    ----------
    vehicle : SpaceVehicle
        Its values are floats or of shape (n,), as those of the next.
    wall : SpaceWall
        Its height is not used.
    speed, angle : float or ndarray
        Speed [m/s] and angle [rad] before the impact.
    scan : float
        Step of the search before the bisection to 1 mm [m].
    on_compile : callable
        See `solve_space`.

    Returns
    -------
    ndarray, shape (n,)
        NaN where a wall as high as the highest centre of mass does not suffice; 0.1 where any wall does.

    Raises
    ------
    RigidBodyError
        As `solve_spaces`.
    """
    fleet = fleet_of(vehicle, wall, speed, angle)
    clock = _clock(MANY_INTERVAL, _parts(fleet, MANY_INTERVAL, MANY_PHASE, None), None, NO_PUSH)
    lowest, none = np.empty(len(fleet.units)), np.empty((0, 0))
    arguments = fleet, clock, _workspace(fleet, clock), np.empty((0, 0, 0)), none, none, scan, lowest
    compile_once(lambda: advance(*arguments), advance, *arguments, on_compile=on_compile)
    return lowest


def _clock(interval: float, parts: NDArray[np.int64], end: float | None, push: Array) -> Clock:
    """Return the steps of a run."""
    window = max(1, round(WINDOW / interval))
    return Clock(
        interval, parts, window, end or LONGEST, end is not None, np.ascontiguousarray(push, dtype=float)
    )


def _workspace(fleet: Fleet, clock: Clock) -> SpaceWork:
    """Return the workspace for one sample of a fleet."""
    points, rows = int(fleet.strip_points.sum()), math.ceil(clock.longest / clock.interval) + 2
    return workspace(fleet.units.shape[1], fleet.axles.shape[1], points, len(fleet.profile), rows)


def _run(
    fleet: Fleet,
    interval: float,
    parts: NDArray[np.int64],
    end: float | None,
    push: Array,
    on_compile: OnCompile,
    with_rows: bool,
) -> tuple[SpaceAnswers, Array]:
    """Return the answers of all samples, and the rows of the first."""
    clock, (n, units) = _clock(interval, parts, end, push), fleet.units.shape[:2]
    work = _workspace(fleet, clock)
    rows = np.zeros((1, len(work.windows) if with_rows else 0, row_columns(units, fleet.axles.shape[1])))
    answers, rolls = np.zeros((n, state.ANSWERS)), np.zeros((n, units))
    arguments = fleet, clock, work, rows, answers, rolls, 0.0, np.empty(0)
    compile_once(lambda: advance(*arguments), advance, *arguments, on_compile=on_compile)
    Gate().demand(rules.SPACE_LOST, answers[:, state.OUTCOME] != state.LOST, _fastest(fleet))
    columns: dict[str, Any] = dict(zip(SpaceAnswers._fields[:-1], answers.T, strict=True))
    columns |= {name: columns[name].astype(np.int64) for name in ("outcome", "rows")}
    return SpaceAnswers(**columns, unit_rolls=rolls), rows[0]


def _change(coarse: SpaceAnswers, fine: SpaceAnswers) -> float:
    """Return the largest relative change of the compared quantities.

    It is infinite where the outcome changes.
    """
    if coarse.outcome[0] != fine.outcome[0]:
        return math.inf
    changes = []
    for name, least in COMPARED.items():
        before, after = (float(getattr(answers, name)[0]) for answers in (coarse, fine))
        changes.append(abs(after - before) / max(abs(after), least))
    return max(changes)


def _parts(fleet: Fleet, interval: float, phase: float, step: float | None) -> NDArray[np.int64]:
    """Return the steps of an interval by the fastest oscillation.

    Returns shape (n,). Raises RigidBodyError for too many.
    """
    rate = _fastest(fleet)
    parts = np.ceil(
        interval * rate / phase if step is None else np.full_like(rate, interval / step) * (1.0 - 1e-12)
    )
    is_possible = parts <= MOST_PARTS
    Gate().demand(rules.SPACE_STEPS, is_possible, rate)
    return np.maximum(parts, 1.0).astype(np.int64)


def _fastest(fleet: Fleet) -> Array:
    """Estimate the highest frequencies [rad/s], shape (n,)."""
    axles, strips, units = (np.moveaxis(values, -1, 0) for values in (fleet.axles, fleet.strips, fleet.units))
    mass, inertia = axles[state.AXLE_MASS], axles[state.AXLE_INERTIA]
    vertical = 2.0 * (axles[state.TYRE] + axles[state.SPRING])
    turning = 2.0 * (
        axles[state.TYRE] * axles[state.HALF_TRACK] ** 2
        + axles[state.SPRING] * axles[state.HALF_SPACING] ** 2
    )
    crush = strips[state.STIFFNESS] * strips[state.LENGTH]
    sizes = np.diff(fleet.profile, axis=0)
    upward = float(np.max(sizes[:, 0] ** 2 / (sizes**2).sum(axis=1)))
    for strip, axle in enumerate(fleet.strip_axle):
        if axle >= 0:
            vertical[:, axle] += upward * crush[:, strip]
    squares = [np.max(vertical / mass, axis=-1), np.max(turning / inertia, axis=-1)]
    squares.append(np.max(4.0 * crush / units[state.MASS][:, fleet.strip_unit], axis=-1))
    squares.append(
        np.max(units[state.TWIST] / units[state.I_X], axis=-1) if units.shape[-1] > 1 else squares[0]
    )
    result: Array = np.sqrt(np.max(squares, axis=0))
    return result
