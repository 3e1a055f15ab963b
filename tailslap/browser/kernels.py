"""Compiled answers of a page.

They are a motion with its forces, and the band of many.
"""

from typing import NamedTuple

import numpy as np

from machine_code.compiled import compact, compiled
from postprocess.signals.compiled_filters import centred_means
from solver.impact.accuracy import solve_sample
from solver.impact.instants import interpolate
from solver.impact.train import ROUNDING
from solver.impact.tyres import set_axle_loads
from solver.rules import MIN_INERTIA
from tailslap.case.impact.answers import MEAN_WINDOW
from tailslap.case.impact.rigid import row_interval

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


class Ranges(NamedTuple):
    """Ranges of varied quantities.

    quantities, shape (ranges, 3): the varied one, one of which a part is added, and the greatest value; -1 for none.
    widths, shape (ranges, 6): half the width, absolute, over the quantity, and over the other; both ends of a range
    that is fixed, NaN otherwise; of an omitted quantity its assumed value over the other, otherwise 0. bounds, shape
    (ranges, 2): of the key; mass: the quantity that is the vehicle's mass; light, shape (vehicles, 2): masses of light
    vehicles and their tolerance, by which it varies; drawn, shape (ranges, n): places within the ranges; ends, shape
    (ranges, 2): result, NaN for a value outside a fixed range.
    """

    quantities: np.ndarray
    widths: np.ndarray
    bounds: np.ndarray
    mass: int
    light: np.ndarray
    drawn: np.ndarray
    ends: np.ndarray


class Motion(NamedTuple):
    """Motion of a page at even instants.

    integrals, rates: see `instants.interpolate`; times, shape (instants,); values, shape (instants, columns); integral:
    workspace; curves, shape (curves, instants): force and its means [N]; widths, shape (curves - 1,): of these [s];
    peaks: their maxima; strike_means, shape (strikes,): largest 50 ms mean about each strike [N].
    """

    integrals: np.ndarray
    rates: np.ndarray
    times: np.ndarray
    values: np.ndarray
    integral: np.ndarray
    curves: np.ndarray
    widths: np.ndarray
    peaks: np.ndarray
    strike_means: np.ndarray
    impulse: int
    counted: int


@compact
def solve_motion(values, parts, case, outcome, motion):
    """Solve the impact of these quantities, shape (quantities, 1).

    Returns the reason why there is none with its item, the verdict, and the number of instants.
    """
    complete(values, parts, 0)
    reason, item = assemble(values, parts, case[0], case[1], case[2], 0)
    if reason != POSSIBLE:
        return reason, item, 0, 0
    solve_sample((case[0], case[1], case[2][0], case[3], case[4], case[5]), outcome, 0, outcome.rows[0])
    if outcome.verdict[0] != 0:
        return reason, item, outcome.verdict[0], 0
    if case[4].reached[0] > float(outcome.rows.shape[1] - 1) * outcome.interval[0]:
        return reason, item, MORE_ROWS, 0
    return reason, item, 0, sample(outcome, case[4].reached[0], motion)


@compiled
def sample(outcome, end, motion):
    """Fill the motion at even instants, and return their number."""
    strikes = outcome.strikes[0]
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
    interpolate(
        outcome.rows[0],
        outcome.interval[0],
        end,
        motion.integrals,
        motion.rates,
        motion.times,
        motion.values,
        count,
    )
    fill_forces(motion, count, step)
    for s in range(strikes.shape[0]):
        largest = 0.0
        for k in range(1, count):
            if motion.times[k] >= strikes[s, 1] and motion.times[k] - step <= strikes[s, 2]:
                largest = max(largest, motion.curves[motion.curves.shape[0] - 1, k])
        motion.strike_means[s] = largest
    return count


@compiled
def fill_forces(motion, count, step):
    """Fill the lateral force, mean since the instant before, and its means."""
    force = motion.curves[0]
    force[0] = 0.0
    for k in range(1, count):
        before, after = motion.values[k - 1, motion.impulse], motion.values[k, motion.impulse]
        force[k] = (after - before) / (motion.times[k] - motion.times[k - 1])
    for c in range(motion.widths.size):
        centred_means(force, count, 0.5 * motion.widths[c] / step, motion.integral, motion.curves[c + 1])
    for c in range(motion.curves.shape[0]):
        motion.peaks[c] = 0.0
        for k in range(1, count):
            motion.peaks[c] = max(motion.peaks[c], motion.curves[c, k])


@compact
def solve_band(
    nominal, values, parts, ranges, classes, case, outcome, integral, touched, means, forces, percentiles
):
    """Solve the impacts of a band.

    The percentiles of their largest means are filled.

    nominal: shape (quantities, 1); values, shape (quantities, n); forces, shape (n,); percentiles, shape (2, m): their
    places and results. Returns the reason why there is no band with its item, the verdict on a motion, the number of
    ranges, and the class of vehicles by which the band is calibrated, or -1.
    """
    train, tyres, start, choice, clock, work = case
    complete(nominal, parts, 0)
    varied, item = spread(nominal, values, ranges)
    if item >= 0:
        return ENDS, item, 0, varied, -1
    interval = choice.interval
    for i in range(values.shape[1]):
        reason, item = assemble(values, parts, train, tyres, start, i)
        if reason != POSSIBLE:
            return reason, item, 0, varied, -1
        solve_sample((train, tyres, start[i], choice, clock, work), outcome, i, outcome.rows[0])
        if outcome.verdict[i] != 0:
            return POSSIBLE, 0, outcome.verdict[i], varied, -1
        size = mean_forces(outcome.rows[0], interval, clock.reached[i], touched)
        centred_means(touched, size, 0.5 * MEAN_WINDOW / interval, integral, means)
        forces[i] = 0.0
        for k in range(1, size):
            forces[i] = max(forces[i], means[k])
    sort(forces)
    for k in range(percentiles.shape[1]):
        place = 0.01 * percentiles[0, k] * float(forces.size - 1)
        j = min(int(place), forces.size - 2)
        percentiles[1, k] = forces[j] + (place - float(j)) * (forces[j + 1] - forces[j])
    return POSSIBLE, 0, 0, varied, calibrate(nominal, parts, classes, percentiles)


@compiled
def calibrate(nominal, parts, classes, percentiles):
    """Widen percentiles about the median by the class of the vehicle.

    classes, shape (classes, 5): least and greatest speed and mass, and factor on logarithms, NaN for none. Returns the
    class, or -1.
    """
    speed, mass, median = nominal[parts.common[0], 0], 0.0, percentiles[1, percentiles.shape[1] // 2]
    for u in range(parts.units.shape[0]):
        mass += nominal[parts.units[u, 2], 0]
    for c in range(classes.shape[0]):
        if speed < classes[c, 0] or speed > classes[c, 1] or mass < classes[c, 2] or mass > classes[c, 3]:
            continue
        for k in range(percentiles.shape[1] if classes[c, 4] > 0.0 else 0):
            percentiles[1, k] = median * (percentiles[1, k] / median) ** classes[c, 4]
        return c
    return -1


@compiled
def mean_forces(rows, interval, end, touched):
    """Fill mean forces between rows, after a first value of 0.

    Returns their number.
    """
    count, impulse = int(np.ceil(end / interval)), 0.0
    touched[0] = 0.0
    for k in range(count + 1):
        before = impulse
        if float(k) * interval < end + (1.0 - 1e-9) * interval:  # rows beyond were never written
            impulse = max(impulse, rows[k, 0]) if k > 0 else rows[0, 0]
        if k > 0:
            touched[k] = (impulse - before) / interval
    return count + 1


@compiled
def sort(values):
    """Sort values in place, by insertion."""
    for i in range(1, values.size):
        value, k = values[i], i
        while k > 0 and values[max(k - 1, 0)] > value:
            values[k] = values[k - 1]
            k -= 1
        values[k] = value


@compiled
def complete(values, parts, i):
    """Set quantities that follow from others."""
    for c in range(parts.copies.shape[0]):
        values[parts.copies[c, 0], i] = values[parts.copies[c, 1], i]
    for u in range(parts.units.shape[0]):
        columns = parts.units[u]
        length, width, mass = values[columns[0], i], values[columns[1], i], values[columns[2], i]
        if parts.computed[u, 0] == 1:
            values[columns[3], i] = 0.5 * length
        if parts.computed[u, 1] == 1:
            values[columns[4], i] = mass * (length**2 + width**2) / 12.0


@compiled
def spread(nominal, values, ranges):
    """Fill the quantities of all samples, shape (quantities, n).

    Returns the number of ranges, and one whose ends are beyond the bounds of its key, or -1.
    """
    varied = 0
    for i in range(values.shape[1]):
        for q in range(values.shape[0]):
            values[q, i] = nominal[q, 0]
    for r in range(ranges.quantities.shape[0]):
        q, further, most = ranges.quantities[r, 0], ranges.quantities[r, 1], ranges.quantities[r, 2]
        value, low, high = nominal[q, 0], ranges.widths[r, 3], ranges.widths[r, 4]
        if ranges.widths[r, 5] > 0.0:  # assumed where the scene omits it
            value = ranges.widths[r, 5] * nominal[further, 0]
        if np.isnan(low):
            half = ranges.widths[r, 0] + ranges.widths[r, 1] * value
            if further >= 0:
                half += ranges.widths[r, 2] * nominal[further, 0]
            for v in range(ranges.light.shape[0] if q == ranges.mass else 0):
                if abs(value - ranges.light[v, 0]) <= ranges.light[v, 1]:
                    half = ranges.light[v, 1]
            low, high = value - half, value + half
            if most >= 0:
                low, high = max(low, 0.0), min(high, nominal[most, 0])
        margin = 1e-9 * (high - low)
        if not (value >= low - margin and value <= high + margin):
            ranges.ends[r, 0] = ranges.ends[r, 1] = np.nan
            continue
        ranges.ends[r, 0], ranges.ends[r, 1] = low, high
        if not (low >= ranges.bounds[r, 0] and low < high and high <= ranges.bounds[r, 1]):
            return varied, r
        varied += 1
        for i in range(values.shape[1]):
            values[q, i] = low + (high - low) * ranges.drawn[r, i]
    return varied, -1


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
        start[i, u, 0], start[i, u, 1] = (
            half * s - centre * c - behind * c,
            centre * s + half * c + behind * s,
        )
        start[i, u, 2], start[i, u, 3], start[i, u, 4], start[i, u, 5] = theta, speed * c, -speed * s, 0.0
    inside = -np.inf
    for p in range(train.unit.size):
        y = start[i, train.unit[p], 1]
        inside = max(inside, -(y + train.across[p, i] * c - train.along[p, i] * s))
    if abs(inside) > ROUNDING * abs(start[i, 0, 1]):
        for u in range(start.shape[1]):
            start[i, u, 1] += inside
