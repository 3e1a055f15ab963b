"""Compiled motion of trains that strike a wall.

A train consists of rigid units joined by hinges, with points that the wall, Y = 0, may push. The step is that of the
finite-element loop: forces at the positions of the points, velocities half a step ahead, then positions a step ahead.
    depth       d of a point behind the wall, -y; the crush law takes its mean a step before and a step ahead
    normal      N by the crush law: F0 + k d, and the line of unloading below the deepest
    stopping    the force that would end the step with the point at rest along the wall
    tangential  the stopping force, at most mu N: a point either sticks or slides
The forces, and those in the hinges, are solved together by Gauss-Seidel over the points in contact. A force that begins
suddenly, as F0 does at first touch, counts for its part of the step; a vertical line of unloading (e = 0) is solved for
the end of the step. The scheme is of second order.

Steps of a train are divided into parts, because its unloading lasts a millisecond and its motion a second:
`_parts_of_step`.
"""

import numpy as np

from fem.laws.contact_forces import crush_line
from machine_code.compiled import compiled, inlined
from solver.impact import state as col
from solver.impact.contact import crush_of, deepening, mean_speeds, press, set_line
from solver.impact.counting import count_strikes, end_of_motion, mark_cut
from solver.impact.tyres import end_tyre_step, record_tyres, start_tyres, steer
from solver.rotation import sine_and_versine

NEAR = 0.25
"""Step over the remaining time to the next jump of stiffness, at the tolerance."""

ROUNDED = 1e-9
"""Depth beyond a jump of stiffness [m] that is rounding, by which no step is chosen."""

LOADING, UPRIGHT = 2.0, 0.25
"""Phase of a step on loading over that on a line of unloading; the second where the line is vertical and force
jumps."""


@compiled
def begin(train, i, state, work):
    """Set the workspace to the start of sample i, without contact."""
    points, reach = work.points, work.reach
    points[:], work.sums[:], work.groups[:], reach[:] = 0.0, 0.0, -1.0, 0.0
    for u in range(state.shape[0]):
        for j in range(3):
            m = 3 * u + j
            work.motion[0, m], work.motion[2, m] = state[u, j], state[u, 3 + j]
            work.masses[m] = 1.0 / (train.inertia[u, i] if j == 2 else train.mass[u, i])
            work.load[m] = work.masses[m] * train.load[u, j, i]
    for hinge in range(work.joints.shape[0]):
        work.joints[hinge, 0], work.joints[hinge, 1] = train.hitch[hinge, i], train.kingpin[hinge, i]
    for p in range(train.unit.size):
        u = train.unit[p]
        work.point_owner[p, 0], work.point_owner[p, 1] = u, train.group[p]
        points[p, col.ALONG], points[p, col.ACROSS] = train.along[p, i], train.across[p, i]
        points[p, col.STIFFNESS], points[p, col.INITIAL] = train.stiffness[p, i], train.initial_force[p, i]
        points[p, col.PLATEAU], points[p, col.UNLOADING] = (
            train.plateau_force[p, i],
            train.unloading_stiffness[p, i],
        )
        points[p, col.RESTITUTION], points[p, col.FRICTION] = train.restitution[p, i], train.friction[p, i]
        points[p, col.HARDENING] = train.hardening[p, i]
        set_line(points[p])
        reach[u] = max(reach[u], np.hypot(train.along[p, i], train.across[p, i]))


@compiled
def follow(state, clock, tyres, i, work, rows, strikes):
    """Integrate sample i, and return its end [s] and number of strikes.

    The end is NaN if the steps did not suffice.
    """
    points, owner, motion = work.points, work.point_owner, work.motion
    active, sums = work.active, work.sums
    whole, parts, stride, end = clock.step[i], clock.parts[i], clock.stride[i], clock.end
    finish, reached, parts_taken, h = min(end, clock.longest), np.nan, parts, whole
    number = row = part = 0
    loaded, largest = 0.0, 0.0
    for m in range(motion.shape[1]):
        motion[2, m] -= 0.5 * h * work.load[m]
    steered = tyres.unit.size > 0
    if steered:
        start_tyres(tyres, i, work.masses, work.headings, work.load, motion, h)
    for k in range(clock.most):
        t, last = part * (whole / parts), h
        _place(points, owner, motion, work.headings, last, k == 0)
        if parts > 1:
            parts_taken = _parts_of_step(points, clock, i, part, parts_taken, last)
            h = parts_taken * (whole / parts)
            _look_back(points, last, h)
        kick = 0.5 * (last + h)
        for m in range(motion.shape[1]):
            motion[2, m] += kick * work.load[m]
        if steered:
            steer(tyres, i, work.masses, work.headings, motion, last, kick)
        if work.joints.shape[0] > 0:
            _tie(motion, work.masses, work.joints, work.headings, work.ties, h)
        touching = press(points, owner, motion, work.masses, work.ties, work.effect, active, kick, h)
        pressed = active[:touching]
        if touching > 0 and t < finish + h:
            steps_left = min((finish - t) / kick, 1.0)
            number = count_strikes(
                points, owner, motion, pressed, work.groups, strikes, number, last, h, t, k, steps_left
            )
        if np.isnan(reached) and not end < np.inf:
            finish, loaded, largest = end_of_motion(
                t, k, number, touching, loaded, largest, motion, work, strikes, clock, steered
            )
        if np.isnan(reached) and finish < t + h:
            _leave(kick, h, finish - t, motion, state)
            mark_cut(work.groups, k, finish, strikes)
            reached = finish
        if row * stride <= part and row < rows.shape[0]:
            early = _early(points, pressed, 0.5 * last / kick) if k > 0 else 0.0
            row = _write_rows(tyres, clock, i, work, pressed, early, kick, rows, row, stride, part)
        if t >= finish and (row == rows.shape[0] or (row - 1) * stride * (whole / parts) >= finish):
            break
        _add(points, owner, motion, pressed, kick, sums)
        if steered:
            end_tyre_step(tyres, i, work.headings, motion, kick)
        _move(points, motion, pressed, h)
        part += parts_taken
    return reached, number


@inlined
def _write_rows(tyres, clock, i, work, pressed, early, kick, rows, row, stride, part):
    """Write the row of this instant and return the next number.

    Of rows with the impulse alone, or the velocity of the sensor beside it, all since the last one are written.
    """
    points, motion = work.points, work.motion
    if rows.shape[1] > 2:
        _record(points, work.point_owner, motion, pressed, work.sums, early, kick, rows[row])
        if tyres.unit.size > 0:
            record_tyres(tyres, i, work.headings, motion, early * kick, rows[row])
        return row + 1
    impulse = work.sums[0]
    for p in pressed:
        impulse += early * kick * points[p, col.NORMAL]
    velocity = 0.0
    if rows.shape[1] > 1:
        arm = clock.sensor[i] * work.headings[0, 0]
        before, after = motion[1, 1] + arm * motion[1, 2], motion[2, 1] + arm * motion[2, 2]
        velocity = before + early * (after - before)
    return _fill(rows, row, stride, part, impulse, velocity)


@compiled
def _parts_of_step(points, clock, i, part, parts_taken, last):
    """Choose the next step in parts of a whole step.

    Their number is a power of two, at most twice the last, and divides the position in the whole step. On the law a
    step is a phase of its oscillation, whose stiffness on the line of unloading is larger by 1/e^2. Near jumps of
    stiffness, at touch, at the deepest point and at the foot of the line, steps decrease with the remaining time, to
    `floor` times the step beyond the jump. On a vertical line they do not, because its force stops a point within a
    step.
    """
    phase, near, floor = clock.phase * clock.pace[i], NEAR * clock.pace[i], clock.floor
    shortest = np.inf
    for p in range(points.shape[0]):
        depth = points[p, col.DEPTH]
        upright = points[p, col.RESTITUTION] == 0.0 and points[p, col.UNLOADING] == 0.0
        rate = (depth - points[p, col.EARLIER]) / last
        slowing = (points[p, col.RATE] - rate) / last
        points[p, col.RATE] = rate
        pressed = (UPRIGHT if upright else LOADING) * phase / clock.rate[i]
        if depth <= points[p, col.FOOT] + ROUNDED:
            if rate > 0.0:
                time_left = near * (points[p, col.FOOT] - depth) / rate
                length = -points[p, col.FOOT]
                least = pressed if upright else floor * (phase * length / rate if length > 0.0 else pressed)
                shortest = min(shortest, max(time_left, least))
            continue
        shortest = min(shortest, pressed)
        if upright:
            points[p, col.FOOT] = 0.0
        elif rate > 0.0 and depth >= -ROUNDED:
            if slowing > 0.0:
                least = floor * phase * np.sqrt(points[p, col.LINE] / slowing) if floor > 0.0 else 0.0
                shortest = min(shortest, max(near * rate / slowing, least))
        else:
            length = points[p, col.LINE]
            points[p, col.FOOT] = -length
            speed = max(abs(rate), 1e-300)
            end = -depth if rate > 0.0 else depth - points[p, col.FOOT]
            swing = max(speed, np.sqrt(length * abs(slowing)))
            full = phase * length / swing
            shortest = min(shortest, full, max(near * end / speed, floor * full))
    parts_taken = min(2 * parts_taken, clock.parts[i])
    while part & (parts_taken - 1) > 0 or (
        parts_taken > 1 and parts_taken * clock.step[i] > shortest * clock.parts[i]
    ):
        parts_taken >>= 1
    return parts_taken


@compiled
def _look_back(points, last, h):
    """Set the earlier depth where the step changes.

    The mean of the depths is then that of the middle of the kick.
    """
    if h != last:
        for p in range(points.shape[0]):
            points[p, col.EARLIER] = points[p, col.DEPTH] - 0.5 * (last + h) * points[p, col.RATE]


@compiled
def _place(points, point_owner, motion, headings, h, start):
    """Update arms and depths of all points at the new instant.

    Headings turn, and depths increase, by the motion of the step.
    """
    for j in range(motion.shape[1]):
        motion[1, j] = motion[2, j]
    for u in range(headings.shape[0]):
        heading, turn = headings[u], h * motion[2, 3 * u + 2]
        if start:
            heading[0], heading[1] = np.cos(motion[0, 3 * u + 2]), np.sin(motion[0, 3 * u + 2])
            continue
        square, c, s = turn * turn, heading[0], heading[1]
        sine, versine = sine_and_versine(square)
        sine, versine = turn * sine, 0.5 * square * versine
        heading[0] += s * sine - c * versine
        heading[1] -= c * sine + s * versine
        heading[2], heading[3] = sine, versine
    for p in range(points.shape[0]):
        point, heading, j = points[p], headings[point_owner[p, 0]], 3 * point_owner[p, 0]
        x = point[col.ALONG] * heading[0] + point[col.ACROSS] * heading[1]
        y = point[col.ACROSS] * heading[0] - point[col.ALONG] * heading[1]
        if start:
            point[col.DEPTH] = -(motion[0, j + 1] + y)
            point[col.EARLIER] = point[col.DEPTH] + h * (motion[2, j + 1] + motion[2, j + 2] * x)
        else:
            point[col.EARLIER] = point[col.DEPTH]
            point[col.DEPTH] += point[col.Y] * heading[3] - point[col.X] * heading[2] - h * motion[2, j + 1]
        point[col.X], point[col.Y] = x, y


@compiled
def _tie(motion, masses, joints, headings, ties, h):
    """Correct velocities so that hinges are closed at the step's end.

    A row of `ties` is a hinge's condition along or across: velocities by a unit impulse in it, the condition itself,
    and the rate at which the gap opens. Rows are orthonormal in the inverse masses, so that corrections are
    independent.
    """
    size = masses.size
    ties[:] = 0.0
    for a in range(ties.shape[0]):
        hinge, axis, row = a // 2, a % 2, ties[a]
        for side in range(2):
            u, sign = hinge + side, 1.0 - 2.0 * side
            j, w = 3 * u, motion[2, 3 * u + 2]
            x, y = joints[hinge, side] * headings[u, 0], -joints[hinge, side] * headings[u, 1]
            arm = x if axis == 0 else y
            row[size + j + axis] = sign
            row[size + j + 2] = sign * (x if axis == 1 else -y)
            row[j + axis] = masses[j + axis] * row[size + j + axis]
            row[j + 2] = masses[j + 2] * row[size + j + 2]
            row[-1] += sign * ((motion[0, j + axis] + arm) / h - 0.5 * h * w * w * arm)
            row[-1] += row[size + j + axis] * motion[2, j + axis] + row[size + j + 2] * w
        for b in range(max(a - 3, 0), a):  # a unit has no more hinges than two
            along = 0.0
            for j in range(size):
                along += ties[b, j] * row[size + j]
            for j in range(2 * size):
                row[j] -= along * ties[b, j]
        length = 0.0
        for j in range(size):
            length += row[j] * row[size + j]
        scale = 1.0 / np.sqrt(length)
        for j in range(row.size):
            row[j] *= scale
        for j in range(size):
            motion[2, j] -= row[j] * row[-1]


@compiled
def _leave(kick, h, ahead, motion, state):
    """Write the state `ahead` seconds after this instant into `state`."""
    for m in range(motion.shape[1]):
        v, gain = motion[2, m], motion[2, m] - motion[1, m]
        state[m // 3, m % 3] = motion[0, m] + (-ahead if m % 3 == 2 else ahead) * v
        state[m // 3, 3 + m % 3] = v + (ahead / kick - 0.5 * h / kick) * gain


@compiled
def _early(points, active, before):
    """Return the part of this step's impulse before its instant."""
    total, early = 0.0, 0.0
    for p in active:
        part, normal = points[p, col.PART], points[p, col.NORMAL]
        total += normal
        early += normal * (
            before if part == 1.0 else max(part - (1.0 - before), 0.0) / part if part > 0.0 else 0.0
        )
    return early / total if total > 0.0 else 0.5


@compiled
def _record(points, point_owner, motion, active, sums, early, h, row):
    """Fill the row of this instant."""
    base = 2 * motion.shape[1]
    for m in range(motion.shape[1]):
        row[6 * (m // 3) + m % 3] = motion[0, m]
        row[6 * (m // 3) + 3 + m % 3] = motion[1, m] + early * (motion[2, m] - motion[1, m])
    row[base:] = 0.0
    for p in active:
        row[base] += points[p, col.NORMAL]
        row[base + 1] += points[p, col.TANGENTIAL]
    for j in range(sums.size):
        row[base + 4 + j] = sums[j]
    _add(points, point_owner, motion, active, early * h, row[base + 4 : base + 4 + sums.size])
    for p in range(points.shape[0]):
        beyond = deepening(points[p])
        if points[p, col.DEEPEST] + beyond > 0.0:
            _, absorbed, length, returned = crush_line(crush_of(points[p]), points[p, col.DEEPEST] + beyond)
            length_left = length - beyond + points[p, col.DEPTH]
            row[base + 3] += (1.0 - returned) * absorbed
            if length_left > 0.0 and length > 0.0:
                row[base + 2] += returned * absorbed * min(length_left / length, 1.0) ** 2


@compiled
def _fill(rows, row, stride, part, impulse, velocity):
    """Write impulse and sensor's velocity since the last row.

    A step over several rows begins at a row. Returns the number of the next row.
    """
    before, count = row - 1, part // stride - row + 1
    for j in range(1, min(count, rows.shape[0] - row) + 1):
        for column in range(rows.shape[1]):
            value = impulse if column == 0 else velocity
            rows[before + j, column] = value
            if j < count:
                rows[before + j, column] += (j / count - 1.0) * (value - rows[before, column])
    return min(row + count, rows.shape[0])


@compiled
def _add(points, point_owner, motion, active, h, sums):
    """Add impulses and works of the wall's forces over h."""
    for p in active:
        j = 3 * point_owner[p, 0]
        normal, along = h * points[p, col.NORMAL], h * points[p, col.TANGENTIAL]
        slip, opening = mean_speeds(points[p], motion, j)
        sums[0] += normal
        sums[1] += along
        sums[2] += (motion[0, j] + points[p, col.X]) * normal - (motion[0, j + 1] + points[p, col.Y]) * along
        sums[3] += along * slip
        sums[4] -= normal * opening
        if sums.size > 5:
            sums[5 + 2 * point_owner[p, 0]] += normal
            sums[6 + 2 * point_owner[p, 0]] += along


@compiled
def _move(points, motion, active, h):
    """Advance points and units to the end of the step."""
    for p in active:
        beyond = deepening(points[p])
        if beyond > 0.0:
            points[p, col.DEEPEST] += beyond
            points[p, col.DEPTH] -= beyond
            points[p, col.FOOT] -= beyond
            set_line(points[p])
    for m in range(motion.shape[1]):
        motion[0, m] += (-h if m % 3 == 2 else h) * motion[2, m]
