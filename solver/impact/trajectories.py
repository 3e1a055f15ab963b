"""Motions of any number of rigid trains that strike a wall.

Every step is chosen by the tolerance (`accuracy`).
"""

import math
from functools import partial
from typing import NamedTuple

import numpy as np

from machine_code.compiled import OnCompile, compile_once, ignore_compiling
from solver.conditions import Array, RigidBodyError
from solver.impact.accuracy import MOST_ROWS, PASSED, Choice, Outcome, choose_step, solve
from solver.impact.state import STRIKE, columns, workspace
from solver.impact.train import Train
from solver.impact.tyres import Tyres, no_tyres

TOLERANCE = 1e-5
"""Error of peaks, impulses and spin of one impact by which the step is chosen."""

PHASE_OF_PARTS, COARSE_PHASE, COARSE_FLOOR = 0.32, 1.0, 0.5
"""Phase of a part of a step of a train, and of many vehicles, over the square root of the tolerance, in radians; their
least step near a jump of stiffness over the step beyond it."""

LOOSE = 1e-3
"""Tolerance from which steps of many vehicles are coarse."""

LONGEST_RUN, STEP_COST, POINT_COST = 4.0, 3e-7, 2e-8
"""Longest computation of an impact, and approximate costs of a step and of a point in a step [s]."""

COARSE_RUN = 0.005
"""Longest computation of an impact with coarse steps over the longest one."""


class Timing(NamedTuple):
    """Steps and ends of n samples.

    step [s], its number of parts, and parts per row, shape (n,). end [s]: infinite for an open end, which
    is `after` [s] after the end of the second strike, or after the start as soon as contact is impossible, and at
    which no strike is in progress. awaited: group whose strike is awaited in place of the second one, or -1.

    phase: part of a step in radians of the oscillation on the law, times `pace`, shape (n,), step over the one that the
    tolerance requires; floor: least step near a jump of stiffness over the step beyond it; rate: of the stiffest
    oscillation [1/s], shape (n,). longest: latest open end [s]; most: largest number of steps. reached, shape (n,): the
    end, NaN where the steps did not suffice; counted, shape (n,): strikes. sensor: as of `solve_trains`, or empty.
    """

    step: np.ndarray
    parts: np.ndarray
    stride: np.ndarray
    phase: float
    floor: float
    pace: np.ndarray
    rate: np.ndarray
    end: float
    after: float
    awaited: int
    longest: float
    most: int
    reached: np.ndarray
    counted: np.ndarray
    sensor: np.ndarray


class Trajectories(NamedTuple):
    """Motions of n trains.

    Attributes
    ----------
    end : ndarray, shape (n,)
        End of each [s].
    state : ndarray, shape (n, units, 6)
        State at the end, in the order of `state.UNIT`.
    strikes : ndarray, shape (n, strikes, columns)
        In the order of their starts, columns as of `state.STRIKE`; NaN where there is none.
    rows : ndarray, shape (n, rows, columns)
        Columns as of `state.UNIT` of each unit and `state.SUMS`, with tyres as of `tyres.SUMS` of each unit, or the
        impulse alone; undefined after the end.
    interval : ndarray, shape (n,)
        Time between rows [s].
    step : ndarray, shape (n,)
        Time step [s].
    error : ndarray, shape (n,)
        Largest relative change, against twice the step, of the first two peaks, impulses and durations, with hinges or
        tyres of all heavy strikes, and of the spin at the end; that of durations times tolerance over
        `DURATION_TOLERANCE`, if less.
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
    tyres: Tyres | None = None,
    step: float | None = None,
    end: float | None = None,
    interval: float | None = None,
    impulse_alone: bool = False,
    sensor: Array | None = None,
    after_second: float = 0.1,
    awaited: int = -1,
    longest: float = 5.0,
    tolerance: float = TOLERANCE,
    strikes: int = 2,
    on_compile: OnCompile = ignore_compiling,
) -> Trajectories:
    """Solve whole impacts of rigid trains.

    Parameters
    ----------
    train : Train
        n samples.
    state : ndarray, shape (n, units, 6)
        State at the start, in the order of `state.UNIT` [m, rad, m/s, rad/s]; hinges closed.
    tyres : Tyres or None
        Tyres of its axles, if any.
    step : float or None
        Time step [s]; None: chosen by the tolerance.
    end : float or None
        End of the motion [s]. None: `after_second` after the first two strikes, without a second when contact is no
        longer possible, `after_second` at the earliest; and not before the end of a strike in progress.
    interval : float or None
        Time between rows [s]; 0: every step, or as `MOST_ROWS` allows; None: no rows.
    impulse_alone : bool
        Rows have one column, the normal impulse of the wall; new memory for all would take longer than the motions.
    sensor : ndarray, shape (n,), or None
        Place of a sensor on the centre line of the first unit ahead of its centre of mass [m], whose velocity away from
        the wall is a second column beside the impulse alone.
    after_second, longest : float
        See `end`; latest end without `end` [s].
    awaited : int
        Group whose strike is awaited in place of the second one; -1: none.
    tolerance : float
        Tolerance of peaks, impulses and spin, by which the step is chosen [-].
    strikes : int
        Initial capacity for strikes.
    on_compile : callable
        Called when code is compiled, see `machine_code.compiled.compile_once`.

    Returns
    -------
    Trajectories
        Motions with their errors.

    Raises
    ------
    RigidBodyError
        For a vehicle that passes through the wall, and where the steps become too short or the error remains too large.
    """
    tyres = tyres or no_tyres(train)
    choice, clock = timing(
        train, state, tyres, step, end, interval, impulse_alone, after_second, awaited, longest, tolerance
    )
    clock = clock._replace(sensor=np.zeros(0) if sensor is None else np.ascontiguousarray(sensor))
    width = (1 if sensor is None else 2) if impulse_alone else columns(state.shape[1]) + tyres.sums.size
    rows, room = 0 if interval is None else _rows(train, state, choice, clock), strikes
    while True:
        outcome = room_for(state, rows, room, width)
        work = workspace(state.shape[1], len(train.hitch), train.unit.size, 1 + int(train.group.max()))
        arguments = train, tyres, state, choice, clock, work, outcome
        compile_once(partial(solve, *arguments), solve, *arguments, on_compile=on_compile)
        if rows and bool((clock.reached > (rows - 1) * outcome.interval).any()):
            rows *= 2
        elif not clock.counted.max() > room > 2:
            break
        room = max(room, int(clock.counted.max()))
    _demand_solved(clock, outcome)
    return Trajectories(
        clock.reached,
        outcome.state,
        outcome.strikes,
        outcome.rows,
        outcome.interval,
        clock.step,
        outcome.error,
    )


def timing(
    train: Train, state: Array, tyres: Tyres, step: float | None, end: float | None, interval: float | None,
    impulse_alone: bool, after_second: float, awaited: int, longest: float, tolerance: float,
) -> tuple[Choice, Timing]:  # fmt: skip
    """Return what determines steps, with arguments as of `solve_trains`."""
    most = int(LONGEST_RUN / (STEP_COST + POINT_COST * train.unit.size))
    is_free = len(train.hitch) > 0 or tyres.unit.size > 0
    is_coarse = step is None and impulse_alone and tolerance >= LOOSE
    choice = Choice(
        tolerance, math.nan if step is None else step, interval or 0.0, most,
        varies=step is None and (is_free or is_coarse), is_coarse=is_coarse, compares_all=is_free or awaited >= 0,
    )  # fmt: skip
    phase, floor = (COARSE_PHASE, COARSE_FLOOR) if is_coarse else (PHASE_OF_PARTS, 0.0)
    numbers = [np.zeros(len(state)) for _ in range(4)]
    whole = [np.zeros(len(state), dtype=np.int64) for _ in range(3)]
    clock = Timing(
        step=numbers[0], parts=whole[0], stride=whole[1], phase=phase * math.sqrt(tolerance), floor=floor,
        pace=numbers[1], rate=numbers[2], end=math.inf if end is None else end, after=after_second, awaited=awaited,
        longest=longest if end is None else end, most=math.ceil(COARSE_RUN * most) if is_coarse else most,
        reached=numbers[3], counted=whole[2], sensor=np.zeros(0),
    )  # fmt: skip
    return choice, clock


def _rows(train: Train, state: Array, choice: Choice, clock: Timing) -> int:
    """Return the number of rows for which there is room at first."""
    if choice.interval:
        return math.ceil(clock.longest / choice.interval) + 2
    for i in range(len(state)):
        choose_step(train, state[i], choice, clock, i)
    return math.ceil(min(clock.longest / clock.step.min(), choice.most, MOST_ROWS)) + 2


def room_for(state: Array, rows: int, strikes: int, width: int) -> Outcome:
    """Return memory for motions with these numbers of rows and strikes.

    width: number of columns of a row.
    """
    n, units, _ = state.shape
    return Outcome(
        np.zeros(state.shape), np.zeros((n, strikes, len(STRIKE))), np.empty((n, rows, width)), np.zeros(n),
        np.zeros(n), np.zeros(n, dtype=np.int64), np.zeros((units, 6)), np.zeros((strikes, len(STRIKE))),
    )  # fmt: skip


def _demand_solved(clock: Timing, outcome: Outcome) -> None:
    """Raise RigidBodyError where a motion is not a solution."""
    bad = np.flatnonzero(outcome.verdict)
    if not bad.size:
        return
    passed = np.flatnonzero(outcome.verdict == PASSED)
    i = int(passed[0]) if passed.size else int(bad[0])
    place = f" at index {i}" if len(clock.step) > 1 else ""
    if passed.size:
        behind = -outcome.state[i, :, 1].min()
        why = f"the crush does not stop the vehicle, which is {behind:.3g} m behind the wall{place}"
        raise RigidBodyError("contact", "this law", why, "a larger stiffness or plateau force")
    why = f"steps of {clock.step[i]:.2g} s leave an error of {outcome.error[i]:.2g}{place}"
    raise RigidBodyError("contact", "this law", why, "a smaller stiffness or friction")
