"""One motion in space, refined until its error is small.

Steps and points of the strips are halved apart from each other. As the change by half of either may be small by
chance, a further motion has other steps and points than halves. An outcome is decided where all these motions, and
those with half the steps on walls a little lower and higher, have the same, and no two of them part near balance.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

from machine_code.compiled import OnCompile, ignore_compiling
from solver import rules
from solver.conditions import Array, Gate
from solver.impact.strikes import Strike, strikes_of
from solver.impact.strips import names_of_places
from solver.space import state
from solver.space.looks import LEAST_ERROR, SAFETY, Look, look_at, strike_errors
from solver.space.solve import (
    NO_PUSH,
    OUTCOMES,
    SCAN,
    SpaceAnswers,
    highest_centres,
    run,
    searched_walls,
    steps_of,
    with_points,
)
from solver.space.strips import joined
from solver.space.vehicle import SpaceVehicle, SpaceWall, fleet_of

UNDECIDED = "undecided"
"""Outcome that changes with step, points, or the height of the wall by `MARGIN`, or of a motion near balance."""

BALANCE = 0.25 * math.pi
"""Angle from balance to a roll of 90 deg, about [rad]: motions whose rolls part by it over `SAFETY` may end apart."""

INTERVAL, PHASE = 1e-3, 0.2
"""Time between rows [s], and first step times the rate of the fastest oscillation [rad]."""

TOLERANCE, REFINEMENTS, POINTS, MOST_POINTS = 1e-3, 6, 2, 8
"""Largest error, most refinements of step or points, first and most points of a strip over those of many motions."""

FORMER, UNRESOLVED = 0.25, 0.1
"""Part of the change before the last that counts, as in a scheme of second order, and the change from which a step does
not resolve the motion and does not count. A single change may be small by chance."""

OTHER_STEPS, OTHER_POINTS = 2.0 / 3.0, 0.75
"""Steps and points of the further motion over those of the answer."""

LOWEST_WALLS = (0.7 * SCAN, 1.0, 1.0), (0.85 * SCAN, 1.5, 2.0), (SCAN, 2.0, 4.0)
"""Step of the search for a lowest wall [m], with steps and points over those of many motions.

Outcomes may alternate with the height of the wall: searches that try other walls then end apart."""

MARGIN = 2e-3
"""Change of the height of the wall within which the outcome must be the same, and least error of a lowest wall [m]."""


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
        """Return the stated errors of strikes.

        Parameters
        ----------
        strikes : sequence of Strike
            Of this motion with shorter rows.

        Returns
        -------
        list of dict
            Relative errors of `looks.QUANTITIES` of each strike, see `looks.strike_errors`.
        """
        return strike_errors(strikes, float(self.history["t"][1]), self.pushes, self.compared)


def column_names(units: int, axles: int) -> tuple[str, ...]:
    """Return the column names of a row."""
    ends = ("", *(f"_{unit}" for unit in range(2, units + 1)))
    poses = [f"{name}{end}" for end in ends for name in state.POSE]
    wheels = [f"{name}_{axle}" for axle in range(1, axles + 1) for name in state.WHEELS]
    pulls = [f"{name}_{hinge}" for hinge in range(1, units) for name in state.HINGE]
    return (*state.FORCES, *state.SENSOR, *state.WORKS, *state.ENERGIES, *poses, *wheels, *pulls)


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
    points: float = POINTS,
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
    parts = int(steps_of(fleet, interval, PHASE, step)[0])

    @cache
    def solved(parts: int, points: float, higher: float = 0.0) -> tuple[SpaceAnswers, Array, Look]:
        changed = with_points(fleet, points)._replace(height=fleet.height + higher)
        answers, rows = run(changed, interval, np.array([parts]), end, push, on_compile, with_rows=True)
        Gate().demand(rules.NO_CONTACT, bool(answers.rows[0]), float(fleet.height[0]))
        return answers, rows, look_at(answers, rows, interval)

    def look(*of: float) -> Look:
        return solved(*of)[2]

    strip_error, other_error, parting, outcomes, compared = 0.0, 0.0, 0.0, set[int](), list[Look]()
    if step:
        step_error = SAFETY * max(look(parts, points).changes(look(max(parts // 2, 1), points)))
    else:
        parts, points, step_error, strip_error = _refined(look, parts, points, tolerance)
    answers, rows, one = solved(parts, points)
    if not step:
        further, half = look(max(1, round(OTHER_STEPS * parts)), OTHER_POINTS * points), max(parts // 2, 1)
        compared = [look(half, points), look(parts, 0.5 * points), further]
        walls = [look(half, points, higher) for higher in (-MARGIN, MARGIN)]
        of_mean = SAFETY * max(one.changes(motion)[1] for motion in compared)
        other_error = max(SAFETY * max(one.changes(further)), one.spread(of_mean))
        outcomes |= {motion.outcome for motion in (*compared, *walls)}
        parting = SAFETY * max(one.parting(motion) for motion in compared)
        step_error = max(step_error, LEAST_ERROR - strip_error)
    error = max(step_error + strip_error, other_error)
    table, names = rows[: int(answers.rows[0])], column_names(fleet.units.shape[1], fleet.axles.shape[1])
    strips = push_names(vehicle)

    def pushes(look: Look) -> dict[str, Array]:
        return dict(zip(strips, look.rows[1:, len(names) :].T, strict=True))

    instants: Array = interval * np.arange(len(table), dtype=np.float64)
    history = {"t": instants, **dict(zip(names, table.T, strict=False))}
    if vehicle.sensor is None:
        history = {name: column for name, column in history.items() if name not in state.SENSOR}
    return SpaceMotion(
        UNDECIDED if outcomes - {one.outcome} or parting > BALANCE else OUTCOMES[one.outcome],
        SpaceAnswers(*(values[0] for values in answers)),
        history, pushes(one), tuple(map(pushes, compared)),
        interval / parts, points, step_error, strip_error, other_error, one.heights(error),
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
        Height as of `lowest_walls` and error: `SAFETY` times its range by steps and points, or up to the next tried
        wall above one on which the vehicle almost tips [m]; infinite where the highest centre of mass is within it, or
        only some of the searches succeed.

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


def _refined(
    look: Callable[..., Look], parts: int, points: float, tolerance: float
) -> tuple[int, float, float, float]:
    """Refine steps or points, whichever have the larger error.

    Returns the steps of an interval, the points, and the errors by both.
    """
    parts, former, errors = max(parts, 2), [math.inf, math.inf], [math.inf, 0.0]
    for attempt in range(REFINEMENTS + 1):
        if attempt and errors[0] < errors[1]:
            points, former[0] = 2.0 * points, math.inf
        elif attempt:
            parts, former[1] = 2 * parts, math.inf
        one, coarse = look(parts, points), (look(parts // 2, points), look(parts, 0.5 * points))
        for k, coarser in enumerate(coarse):
            before = FORMER * former[k] if former[k] < UNRESOLVED else 0.0
            former[k] = max(one.changes(coarser))
            errors[k] = SAFETY * max(former[k], before)
        is_same = all(coarser.outcome == one.outcome for coarser in coarse)
        if (sum(errors) <= tolerance and is_same) or (errors[0] < errors[1] and points >= MOST_POINTS):
            break
    return parts, points, errors[0], errors[1]
