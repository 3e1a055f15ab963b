"""Roll of a vehicle over a low wall.

The wall is lower than the centre of mass. The body is rigid, in the plane across the wall: its centre of mass is at
the height z, its roll phi positive towards the wall. Wheels are points of the body, half the track to either side of
the centre line and on the ground at rest, each over a
unilateral spring of the ground; lever a of each about the centre of mass, height y above the ground at rest:

    load        N = k max(m g/2k - y, 0) max(1 - c y', 0), damped in proportion to the load (Hunt and Crossley 1975)
    friction    T of the wall's face, up on a side that slides down; Coulomb's in the direction of sliding
    heave       m z'' = N_near + N_far - m g + T
    roll        I phi'' = F (z - h) + N_near a_near + N_far a_far - T d

F is the wall's force, horizontal at its top, h, from a planar impact; the wheels slide freely across the wall.
Positions advance by half a step before and half a step after the forces: of second order, and for springs alone
symplectic. SI units and radians.

References
----------
.. [1] Hunt and Crossley, Coefficient of restitution interpreted as damping in vibroimpact, J. Appl. Mech. 42(2), 1975.
"""

import math
from dataclasses import dataclass, fields

import numpy as np

from fem.laws.contact_forces import coulomb_force
from machine_code.compiled import OnCompile, compile_once, compiled, ignore_compiling
from solver import rules
from solver.body import GRAVITY
from solver.conditions import Array, Gate, Number, number, one

DAMPING_RATIO = 0.15
"""Assumed damping of the suspension in heave, relative to critical."""

TIPPED = 0.5 * math.pi
"""Largest roll of a vehicle that tips; its fall is not computed [rad]."""

ONE, MANY, VERDICTS = 4e-3, 2e-2, 4e-2
"""Step of one roll, of many, and of many limits of height, times the rate of the fastest oscillation [rad].

With them the limits change by less than `RESOLUTION`.
"""

TOLERANCE, HALVINGS = 1e-5, 4
"""Largest change of one largest roll with half the step, and number of halvings."""

FREE, MOST_STEPS = 10.0, 30_000_000
"""Longest duration of a roll after the force [s], and largest number of steps."""

FINE, COARSE, RESOLUTION, FAR_ABOVE = 0.02, 0.1, 1e-3, 5.0
"""Scan of levers, centre of mass over wall.

Steps for one vehicle and for many, resolution of the bisection [m], and largest lever of a centre over the track.
"""

AT_REST = (0.0, 0.0, 0.0, 0.0)

MASS, CENTRE, INERTIA, TRACK, SPRING, DAMPING, WIDTH, FRICTION, SPEED, WALL = range(10)
"""Columns of a body in the compiled code.

As in `RollingVehicle`, but damping is that of the load per speed [s/m]; height of the wall.
"""

ROW = ("height", "roll", "v_z", "rate", "load_near", "load_far", "wall_work", "friction_work", "damping_work")
"""Columns of a row.

Centre of mass [m], rad, m/s, rad/s, wheel loads of the near and the far side of the wall at the latest half step [N],
works on the body [J].
"""

LARGEST, LOWEST, HIGHEST = range(3)
"""Answers: largest roll, lowest wall, highest centre of mass."""


@dataclass(frozen=True)
class RollingVehicle:
    """Vehicles that roll, floats or broadcast arrays.

    Parameters
    ----------
    mass : float or ndarray
        m [kg].
    centre_height : float or ndarray
        Of the centre of mass above the ground at rest [m].
    roll_inertia : float or ndarray
        About the centre of mass, I [kg m^2].
    track : float or ndarray
        Between the wheels of both sides [m].
    suspension : float or ndarray
        Vertical stiffness of the wheels of one side, k [N/m].
    damping_ratio : float or ndarray
        Of the heave on both sides, to critical [-].
    width : float or ndarray
        Between the side that the wall pushes and the far one [m]; counts with friction alone.
    friction : float or ndarray
        Of the wall's face [-].
    speed : float or ndarray
        At which the side slides along the wall [m/s]: friction acts against this and the sliding up or down together.

    Raises
    ------
    RigidBodyError
        Unless the first five are positive and finite, and the others 0 or more and finite.
    """

    mass: Number
    centre_height: Number
    roll_inertia: Number
    track: Number
    suspension: Number
    damping_ratio: Number = DAMPING_RATIO
    width: Number = 0.0
    friction: Number = 0.0
    speed: Number = 0.0

    def __post_init__(self) -> None:
        for position, field in enumerate(fields(self)):
            value, gate = number(field.name, getattr(self, field.name)), Gate()
            demand = gate.positive if position <= SPRING else gate.not_negative
            demand(rules.ROLLING[field.name], value)
            object.__setattr__(self, field.name, value)


@dataclass(frozen=True)
class RollMotion:
    """One roll, from `solve_roll`.

    Attributes
    ----------
    tips : bool
        True if the centre of mass comes to lie beyond the wheels of the wall's side and rolls on: nothing brings the
        vehicle back from there, and it is not followed any further.
    largest_roll : float
        While the force acts and up to the first turning after it [rad]; `TIPPED` where it tips.
    interval : float
        Between rows [s].
    rows : ndarray, shape (rows, columns)
        From 0 until it has turned after the force and both sides' wheels are loaded; columns as of `ROW` [SI].
    step : float
        [s].
    error : float
        Relative change of the largest roll with twice the step; infinite where one of both tips [-].
    """

    tips: bool
    largest_roll: float
    interval: float
    rows: Array
    step: float
    error: float

    def lifted(self) -> list[tuple[str, float, float]]:
        """Return the intervals with wheels off the ground, in order.

        Side, "near" or "far", start and end [s].
        """
        intervals = []
        for side in ("near", "far"):
            load = self.rows[:, ROW.index(f"load_{side}")]
            edges = np.flatnonzero(np.diff(np.concatenate([[0], load <= 0.0, [0]]))).reshape(-1, 2)
            intervals += [
                (side, self.interval * first, self.interval * last) for first, last in edges.tolist()
            ]
        return sorted(intervals, key=lambda entry: entry[1])


@compiled
def answer(bodies, force, interval, parts, start, question, scan, rows, outcome):
    """Compute the answer of each body.

    outcome, shape (n, 2): value, and number of rows written; bodies, shape (n, 10); force, shape (n or 1, intervals);
    parts, shape (n,): steps of an interval; start: height over that at rest, roll, and their rates.
    """
    for i in range(bodies.shape[0]):
        body, push = bodies[i], force[i if force.shape[0] > 1 else 0]
        if question == LARGEST:
            outcome[i, 0], outcome[i, 1] = _follow(body, push, interval, parts[i], start, False, rows)
        elif question == LOWEST:
            outcome[i, 0] = body[CENTRE] - _largest_lever(body, push, interval, parts[i], start, WALL, scan)
        else:
            outcome[i, 0] = body[WALL] + _largest_lever(body, push, interval, parts[i], start, CENTRE, scan)


@compiled
def _largest_lever(body, push, interval, parts, start, varied, scan):
    """Return the largest lever of a body that does not tip [m].

    Lever: centre of mass over wall, varied by a lower wall or a higher centre.
    """
    held, tipping, centre, wall = 0.0, np.inf, body[CENTRE], body[WALL]
    most = centre if varied == WALL else FAR_ABOVE * body[TRACK]
    while tipping - held > RESOLUTION:
        lever = min(held + scan, 0.5 * (held + tipping))
        if lever >= most:
            return most
        body[varied] = centre - lever if varied == WALL else wall + lever
        largest, _ = _follow(body, push, interval, parts, start, True, np.zeros((0, 0)))
        if largest < TIPPED:
            held = lever
        else:
            tipping = lever
    return held


@compiled
def _follow(body, push, interval, parts, start, is_verdict, rows):
    """Integrate a body to its verdict or return.

    Returns the largest roll [rad], `TIPPED` where it tips, and the number of rows written. Without a verdict it ends
    when the body stands on its wheels again.
    """
    h, weight, half = interval / parts, body[MASS] * GRAVITY, 0.5 * body[TRACK]
    z, roll, v, w, rate_v, rate_w = body[CENTRE] + start[0], start[1], start[2], start[3], 0.0, 0.0
    largest, rising, turned, wall_work, friction_work, damping_work = 0.0, False, False, 0.0, 0.0, 0.0
    last, near, far = push.size, 0.5 * weight, 0.5 * weight
    while last > 0 and push[last - 1] == 0.0:
        last -= 1
    for k in range(last + int(FREE / interval)):
        if k < rows.shape[0]:
            rows[k] = (z, roll, v, w, near, far, wall_work, friction_work, damping_work)
        if k >= last:
            turned = turned or (rising and w <= 0.0)
            rising = w > 0.0
            if is_verdict and _energy(body, z, roll, v, w) < weight * np.hypot(body[CENTRE], half):
                return largest, k
            if turned and near > 0.0 and far > 0.0:
                return largest, k + 1
        force = push[k] if k < last else 0.0
        for _ in range(parts):
            z, roll = z + 0.5 * h * v, roll + 0.5 * h * w
            s, c = np.sin(roll), np.cos(roll)
            if body[CENTRE] * s > half * c and w > 0.0:
                return TIPPED, k + 1
            mean_v, mean_w, lever = v + 0.5 * h * rate_v, w + 0.5 * h * rate_w, z - body[WALL]
            near, near_arm, near_spring = _wheels(body, -half, z, s, c, mean_v, mean_w)
            far, far_arm, far_spring = _wheels(body, half, z, s, c, mean_v, mean_w)
            rate_v = (near + far) / body[MASS] - GRAVITY
            rate_w = (force * lever + near * near_arm + far * far_arm) / body[INERTIA]
            drag, arm = 0.0, 0.0
            if body[FRICTION] > 0.0 and force > 0.0:
                arm = -(0.5 * body[WIDTH] - lever * s) / c
                drag = _drag(body, force, arm, v, w, rate_v, rate_w, h)
                rate_v, rate_w = rate_v + drag / body[MASS], rate_w + drag * arm / body[INERTIA]
            mean_v, mean_w = v + 0.5 * h * rate_v, w + 0.5 * h * rate_w
            v, w = v + h * rate_v, w + h * rate_w
            z, roll = z + 0.5 * h * v, roll + 0.5 * h * w
            largest = max(largest, roll)
            wall_work += h * force * lever * mean_w
            friction_work += h * drag * (mean_v + arm * mean_w)
            damping_work += h * (near - near_spring) * (mean_v + near_arm * mean_w)
            damping_work += h * (far - far_spring) * (mean_v + far_arm * mean_w)
    return largest, last


@compiled
def _wheels(body, side, z, s, c, v, w):
    """Return load and lever of the wheels of a side.

    side: distance from the centre line; the third value is the load of the spring alone [N].
    """
    arm = side * c + body[CENTRE] * s
    depth = 0.5 * body[MASS] * GRAVITY / body[SPRING] - (z + side * s - body[CENTRE] * c)
    spring = body[SPRING] * max(depth, 0.0)
    return spring * max(1.0 - body[DAMPING] * (v + arm * w), 0.0), arm, spring


@compiled
def _drag(body, force, arm, v, w, rate_v, rate_w, h):
    """Return the upward friction of the wall [N].

    It would stop the side by the end of the step, but is limited to the component of Coulomb's friction along the
    mean sliding up or down in the step, including the change of that by the friction.
    """
    slip, gain = v + arm * w, h * (rate_v + arm * rate_w)
    lightness = h * (1.0 / body[MASS] + arm * arm / body[INERTIA])
    mean = abs(slip + 0.5 * gain)
    sliding = np.hypot(mean, body[SPEED])
    most = body[FRICTION] * force * mean / (sliding + 0.5 * lightness * body[FRICTION] * force)
    return coulomb_force(-(slip + gain) / lightness, most)


@compiled
def _energy(body, z, roll, v, w):
    """Return kinetic energy, and that of gravity and springs [J].

    Above m g times the distance of wheels and centre of mass the body can tip.
    """
    total = 0.5 * (body[MASS] * v * v + body[INERTIA] * w * w) + body[MASS] * GRAVITY * z
    for side in (-0.5, 0.5):
        spring = _wheels(body, side * body[TRACK], z, np.sin(roll), np.cos(roll), 0.0, 0.0)[2]
        total += 0.5 * spring * spring / body[SPRING]
    return total


def _bodies(vehicle: RollingVehicle, wall_height: Number) -> tuple[Array, tuple[int, ...]]:
    """Return the columns of the compiled code and the common shape.

    Columns: shape (n, 10).
    """
    wall = number("wall_height", wall_height)
    Gate().positive(rules.ROLLING["wall_height"], wall)
    columns = np.broadcast_arrays(*(getattr(vehicle, field.name) for field in fields(vehicle)), wall)
    bodies = np.stack([np.ravel(column) for column in columns], axis=-1).astype(float)
    critical = np.sqrt(2.0 * bodies[:, SPRING] / bodies[:, MASS])
    bodies[:, DAMPING] *= 2.0 * critical / GRAVITY
    return bodies, columns[0].shape


def _parts(bodies: Array, interval: float, intervals: int, phase: float, step: float | None = None) -> Array:
    """Return the steps of an interval, shape (n,).

    From the step, or from the fastest oscillation on the springs.
    """
    reach2 = bodies[:, CENTRE] ** 2 + 0.25 * bodies[:, TRACK] ** 2
    rate = np.sqrt(2.0 * bodies[:, SPRING] * (1.0 / bodies[:, MASS] + reach2 / bodies[:, INERTIA]))
    parts = np.ceil(
        interval * rate / phase if step is None else interval / step * np.full_like(rate, 1.0 - 1e-12)
    )
    few = parts * (intervals + FREE / interval) <= MOST_STEPS
    Gate().demand(rules.ROLL_STEPS, few.squeeze(), bodies[:, SPRING].squeeze(), rate=rate.squeeze())
    return parts.astype(np.int64)


def _answered(
    vehicle: RollingVehicle, wall_height: Number, force: Array, interval: float, question: int
) -> Array:
    """Return the answers for each vehicle, in their common shape."""
    bodies, shape = _bodies(vehicle, wall_height)
    push = np.ascontiguousarray(np.atleast_2d(force), dtype=float)
    scan, phase = (FINE, MANY) if len(bodies) == 1 else (COARSE, MANY if question == LARGEST else VERDICTS)
    outcome, parts = np.empty((len(bodies), 2)), _parts(bodies, interval, push.shape[1], phase)
    answer(bodies, push, interval, parts, AT_REST, question, scan, np.zeros((0, len(ROW))), outcome)
    return outcome[:, 0].reshape(shape)


def largest_rolls(vehicle: RollingVehicle, wall_height: Number, force: Array, interval: float) -> Array:
    """Return the largest roll of each vehicle.

    Values of vehicles and the wall's height broadcast.

    Parameters
    ----------
    vehicle : RollingVehicle
        One or many.
    wall_height : float or ndarray
        Of the wall's top, h [m].
    force : ndarray, shape (intervals,) or (n, intervals)
        Mean force of the wall in each interval [N], on all n or on each; none after that.
    interval : float
        [s].

    Returns
    -------
    ndarray
        While the force acts and up to the first turning after it [rad]; `TIPPED` where it tips.

    Raises
    ------
    RigidBodyError
        For a wall without height, and springs too stiff to be followed.
    """
    return _answered(vehicle, wall_height, force, interval, LARGEST)


def lowest_walls(vehicle: RollingVehicle, force: Array, interval: float) -> Array:
    """Return the heights of the lowest walls that prevent tipping [m].

    To `RESOLUTION`, 0 where any wall does; all higher walls prevent it, too. Arguments are those of `largest_rolls`.
    """
    return _answered(vehicle, 1.0, force, interval, LOWEST)


def highest_centres(vehicle: RollingVehicle, wall_height: Number, force: Array, interval: float) -> Array:
    """Return the heights of the highest centres of mass without tipping [m].

    To `RESOLUTION`; no lower centre tips. Arguments are those of `largest_rolls`; the vehicle's centre is ignored. At
    most `FAR_ABOVE` tracks above the wall.
    """
    return _answered(vehicle, wall_height, force, interval, HIGHEST)


def solve_roll(
    vehicle: RollingVehicle,
    wall_height: float,
    force: Array,
    interval: float,
    step: float | None = None,
    start: tuple[float, float, float, float] = AT_REST,
    on_compile: OnCompile = ignore_compiling,
) -> RollMotion:
    """Compute one roll with its motion.

    Its error follows from a run with twice the step.

    Parameters
    ----------
    vehicle : RollingVehicle
        One.
    wall_height : float
        Of the wall's top, h [m].
    force : ndarray, shape (intervals,)
        Mean force of the wall in each interval [N]; none after that.
    interval : float
        [s].
    step : float or None
        At most [s]; None: chosen, and halved up to `HALVINGS` times where that changes the roll by more than
        `TOLERANCE`.
    start : tuple of float
        Height of the centre of mass over that at rest [m], roll [rad], and their rates [m/s], [rad/s].
    on_compile : callable
        Called when code is compiled, see `machine_code.compiled.compile_once`.

    Returns
    -------
    RollMotion
        With a row an interval.

    Raises
    ------
    RigidBodyError
        As `largest_rolls`.
    """
    bodies, _ = _bodies(vehicle, one("wall_height", wall_height))
    push = np.ascontiguousarray(force, dtype=float)[None]
    parts = _parts(bodies, interval, push.size, ONE, step)
    rows, outcome = np.empty((push.size + int(FREE / interval) + 1, len(ROW))), np.empty((1, 2))

    def run(parts: Array) -> tuple[float, int]:
        arguments = bodies, push, interval, parts, start, LARGEST, FINE, rows, outcome
        compile_once(lambda: answer(*arguments), answer, *arguments, on_compile=on_compile)
        return float(outcome[0, 0]), int(outcome[0, 1])

    coarse, _ = run(np.maximum(parts // 2, 1))
    for _ in range(1 if step else HALVINGS + 1):
        largest, written = run(parts)
        tips = largest == TIPPED
        change = 0.0 if largest == coarse else abs(coarse / largest - 1.0)
        error = change if tips == (coarse == TIPPED) else math.inf
        if error <= TOLERANCE:
            break
        coarse, parts = largest, 2 * parts
    return RollMotion(tips, largest, interval, rows[:written], interval / int(parts[0]), error)
