"""Motions in space of many vehicles striking a wall, and lowest walls."""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from machine_code.compiled import OnCompile, compile_once, ignore_compiling
from solver import rules
from solver.conditions import Array, Gate, Number
from solver.space import accuracy, columns, state
from solver.space.accuracy import MOST_CHOSEN, Choice, Motions
from solver.space.state import Clock, Fleet, SpaceWork, workspace
from solver.space.vehicle import SpaceVehicle, SpaceWall, fleet_of

OUTCOMES = ("upright", "on its side", "over the wall")
"""Outcomes by their number in compiled code."""

LONGEST = 4.0
"""Latest end of a motion [s]."""

INTERVAL, PHASE = 2e-3, 0.4
"""Time between rows of many motions [s], and step times the rate of the fastest oscillation [rad]."""

MOST_PARTS = 4096
"""Most prescribed steps of an interval."""

NO_PUSH, NOTHING = np.zeros((0, 5)), np.zeros((0, 2))
"""No force besides that of the wall; no answers."""

NO_CHOICE = Choice(1.0, False, 0.0)
"""Choice of no motion."""

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
    moment, moment_height, moment_length : ndarray
        Largest 50 ms mean of the moment of the lateral force about the foot of the wall [N m], with height and length
        of the force then [m].
    raw : ndarray
        Largest mean of a row [N].
    exit_speed, exit_direction, exit_yaw : ndarray
        Speed of the first unit at the last contact [m/s], its direction and the heading away from the wall [rad].
    end, last_contact : ndarray
        End and last contact [s].
    rows : ndarray
        Number of rows up to the end.
    inertial_50ms : ndarray
        Mass of the first unit times the largest 50 ms mean of its sensor's acceleration away from the wall [N].
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
    moment: Array
    moment_height: Array
    moment_length: Array
    raw: Array
    exit_speed: Array
    exit_direction: Array
    exit_yaw: Array
    end: Array
    last_contact: Array
    rows: NDArray[np.int64]
    inertial_50ms: Array
    unit_rolls: Array


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
    parts = refine * steps_of(fleet, INTERVAL, PHASE, None)
    answers, rolls = np.zeros((len(parts), state.ANSWERS)), np.zeros(fleet.units.shape[:2])
    call(fleet, clock_of(INTERVAL, parts, None, NO_PUSH), ignore_compiling, answers=answers, rolls=rolls)
    return answers_of(fleet, answers, rolls)


def highest_centres(fleet: Fleet) -> Array:
    """Return the height of the highest centre of mass [m], shape (n,)."""
    result: Array = (fleet.units[:, :, state.HEIGHT] + fleet.units[:, :, state.WHOLE_Z]).max(axis=1)
    return result


def searched_walls(fleet: Fleet, scan: float, refine: float, finer: float, on_compile: OnCompile) -> Array:
    """Return the lowest walls above which n vehicles remain upright [m].

    Walls from there up to the height of the highest centre of mass are tried in steps of `scan` before the bisection to
    1 mm [m]; refine, finer: steps in place of each chosen one, and points of a strip. Shape (n, 2): lowest walls, NaN
    where a wall by `scan` above that centre does not suffice, 0.1 where any does; and the highest tried wall on which
    the vehicle almost tips, although a lower one suffices, 0 without.
    """
    fleet = with_points(fleet, finer)
    parts = np.ceil(refine * steps_of(fleet, INTERVAL, PHASE, None)).astype(np.int64)
    walls = np.stack([highest_centres(fleet), np.zeros(len(parts))], axis=1)
    call(fleet, clock_of(INTERVAL, parts, None, NO_PUSH), on_compile, scan=scan, lowest=walls)
    return walls


def clock_of(interval: float, parts: NDArray[np.int64], end: float | None, push: Array) -> Clock:
    """Return the steps of a run.

    Raises RigidBodyError unless the end is positive and finite, or None.
    """
    if end is not None:
        Gate().positive(rules.END, end)
    window = max(1, round(accuracy.WINDOW / interval))
    return Clock(
        interval, parts, window, end or LONGEST, end is not None, np.ascontiguousarray(push, dtype=float)
    )


def rows_of(clock: Clock) -> int:
    """Return the most rows of a motion."""
    return math.ceil(clock.longest / clock.interval) + 2


def workspace_of(fleet: Fleet, clock: Clock) -> SpaceWork:
    """Return the workspace for one sample of a fleet."""
    points, rows = int(fleet.strip_points.sum()), rows_of(clock)
    units, axles, strips = (part.shape[1] for part in (fleet.units, fleet.axles, fleet.strips))
    return workspace(units, axles, strips, points, len(fleet.profile), rows)


def call(
    fleet: Fleet,
    clock: Clock,
    on_compile: OnCompile,
    *,
    motions: Motions | None = None,
    choice: Choice = NO_CHOICE,
    answers: Array = NOTHING,
    rolls: Array = NOTHING,
    scan: float = 0.0,
    lowest: Array = NOTHING,
) -> None:
    """Call `accuracy.advance` without what is absent."""
    most = max(choice.finer, 2.0 * accuracy.MOST_POINTS if choice.is_chosen else 1.0)
    work = workspace_of(with_points(fleet, most), clock)
    motions = motions or accuracy.room_for(fleet, 0, clock.interval)
    arguments = fleet, clock, work, motions, choice, answers, rolls, scan, lowest
    compile_once(lambda: accuracy.advance(*arguments), accuracy.advance, *arguments, on_compile=on_compile)


def answers_of(fleet: Fleet, answers: Array, rolls: Array) -> SpaceAnswers:
    """Return answers, shape (n, columns), and rolls by name.

    Raises RigidBodyError for a motion that became infinite.
    """
    Gate().demand(rules.SPACE_LOST, answers[:, state.OUTCOME] != state.LOST, _fastest(fleet))
    named: dict[str, Any] = dict(zip(SpaceAnswers._fields[:-1], answers.T, strict=True))
    named |= {name: named[name].astype(np.int64) for name in ("outcome", "rows")}
    return SpaceAnswers(**named, unit_rolls=rolls)


def with_points(fleet: Fleet, finer: float) -> Fleet:
    """Return a fleet with more or fewer points of the strips."""
    return fleet._replace(strip_points=np.ceil(finer * fleet.strip_points).astype(np.int64))


def steps_of(fleet: Fleet, interval: float, phase: float, step: float | None) -> NDArray[np.int64]:
    """Return the steps of an interval by the fastest oscillation.

    Returns shape (n,). Raises RigidBodyError for too many.
    """
    rate = _fastest(fleet)
    parts = np.ceil(
        interval * rate / phase if step is None else np.full_like(rate, interval / step) * (1.0 - 1e-12)
    )
    is_possible = parts <= (MOST_CHOSEN if step is None else MOST_PARTS)
    Gate().demand(rules.SPACE_STEPS, is_possible, rate)
    return np.maximum(parts, 1.0).astype(np.int64)


def _fastest(fleet: Fleet) -> Array:
    """Estimate the highest frequencies [rad/s], shape (n,)."""
    rates = np.zeros(len(fleet.height))
    columns.fill_rates(fleet, rates)
    return rates
