"""Motions of any number of rigid trains that strike a wall.

The step follows from the stiffest contact, the rotation and the tolerance; hinged units use parts of a step. The error
is estimated by a run with twice the step, and the step is halved where it is above the tolerance.
"""

import math
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from machine_code.compiled import OnCompile, compile_once, ignore_compiling
from solver.conditions import Array, RigidBodyError
from solver.impact.counting import LEANING, SHORTEST
from solver.impact.state import CUT, STRIKE, columns, workspace
from solver.impact.step import advance
from solver.impact.train import Train
from solver.impact.tyres import Tyres, chosen_tyres, no_tyres

TOLERANCE = 1e-5
"""Error of peaks, impulses and spin of one impact by which the step is chosen."""

PHASE, TURN = 0.7, 0.025
"""Step over the square root of the tolerance: in radians of the stiffest oscillation, and times speed over size."""

PHASE_OF_PARTS, TURN_OF_PARTS, PARTS = 0.32, 0.1, 1024
"""Phase of a part of a step of a train, rotation in its whole step, as above; largest number of parts of a step."""

COARSE_PHASE, COARSE_TURN, COARSE_FLOOR = 1.0, 0.4, 0.5
"""Both for many vehicles, and their least step near a jump of stiffness over the step beyond it."""

LOOSE = 1e-3
"""Tolerance from which steps of many vehicles are coarse."""

UPRIGHT_FACTOR = 4.0
"""Factor on the error of a train with a vertical line of unloading, whose steps are of first order."""

STEEP = 0.03
"""Restitution up to which the error with coarse steps is at least the tolerance: two steps may agree by accident."""

DURATION_TOLERANCE = 4e-3
"""Allowed change of durations where the tolerance is smaller: they are of first order where unloading is abrupt."""

LARGEST_ERROR = 1e-3
"""Error above which there is no solution, or ten times the tolerance if that is larger."""

LONGEST_RUN, STEP_COST, POINT_COST = 4.0, 3e-7, 2e-8
"""Longest computation of an impact, and approximate costs of a step and of a point in a step [s]."""

COARSE_RUN = 0.005
"""Longest computation of an impact with coarse steps over the longest one."""

MOST_ROWS = 1_000_000

WEIGHT = 0.05
"""Least impulse of a heavy strike, over the largest of its train."""


class Timing(NamedTuple):
    """Steps and ends of n samples.

    step [s], its number of parts, and parts per row, shape (n,). end [s], shape (n,): infinite for an open end, which
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
    end: np.ndarray
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
    most = int(LONGEST_RUN / (STEP_COST + POINT_COST * train.unit.size))
    latest = longest if end is None else end
    rate, turning = _rates(train, state)
    tyres = no_tyres(train) if tyres is None else tyres
    steered = tyres.unit.size > 0
    is_free = len(train.hitch) > 0 or steered
    many_strikes = is_free or awaited >= 0
    is_coarse = step is None and impulse_alone and tolerance >= LOOSE
    varies = step is None and (is_free or is_coarse)
    phase, floor = (COARSE_PHASE, COARSE_FLOOR) if is_coarse else (PHASE_OF_PARTS, 0.0)
    h = _whole_steps(rate, turning, tolerance, step, varies, is_coarse)
    h = np.maximum(h, latest / most)  # first coarser, then finer as far as the computed end allows
    whole = interval or latest
    rows_a_step = np.exp2(np.floor(np.log2(np.clip(h / whole, 1.0, PARTS)))) if is_coarse else 1.0
    h = aimed_step = whole / np.ceil(whole / h) * rows_a_step
    parts = np.ones(len(state), dtype=np.int64)
    if varies:
        parts <<= np.log2(np.clip(most * h / latest, 1, PARTS)).astype(np.int64)

    def run(chosen: NDArray[np.int64], h: Array, interval: float | None, room: int = strikes) -> Trajectories:
        samples = Train(*(v if v.ndim == 1 else np.ascontiguousarray(v[..., chosen]) for v in train))
        out, n = np.array(state[chosen]), len(chosen)
        stride, count = parts[chosen], 0
        if interval is not None:
            rows_apart = interval / h if interval else np.ceil(latest / h / MOST_ROWS)
            stride = np.rint(rows_apart * stride).astype(np.int64)
            count = math.ceil(min(float((latest / h * parts[chosen] / stride).max()), most)) + 2
        samples_tyres = chosen_tyres(tyres, chosen)
        width = columns(out.shape[1]) + samples_tyres.sums.size
        place = np.zeros(0) if sensor is None else sensor[chosen]
        rows = np.empty((n, count, (1 if sensor is None else 2) if impulse_alone else width))
        strike_rows = np.full((n, room, len(STRIKE)), np.nan)
        ends = np.full(n, math.inf if end is None else end)
        reached, counted = np.full(n, np.nan), np.zeros(n, dtype=np.int64)
        clock = Timing(
            h, parts[chosen], stride, phase * math.sqrt(tolerance), floor, h / aimed_step[chosen], rate[chosen], ends,
            after_second, awaited, latest, math.ceil(COARSE_RUN * most) if is_coarse else most, reached, counted, place,
        )  # fmt: skip
        work = workspace(out.shape[1], len(samples.hitch), samples.unit.size, 1 + int(samples.group.max()))
        arguments = samples, samples_tyres, out, clock, work, rows, strike_rows
        compile_once(lambda: advance(*arguments), advance, *arguments, on_compile=on_compile)
        if counted.max() > room > 2:
            return run(chosen, h, interval, int(counted.max()))
        return Trajectories(reached, out, strike_rows, rows, h / parts[chosen] * stride, h, np.zeros(n))

    all_samples = np.arange(len(state))
    steepest = np.where(train.unloading_stiffness == 0.0, train.restitution, 1.0).min(axis=0)
    error_factor = np.where((steepest == 0.0) & (varies and not is_coarse), UPRIGHT_FACTOR, 1.0)
    least_error = np.where((steepest <= STEEP) & is_coarse, tolerance, 0.0)
    weight = tolerance / max(tolerance, DURATION_TOLERANCE)

    def change(fine: Trajectories, coarse: Trajectories, chosen: NDArray[np.int64]) -> Array:
        difference = _difference(fine, coarse, turning[chosen], weight, many_strikes)
        return np.maximum(error_factor[chosen] * difference, least_error[chosen])

    motions = run(all_samples, h.copy(), interval)
    if end is None:
        _demand_stopped(train, motions.state)
    error = change(motions, run(all_samples, 2.0 * h, None), all_samples)
    if step is None:
        motions = _refined(partial(run, interval=interval), change, motions, error, tolerance * h, most)
        _demand_small(error, motions.step, max(LARGEST_ERROR, 10.0 * tolerance))
    return motions._replace(error=error)


def _refined(
    run: Callable[..., Trajectories],
    change: Callable[..., Array],
    motions: Trajectories,
    error: Array,
    limit: Array,
    most: int,
) -> Trajectories:
    """Halve the steps where errors exceed the limit over the step.

    The errors are updated in place. most: largest number of steps.
    """
    settled = np.zeros(len(error), dtype=np.bool_)
    while True:
        settled |= (error <= limit / motions.step) | ~(2.0 * motions.end <= most * motions.step)
        chosen = np.flatnonzero(~settled)
        if not chosen.size:
            return motions
        finer = run(chosen, 0.5 * motions.step[chosen])
        settled[chosen] = np.isnan(finer.end)  # steps did not suffice: the previous result stays
        if settled[chosen].any():
            finer, chosen = _samples(finer, ~settled[chosen]), chosen[~settled[chosen]]
        coarse = _samples(motions._replace(rows=motions.end), chosen)  # rows are large
        error[chosen] = change(finer, coarse, chosen)
        motions = _replaced(motions, chosen, finer)


def _whole_steps(
    rate: Array, turning: Array, tolerance: float, step: float | None, varies: bool, is_coarse: bool
) -> Array:
    """Return the whole steps of n trains [s].

    rate, turning: as of `_rates`; varies: True where parts of them are taken.
    """
    if step is not None:
        return np.full(len(rate), step)
    if is_coarse:
        return COARSE_TURN * math.sqrt(tolerance) / turning
    if varies:
        return np.minimum(TURN_OF_PARTS * math.sqrt(tolerance) / turning, 0.5 * SHORTEST)
    return PHASE * math.sqrt(tolerance) / np.maximum(rate, turning / TURN)


def _demand_stopped(train: Train, state: Array) -> None:
    """Raise RigidBodyError for units that are wholly behind the wall."""
    reach = np.zeros_like(train.mass)
    np.maximum.at(reach, train.unit, np.hypot(train.along, train.across))
    passed = np.flatnonzero((state[..., 1].T + reach < 0.0).any(axis=0))
    if passed.size:
        i = int(passed[0])
        place = f" at index {i}" if len(state) > 1 else ""
        why = f"the crush does not stop the vehicle, which is {-state[i, :, 1].min():.3g} m behind the wall{place}"
        raise RigidBodyError("contact", "this law", why, "a larger stiffness or plateau force")


def _demand_small(error: Array, steps: Array, largest: float) -> None:
    """Raise RigidBodyError where an error exceeds the largest one."""
    bad = ~(error <= largest)
    if bad.any():
        i = int(np.argmax(bad))
        place = f" at index {i}" if len(bad) > 1 else ""
        why = f"steps of {steps[i]:.2g} s leave an error of {error[i]:.2g}{place}"
        raise RigidBodyError("contact", "this law", why, "a smaller stiffness or friction")


def _samples(motions: Trajectories, chosen: NDArray[Any]) -> Trajectories:
    return Trajectories(*(value[chosen] for value in motions))


def _replaced(motions: Trajectories, chosen: NDArray[np.int64], finer: Trajectories) -> Trajectories:
    """Replace samples by finer ones, which may have more strikes."""
    if len(chosen) == len(motions.end) or not chosen.size:
        return finer if chosen.size else motions
    room = max(motions.strikes.shape[1], finer.strikes.shape[1])
    motions, finer = _with_room(motions, room), _with_room(finer, room)
    written = math.ceil(float((finer.end / finer.interval).max())) + 2
    for old, new in zip(motions._replace(rows=motions.rows[:, :written]), finer, strict=True):
        old[chosen] = new[:, :written] if new is finer.rows else new
    return motions


def _with_room(motions: Trajectories, room: int) -> Trajectories:
    """Pad the table of strikes to this number of rows."""
    more = ((0, 0), (0, room - motions.strikes.shape[1]), (0, 0))
    return motions._replace(strikes=np.pad(motions.strikes, more, constant_values=np.nan))


def _rates(train: Train, state: Array) -> tuple[Array, Array]:
    """Return the stiffest rate on loading, and speed over size [1/s]."""
    reach2, stiffness = np.zeros_like(train.mass), np.zeros_like(train.mass)
    np.maximum.at(reach2, train.unit, train.along**2 + train.across**2)
    np.add.at(stiffness, train.unit, 0.5 * train.stiffness)  # those of one side at once
    rate = np.sqrt((stiffness * (1.0 / train.mass + reach2 / train.inertia)).max(axis=0))
    velocity = np.moveaxis(state[..., 3:], -1, 0).swapaxes(1, 2)
    turning = np.hypot(velocity[0], velocity[1]) / np.sqrt(reach2) + np.abs(velocity[2])
    return rate, np.maximum(turning.max(axis=0), 1e-300)


def _difference(
    fine: Trajectories, coarse: Trajectories, turning: Array, weight: float, many_strikes: bool
) -> Array:
    """Return the largest change of strikes and spin.

    Spin is compared with itself plus a tenth of speed over size, durations count times the weight. With many strikes
    all heavy ones count, otherwise the first two. The change is infinite where strikes differ, or a value is not
    finite.
    """
    spin, coarse_spin = fine.state[..., 5], coarse.state[..., 5]
    goes_on = (fine.strikes[..., CUT] == 1.0) & (fine.end != coarse.end)[:, None]
    with np.errstate(invalid="ignore", divide="ignore"):
        measures = _measures(fine, weight), _measures(coarse, weight)
        changes = _changes_of_all(*measures, goes_on) if many_strikes else _changes(*measures)
        spins = (np.abs(coarse_spin - spin) / (np.abs(spin) + 0.1 * turning[:, None])).max(axis=1)
    spins[goes_on.any(axis=1)] = 0.0  # of a vehicle that bounces along the wall, at another instant
    is_finite = np.isfinite(fine.state).all(axis=(1, 2)) & np.isfinite(fine.end + coarse.end)
    return np.where(is_finite, np.maximum(changes, spins), math.inf)


def _measures(motions: Trajectories, weight: float) -> Array:
    """Return the compared measures of strikes.

    Group, start, impulse, peak and duration, shape (n, strikes, 5). The duration is raised to the power of its weight,
    so that relative changes are those of the duration times the weight.
    """
    group, start, end, peak, impulse = np.moveaxis(motions.strikes, -1, 0)[:5]
    return np.stack([group, start, impulse, peak, (end - start) ** weight], axis=-1)


def _changes(fine: Array, coarse: Array) -> Array:
    """Return the largest change of two strikes.

    Columns as of `_measures`.
    """
    fine, coarse = fine[:, :2], coarse[:, :2]
    same = (fine[..., 0] == coarse[..., 0]) | (np.isnan(fine[..., 0]) & np.isnan(coarse[..., 0]))
    changes = np.nan_to_num(np.abs(coarse[..., 2:] / fine[..., 2:] - 1.0), nan=0.0).max(axis=(1, 2))
    return np.where(same.all(axis=1), changes, math.inf)


def _changes_of_all(fine: Array, coarse: Array, goes_on: NDArray[np.bool_]) -> Array:
    """Return the largest change of heavy strikes.

    Each is compared with the strike of the same group with the nearest start, because light strikes between may
    differ. goes_on, shape (n, strikes): strikes in progress at ends that differ, of which the peak alone counts, if
    the vehicle did more than lean on the wall.
    """
    distance = np.abs(fine[:, :, None, 1] - coarse[:, None, :, 1])
    distance = np.where(fine[:, :, None, 0] == coarse[:, None, :, 0], distance, math.inf)
    matched = np.take_along_axis(coarse, distance.argmin(axis=2)[..., None], axis=1)
    changes = np.abs(matched[..., 2:] / fine[..., 2:] - 1.0)
    changes[..., ::2] = np.where(goes_on[..., None], 0.0, changes[..., ::2])  # impulse and duration
    changes = changes.max(axis=2)
    changes = np.where(np.isfinite(distance.min(axis=2)), changes, math.inf)
    is_heavy = fine[..., 2] >= WEIGHT * np.nanmax(fine[..., 2], axis=1, initial=0.0)[:, None]
    is_leaning = fine[..., 3] < LEANING * np.nanmax(fine[..., 3], axis=1, initial=0.0)[:, None]
    is_heavy &= ~(goes_on & is_leaning)
    return np.where(is_heavy, changes, 0.0).max(axis=1)
