"""Compare motions of one vehicle with different steps and points.

The largest 50 ms mean may belong to another strike for a change of force by less than the error. Motions are
therefore compared strike by strike, and all strikes within the error of the largest have a height.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from solver.conditions import Array
from solver.impact.counting import LIGHT
from solver.impact.strikes import Strike, nearest, strikes_of
from solver.space import state

WINDOW = 0.05
"""Duration of the mean of the design force [s]."""

COMPARED = {"largest_roll": 0.05, "mean_50ms": 1e3, "height": 0.05, "moment": 1e3}
"""Quantities by which the error is judged, with the sizes below which their change is not relative [rad, N, m, N m]."""

SAFETY, LEAST_ERROR = 3.0, 2e-4
"""Error over the last change by half the step or points, and least error of a chosen step."""

QUANTITIES = "peak_force", "impulse", "duration"
"""Quantities of a strike whose error is stated."""

LIGHTER, APART = 1.5, 1.2
"""Factors up and down on impulse and time off the wall by which touches belong to one strike."""


@dataclass(frozen=True)
class Look:
    """One motion with its rows up to the end.

    Attributes
    ----------
    outcome : int
        Outcome by its number in compiled code.
    roll, mean, height, time, moment : float
        Largest roll, 90 deg unless upright [rad], largest 50 ms mean [N], height of its resultant [m] and its end [s];
        largest 50 ms mean of the moment [N m].
    rows : ndarray, shape (rows, columns)
        See `state`.
    interval : float
        Time between rows [s].
    units : int
        Number of units.
    """

    outcome: int
    roll: float
    mean: float
    height: float
    time: float
    moment: float
    rows: Array
    interval: float
    units: int

    @cached_property
    def strikes(self) -> tuple[Array, Array]:
        """Means and heights of their resultants by their ends.

        Two arrays of shape (rows,) [N], [m].
        """
        window = max(1, round(WINDOW / self.interval))
        sums = np.cumsum(self.rows[:, [state.LATERAL, state.MOMENT]], axis=0)
        sums[window:] -= sums[:-window].copy()
        force, moment = sums.T
        heights = np.divide(moment, force, out=np.zeros_like(force), where=force > 0.0)
        return force / window, heights

    def at(self, time: float) -> tuple[float, float]:
        """Return mean and height of the strike about a time [s]."""
        means, heights = self.strikes
        half = round(0.5 * WINDOW / self.interval)
        middle = round(time / self.interval)
        first = min(max(middle - half, 0), len(means) - 1)
        row = first + int(np.argmax(means[first : middle + half + 1]))
        return float(means[row]), float(heights[row])

    def changes(self, other: "Look") -> tuple[float, float, float, float]:
        """Return relative changes of `COMPARED` from another motion."""
        roll, mean, height, moment = COMPARED.values()
        force, place = self.at(other.time)
        return (
            abs(other.roll - self.roll) / max(self.roll, roll),
            abs(other.mean - force) / max(force, mean),
            abs(other.height - place) / max(place, height),
            abs(other.moment - self.moment) / max(self.moment, moment),
        )

    def parting(self, other: "Look") -> float:
        """Return the largest change of a roll until either ends [rad].

        Near balance, motions part by far more than their largest rolls differ.
        """
        both = min(len(self.rows), len(other.rows))
        rolls = [look.rows[:both, state.rolls(self.units)] for look in (self, other)]
        return float(np.abs(rolls[0] - rolls[1]).max(initial=0.0))

    def spread(self, error: float) -> float:
        """Return the largest change of the height among equal means.

        They are within an error of the largest mean and in its strike; the change is relative.
        """
        means, places = self.strikes
        row, window = round(self.time / self.interval), round(WINDOW / self.interval)
        strike = slice(max(row - window, 0), row + window + 1)
        near = places[strike][means[strike] >= (1.0 - error) * self.mean]
        return float(np.abs(near - self.height).max(initial=0.0) / max(self.height, COMPARED["height"]))

    def heights(self, error: float) -> tuple[float, ...]:
        """Return heights of strikes within an error of the largest mean.

        The height of the largest mean is the first one [m]. Other strikes are at least a window apart.
        """
        means, places = self.strikes[0].copy(), self.strikes[1]
        window, result = round(WINDOW / self.interval), [self.height]
        row = round(self.time / self.interval)
        while True:
            means[max(row - window, 0) : row + window + 1] = -np.inf
            row = int(np.argmax(means))
            if means[row] < (1.0 - error) * self.mean:
                return tuple(result)
            result.append(float(places[row]))


def look_at(answers: Any, rows: Array, interval: float) -> Look:
    """Return the first of motions with its rows."""
    outcome = int(answers.outcome[0])
    roll = min(abs(float(answers.largest_roll[0])), 0.5 * np.pi) if outcome == state.UPRIGHT else 0.5 * np.pi
    mean, height, time, moment = (
        float(values[0]) for values in (answers.mean_50ms, answers.height, answers.mean_time, answers.moment)
    )
    units = answers.unit_rolls.shape[1]
    return Look(outcome, roll, mean, height, time, moment, rows[: int(answers.rows[0])], interval, units)


def strike_errors(
    strikes: Sequence[Strike],
    interval: float,
    pushes: Mapping[str, Array],
    compared: Iterable[Mapping[str, Array]],
) -> list[dict[str, float]]:
    """Return relative errors of strikes by quantity.

    `SAFETY` times the sum of the changes by steps, points and rows, plus the largest change by other limits of what
    belongs to a strike. As the former may be small by chance, it counts as no less than its geometric mean with the
    largest of the strike. Infinite where a motion lacks the strike.

    strikes: of a motion with shorter rows; interval: between rows of the forces [s]; pushes, compared: as of
    `SpaceMotion`.
    """

    def counted(forces: Mapping[str, Array], light: float = LIGHT, apart: float = 1.0) -> tuple[Strike, ...]:
        size = len(next(iter(forces.values())))
        instants: Array = interval * np.arange(size + 1, dtype=np.float64)
        return strikes_of(instants, forces, light=light, apart=apart)

    same, motions = counted(pushes), [counted(forces) for forces in compared]
    limits = [counted(pushes, factor * LIGHT) for factor in (1.0 / LIGHTER, LIGHTER)]
    limits += [counted(pushes, apart=factor) for factor in (1.0 / APART, APART)]
    errors = []
    for strike in strikes:
        changes = [_changes(strike, same, after) for after in motions]
        resolved = SAFETY * np.sum([_changes(strike, [strike], same), *changes], axis=0)
        unsure = np.max([_changes(strike, same, after) for after in limits], axis=0)
        error = np.maximum(np.sqrt(resolved * resolved.max()) + unsure, LEAST_ERROR)
        errors.append(dict(zip(QUANTITIES, error.tolist(), strict=True)))
    return errors


def _changes(strike: Strike, before: Sequence[Strike], after: Sequence[Strike]) -> Array:
    """Return the relative change of each of `QUANTITIES` of the nearest strikes."""
    pair = nearest(before, strike), nearest(after, strike)
    if not all(pair):
        return np.full(len(QUANTITIES), np.inf)
    first, last = (np.array([getattr(one, name) for name in QUANTITIES]) for one in pair)
    return np.abs(last / first - 1.0)
