"""Compiled motion of vehicles in space that strike a wall.

A step evaluates the forces at the positions of an instant, advances the velocities from half a step before it to half
a step after, then the positions to the next instant. Forces that depend on velocities take those at the instant, from
the velocities half a step before and the last accelerations. The scheme is of second order.
"""

import numpy as np

from machine_code.compiled import compiled
from solver.space import state as col
from solver.space.dynamics import assemble, begin_step, close_hinges, kick, move, rotated, turned_back
from solver.space.forces import (
    add_force,
    point_velocity,
    press_axles,
    press_strips,
    twist_hinges,
)
from solver.space.rows import end_row, means, record
from solver.space.stopping import add_stopped, returns_nothing, stop_strips
from solver.space.verdict import LEANING, QUIET, SOONEST, finish, leave, verdict
from solver.space.wall import point_of_face, wall_facets

AGAIN = 3
"""Repetitions by which hinges close and strips that return no energy stop together."""

RESOLUTION, LOWEST_WALL, ALMOST = 1e-3, 0.1, np.radians(65.0)
"""Resolution and lowest height of the search for a wall [m], and roll from which a vehicle almost tips [rad]."""


@compiled
def lowest_wall(fleet, clock, i, work, holds, scan):
    """Return the lowest wall above which sample i remains upright.

    holds: first wall that is tried [m]. The second value is the highest tried wall on which it almost tips, see
    `accuracy.advance`.
    """
    fails, almost, latest = LOWEST_WALL, 0.0, 0.0
    if not _is_upright(fleet, clock, i, holds, work):
        fails, holds = holds, holds + scan
        if not _is_upright(fleet, clock, i, holds, work):
            return np.nan, 0.0
    height = holds - scan
    while height > fails:
        if not _is_upright(fleet, clock, i, height, work):
            fails = height
            break
        almost = max(almost, latest)
        latest = height if abs(work.answer[col.ROLL]) > ALMOST else 0.0
        holds, height = height, height - scan
    while holds - fails > RESOLUTION:
        height = 0.5 * (holds + fails)
        if _is_upright(fleet, clock, i, height, work):
            holds = height
        else:
            fails = height
    return holds, almost


@compiled
def _is_upright(fleet, clock, i, height, work):
    """Return True if sample i remains upright on this wall."""
    follow(fleet, clock, i, height, work, work.windows[:0], work.answer, work.rolls)
    return work.answer[col.OUTCOME] == col.UPRIGHT


@compiled
def follow(fleet, clock, i, height, work, rows, answer, rolls):
    """Follow sample i on a wall of this height to its end."""
    units, strips, parts = fleet.units[i], fleet.strips[i], clock.parts[i]
    h = clock.interval / parts
    facets = wall_facets(fleet.profile, height, work.wall)
    edge = work.wall[facets - 1, 2]
    answer[:], rolls[:], work.sums[:], work.pushes[:], work.pulls[:] = 0.0, 0.0, 0.0, 0.0, 0.0
    bodies, joints, sums, before = work.bodies, work.joints, work.sums, work.before
    if not _begin(fleet, i, units, fleet.axles[i], strips, facets, clock.is_end_fixed, work):
        answer[col.OUTCOME] = col.OVER
        return
    stops = False
    for k in range(strips.shape[0]):
        stops = stops or returns_nothing(strips[k])
    touched, largest, touching, row, reached, outcome = 0.0, 0.0, False, 0, clock.longest, col.UPRIGHT
    for k in range(int(np.ceil(clock.longest / clock.interval * (1.0 - 1e-12))) * parts + 1):
        t = k * h
        touches = _press(fleet, clock, i, k, h, facets, work, rows.shape[0] > 0)
        _accelerate(fleet, i, k, h, work, stops)
        force = sums[col.LATERAL] - before[col.LATERAL]
        largest = max(largest, force)
        if force > LEANING * largest:
            touched = t
        if touching and not touches:
            leave(units[0], bodies[0], answer)
        touching = touches
        if k % parts == 0:
            _write_row(fleet, i, work, k == 0, parts, row, rows)
            row += 1
        is_last = t >= clock.longest * (1.0 - 1e-12)
        most = 0.0 if is_last and not clock.is_end_fixed else 1.0
        outcome, unsettled = verdict(units, bodies, joints, edge, most, t, answer)
        is_over = outcome != col.UPRIGHT or (t >= SOONEST and t - touched >= QUIET and not unsettled)
        if k % parts == 0 and ((is_over and not clock.is_end_fixed) or is_last):
            reached = t
            break
        move(bodies, joints, h)
    if touching:
        leave(units[0], bodies[0], answer)
    finish(answer, rolls, bodies, outcome, reached, touched, row)
    means(work.windows[:row], sums, clock.window, clock.interval, answer)
    answer[col.INERTIAL] *= units[0, col.WHOLE]


@compiled
def _press(fleet, clock, i, k, h, facets, work, with_rows):
    """Set the loads of step k, and add to the sums.

    Returns as `press_strips`.
    """
    units, axles, ahead = fleet.units[i], fleet.axles[i], h if k > 0 else 0.5 * h
    begin_step(work.bodies, work.joints, h if k > 0 else 0.0)
    for j in range(10):
        work.before[j] = work.sums[j]
    for p in range(work.pushes.shape[0] if with_rows else 0):
        work.pushes[p, col.BEFORE] = work.pushes[p, col.PUSH]
    for j in range(work.pulls.shape[1] if with_rows else 0):
        work.pulls[1, j] = work.pulls[0, j]
    press_axles(axles, fleet.axle_unit, work.bodies, work.joints, work.sums, ahead)
    touches = press_strips(fleet, i, units, axles, fleet.strips[i], facets, work, ahead, 0.5 * h)
    if clock.push.shape[0] > 0:
        _push_at(clock.push, k, clock.parts[i], units[0], work.bodies[0])
    if units.shape[0] > 1:
        twist_hinges(units, work.bodies)
    return touches


@compiled
def _accelerate(fleet, i, k, h, work, stops):
    """Advance the velocities of step k by the loads.

    stops: True where a strip returns no energy.
    """
    units, strips, ahead = fleet.units[i], fleet.strips[i], h if k > 0 else 0.5 * h
    assemble(units, fleet.axles[i], fleet.axle_unit, work.bodies, work.joints)
    kick(fleet.axle_unit, work.bodies, work.joints, ahead)
    if stops:
        stop_strips(fleet, strips, work, ahead, False)
    if units.shape[0] > 1:
        close_hinges(units, fleet.axle_unit, work, ahead, h)
        for _ in range(AGAIN if stops else 0):
            stop_strips(fleet, strips, work, ahead, True)
            close_hinges(units, fleet.axle_unit, work, ahead, h)
    if stops:
        add_stopped(strips, work)


@compiled
def _write_row(fleet, i, work, first, parts, row, rows):
    """Write the means of a row, and the row if it fits."""
    unit, means_of_row = fleet.units[i, 0], work.windows[row]
    end_row(work.sums, work.before, first, parts, means_of_row[: col.SENSED])
    _, means_of_row[col.SENSED], _ = point_velocity(
        work.bodies[0], unit[col.SENSOR_X], 0.0, unit[col.SENSOR_Z], 0.0, 0.0
    )
    if row < rows.shape[0]:
        record(fleet.units[i], fleet.axles[i], fleet.axle_unit, work, first, parts, rows[row])
        for j in range(col.SENSED + 1):
            rows[row, j] = means_of_row[j]


@compiled
def _push_at(pushes, k, parts, unit, b):
    """Add the force of a history at a step.

    At the border of two intervals it is the mean of both.
    """
    border = k > 0 and k % parts == 0
    for row in range(k // parts - (1 if border else 0), k // parts + 1):
        if row < pushes.shape[0]:
            _push(pushes[row], 0.5 if border else 1.0, unit, b)


@compiled
def _begin(fleet, i, units, axles, strips, facets, anywhere, work):
    """Set sample i to the instant of first contact.

    Returns False where no strip can touch the face. anywhere: True to begin without contact.
    """
    theta = fleet.angle[i]
    c, s = np.cos(theta), np.sin(theta)
    bodies, behind = work.bodies, 0.0
    work.memory[:], bodies[:], work.joints[:] = 0.0, 0.0, 0.0
    for u in range(units.shape[0]):
        if u > 0:
            behind += units[u - 1, col.HITCH_X] - units[u, col.KING_X]
        b = bodies[u]
        b[col.AT], b[col.AT + 1], b[col.AT + 2] = behind * c, -behind * s, units[u, col.HEIGHT]
        b[col.SPEED], b[col.SPEED + 1] = fleet.speed[i] * c, -fleet.speed[i] * s
        b[col.LARGEST + 1] = 1.0
        b[col.TURN], b[col.TURN + 3] = np.cos(0.5 * theta), -np.sin(0.5 * theta)
    gap, top = np.inf, work.wall[facets - 1, 3]
    for k in range(strips.shape[0]):
        u, a, strip, points = fleet.strip_unit[k], fleet.strip_axle[k], strips[k], fleet.strip_points[k]
        raised = axles[a, col.CENTRE] if a >= 0 else 0.0
        half = max(0.5 * abs(strip[col.END + 2] - strip[col.START + 2]) / points, strip[col.THICK])
        for n in range(points):
            p = (n + 0.5) / points
            x = strip[col.START] + p * (strip[col.END] - strip[col.START])
            y = strip[col.START + 1] + p * (strip[col.END + 1] - strip[col.START + 1])
            z = (
                strip[col.START + 2]
                + p * (strip[col.END + 2] - strip[col.START + 2])
                + raised
                + units[u, col.HEIGHT]
            )
            if z - half < top:
                place = bodies[u, col.AT + 1] - s * x - c * y
                gap = min(gap, place - point_of_face(work.wall, facets, z)[0])
    if gap == np.inf:
        return anywhere
    for u in range(units.shape[0]):
        bodies[u, col.AT + 1] -= gap
    return True


@compiled
def _push(push, share, unit, b):
    """Add a fraction of a force of a history to a unit.

    Columns: along, across and up [N], the point's place ahead of the centre of the whole mass along X [m], and its
    height [m], NaN for that of the centre. The centre is that with the axles at rest on the body.
    """
    x, y, z = rotated(b, unit[col.WHOLE_X], 0.0, unit[col.WHOLE_Z])
    height = z if np.isnan(push[4]) else push[4] - b[col.AT + 2]
    x, y, z = turned_back(b, x + push[3], y, height)
    add_force(b, x, y, z, share * push[0], share * push[1], share * push[2])
