"""Compiled choice of the step of a motion, and its error.

The step follows from the stiffest contact, the rotation and the tolerance; hinged units use parts of a step. The error
is estimated by a run with twice the step, and the step is halved where it is above the tolerance. What is tolerated
doubles with each halving, because abrupt forces leave errors of first order.
"""

from typing import NamedTuple

import numpy as np

from machine_code.compiled import compact, compiled
from solver.impact import state as col
from solver.impact.counting import LEANING, SHORTEST
from solver.impact.step import begin, follow

PHASE, TURN = 0.7, 0.025
"""Step over the square root of the tolerance: in radians of the stiffest oscillation, and times speed over size."""

TURN_OF_PARTS, PARTS = 0.1, 1024
"""Rotation in a whole step of a train, as above; largest number of parts of a step."""

COARSE_TURN = 0.4
"""Rotation in a step of many vehicles, as above."""

UPRIGHT_FACTOR = 4.0
"""Factor on the error of a train with a vertical line of unloading, whose steps are of first order."""

STEEP = 0.03
"""Restitution up to which the error with coarse steps is at least the tolerance: two steps may agree by accident."""

DURATION_TOLERANCE = 4e-3
"""Allowed change of durations where the tolerance is smaller: they are of first order where unloading is abrupt."""

LARGEST_ERROR = 1e-3
"""Error above which there is no solution, or ten times the tolerance if that is larger."""

MOST_ROWS = 1_000_000

WEIGHT = 0.05
"""Least impulse of a heavy strike, over the largest of its train."""

SOLVED, PASSED, INACCURATE = range(3)
"""Verdicts on a motion: the vehicle passed through the wall; the error remains too large."""


class Choice(NamedTuple):
    """What determines the steps of all samples.

    tolerance [-]; step: NaN where it is chosen [s]; interval: between rows, 0 for every step [s]; most: largest number
    of steps. varies: parts of steps are taken; is_coarse: of many vehicles; compares_all: heavy strikes are compared,
    otherwise the first two. impulse_alone: rows have one column.
    """

    tolerance: float
    step: float
    interval: float
    most: int
    varies: bool
    is_coarse: bool
    compares_all: bool


class Outcome(NamedTuple):
    """Motions of n samples, and of one with another step for comparison.

    state, shape (n, units, 6); strikes, shape (n, strikes, columns); rows, shape (n, rows, columns); error, interval,
    shape (n,); verdict, shape (n,): see `SOLVED`. other_state, other_strikes: of one sample.
    """

    state: np.ndarray
    strikes: np.ndarray
    rows: np.ndarray
    error: np.ndarray
    interval: np.ndarray
    verdict: np.ndarray
    other_state: np.ndarray
    other_strikes: np.ndarray


@compact
def solve(train, tyres, start, choice, clock, work, outcome):
    """Integrate every sample with a step by its tolerance."""
    for i in range(start.shape[0]):
        solve_sample((train, tyres, start[i], choice, clock, work), outcome, i, outcome.rows[i])


@compiled
def solve_sample(case, outcome, i, rows):
    """Integrate sample i, and write its outcome."""
    train, start, choice, clock = case[0], case[2], case[3], case[4]
    state, strikes = outcome.state[i], outcome.strikes[i]
    turning = choose_step(train, start, choice, clock, i)
    aimed = step = clock.step[i]
    end, counted = _run(case, outcome, i, aimed, aimed, state, rows, strikes)
    if not clock.end < np.inf and _has_passed(train, state, i):
        clock.reached[i], outcome.error[i], outcome.verdict[i] = end, np.inf, PASSED
        return
    coarse_state, compared, no_rows = outcome.other_state, outcome.other_strikes, rows[rows.shape[0] :]
    other_end, compared_count = _run(case, outcome, i, aimed, 2.0 * aimed, coarse_state, no_rows, compared)
    error = _error(train, choice, outcome, i, end, other_end, turning)
    counted = max(counted, compared_count)
    while (
        np.isnan(choice.step) and error > choice.tolerance * aimed / step and 2.0 * end <= choice.most * step
    ):
        _copy(state, coarse_state)
        _copy(strikes, compared)
        other_end = end
        end, compared_count = _run(case, outcome, i, aimed, 0.5 * step, state, rows, strikes)
        counted = max(counted, compared_count)
        if np.isnan(end):  # steps did not suffice: the motion before is the result
            end, _ = _run(case, outcome, i, aimed, step, state, rows, strikes)
            break
        step = 0.5 * step
        error = _error(train, choice, outcome, i, end, other_end, turning)
    clock.step[i], clock.reached[i], clock.counted[i] = step, end, counted
    outcome.error[i], outcome.verdict[i] = error, SOLVED
    if np.isnan(choice.step) and not error <= max(LARGEST_ERROR, 10.0 * choice.tolerance):
        outcome.verdict[i] = INACCURATE


@compiled
def choose_step(train, start, choice, clock, i):
    """Set the whole step of sample i and its parts.

    Returns its speed over its size [1/s].
    """
    clock.rate[i], turning = _rates(train, start, i)
    root, latest, whole = np.sqrt(choice.tolerance), clock.longest, clock.longest
    if choice.interval > 0.0:
        whole = choice.interval
    if not np.isnan(choice.step):
        h = choice.step
    elif choice.is_coarse:
        h = COARSE_TURN * root / turning
    elif choice.varies:
        h = min(TURN_OF_PARTS * root / turning, 0.5 * SHORTEST)
    else:
        h = PHASE * root / max(clock.rate[i], turning / TURN)
    h = max(h, latest / choice.most)  # first coarser, then finer as far as the computed end allows
    rows_a_step = float(_power_of_two(h / whole)) if choice.is_coarse else 1.0
    clock.step[i] = whole / np.ceil(whole / h) * rows_a_step
    clock.parts[i] = _power_of_two(choice.most * clock.step[i] / latest) if choice.varies else 1
    return turning


@compiled
def _power_of_two(most):
    """Return the largest power of two up to a number.

    It is from 1 to `PARTS`.
    """
    power = 1
    while power < PARTS and float(2 * power) <= most:
        power *= 2
    return power


@compiled
def _rates(train, start, i):
    """Return the stiffest rate on loading, and speed over size [1/s]."""
    rate2, turning = 0.0, 1e-300
    for u in range(start.shape[0]):
        reach2, stiffness = 0.0, 0.0
        for p in range(train.unit.size):
            if train.unit[p] == u:
                reach2 = max(reach2, train.along[p, i] ** 2 + train.across[p, i] ** 2)
                stiffness += 0.5 * train.stiffness[p, i]  # those of one side at once
        rate2 = max(rate2, stiffness * (1.0 / train.mass[u, i] + reach2 / train.inertia[u, i]))
        turning = max(turning, np.hypot(start[u, 3], start[u, 4]) / np.sqrt(reach2) + abs(start[u, 5]))
    return np.sqrt(rate2), turning


@compiled
def _run(case, outcome, i, aimed, h, state, rows, strikes):
    """Integrate sample i with the step h [s].

    aimed: the step that the tolerance requires [s]. Returns the end, NaN where the steps did not suffice [s], and the
    number of strikes.
    """
    train, tyres, start, choice, clock, work = case
    _copy(start, state)
    strikes[:] = np.nan
    clock.step[i], clock.pace[i] = h, h / aimed
    rows_apart = choice.interval / h if choice.interval > 0.0 else np.ceil(clock.longest / h / MOST_ROWS)
    clock.stride[i] = max(int(np.rint(rows_apart * float(clock.parts[i]))), 1)
    if rows.shape[0] > 0:
        outcome.interval[i] = h / float(clock.parts[i]) * float(clock.stride[i])
    begin(train, i, state, work)
    return follow(state, clock, tyres, i, work, rows, strikes)


@compiled
def _copy(source, target):
    for j in range(source.shape[0]):
        for k in range(source.shape[1]):
            target[j, k] = source[j, k]


@compiled
def _has_passed(train, state, i):
    """Return True for a sample with a unit wholly behind the wall."""
    for u in range(state.shape[0]):
        reach = 0.0
        for p in range(train.unit.size):
            if train.unit[p] == u:
                reach = max(reach, np.hypot(train.along[p, i], train.across[p, i]))
        if state[u, 1] + reach < 0.0:
            return True
    return False


@compiled
def _error(train, choice, outcome, i, end, other_end, turning):
    """Return the error of sample i.

    It is the largest change of strikes and spin against the other motion.
    """
    steepest = 1.0
    for p in range(train.unit.size):
        if train.unloading_stiffness[p, i] == 0.0:
            steepest = min(steepest, train.restitution[p, i])
    weight = choice.tolerance / max(choice.tolerance, DURATION_TOLERANCE)
    fine, coarse = outcome.strikes[i], outcome.other_strikes
    error = _change_of_spin(outcome.state[i], outcome.other_state, fine, end != other_end, turning)
    if choice.compares_all:
        error = max(error, _change_of_all(fine, coarse, end != other_end, weight))
    else:
        error = max(error, _change_of_two(fine, coarse, weight))
    if steepest == 0.0 and choice.varies and not choice.is_coarse:
        error *= UPRIGHT_FACTOR
    if not abs(end + other_end) < np.inf or np.isnan(error):
        error = np.inf
    return max(error, choice.tolerance) if steepest <= STEEP and choice.is_coarse else error


@compiled
def _change_of_spin(state, coarse_state, strikes, ends_differ, turning):
    """Return the largest change of spin [-].

    It is compared with itself plus a tenth of speed over size: infinite where a value is not finite, 0 for a vehicle
    that bounces along the wall, at another instant.
    """
    largest, goes_on = 0.0, False
    for u in range(state.shape[0]):
        for k in range(6):
            if not abs(state[u, k]) < np.inf:
                return np.inf
        largest = max(largest, abs(coarse_state[u, 5] - state[u, 5]) / (abs(state[u, 5]) + 0.1 * turning))
    for s in range(strikes.shape[0]):
        goes_on = goes_on or (strikes[s, col.CUT] == 1.0 and ends_differ)
    return 0.0 if goes_on else largest


@compiled
def _change_of_two(fine, coarse, weight):
    """Return the largest change of the first two strikes.

    Impulses, peaks and durations, which count times the weight; infinite where other groups strike.
    """
    largest = 0.0
    for s in range(2):
        if np.isnan(fine[s, 0]) and np.isnan(coarse[s, 0]):
            continue
        if fine[s, 0] != coarse[s, 0]:
            return np.inf
        largest = max(largest, _change(fine[s], coarse[s], True, weight))
    return largest


@compiled
def _change(fine, coarse, is_over, weight):
    """Return the largest change of a strike.

    It is that of its peak alone if it is not over.
    """
    largest = abs(coarse[3] / fine[3] - 1.0)
    if is_over:
        largest = max(largest, abs(coarse[4] / fine[4] - 1.0))
        duration, coarse_duration = fine[2] - fine[1], coarse[2] - coarse[1]
        change = coarse_duration**weight / duration**weight - 1.0
        largest = max(largest, abs(change) if duration != coarse_duration else 0.0)
    return largest


@compiled
def _change_of_all(fine, coarse, ends_differ, weight):
    """Return the largest change of heavy strikes.

    Each is compared with the strike of the same group with the nearest start, because light strikes between may
    differ. Of strikes in progress at ends that differ the peak alone counts, if the vehicle did more than lean on the
    wall.
    """
    heaviest, strongest, largest = 0.0, 0.0, 0.0
    for s in range(fine.shape[0]):
        if fine[s, 4] > heaviest:
            heaviest = fine[s, 4]
        if fine[s, 3] > strongest:
            strongest = fine[s, 3]
    for s in range(fine.shape[0]):
        goes_on = fine[s, col.CUT] == 1.0 and ends_differ
        if not fine[s, 4] >= WEIGHT * heaviest or (goes_on and fine[s, 3] < LEANING * strongest):
            continue
        nearest, distance = -1, np.inf
        for c in range(coarse.shape[0]):
            if coarse[c, 0] == fine[s, 0] and abs(coarse[c, 1] - fine[s, 1]) < distance:
                nearest, distance = c, abs(coarse[c, 1] - fine[s, 1])
        if nearest < 0:
            return np.inf
        largest = max(largest, _change(fine[s], coarse[nearest], not goes_on, weight))
    return largest
