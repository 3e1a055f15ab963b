"""Compiled motion of vehicles in space that strike a wall.

A step evaluates the forces at the positions of an instant, advances the velocities from half a step before it to half
a step after, then the positions to the next instant. Forces that depend on velocities take those at the instant, from
the velocities half a step before and the last accelerations. The scheme is of second order.

A motion ends with a unit that has rolled by 90 deg; or where the wall has not pushed for `QUIET` by more than the tenth
of its largest force, all wheels are loaded, all units roll back and are not about to cross the wall; or at the longest
time, at which a unit behind the upper edge of the wall is over it.
"""

import numpy as np

from machine_code.compiled import compact, compiled
from solver.body import GRAVITY
from solver.space import state as col
from solver.space.dynamics import assemble, begin_step, close_hinges, cross, kick, move, rotated, turned_back
from solver.space.forces import (
    add_force,
    point_of_face,
    point_velocity,
    press_axles,
    press_strips,
    twist_hinges,
    wall_facets,
)

QUIET, SOONEST, LEANING = 0.3, 0.6, 0.1
"""Time without force of the wall that ends a motion, within which no centre may cross the wall either [s]; its earliest
end [s]; and the force over the largest up to which a vehicle merely leans on the wall."""

LEVEL = 0.02
"""Sine of the roll up to which a unit counts as rolling back."""

RESOLUTION, LOWEST_WALL, ALMOST = 1e-3, 0.1, np.radians(65.0)
"""Resolution and lowest height of the search for a wall [m], and roll from which a vehicle almost tips [rad]."""


@compact
def advance(fleet, clock, work, rows, answers, rolls, scan, lowest):
    """Follow every sample to its end, or search for the lowest wall.

    rows, shape (1 or n, rows, columns): as many as fit; answers, shape (n, columns); rolls, shape (n, units): largest
    of each unit [rad]. lowest: empty, or of shape (n, 2) with the first wall of a search, which becomes the lowest wall
    above which each sample remains upright, NaN where a wall by `scan` higher than the first does not suffice, and the
    highest tried one on which it almost tips although a lower one suffices, 0 without; scan: steps downwards from the
    first wall, before the bisection [m].
    """
    for i in range(fleet.units.shape[0]):
        if lowest.size > 0:
            lowest[i, 0], lowest[i, 1] = _lowest_wall(fleet, clock, i, work, lowest[i, 0], scan)
        else:
            row = rows[min(i, rows.shape[0] - 1)]
            _follow(fleet, clock, i, fleet.height[i], work, row, answers[i], rolls[i])


@compiled
def _lowest_wall(fleet, clock, i, work, holds, scan):
    """Return the lowest wall above which sample i remains upright.

    holds: first wall that is tried [m]. The second value is the highest tried wall on which it almost tips, see
    `advance`.
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
    _follow(fleet, clock, i, height, work, work.windows[:0], work.answer, work.rolls)
    return work.answer[col.OUTCOME] == col.UPRIGHT


@compiled
def _follow(fleet, clock, i, height, work, rows, answer, rolls):
    """Follow sample i on a wall of this height to its end."""
    units, axles, strips, parts = fleet.units[i], fleet.axles[i], fleet.strips[i], clock.parts[i]
    h = clock.interval / parts
    facets = wall_facets(fleet.profile, height, work.wall)
    edge = work.wall[facets - 1, 2]
    answer[:], rolls[:], work.sums[:] = 0.0, 0.0, 0.0
    bodies, joints, sums, before = work.bodies, work.joints, work.sums, work.before
    if not _begin(fleet, i, units, axles, strips, facets, clock.is_end_fixed, work):
        answer[col.OUTCOME] = col.OVER
        return
    touched, largest, touching, row, reached, outcome = 0.0, 0.0, False, 0, clock.longest, col.UPRIGHT
    for k in range(int(np.ceil(clock.longest / clock.interval * (1.0 - 1e-12))) * parts + 1):
        t, last, ahead = k * h, h if k > 0 else 0.0, h if k > 0 else 0.5 * h
        begin_step(bodies, joints, last)
        for j in range(10):
            before[j] = sums[j]
        press_axles(axles, fleet.axle_unit, bodies, joints, sums, ahead)
        touches = press_strips(fleet, i, units, axles, strips, facets, work, ahead, 0.5 * h)
        if clock.push.shape[0] > 0:
            _push_at(clock.push, k, parts, units[0], bodies[0])
        if units.shape[0] > 1:
            twist_hinges(units, bodies)
        force = sums[col.LATERAL] - before[col.LATERAL]
        largest = max(largest, force)
        if force > LEANING * largest:
            touched = t
        if touching and not touches:
            _leave(units[0], bodies[0], answer)
        touching = touches
        if k % parts == 0:
            _end_row(sums, before, k == 0, parts, work.windows[row])
            _, work.windows[row, col.SENSED], _ = point_velocity(
                bodies[0], units[0, col.SENSOR_X], 0.0, units[0, col.SENSOR_Z], 0.0, 0.0
            )
            if row < rows.shape[0]:
                _record(units, axles, fleet.axle_unit, work, k == 0, before, rows[row])
                for j in range(6):
                    rows[row, j] = work.windows[row, j]
            row += 1
        is_last = t >= clock.longest * (1.0 - 1e-12)
        most = 0.0 if is_last and not clock.is_end_fixed else 1.0
        outcome, unsettled = _verdict(units, bodies, joints, edge, most, t, answer, rolls)
        is_over = outcome != col.UPRIGHT or (t >= SOONEST and t - touched >= QUIET and not unsettled)
        if k % parts == 0 and ((is_over and not clock.is_end_fixed) or is_last):
            reached = t
            break
        assemble(units, axles, fleet.axle_unit, bodies, joints)
        kick(fleet.axle_unit, bodies, joints, ahead)
        if units.shape[0] > 1:
            close_hinges(units, fleet.axle_unit, work, ahead, h)
        move(bodies, joints, h)
    if touching:
        _leave(units[0], bodies[0], answer)
    _finish(answer, rolls, outcome, reached, touched, row)
    _means(work.windows[:row], sums, clock.window, clock.interval, answer)
    answer[col.INERTIAL] *= units[0, col.WHOLE]


@compiled
def _finish(answer, rolls, outcome, reached, touched, row):
    """Store outcome, end and last contact, and complete the angles."""
    answer[col.OUTCOME], answer[col.REACHED] = outcome, reached
    answer[col.TOUCHED], answer[col.ROWS_WRITTEN] = touched, row
    answer[col.PITCH] = np.arcsin(min(max(answer[col.PITCH], -1.0), 1.0))  # the sine up to here
    if outcome in (col.ON_ITS_SIDE, col.OVER):  # the end is on a row, a moment later than the roll of 90 deg
        answer[col.ROLL] = min(max(answer[col.ROLL], -0.5 * np.pi), 0.5 * np.pi)
        for u in range(rolls.size):
            rolls[u] = min(max(rolls[u], -0.5 * np.pi), 0.5 * np.pi)


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
def _end_row(sums, before, first, parts, means):
    """Set the mean forces of a row that ends with this step.

    Half of the step belongs to this row, half to the next one.
    """
    for j in range(6):
        change = sums[j] - before[j]
        means[j] = 0.0 if first else (before[j] + 0.5 * change) / parts
        sums[j] = 0.5 * change


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


@compiled
def _leave(unit, b, answer):
    """Store speed and directions of the first unit at a contact.

    Its axles are taken as at rest on the body.
    """
    x, y, z = cross(b[col.NOW + 3], b[col.NOW + 4], b[col.NOW + 5], unit[col.WHOLE_X], 0.0, unit[col.WHOLE_Z])
    vx, vy, _ = rotated(b, x, y, z)
    vx, vy = b[col.NOW] + vx, b[col.NOW + 1] + vy
    answer[col.EXIT_SPEED], answer[col.EXIT_ANGLE] = np.hypot(vx, vy), np.arctan2(vy, vx)
    answer[col.EXIT_YAW] = np.arctan2(b[3], b[0])


@compiled
def _verdict(units, bodies, joints, edge, most, t, answer, rolls):
    """Update the largest angles.

    Returns the outcome so far, and True while the motion goes on: a unit rolls outwards, has a wheel off the ground,
    or is about to cross the wall. most: heights of a unit by which its centre is behind the edge before it is over.
    """
    outcome, unsettled = col.UPRIGHT, False
    for u in range(units.shape[0]):
        b = bodies[u]
        sine, roll = abs(b[7]), rolls[u]
        if sine > abs(roll) * b[8]:  # the tangent is larger than the angle: few angles are computed in vain
            roll = np.arctan2(b[7], b[8])
            if abs(roll) > abs(rolls[u]):
                rolls[u] = roll
            if abs(roll) > abs(answer[col.ROLL]):
                answer[col.ROLL], answer[col.ROLL_TIME] = roll, t
        if abs(b[6]) > abs(answer[col.PITCH]):
            answer[col.PITCH], answer[col.PITCH_TIME] = -b[6], t
        unsettled = unsettled or (sine > LEVEL and b[7] * b[col.NOW + 3] > 0.0)
        beyond = edge - b[col.AT + 1] - b[3] * units[u, col.WHOLE_X] - b[5] * units[u, col.WHOLE_Z]
        if not np.isfinite(beyond + sine):
            outcome = col.LOST
        elif b[8] <= 0.0:
            outcome = col.OVER if beyond > 0.0 else col.ON_ITS_SIDE
        elif beyond > most * units[u, col.HEIGHT]:
            outcome = col.OVER
        unsettled = unsettled or beyond > QUIET * b[col.NOW + 1]
    for a in range(joints.shape[0]):
        unsettled = unsettled or joints[a, col.WHEEL] <= 0.0 or joints[a, col.WHEEL + 1] <= 0.0
    return outcome, unsettled


@compiled
def _means(windows, sums, window, interval, answer):
    """Set the largest means of lateral force, its moment, and acceleration.

    sums: overwritten.
    """
    for k in range(windows.shape[0]):
        gain = windows[k, col.SENSED] - windows[max(k - window, 0), col.SENSED]
        answer[col.INERTIAL] = max(answer[col.INERTIAL], gain / (window * interval))
        answer[col.RAW] = max(answer[col.RAW], windows[k, col.LATERAL])
    _add_largest(windows, col.MOMENT, window, sums)
    answer[col.MOMENT_MEAN] = sums[col.MOMENT] / window
    answer[col.MOMENT_HEIGHT], answer[col.MOMENT_LENGTH] = _height_and_length(sums)
    at = _add_largest(windows, col.LATERAL, window, sums)
    answer[col.MEAN], answer[col.MEAN_TIME] = sums[col.LATERAL] / window, at * interval
    answer[col.MEAN_ALONG], answer[col.MEAN_UP] = sums[col.ALONG] / window, sums[col.UP] / window
    answer[col.CENTRE_HEIGHT], answer[col.CONTACT_LENGTH] = _height_and_length(sums)


@compiled
def _height_and_length(sums):
    """Return height and length of the lateral force of a window."""
    force = sums[col.LATERAL]
    if force <= 0.0:
        return 0.0, 0.0
    station = sums[col.STATION] / force
    return sums[col.MOMENT] / force, np.sqrt(12.0 * max(sums[col.SPREAD] / force - station * station, 0.0))


@compiled
def _add_largest(windows, column, window, sums):
    """Add up the window with the largest sum of a column.

    Returns its last row.
    """
    total, best, at = 0.0, 0.0, 0
    for k in range(windows.shape[0]):
        total += windows[k, column] - (windows[k - window, column] if k >= window else 0.0)
        if total > best:
            best, at = total, k
    sums[:] = 0.0
    for k in range(max(at - window + 1, 0), at + 1):
        for j in range(6):
            sums[j] += windows[k, j]
    return at


@compiled
def _record(units, axles, axle_unit, work, first, before, row):
    """Fill this instant's row except for the forces.

    before: works before this step, half of which they have at the instant.
    """
    for j in range(6, 10):
        row[j] = before[j] + (0.0 if first else 0.5 * (work.sums[j] - before[j]))
    kinetic, gravity, spring, tyre = 0.0, 0.0, 0.0, 0.0
    column = 14
    for u in range(units.shape[0]):
        body, b = units[u], work.bodies[u]
        wx, wy, wz = b[col.NOW + 3], b[col.NOW + 4], b[col.NOW + 5]
        kinetic += (
            0.5
            * body[col.MASS]
            * (b[col.NOW] * b[col.NOW] + b[col.NOW + 1] * b[col.NOW + 1] + b[col.NOW + 2] * b[col.NOW + 2])
        )
        kinetic += (
            0.5 * (body[col.I_X] * wx * wx + body[col.I_Y] * wy * wy + body[col.I_Z] * wz * wz)
            - body[col.I_XZ] * wx * wz
        )
        for j in range(3):
            row[column + j] = body[col.MASS] * b[col.AT + j]
            row[column + 6 + j] = body[col.MASS] * b[col.NOW + j]
        for a in range(axles.shape[0]):
            if axle_unit[a] == u:
                kinetic += _record_axle(axles[a], b, work.joints[a], row, column)
        gravity += GRAVITY * row[column + 2]
        _record_pose(body, b, row, column)
        if u > 0:
            ahead = work.bodies[u - 1]
            sine = ahead[1] * b[2] + ahead[4] * b[5] + ahead[7] * b[8]
            spring += 0.5 * body[col.TWIST] * sine * sine
        column += 12
    for a in range(axles.shape[0]):
        axle, q = axles[a], work.joints[a]
        for side in range(2):
            shift = q[col.JOINT] + (2.0 * side - 1.0) * axle[col.HALF_SPACING] * np.sin(q[col.JOINT + 1])
            spring += 0.5 * axle[col.SPRING] * shift * shift + axle[col.PRELOAD] * shift
            tyre += 0.5 * q[col.WHEEL + side] * q[col.WHEEL + side] / axle[col.TYRE]
            row[column + side], row[column + 2 + side] = q[col.WHEEL + side], q[col.JOINT + side]
        column += 4
    row[10], row[11], row[12], row[13] = kinetic, gravity, spring, tyre


@compiled
def _record_pose(body, b, row, column):
    """Fill a unit's position, velocity, angles and spin.

    The row has the sums of mass times position and velocity.
    """
    for j in range(3):
        row[column + j] /= body[col.WHOLE]
        row[column + 6 + j] /= body[col.WHOLE]
    row[column + 3] = np.arctan2(b[3], b[0])
    row[column + 4] = -np.arcsin(min(max(b[6], -1.0), 1.0))
    row[column + 5] = np.arctan2(b[7], b[8])
    x, y, z = rotated(b, b[col.NOW + 3], b[col.NOW + 4], b[col.NOW + 5])
    row[column + 9], row[column + 10], row[column + 11] = x, y, z


@compiled
def _record_axle(axle, b, q, row, column):
    """Add an axle to position and velocity of its unit's row.

    Returns its kinetic energy [J].
    """
    c, s, rate = q[col.COSINE], q[col.SINE], q[col.JOINT_NOW + 1]
    x, y, z = axle[col.PLACE], axle[col.BELOW] * s, axle[col.CENTRE] + q[col.JOINT] - axle[col.BELOW] * c
    px, py, pz = rotated(b, x, y, z)
    vx, vy, vz = point_velocity(
        b, x, y, z, axle[col.BELOW] * c * rate, q[col.JOINT_NOW] + axle[col.BELOW] * s * rate
    )
    m = axle[col.AXLE_MASS]
    for j, place, speed in ((0, px, vx), (1, py, vy), (2, pz, vz)):
        row[column + j] += m * (b[col.AT + j] + place)
        row[column + 6 + j] += m * speed
    spin = (b[col.NOW + 3] + rate) ** 2 + (c * b[col.NOW + 5] - s * b[col.NOW + 4]) ** 2
    return 0.5 * m * (vx * vx + vy * vy + vz * vz) + 0.5 * axle[col.AXLE_INERTIA] * spin
