"""One motion in space with its history, stated errors and lowest wall.

Steps and points are chosen in compiled code, see `solver.space.accuracy`.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from machine_code.compiled import OnCompile, ignore_compiling
from solver import rules
from solver.conditions import Array, Gate
from solver.impact.counting import LIGHT
from solver.impact.strikes import Strike, nearest, strikes_of
from solver.impact.strips import names_of_places
from solver.space import accuracy, state
from solver.space.accuracy import LEAST_ERROR, MARGIN, SAFETY, Choice
from solver.space.solve import (
    NO_PUSH,
    OUTCOMES,
    SCAN,
    SpaceAnswers,
    answers_of,
    call,
    clock_of,
    highest_centres,
    rows_of,
    searched_walls,
    steps_of,
)
from solver.space.strips import joined
from solver.space.vehicle import SpaceVehicle, SpaceWall, fleet_of

UNDECIDED = "undecided"
"""Outcome that changes with step, points, or the height of the wall by `MARGIN`, or of a motion near balance."""

INTERVAL, PHASE = 1e-3, 0.2
"""Time between rows [s], and first step times the rate of the fastest oscillation [rad]."""

LOWEST_WALLS = (0.7 * SCAN, 1.0, 1.0), (0.85 * SCAN, 1.5, 2.0), (SCAN, 2.0, 4.0)
"""Step of the search for a lowest wall [m], with steps and points over those of many motions.

Outcomes may alternate with the height of the wall: searches that try other walls then end apart."""

QUANTITIES = "peak_force", "impulse", "duration"
"""Quantities of a strike whose error is stated."""

LIGHTER, APART = 1.5, 1.2
"""Factors up and down on impulse and time off the wall by which touches belong to one strike."""


@dataclass(frozen=True)
class SpaceMotion:
    """One motion in space.

    Attributes
    ----------
    outcome : str
        One of `OUTCOMES`, or `UNDECIDED`.
    answers : SpaceAnswers
        Answers of this motion, floats in place of arrays.
    history : dict of ndarray, shape (rows,)
        Columns by name: t and the columns of `state` [SI]; those of later units end with "_2" and so on, those of axles
        or hinges with the number of the axle or hinge from 1.
    pushes : dict of ndarray, shape (rows - 1,)
        Mean lateral force between rows on each strip that touches [N].
    compared : tuple of dict
        Such forces with half the steps, half the points, and other ones than halves; empty with a prescribed step.
    step : float
        Time step [s].
    points : float
        Points of the strips over those of many motions [-].
    step_error, strip_error : float
        `SAFETY` times the last change of `COMPARED` by half the steps or half the points, or a quarter of the change
        before it if that is larger; with a chosen step at least `LEAST_ERROR` in all; the second is 0 with a prescribed
        step [-].
    other_error : float
        `SAFETY` times the change by `OTHER_STEPS` and `OTHER_POINTS`, or the change of the height between means
        that are equal within their error if that is larger; 0 with a prescribed step [-].
    heights : tuple of float
        Height of the resultant, and of that of other strikes with a mean within the error of the largest [m].
    """

    outcome: str
    answers: SpaceAnswers
    history: dict[str, Array]
    pushes: dict[str, Array]
    compared: tuple[dict[str, Array], ...]
    step: float
    points: float
    step_error: float
    strip_error: float
    other_error: float
    heights: tuple[float, ...]

    @property
    def error(self) -> float:
        """Stated relative error of largest roll, 50 ms mean and height."""
        return max(self.step_error + self.strip_error, self.other_error)

    @cached_property
    def strikes(self) -> tuple[Strike, ...]:
        """Strikes of the strips, by `pushes`, in order of time."""
        return strikes_of(self.history["t"], self.pushes)

    def strike_errors(self, strikes: Sequence[Strike]) -> list[dict[str, float]]:
        """Return the stated relative errors of strikes by quantity.

        `SAFETY` times the sum of the changes by steps, points and rows, plus the largest change by other limits of what
        belongs to a strike. As the former may be small by chance, it counts as no less than its geometric mean with the
        largest of the strike. Infinite where a motion lacks the strike.

        Parameters
        ----------
        strikes : sequence of Strike
            Of this motion with shorter rows.

        Returns
        -------
        list of dict
            Errors of `QUANTITIES` of each strike.
        """
        t = self.history["t"]

        def counted(
            forces: Mapping[str, Array], light: float = LIGHT, apart: float = 1.0
        ) -> tuple[Strike, ...]:
            size = len(next(iter(forces.values())))
            instants: Array = t[1] * np.arange(size + 1, dtype=np.float64)
            return strikes_of(instants, forces, light=light, apart=apart)

        same, motions = counted(self.pushes), [counted(forces) for forces in self.compared]
        limits = [counted(self.pushes, factor * LIGHT) for factor in (1.0 / LIGHTER, LIGHTER)]
        limits += [counted(self.pushes, apart=factor) for factor in (1.0 / APART, APART)]
        errors = []
        for strike in strikes:
            changes = [_changes(strike, same, after) for after in motions]
            resolved = SAFETY * np.sum([_changes(strike, [strike], same), *changes], axis=0)
            unsure = np.max([_changes(strike, same, after) for after in limits], axis=0)
            error = np.maximum(np.sqrt(resolved * resolved.max()) + unsure, LEAST_ERROR)
            errors.append(dict(zip(QUANTITIES, error.tolist(), strict=True)))
        return errors


def push_names(vehicle: SpaceVehicle) -> tuple[str, ...]:
    """Return the names of a row's strips on both sides.

    They are those of groups in the plane, see `solver.impact.group_names`.
    """
    strips, units = joined(vehicle.strips), range(len(vehicle.units))
    numbers = [[k for k, strip in enumerate(strips) if strip.unit == unit] for unit in units]
    places = [[strips[k].at for k in of_unit] for of_unit in numbers]
    names = names_of_places(places, [unit.length for unit in vehicle.units])
    order = [2 * k + side for of_unit in numbers for side in range(2) for k in of_unit]
    return tuple(name for _, name in sorted(zip(order, names, strict=True)))


def solve_space(
    vehicle: SpaceVehicle,
    wall: SpaceWall,
    speed: float,
    angle: float,
    *,
    interval: float = INTERVAL,
    step: float | None = None,
    points: float = accuracy.POINTS,
    end: float | None = None,
    push: Array = NO_PUSH,
    tolerance: float = accuracy.TOLERANCE,
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
        Largest step [s]; None: chosen, and refined with the points while the error exceeds the tolerance.
    points : float
        Points of the strips over those of many motions, of the first attempt without a step [-].
    end : float or None
        End of the motion [s]; None: when the vehicle no longer leans on the wall or rolls.
    push : ndarray, shape (rows, 5)
        Force on the first unit in each interval: along, across and up [N], its place ahead of the centre of mass along
        the wall and its height [m], NaN for that of the centre.
    tolerance : float
        Tolerance by which step and points are chosen [-].
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
    clock = clock_of(interval, steps_of(fleet, interval, PHASE, step), end, push)
    motions = accuracy.room_for(fleet, rows_of(clock), interval)
    call(
        fleet,
        clock,
        on_compile,
        motions=motions,
        choice=Choice(float(points), not step, tolerance),
    )
    one, *compared = motions.at
    answers = answers_of(fleet, motions.answers[one : one + 1], motions.rolls[one : one + 1])
    Gate().demand(rules.NO_CONTACT, bool(answers.rows[0]), float(fleet.height[0]))
    names = state.column_names(fleet.units.shape[1], fleet.axles.shape[1])
    strips = push_names(vehicle)

    def pushes(k: int) -> dict[str, Array]:
        rows = motions.rows[k, 1 : int(motions.answers[k, state.ROWS_WRITTEN])]
        return dict(zip(strips, rows[:, len(names) :].T, strict=True))

    parts, finer, step_error, strip_error, other_error, undecided, heights = motions.result.tolist()
    table = motions.rows[one, : int(answers.rows[0])]
    instants: Array = interval * np.arange(len(table), dtype=np.float64)
    history = {"t": instants, **dict(zip(names, table.T, strict=False))}
    if vehicle.sensor is None:
        history = {name: column for name, column in history.items() if name not in state.SENSOR}
    return SpaceMotion(
        UNDECIDED if undecided else OUTCOMES[int(answers.outcome[0])],
        SpaceAnswers(*(values[0] for values in answers)),
        history, pushes(one), () if step else tuple(map(pushes, compared)),
        interval / parts, finer, step_error, strip_error, other_error,
        tuple(motions.heights[: int(heights)].tolist()),
    )  # fmt: skip


def lowest_wall(
    vehicle: SpaceVehicle,
    wall: SpaceWall,
    speed: float,
    angle: float,
    *,
    on_compile: OnCompile = ignore_compiling,
) -> tuple[float, float]:
    """Return the lowest wall that keeps a vehicle upright, with its error.

    Parameters
    ----------
    vehicle, wall : SpaceVehicle, SpaceWall
        With floats; the height of the wall is not used.
    speed, angle : float
        Speed [m/s] and angle [rad] before the impact.
    on_compile : callable
        See `solve_space`.

    Returns
    -------
    tuple of float
        Height, NaN where a wall as high as the highest centre of mass does not suffice, and error: `SAFETY` times its
        range by steps and points, or up to the next tried wall above one on which the vehicle almost tips [m]; infinite
        where the highest centre of mass is within it, or only some of the searches succeed.

    Raises
    ------
    RigidBodyError
        As `solve_space`.
    """
    fleet = fleet_of(vehicle, wall, speed, angle)
    walls = np.array([searched_walls(fleet, *search, on_compile)[0] for search in LOWEST_WALLS])
    height, unstated = float(walls[-1, 0]), np.isnan(walls[:, 0])
    if unstated.any():
        return height, 0.0 if unstated.all() else math.inf
    error, above = MARGIN + SAFETY * float(np.ptp(walls[:, 0])), height - float(highest_centres(fleet)[0])
    if above + error > 0.0:
        return (math.nan, 0.0) if above > error else (height, math.inf)
    almost = float(walls[:, 1].max())
    return height, max(error, almost + SCAN - height if almost else 0.0)


def _changes(strike: Strike, before: Sequence[Strike], after: Sequence[Strike]) -> Array:
    """Return the relative change of each of `QUANTITIES` of the nearest strikes."""
    pair = nearest(before, strike), nearest(after, strike)
    if not all(pair):
        return np.full(len(QUANTITIES), np.inf)
    first, last = (np.array([getattr(one, name) for name in QUANTITIES]) for one in pair)
    return np.abs(last / first - 1.0)
