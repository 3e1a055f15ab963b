"""Compiled answers of a page in space.

They are a motion with its rows, at fixed steps and with its error, the band of many, and walls of other heights.
"""

from typing import NamedTuple

import numpy as np

from machine_code.compiled import compact, compiled
from postprocess.signals.compiled_filters import centred_means
from solver.space import columns
from solver.space import state as col
from solver.space.accuracy import MOST_CHOSEN, solve_one
from solver.space.columns import fastest, fill_sample
from solver.space.solve import SCAN
from solver.space.step import follow, lowest_wall
from solver.space.vehicle import GYRATION
from tailslap.browser.bands import calibrate, explain, fill_percentiles, spread
from tailslap.browser.kernels import ENDS, POSSIBLE, body_reason, law_reason
from tailslap.campaign.input_ranges import HARDENING
from tailslap.campaign.sampling import MIN_ROWS

OF_COLUMNS = 16
"""First number of the reasons of `columns.REASONS`, behind those of the plane."""

STEPS, LOST, NO_CONTACT, TOO_FEW = range(32, 36)
"""Further reasons: steps too short, an infinite motion, strips above the wall, too few motions of a band."""

BLOCK = 6
"""Motions of a band by one call, so that the page answers between calls."""

LOWEST, ABOVE = 0.3, 1.15
"""Lowest wall of the sweep [m], and the highest over the highest centre of mass."""


class Parts(NamedTuple):
    """Structure of vehicles in space, by numbers of their quantities.

    units, shape (units, 12), axles, (axles, 11), strips, (strips, 11): in the order of `columns.Values`; factors of the
    latter two, of the same shapes; computed, (units, 4): 1 where centre and inertias in roll, pitch and yaw follow from
    others; varied, (units, 3): 1 where these inertias vary in a band; hardened, (strips,): 1 where it assumes a
    hardening; common, (4,): speed, angle, friction and height of the wall.
    """

    units: np.ndarray
    axles: np.ndarray
    axle_factors: np.ndarray
    strips: np.ndarray
    strip_factors: np.ndarray
    computed: np.ndarray
    varied: np.ndarray
    hardened: np.ndarray
    common: np.ndarray


class Room(NamedTuple):
    """Memory of one motion.

    values: see `columns`; fleet, clock, work: see `state`; answers, shape (1, columns); rolls, (1, units); limit, (1,):
    what a refused value is compared with; phase: first step times the rate of the fastest oscillation [rad].
    """

    values: columns.Values
    fleet: col.Fleet
    clock: col.Clock
    work: col.SpaceWork
    answers: np.ndarray
    rolls: np.ndarray
    limit: np.ndarray
    phase: float


class Curves(NamedTuple):
    """Rows of a motion, and forces between them.

    rows, shape (1, rows, columns); force, (curves, rows): lateral force and its means [N]; widths, (curves - 1,): of
    these [s]; peaks, (curves,): their maxima; integral: workspace.
    """

    rows: np.ndarray
    force: np.ndarray
    widths: np.ndarray
    peaks: np.ndarray
    integral: np.ndarray


@compact
def solve_motion(values, parts, room, curves):
    """Solve the motion of these quantities, shape (quantities, 1).

    Returns the reason why there is none with its item, and the number of rows.
    """
    reason, item = prepare(values, values, parts, room, 0, False)
    if reason != POSSIBLE:
        return reason, item, 0
    rows = curves.rows[0]
    follow(room.fleet, room.clock, 0, room.fleet.height[0], room.work, rows, room.answers[0], room.rolls[0])
    return motion_reason(room), 0, fill_forces(room, curves)


@compact
def solve_accurately(values, parts, room, motions, choice, curves):
    """Solve the motion of these quantities with its error.

    motions, choice: see `accuracy`. Returns as `solve_motion`.
    """
    reason, item = prepare(values, values, parts, room, 0, False)
    if reason != POSSIBLE:
        return reason, item, 0
    solve_one(room.fleet, room.clock, room.work, motions, choice)
    rows, answer = motions.rows[motions.at[0]], motions.answers[motions.at[0]]
    for k in range(answer.size):
        room.answers[0, k] = answer[k]
    for j in range(int(answer[col.ROWS_WRITTEN])):
        for k in range(rows.shape[1]):
            curves.rows[0, j, k] = rows[j, k]
    return motion_reason(room), 0, fill_forces(room, curves)


@compiled
def fill_forces(room, curves):
    """Fill the lateral force and its means from the rows.

    Returns the number of rows.
    """
    rows, force, interval = curves.rows[0], curves.force, room.clock.interval
    count = min(int(room.answers[0, col.ROWS_WRITTEN]), rows.shape[0])
    for k in range(count):
        force[0, k] = rows[k, col.LATERAL]
    for c in range(curves.widths.size):
        centred_means(force[0], count, 0.5 * curves.widths[c] / interval, curves.integral, force[c + 1])
    for c in range(force.shape[0]):
        curves.peaks[c] = 0.0
        for k in range(1, count):
            curves.peaks[c] = max(curves.peaks[c], force[c, k])
    return count


@compact
def solve_block(nominal, values, parts, ranges, classes, room, forces, outcomes, place, percentiles):
    """Solve further motions of a band.

    nominal: shape (quantities, 1); values, (quantities, n); forces, (n,); outcomes, (3,): numbers of motions; place,
    (1,): the next motion, 0 to begin; percentiles: see `bands.solve_band`. Returns the reason why there is no band
    with its item, the number of solved motions, that of ranges, and the class by which the band is calibrated, or -1;
    it is complete where the place is n.
    """
    if place[0] == 0:
        complete(nominal, parts)
        forces[:], outcomes[:] = np.inf, 0.0
    varied, item = spread(nominal, values, ranges)
    if item >= 0:
        return ENDS, item, 0, varied, -1
    last = min(place[0] + BLOCK, values.shape[1])
    for i in range(place[0], last):
        reason, _ = prepare(values, nominal, parts, room, i, True)
        if reason == POSSIBLE:
            height, nothing = room.fleet.height[0], room.work.windows[:0]
            follow(room.fleet, room.clock, 0, height, room.work, nothing, room.answers[0], room.rolls[0])
            if motion_reason(room) != LOST:
                forces[i] = room.answers[0, col.MEAN]
                outcomes[int(room.answers[0, col.OUTCOME])] += 1.0
    place[0] = last
    count, group = int(outcomes[0] + outcomes[1] + outcomes[2]), -1
    if last == values.shape[1]:
        if count < MIN_ROWS:
            return TOO_FEW, 0, count, varied, -1
        ranges.fractions[:] = 0.0
        if count == forces.size:
            explain(ranges, forces)
        fill_percentiles(forces, count, percentiles)
        group = calibrate(nominal, parts, classes, percentiles)
    return POSSIBLE, 0, count, varied, group


@compact
def solve_wall(values, parts, room, place, walls, lowest):
    """Solve the motion on a further wall, last the lowest.

    place, shape (1,): its number; walls, (n, 6): height, outcome, largest roll, mean, its height and largest moment;
    lowest, (2,): see `step.lowest_wall`. Returns the reason why there is no motion.
    """
    reason, _ = prepare(values, values, parts, room, 0, False)
    if reason != POSSIBLE:
        return reason
    top = 0.0
    for u in range(room.fleet.units.shape[1]):
        unit = room.fleet.units[0, u]
        top = max(top, unit[col.HEIGHT] + unit[col.WHOLE_Z])
    if place[0] == walls.shape[0]:
        lowest[0], lowest[1] = lowest_wall(room.fleet, room.clock, 0, room.work, top, SCAN)
        if lowest[0] > top:
            lowest[0] = np.nan
        return POSSIBLE
    wall, answer = walls[place[0]], room.answers[0]
    wall[0] = LOWEST + (ABOVE * top - LOWEST) * float(place[0]) / float(walls.shape[0] - 1)
    follow(room.fleet, room.clock, 0, wall[0], room.work, room.work.windows[:0], answer, room.rolls[0])
    wall[1], wall[2], wall[3] = answer[col.OUTCOME], answer[col.ROLL], answer[col.MEAN]
    wall[4], wall[5] = answer[col.CENTRE_HEIGHT], answer[col.MOMENT_MEAN]
    place[0] += 1
    return POSSIBLE


@compiled
def motion_reason(room):
    """Return the reason why the last motion has no answer."""
    if room.answers[0, col.OUTCOME] == float(col.LOST):
        return LOST
    return POSSIBLE if room.answers[0, col.ROWS_WRITTEN] > 0.0 else NO_CONTACT


@compiled
def complete(values, parts):
    """Set quantities of the scene that follow from others."""
    for u in range(parts.units.shape[0]):
        unit, computed = parts.units[u], parts.computed[u]
        length, width = values[unit[columns.LENGTH], 0], values[unit[columns.WIDTH], 0]
        mass = values[unit[columns.MASS], 0]
        if computed[0] == 1:
            values[unit[columns.CENTRE], 0] = 0.5 * length
        if computed[3] == 1:
            values[unit[columns.YAW], 0] = mass * (length**2 + width**2) / 12.0
        if computed[1] == 1:
            values[unit[columns.ROLL], 0] = mass * (GYRATION * width) ** 2
        if computed[2] == 1:
            values[unit[columns.PITCH], 0] = values[unit[columns.YAW], 0]


@compiled
def prepare(values, nominal, parts, room, i, is_varied):
    """Fill the fleet by sample i with its steps.

    Returns the reason why it is impossible, and its item.
    """
    if is_varied:
        scale(values, nominal, parts, i)
    else:
        complete(values, parts)
    fill_values(values, nominal, parts, room, i, is_varied)
    for u in range(0 if is_varied else parts.units.shape[0]):
        unit = room.values.units[0, u]
        length, width = unit[columns.LENGTH], unit[columns.WIDTH]
        mass, centre = unit[columns.MASS], unit[columns.CENTRE]
        reason = body_reason(length, width, mass, centre, unit[columns.YAW])
        if reason != POSSIBLE:
            greatest = mass * (centre * (length - centre) + 0.25 * width**2)
            room.limit[0] = greatest if 0.0 < centre < length else length
            return reason, u
    for k in range(0 if is_varied else parts.strips.shape[0]):
        s = room.values.strips[0, k]
        reason = law_reason(s[columns.STIFFNESS], s[columns.INITIAL], s[columns.PLATEAU], s[columns.RESTITUTION],
                            s[columns.UNLOADING], s[columns.HARDENING])  # fmt: skip
        if reason != POSSIBLE:
            is_plateau = s[columns.PLATEAU] >= s[columns.INITIAL]
            room.limit[0] = s[columns.STIFFNESS] if is_plateau else s[columns.INITIAL]
            return reason, k
    reason, item, limit = fill_sample(room.values, room.fleet, 0)
    room.limit[0] = limit
    if reason != columns.POSSIBLE:
        return OF_COLUMNS + reason, item
    rate = fastest(room.fleet, 0)
    steps = max(np.ceil(room.clock.interval * rate / room.phase), 1.0)
    room.limit[0], room.clock.parts[0] = rate, int(min(steps, float(MOST_CHOSEN)))
    return (POSSIBLE if steps <= float(MOST_CHOSEN) else STEPS), 0


@compiled
def scale(values, nominal, parts, i):
    """Set the inertias of a sample by its mass."""
    for u in range(parts.units.shape[0]):
        unit = parts.units[u]
        part = values[unit[columns.MASS], i] / nominal[unit[columns.MASS], 0]
        for k in (0, 2, 1):
            column = unit[columns.ROLL + k]
            if parts.varied[u, k] == 0:
                values[column, i] = part * nominal[column, 0]
                if k == 1 and parts.computed[u, 2] == 1:
                    values[column, i] = values[unit[columns.YAW], i]


@compiled
def fill_values(values, nominal, parts, room, i, is_varied):
    """Fill the values of the parts of sample i."""
    into, fleet, common = room.values, room.fleet, parts.common
    for u in range(parts.units.shape[0]):
        for k in range(parts.units.shape[1]):
            into.units[0, u, k] = values[parts.units[u, k], i]
    for a in range(parts.axles.shape[0]):
        for k in range(parts.axles.shape[1]):
            into.axles[0, a, k] = values[parts.axles[a, k], i] * values[parts.axle_factors[a, k], i]
    for s in range(parts.strips.shape[0]):
        for k in range(parts.strips.shape[1]):
            into.strips[0, s, k] = values[parts.strips[s, k], i] * values[parts.strip_factors[s, k], i]
        if is_varied and parts.hardened[s] == 1:
            stiffness = nominal[parts.strips[s, columns.STIFFNESS], 0]
            factor = values[parts.strip_factors[s, columns.HARDENING], i]
            into.strips[0, s, columns.HARDENING] = HARDENING * stiffness * factor
    fleet.speed[0], fleet.angle[0] = values[common[0], i], values[common[1], i]
    fleet.friction[0], fleet.height[0] = values[common[2], i], values[common[3], i]
