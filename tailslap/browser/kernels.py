"""Compiled motion of a page with its forces."""

import math
from typing import NamedTuple

import numpy as np

from machine_code.compiled import compact, compiled
from postprocess.signals.compiled_filters import centred_means, filter_both_ways
from postprocess.signals.filters import settling_samples
from solver import stage_1, stage_2, stage_3
from solver.conditions import SCALAR
from solver.impact.accuracy import solve_sample
from solver.impact.instants import interpolate
from solver.impact.train import ROUNDING
from solver.impact.tyres import set_axle_loads
from solver.rules import MIN_INERTIA
from tailslap.case.corner.rigid_stages import MEAN_WINDOW
from tailslap.case.impact.rigid_motion import row_interval

POSSIBLE, PLATEAU, LINE, UNLOADING, HARDENING, CENTRE, INERTIA, AXLE, AXLE_LOAD, ENDS = range(10)
"""Reasons why there is no impact: rules of the theory, and ends of a range beyond the bounds of its key."""


MORE_ROWS = 3
"""Verdict on a motion for whose rows there is too little room, beside those of `accuracy.SOLVED`."""


class Parts(NamedTuple):
    """Structure of trains, by numbers of their quantities.

    units, shape (units, 7): length, width, mass, centre of mass, yaw inertia, hitch and kingpin; computed, shape
    (units, 2): 1 where centre and inertia follow from the others; axles, shape (axles, 3): position, friction and
    cornering; points, shape (points, 9): both ends, inset and law of their strip; places, shape (points, 3): side,
    place and weight on a line, whose weight is 0 for a point; common, shape (3,): speed, angle, friction; copies,
    shape (copies, 2): quantities of a further corner, and those of the first.
    """

    units: np.ndarray
    computed: np.ndarray
    axles: np.ndarray
    points: np.ndarray
    places: np.ndarray
    common: np.ndarray
    copies: np.ndarray


class Motion(NamedTuple):
    """Motion of a page at even instants.

    integrals, rates: see `instants.interpolate`; times, shape (instants,); values, shape (instants, columns); integral:
    workspace; curves, shape (curves, instants): force, its means, and low-pass filters of it [N]; widths: of the means
    [s]; filters, shape (filters, 3): see `LowPass`; padded: workspace; peaks: maxima of the curves; strike_means, shape
    (strikes,): largest 50 ms mean about each strike [N].
    """

    integrals: np.ndarray
    rates: np.ndarray
    times: np.ndarray
    values: np.ndarray
    integral: np.ndarray
    curves: np.ndarray
    widths: np.ndarray
    filters: np.ndarray
    padded: np.ndarray
    peaks: np.ndarray
    strike_means: np.ndarray
    impulse: int
    counted: int


class Paper(NamedTuple):
    """Inputs of the paper's method, by numbers of their quantities.

    columns, shape (8,): speed, angle, friction and restitution of Stage 1, length, width and mass of the vehicle,
    duration of the strike; -1 without the method. sign: -1 by the paper's convention of restitution, 1 by Newton's.
    mean, shape (1,): result, the 50 ms mean [N], NaN without one.
    """

    columns: np.ndarray
    sign: float
    mean: np.ndarray


class Corner(NamedTuple):
    """Rectangle about its corner, as of `RectangularBody`."""

    corner_angle: float
    corner_radius: float
    mass: float


@compact
def solve_motion(values, parts, case, outcome, motion, paper):
    """Solve the impact of these quantities, shape (quantities, 1).

    Returns the reason why there is none with its item, the verdict, and the number of instants.
    """
    complete(values, parts)
    paper.mean[0] = paper_mean(values, paper.columns, paper.sign) if paper.columns[0] >= 0 else np.nan
    reason, item = assemble(values, parts, case[0], case[1], case[2], 0)
    if reason != POSSIBLE:
        return reason, item, 0, 0
    solve_sample((case[0], case[1], case[2][0], case[3], case[4], case[5]), outcome, 0, outcome.rows[0])
    if outcome.verdict[0] != 0:
        return reason, item, outcome.verdict[0], 0
    if case[4].reached[0] > float(outcome.rows.shape[1] - 1) * outcome.interval[0]:
        return reason, item, MORE_ROWS, 0
    return reason, item, 0, sample(outcome, case[4].reached[0], motion)


@compact
def paper_mean(values, columns, sign):
    """Return the 50 ms mean of the paper's tail-slap [N].

    NaN where the stages have no solution, as their rules demand.
    """
    speed, theta = values[columns[0], 0], values[columns[1], 0]
    mu, e = values[columns[2], 0], values[columns[3], 0]
    length, width, mass = values[columns[4], 0], values[columns[5], 0], values[columns[6], 0]
    gamma, radius = math.atan2(width, length), math.hypot(length, width) / 2.0
    phi = theta + gamma
    if not (theta > 0.0 and phi < 0.5 * math.pi and mu < math.cos(phi) / math.sin(phi)):
        return np.nan
    corner = Corner(gamma, radius, mass)
    omega, v_p, _ = stage_1.after_impulse(SCALAR, corner, speed, theta, mu, 1.0 + sign * e)
    if not (omega > 0.0 and (mu == 0.0 or v_p > 0.0)):
        return np.nan
    start = stage_2.Start(stage_2.Path(gamma, theta, mu), mass, radius, omega, v_p)
    _, _, _, _, v_gy, v_p_end, _, _, _, _, _ = stage_2.numbers_at(SCALAR, SCALAR, start, 0.0, 0.0)
    if not (mu == 0.0 or v_p_end >= 0.0):
        return np.nan
    duration = values[columns[7], 0]
    return stage_3.triangle_mean(2.0 * mass * abs(v_gy) / duration, duration, MEAN_WINDOW)


@compiled
def sample(outcome, end, motion):
    """Fill the motion at even instants, and return their number."""
    rows, interval, strikes = outcome.rows[0], outcome.interval[0], outcome.strikes[0]
    shortest, latest = np.inf, -np.inf
    for _ in range(motion.counted):  # in order of their starts
        start, duration = np.inf, np.inf
        for s in range(strikes.shape[0]):
            if strikes[s, 4] > 0.0 and strikes[s, 1] > latest and strikes[s, 1] < min(start, end):
                start, duration = strikes[s, 1], min(strikes[s, 2], end) - strikes[s, 1]
        shortest, latest = min(shortest, duration), start
    count = max(2, int(np.ceil(end / row_interval(shortest, end)))) + 1
    count = min(count, motion.times.size)
    step = end / float(count - 1)
    for k in range(count):
        motion.times[k] = float(k) * step
    motion.times[count - 1] = end
    interpolate(rows, interval, end, motion.integrals, motion.rates, motion.times, motion.values, count)
    fill_forces(motion, count, step)
    for s in range(strikes.shape[0]):
        largest = 0.0
        for k in range(1, count):
            if motion.times[k] >= strikes[s, 1] and motion.times[k] - step <= strikes[s, 2]:
                largest = max(largest, motion.curves[motion.widths.size, k])
        motion.strike_means[s] = largest
    return count


@compiled
def fill_forces(motion, count, step):
    """Fill the lateral force, mean since the instant before, and filtered.

    As `postprocess.signals.filters.force_curves` does.
    """
    force = motion.curves[0]
    force[0] = 0.0
    for k in range(1, count):
        before, after = motion.values[k - 1, motion.impulse], motion.values[k, motion.impulse]
        force[k] = (after - before) / (motion.times[k] - motion.times[k - 1])
    for c in range(motion.widths.size):
        centred_means(force, count, 0.5 * motion.widths[c] / step, motion.integral, motion.curves[c + 1])
    for c in range(motion.filters.shape[0]):
        curve = motion.curves[c + 1 + motion.widths.size]
        settling = settling_samples(motion.filters[c, 0], step)
        padding = min(settling, (motion.padded.size - count) // 2)
        corner = math.tan(motion.filters[c, 1] * step) / motion.filters[c, 2]
        filter_both_ways(force, count, padding, corner, motion.padded, curve)
        last = 1 + max(0, count - 2 - settling)
        for k in range(last, count if force[count - 1] != 0.0 else last):  # later forces would change these
            curve[k] = curve[last]
    for c in range(motion.curves.shape[0]):
        motion.peaks[c] = 0.0
        for k in range(1, count):
            motion.peaks[c] = max(motion.peaks[c], motion.curves[c, k])


@compiled
def complete(values, parts):
    """Set quantities of the scene that follow from others."""
    for c in range(parts.copies.shape[0]):
        values[parts.copies[c, 0], 0] = values[parts.copies[c, 1], 0]
    for u in range(parts.units.shape[0]):
        columns = parts.units[u]
        length, width, mass = values[columns[0], 0], values[columns[1], 0], values[columns[2], 0]
        if parts.computed[u, 0] == 1:
            values[columns[3], 0] = 0.5 * length
        if parts.computed[u, 1] == 1:
            values[columns[4], 0] = mass * (length**2 + width**2) / 12.0


@compiled
def assemble(values, parts, train, tyres, start, i):
    """Fill sample i of trains at first touch.

    Returns the reason why it is impossible with its item, a point, unit or axle.
    """
    for p in range(parts.points.shape[0]):
        reason = set_law(values, parts, train, p, i)
        if reason != POSSIBLE:
            return reason, p
    for u in range(parts.units.shape[0]):
        reason = set_body(values, parts, train, u, i)
        if reason != POSSIBLE:
            return reason, u
    set_touch(values, parts, train, start, i)
    for a in range(tyres.unit.size):
        body, axle = parts.units[tyres.unit[a]], parts.axles[a]
        position = values[axle[0], i]
        if not (position >= 0.0 and position <= values[body[0], i]):
            return AXLE, a
        tyres.along[a, i] = values[body[3], i] - position
        tyres.friction[a, i], tyres.cornering[a, i] = values[axle[1], i], values[axle[2], i]
    set_axle_loads(train.mass, train.hitch, train.kingpin, tyres.unit, tyres.along, tyres.load, i)
    for a in range(tyres.unit.size):
        if not tyres.load[a, i] >= 0.0:
            return AXLE_LOAD, a
    return POSSIBLE, 0


@compiled
def set_law(values, parts, train, p, i):
    """Fill place and law of a point.

    Returns the reason why it is impossible.
    """
    column, place = parts.points[p], parts.places[p]
    begin, end = values[column[0], i], values[column[1], i]
    body = parts.units[train.unit[p]]
    length = place[2] * (end - begin) if place[2] > 0.0 else 1.0
    train.along[p, i] = values[body[3], i] - (begin + place[1] * (end - begin))
    train.across[p, i] = place[0] * (0.5 * values[body[1], i] - values[column[2], i])
    stiffness, initial, plateau = values[column[3], i], values[column[4], i], values[column[5], i]
    restitution, unloading, hardening = values[column[6], i], values[column[7], i], values[column[8], i]
    train.stiffness[p, i], train.initial_force[p, i] = length * stiffness, length * initial
    train.plateau_force[p, i], train.restitution[p, i] = length * plateau, restitution
    train.hardening[p, i] = length * hardening
    train.unloading_stiffness[p, i], train.friction[p, i] = length * unloading, values[parts.common[2], i]
    return law_reason(stiffness, initial, plateau, restitution, unloading, hardening)


@compiled
def law_reason(stiffness, initial, plateau, restitution, unloading, hardening):
    """Return the reason why a crush law is impossible."""
    if not (plateau > 0.0 and plateau >= initial):
        return PLATEAU
    if not (initial == 0.0 and plateau == np.inf) and not 2.0 * restitution * restitution <= 1.0 + 1e-12:
        return LINE
    if unloading != 0.0 and not unloading >= stiffness:
        return UNLOADING
    if hardening != 0.0 and not (hardening > 0.0 and hardening <= stiffness and plateau < np.inf):
        return HARDENING
    return POSSIBLE


@compiled
def set_body(values, parts, train, u, i):
    """Fill mass and hinge of a unit.

    Returns the reason why it is impossible.
    """
    column = parts.units[u]
    length, width, mass = values[column[0], i], values[column[1], i], values[column[2], i]
    centre, inertia = values[column[3], i], values[column[4], i]
    train.mass[u, i], train.inertia[u, i] = mass, inertia
    if u > 0:
        train.hitch[u - 1, i] = values[parts.units[u - 1, 3], i] - values[column[5], i]
        train.kingpin[u - 1, i] = centre - values[column[6], i]
    return body_reason(length, width, mass, centre, inertia)


@compiled
def body_reason(length, width, mass, centre, inertia):
    """Return the reason why a body is impossible."""
    if not 0.0 < centre < length:
        return CENTRE
    most = mass * (centre * (length - centre) + width**2 / 4.0)
    if not (inertia >= MIN_INERTIA * most and inertia <= most * (1.0 + 1e-12)):
        return INERTIA
    return POSSIBLE


@compiled
def set_touch(values, parts, train, start, i):
    """Fill the state at first touch, of units in line."""
    front, speed, theta = parts.units[0], values[parts.common[0], i], values[parts.common[1], i]
    centre, half = values[front[3], i], 0.5 * values[front[1], i]
    s, c = np.sin(theta), np.cos(theta)
    behind = 0.0
    for u in range(start.shape[1]):
        if u > 0:
            behind = behind - train.hitch[u - 1, i] + train.kingpin[u - 1, i]
        start[i, u, 0] = half * s - centre * c - behind * c
        start[i, u, 1] = centre * s + half * c + behind * s
        start[i, u, 2], start[i, u, 3], start[i, u, 4], start[i, u, 5] = theta, speed * c, -speed * s, 0.0
    inside = -np.inf
    for p in range(train.unit.size):
        y = start[i, train.unit[p], 1]
        inside = max(inside, -(y + train.across[p, i] * c - train.along[p, i] * s))
    if abs(inside) > ROUNDING * abs(start[i, 0, 1]):
        for u in range(start.shape[1]):
            start[i, u, 1] += inside
