"""Choose steps and points of one motion in space, compiled.

Steps and points of the strips are halved apart from each other. As the change by half of either may be small by
chance, a further motion has other steps and points than halves. The largest 50 ms mean may belong to another strike for
a change of force by less than the error: motions are compared strike by strike, and all strikes within the error of the
largest have a height. An outcome is decided where all these motions, and those with half the steps on walls a little
lower and higher, have the same.
"""

import math
from typing import NamedTuple

import numpy as np

from machine_code.compiled import compact, compiled
from solver.space import state as col
from solver.space.step import follow, lowest_wall

COMPARED = {"largest_roll": 0.05, "mean_50ms": 1e3, "height": 0.05, "moment": 1e3}
"""Quantities by which the error is judged, with the sizes below which their change is not relative [rad, N, m, N m]."""

LEAST_ROLL, LEAST_FORCE, LEAST_HEIGHT, LEAST_MOMENT = COMPARED.values()

SAFETY, LEAST_ERROR = 3.0, 2e-4
"""Error over the last change by half the step or points, and least error of a chosen step."""

BALANCE = 0.25 * math.pi
"""Angle from balance to a roll of 90 deg, about [rad]: motions whose rolls part by it over `SAFETY` may end apart."""

TOLERANCE, REFINEMENTS, POINTS, MOST_POINTS = 1e-3, 6, 2.0, 8.0
"""Largest error, most refinements of step or points, first and most points of a strip over those of many motions."""

MOST_CHOSEN = 1024
"""Most chosen steps of an interval; more would take minutes of processor time before an error is stated."""

FORMER, UNRESOLVED = 0.25, 0.1
"""Part of the change before the last that counts, as in a scheme of second order, and the change from which a step does
not resolve the motion and does not count. A single change may be small by chance."""

OTHER_STEPS, OTHER_POINTS = 2.0 / 3.0, 0.75
"""Steps and points of the further motion over those of the answer."""

WINDOW = 0.05
"""Duration of the mean of the design force [s]."""

MARGIN = 2e-3
"""Change of the height of the wall within which the outcome must be the same, and least error of a lowest wall [m]."""

FURTHER, SCRATCH, MOTIONS = 3, 4, 5
"""Places of the motion with other steps and points, and of those on other walls; number of places."""

PARTS, FINER, STEP_ERROR, STRIP_ERROR, OTHER_ERROR, UNDECIDED, HEIGHTS, RESULT = range(8)
"""Columns of a result: steps of an interval, points over those of many motions, errors by half the step, by half the
points and by other ones [-]; 1 where the outcome is undecided; number of heights."""


class Choice(NamedTuple):
    """What determines steps and points.

    finer: first points over those of many motions; is_chosen: False for a prescribed step, that of the clock;
    tolerance: of the error [-].
    """

    finer: float
    is_chosen: bool
    tolerance: float


class Motions(NamedTuple):
    """Motions of one vehicle with different steps and points.

    answers, shape (5, columns); rolls, (5, units); rows, (5, rows, columns); means, places, (5, rows): 50 ms means that
    end with a row [N], and heights of their resultants [m]; points, (strips,): of many motions; at, (4,): places of the
    answer, that with half the steps, half the points, and the further one; heights: of strikes with a mean within the
    error of the largest [m]; result: see `RESULT`.
    """

    answers: np.ndarray
    rolls: np.ndarray
    rows: np.ndarray
    means: np.ndarray
    places: np.ndarray
    points: np.ndarray
    at: np.ndarray
    heights: np.ndarray
    result: np.ndarray
    interval: float


def room_for(fleet: col.Fleet, rows: int, interval: float) -> Motions:
    """Return room for the motions of a vehicle, none for no rows."""
    units, count = fleet.units.shape[1], MOTIONS if rows else 0
    columns = col.row_columns(units, fleet.axles.shape[1], fleet.strips.shape[1])
    shapes = (count, col.ANSWERS), (count, units), (count, rows, columns), (count, rows), (count, rows)
    at: np.ndarray = np.zeros(4, dtype=np.int64)
    heights, result = np.zeros(rows), np.zeros(RESULT)
    return Motions._make([*map(np.zeros, shapes), fleet.strip_points.copy(), at, heights, result, interval])


@compact
def advance(fleet, clock, work, motions, choice, answers, rolls, scan, lowest):
    """Solve one motion with its error, many, or lowest walls.

    motions: those of one vehicle, or without rows. answers, shape (n, columns); rolls, shape (n, units): largest of
    each unit [rad]. lowest: empty, or of shape (n, 2) with the first wall of a search, which becomes the lowest wall
    above which each sample remains upright, NaN where a wall by `scan` higher than the first does not suffice, and the
    highest tried one on which it almost tips although a lower one suffices, 0 without; scan: steps downwards from the
    first wall, before the bisection [m].
    """
    if motions.rows.shape[0] > 0:
        solve_one(fleet, clock, work, motions, choice)
    for i in range(answers.shape[0]):
        row = work.windows[:0]
        follow(fleet, clock, i, fleet.height[i], work, row, answers[i], rolls[i])
    for i in range(lowest.shape[0]):
        lowest[i, 0], lowest[i, 1] = lowest_wall(fleet, clock, i, work, lowest[i, 0], scan)


@compiled
def solve_one(fleet, clock, work, motions, choice):
    """Fill the motions of the first sample with the result.

    It ends early with a motion without rows, or one that became infinite.
    """
    case, at, result = (fleet, clock, work, motions), motions.at, motions.result
    for k in range(at.size):
        at[k] = k
    parts, finer, other_error, is_undecided = clock.parts[0], choice.finer, 0.0, False
    if choice.is_chosen:
        parts = max(parts, 2)
    is_solved = run(case, parts, finer, 0.0, 0) and run(case, max(parts // 2, 1), finer, 0.0, 1)
    step_error, strip_error = SAFETY * change(motions, at[0], at[1]) if is_solved else 0.0, 0.0
    if choice.is_chosen and is_solved:
        is_solved = run(case, parts, 0.5 * finer, 0.0, 2)
        if is_solved:
            parts, finer, step_error, strip_error, is_solved = refine(case, choice.tolerance, parts, finer)
        half = max(parts // 2, 1)
        is_solved = is_solved and run(
            case, max(int(np.rint(OTHER_STEPS * float(parts))), 1), OTHER_POINTS * finer, 0.0, FURTHER
        )
        if is_solved:
            of_mean, parting = 0.0, 0.0
            for k in range(1, 4):
                _, mean, _, _ = changes(motions, at[0], at[k])
                of_mean = max(of_mean, SAFETY * mean)
                parting = max(parting, SAFETY * parted(motions, at[0], at[k]))
                is_undecided = is_undecided or not same(motions, at[0], at[k])
            other_error = max(SAFETY * change(motions, at[0], FURTHER), spread(motions, at[0], of_mean))
            is_undecided = is_undecided or parting > BALANCE
            step_error = max(step_error, LEAST_ERROR - strip_error)
        for sign in (-1.0, 1.0):
            if is_solved:
                is_solved = run(case, half, finer, sign * MARGIN, SCRATCH)
                is_undecided = is_undecided or not same(motions, at[0], SCRATCH)
    result[PARTS], result[FINER], result[UNDECIDED] = float(parts), finer, 1.0 if is_undecided else 0.0
    result[STEP_ERROR], result[STRIP_ERROR], result[OTHER_ERROR] = step_error, strip_error, other_error
    error = max(step_error + strip_error, other_error)
    result[HEIGHTS] = float(fill_heights(motions, at[0], error)) if is_solved else 0.0


@compiled
def refine(case, tolerance, parts, finer):
    """Refine steps or points, whichever have the larger error.

    Returns the steps of an interval, the points, the errors by both, and False where a motion has no answer.
    """
    motions, at = case[3], case[3].at
    former_step, former_strip, step_error, strip_error = np.inf, np.inf, np.inf, 0.0
    for attempt in range(REFINEMENTS + 1):
        if attempt > 0:
            is_solved = True
            if step_error < strip_error:
                finer, former_step = 2.0 * finer, np.inf
                at[0], at[2] = at[2], at[0]
                is_solved = run(case, max(parts // 2, 1), finer, 0.0, at[1])
            elif 2 * parts > MOST_CHOSEN:
                break
            else:
                parts, former_strip = 2 * parts, np.inf
                at[0], at[1] = at[1], at[0]
                is_solved = run(case, parts, 0.5 * finer, 0.0, at[2])
            if not (is_solved and run(case, parts, finer, 0.0, at[0])):
                return parts, finer, step_error, strip_error, False
        before = FORMER * former_step if former_step < UNRESOLVED else 0.0
        former_step = change(motions, at[0], at[1])
        step_error = SAFETY * max(former_step, before)
        before = FORMER * former_strip if former_strip < UNRESOLVED else 0.0
        former_strip = change(motions, at[0], at[2])
        strip_error = SAFETY * max(former_strip, before)
        is_same = same(motions, at[0], at[1]) and same(motions, at[0], at[2])
        if (step_error + strip_error <= tolerance and is_same) or (
            step_error < strip_error and finer >= MOST_POINTS
        ):
            break
    return parts, finer, step_error, strip_error, True


@compiled
def run(case, parts, finer, higher, k):
    """Solve a motion, and fill its 50 ms means.

    Returns False for one without rows, or that became infinite, which is then the answer.
    """
    fleet, clock, work, motions = case
    for p in range(motions.points.size):
        fleet.strip_points[p] = int(np.ceil(finer * float(motions.points[p])))
    clock.parts[0] = parts
    answer = motions.answers[k]
    follow(fleet, clock, 0, fleet.height[0] + higher, work, motions.rows[k], answer, motions.rolls[k])
    if answer[col.OUTCOME] == float(col.LOST) or answer[col.ROWS_WRITTEN] == 0.0:
        motions.at[0] = k
        return False
    fill_means(motions, clock.window, k)
    return True


@compiled
def fill_means(motions, window, k):
    """Fill the 50 ms means of a motion."""
    force, moment = 0.0, 0.0
    for j in range(int(motions.answers[k, col.ROWS_WRITTEN])):
        row = motions.rows[k, j]
        force, moment = force + row[col.LATERAL], moment + row[col.MOMENT]
        if j >= window:
            force, moment = (
                force - motions.rows[k, j - window, col.LATERAL],
                moment - motions.rows[k, j - window, col.MOMENT],
            )
        motions.means[k, j] = force / float(window)
        motions.places[k, j] = moment / force if force > 0.0 else 0.0


@compiled
def same(motions, one, other):
    """Return True for motions with the same outcome."""
    return motions.answers[one, col.OUTCOME] == motions.answers[other, col.OUTCOME]


@compiled
def roll_of(answer):
    """Return the largest roll of a motion, 90 deg unless upright [rad]."""
    upright = answer[col.OUTCOME] == float(col.UPRIGHT)
    return min(abs(answer[col.ROLL]), 0.5 * np.pi) if upright else 0.5 * np.pi


@compiled
def change(motions, one, other):
    """Return the largest relative change of `COMPARED`."""
    roll, mean, height, moment = changes(motions, one, other)
    return max(roll, mean, height, moment)


@compiled
def changes(motions, one, other):
    """Return relative changes of `COMPARED` from another motion."""
    first, last = motions.answers[one], motions.answers[other]
    force, place = strike_at(motions, one, other)
    roll, moment = roll_of(first), first[col.MOMENT_MEAN]
    return (
        abs(roll_of(last) - roll) / max(roll, LEAST_ROLL),
        abs(last[col.MEAN] - force) / max(force, LEAST_FORCE),
        abs(last[col.CENTRE_HEIGHT] - place) / max(place, LEAST_HEIGHT),
        abs(last[col.MOMENT_MEAN] - moment) / max(moment, LEAST_MOMENT),
    )


@compiled
def strike_at(motions, one, other):
    """Return mean and height of a motion's strike at that of another."""
    count, middle = int(motions.answers[one, col.ROWS_WRITTEN]), row_of(motions, other)
    half = int(np.rint(0.5 * WINDOW / motions.interval))
    row = min(max(middle - half, 0), count - 1)
    for j in range(row, min(middle + half + 1, count)):
        if motions.means[one, j] > motions.means[one, row]:
            row = j
    return motions.means[one, row], motions.places[one, row]


@compiled
def row_of(motions, k):
    """Return the row with the largest mean of a motion."""
    return int(np.rint(motions.answers[k, col.MEAN_TIME] / motions.interval))


@compiled
def parted(motions, one, other):
    """Return the largest change of a roll until either motion ends [rad].

    Near balance, motions part by far more than their largest rolls differ.
    """
    answers, largest = motions.answers, 0.0
    for j in range(int(min(answers[one, col.ROWS_WRITTEN], answers[other, col.ROWS_WRITTEN]))):
        for u in range(motions.rolls.shape[1]):
            roll = col.FIRST_ROLL + len(col.POSE) * u
            largest = max(largest, abs(motions.rows[one, j, roll] - motions.rows[other, j, roll]))
    return largest


@compiled
def spread(motions, one, error):
    """Return the largest change of the height among equal means.

    They are within an error of the largest mean and in its strike; the change is relative.
    """
    answer, row, window = motions.answers[one], row_of(motions, one), int(np.rint(WINDOW / motions.interval))
    height, largest = answer[col.CENTRE_HEIGHT], 0.0
    for j in range(max(row - window, 0), min(row + window + 1, int(answer[col.ROWS_WRITTEN]))):
        if motions.means[one, j] >= (1.0 - error) * answer[col.MEAN]:
            largest = max(largest, abs(motions.places[one, j] - height))
    return largest / max(height, LEAST_HEIGHT)


@compiled
def fill_heights(motions, one, error):
    """Fill heights of strikes within an error of the largest mean.

    The height of the largest mean is the first one. Other strikes are at least a window apart. Returns their number.
    """
    answer, means, window = (
        motions.answers[one],
        motions.means[SCRATCH],
        int(np.rint(WINDOW / motions.interval)),
    )
    size, number = int(answer[col.ROWS_WRITTEN]), 0
    row, value, place = row_of(motions, one), answer[col.MEAN], answer[col.CENTRE_HEIGHT]
    for j in range(size):
        means[j] = motions.means[one, j]
    while value >= (1.0 - error) * answer[col.MEAN] and number < motions.heights.size:
        motions.heights[number] = place
        number += 1
        for j in range(max(row - window, 0), min(row + window + 1, size)):
            means[j] = -np.inf
        row = 0
        for j in range(size):
            if means[j] > means[row]:
                row = j
        value, place = means[row], motions.places[one, row]
    return number
