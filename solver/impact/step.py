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

from typing import NamedTuple

import numpy as np

from fem.laws.contact_forces import (
    PointCrush,
    coulomb_force,
    crush_force,
    crush_line,
    loading_depth,
    loading_force,
)
from machine_code.compiled import compiled
from solver.impact.tyres import end_tyre_step, has_tyres, record_tyres, start_tyres, steer

SWEEPS = 200
SETTLED = 1e-13
"""Relative change of a force at which Gauss-Seidel ends; SWEEPS: largest number of sweeps."""

NEAR = 0.25
"""Step over the remaining time to the next jump of stiffness, at the tolerance."""

LOADING, UPRIGHT = 2.0, 0.25
"""Phase of a step on loading over that on a line of unloading; the second where the line is vertical and force
jumps."""

SHORTEST = 1e-3
"""Shortest separation that ends a strike [s]."""

LEANING = 0.2
"""Force of the wall over the largest, up to which a vehicle with tyres merely leans on it."""

LIGHT = 5e-3
"""Impulse of later touches of a corner, over that of the strike, below which they do not prolong it. Whether such
touches occur depends on micrometres, and therefore on the step."""

STRIKE = (
    "corner",
    "start",
    "end",
    "peak",
    "impulse",
    "tangential",
    "along",
    "place",
    "crush",
    "friction",
    "cut",
)
"""Columns of a strike: number of its unit and corner, 4 unit + corner; times [s], greatest force [N], impulses [N s],
impulse times place on the vehicle and along the wall [N s m], works [J], 1 where the motion ends before it is over."""
CUT = STRIKE.index("cut")

UNIT = ("x_g", "y_g", "theta", "v_gx", "v_gy", "omega")
SUMS = ("force_normal", "force_tangential", "crush_energy_stored", "crush_energy_lost", "impulse_normal",
        "impulse_tangential", "impulse_angular", "friction_work", "crush_work")  # fmt: skip
"""Columns of a row: `UNIT` of each unit, then `SUMS` of the train: forces [N], energies stored and lost [J], impulses
[N s] and that of their moment about the origin [N m s], works of friction and on the crush [J]. Of more units than one
follow for each the wall's impulses on it, normal and tangential [N s]."""

ALONG, ACROSS, STIFFNESS, INITIAL, PLATEAU, RESTITUTION, UNLOADING, FRICTION, X, Y = range(10)
DEPTH, EARLIER, AHEAD, DEEPEST, NORMAL, TANGENTIAL, PART, RATE, FOOT = range(10, 19)
"""Columns of points: as in `Train`; arm about the centre of mass; depth now, a step before, a step ahead, and the
deepest mean so far [m]; forces [N]; part of the step in which the force acts; for trains the rate of the depth
[m/s] and the depth at which the line of unloading ends [m]."""

SLOT, FIRST, LAST, FORCE, BEFORE, STAMP, WHOLE, AFTER = range(8)
"""Columns of groups: number of the latest strike, its start and end so far [s]; forces of this step and the one
before [N]; the step of the last contact; impulses of the strike and of touches after its end so far, the latest
included [N s]."""


def columns(units):
    """Return the number of a row's columns before those of tyres."""
    return 6 * units + len(SUMS) + (2 * units if units > 1 else 0)


class Work(NamedTuple):
    """Workspace of one sample.

    Columns of its tables are named above. points: a row for each point; point_owner: its unit and corner; motion, shape
    (3, 3 units): places and angles, velocities half a step ago and half a step ahead; masses: inverse mass of each
    velocity; load: accelerations by the external load; headings: cosine and sine of each unit's angle; joints: hitch
    and kingpin of each hinge; ties: its two conditions, see `_tie`; reach: from each centre of mass to the farthest
    point; effect: velocities by a unit impulse along and across on each point; groups: a row for each corner; active:
    points that may touch in this step; sums: impulses and works so far.
    """

    points: np.ndarray
    point_owner: np.ndarray
    motion: np.ndarray
    masses: np.ndarray
    load: np.ndarray
    headings: np.ndarray
    joints: np.ndarray
    ties: np.ndarray
    reach: np.ndarray
    effect: np.ndarray
    groups: np.ndarray
    active: np.ndarray
    sums: np.ndarray


def workspace(units: int, hinges: int, points: int) -> Work:
    """Return a workspace for one sample."""
    size = 3 * units
    return Work(
        np.zeros((points, 19)), np.zeros((points, 2), dtype=np.int64), np.zeros((3, size)), np.zeros(size),
        np.zeros(size), np.zeros((units, 2)), np.zeros((hinges, 2)), np.zeros((2 * hinges, 2 * size + 1)),
        np.zeros(units), np.zeros((points, 2, size)), np.zeros((4 * units, 8)), np.zeros(points, dtype=np.int64),
        np.zeros(columns(units) - 6 * units - 4),
    )  # fmt: skip


@compiled
def over_from(start, end):
    """Return the instant [s] from which a strike is over.

    start, end: its first and latest contact [s]. The corner has then been off the wall for as long as the strike has
    lasted. The repeated contacts of a plate are one strike; otherwise their number would depend on the mesh.
    """
    return end + max(SHORTEST, end - start)


@compiled
def advance(train, tyres, states, clock, work, rows, strikes):
    """Integrate every sample to its end.

    Results are written to states, shape (n, units, 6), rows, shape (n, rows, columns) or of the normal impulse alone,
    and strikes, shape (n, strikes, columns), as many as fit.
    """
    for i in range(train.mass.shape[1]):
        _begin(train, i, states[i], work)
        clock.reached[i], clock.counted[i] = _follow(states[i], clock, tyres, i, work, rows[i], strikes[i])


@compiled
def _begin(train, i, state, work):
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
        work.point_owner[p, 0], work.point_owner[p, 1] = u, 4 * u + train.corner[p]
        points[p, ALONG], points[p, ACROSS] = train.along[p, i], train.across[p, i]
        points[p, STIFFNESS], points[p, INITIAL] = train.stiffness[p, i], train.initial_force[p, i]
        points[p, PLATEAU], points[p, UNLOADING] = train.plateau_force[p, i], train.unloading_stiffness[p, i]
        points[p, RESTITUTION], points[p, FRICTION] = train.restitution[p, i], train.friction[p, i]
        reach[u] = max(reach[u], np.hypot(train.along[p, i], train.across[p, i]))


@compiled
def _follow(state, clock, tyres, i, work, rows, strikes):
    """Integrate sample i, and return its end [s] and number of strikes.

    The end is NaN if the steps did not suffice.
    """
    points, owner, motion = work.points, work.point_owner, work.motion
    active, sums = work.active, work.sums
    whole, parts, stride, end = clock.step[i], clock.parts[i], clock.stride[i], clock.end[i]
    finish, reached, parts_taken, h = min(end, clock.longest), np.nan, parts, whole
    number = row = part = np.int64(0)  # for the literal 0 the functions below would be compiled once more
    loaded, largest = 0.0, 0.0
    for m in range(motion.shape[1]):
        motion[2, m] -= 0.5 * h * work.load[m]
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
        steer(tyres, i, work.masses, work.headings, motion, last, kick)
        if work.joints.shape[0] > 0:
            _tie(motion, work.masses, work.joints, work.headings, work.ties, h)
        touching = _press(points, owner, motion, work.masses, work.ties, work.effect, active, kick, h)
        pressed = active[:touching]
        if touching > 0 and t < finish + h:
            steps_left = min((finish - t) / kick, 1.0)
            number = _count(
                points, owner, motion, pressed, work.groups, strikes, number, last, h, t, k, steps_left
            )
        if np.isnan(reached) and not end < np.inf:
            finish, loaded, largest = _finish(
                t, k, number, touching, loaded, largest, motion, work, strikes, clock, has_tyres(tyres)
            )
        if np.isnan(reached) and finish < t + h:
            _leave(kick, h, finish - t, motion, state)
            _name_cut(work.groups, k, finish, strikes)
            reached = finish
        if row * stride <= part and row < rows.shape[0]:
            early = _early(points, pressed, 0.5 * last / kick) if k > 0 else 0.0
            if rows.shape[1] > 1:
                _record(points, owner, motion, pressed, sums, early, kick, rows[row])
                record_tyres(tyres, i, work.headings, motion, early * kick, rows[row])
                row += 1
            else:
                impulse = sums[0]
                for p in pressed:
                    impulse += early * kick * points[p, NORMAL]
                row = _fill(rows, row, stride, part, impulse)
        if t >= finish and (row == rows.shape[0] or (row - 1) * stride * (whole / parts) >= finish):
            break
        _add(points, owner, motion, pressed, kick, sums)
        end_tyre_step(tyres, i, work.headings, motion, kick)
        _move(points, motion, pressed, h)
        part += parts_taken
    return reached, number


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
        depth, deepest = points[p, DEPTH], points[p, DEEPEST]
        upright = points[p, RESTITUTION] == 0.0 and points[p, UNLOADING] == 0.0
        rate = (depth - points[p, EARLIER]) / last
        slowing = (points[p, RATE] - rate) / last
        points[p, RATE] = rate
        pressed = (UPRIGHT if upright else LOADING) * phase / clock.rate[i]
        if depth <= points[p, FOOT]:
            if rate > 0.0:
                time_left = near * (points[p, FOOT] - depth) / rate
                length = deepest - points[p, FOOT]
                least = pressed if upright else floor * (phase * length / rate if length > 0.0 else pressed)
                shortest = min(shortest, max(time_left, least))
            continue
        shortest = min(shortest, pressed)
        if upright:
            points[p, FOOT] = deepest
        elif rate > 0.0 and depth >= deepest:
            if slowing > 0.0:
                least = floor * phase * np.sqrt(_length(points[p]) / slowing) if floor > 0.0 else 0.0
                shortest = min(shortest, max(near * rate / slowing, least))
        else:
            length = _length(points[p])
            points[p, FOOT] = deepest - length
            speed = max(abs(rate), 1e-300)
            end = deepest - depth if rate > 0.0 else depth - points[p, FOOT]
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
            points[p, EARLIER] = points[p, DEPTH] - 0.5 * (last + h) * points[p, RATE]


@compiled
def _place(points, point_owner, motion, headings, h, start):
    """Update arms and depths of all points at the new instant."""
    for j in range(motion.shape[1]):
        motion[1, j] = motion[2, j]
    j, c, s = -1, 1.0, 0.0
    for p in range(points.shape[0]):
        if 3 * point_owner[p, 0] != j:
            j = 3 * point_owner[p, 0]
            c, s = np.cos(motion[0, j + 2]), np.sin(motion[0, j + 2])
            headings[point_owner[p, 0], 0], headings[point_owner[p, 0], 1] = c, s
        x = points[p, ALONG] * c + points[p, ACROSS] * s
        y = points[p, ACROSS] * c - points[p, ALONG] * s
        depth = -(motion[0, j + 1] + y)
        rate = -(motion[2, j + 1] + motion[2, j + 2] * x)
        points[p, EARLIER] = depth - h * rate if start else points[p, DEPTH]
        points[p, X], points[p, Y], points[p, DEPTH] = x, y, depth


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
def _press(points, point_owner, motion, masses, ties, effect, active, kick, h):
    """Solve for the wall's forces and the velocities.

    Returns the number of points that may touch.
    """
    v, touching = motion[2], 0
    for p in range(points.shape[0]):
        j = 3 * point_owner[p, 0]
        x, y, w = points[p, X], points[p, Y], motion[1, j + 2]
        ahead = points[p, DEPTH] + h * (0.5 * h * w * w * y - v[j + 1] - v[j + 2] * x)
        if ahead <= points[p, FOOT] and points[p, DEPTH] <= points[p, FOOT]:
            points[p, NORMAL] = points[p, TANGENTIAL] = 0.0
            continue
        for m in range(v.size):
            effect[p, 0, m] = effect[p, 1, m] = 0.0
        effect[p, 0, j], effect[p, 1, j + 1] = masses[j], masses[j + 1]
        effect[p, 0, j + 2], effect[p, 1, j + 2] = -y * masses[j + 2], x * masses[j + 2]
        for a in range(ties.shape[0]):
            row = ties[a]
            along, across = row[j] - y * row[j + 2], row[j + 1] + x * row[j + 2]
            for m in range(v.size):
                effect[p, 0, m] -= along * row[m]
                effect[p, 1, m] -= across * row[m]
        points[p, PART] = 1.0 if points[p, NORMAL] > 0.0 else h / kick * _part(points[p], ahead)
        active[touching] = p
        touching += 1
    for a in range(touching):
        p = active[a]
        _push(kick * points[p, TANGENTIAL], kick * points[p, NORMAL], effect[p], v)
    for _ in range(SWEEPS if touching > 0 else 0):
        settled = True
        for a in range(touching):
            p = active[a]
            j = 3 * point_owner[p, 0]
            settled &= _solve_point(points[p], effect[p], v, j, motion[1, j + 2], kick, h)
        if settled:
            break
    return touching


@compiled
def _push(along, across, effect, v):
    for j in range(v.size):
        v[j] += along * effect[0, j] + across * effect[1, j]


@compiled
def _solve_point(point, effect, v, j, w, kick, h):
    """Solve for the forces of one point.

    Returns True without a change. j: its unit's first velocity; w: angular velocity.
    """
    x, y = point[X], point[Y]
    inertia = 1.0 / (kick * h * (effect[1, j + 1] + x * effect[1, j + 2]))
    ahead = point[DEPTH] + h * (0.5 * h * w * w * y - v[j + 1] - v[j + 2] * x)
    normal = _normal_force(point, ahead + point[NORMAL] / inertia, inertia)
    more = normal - point[NORMAL]
    _push(0.0, kick * more, effect, v)
    slip = v[j] - v[j + 2] * y - 0.5 * h * w * w * x
    stopping = point[TANGENTIAL] - slip / (kick * (effect[0, j] - y * effect[0, j + 2]))
    tangential = coulomb_force(stopping, point[FRICTION] * normal)
    turned = tangential - point[TANGENTIAL]
    _push(kick * turned, 0.0, effect, v)
    point[NORMAL], point[TANGENTIAL] = normal, tangential
    point[AHEAD] = point[DEPTH] + h * (0.5 * h * w * w * y - v[j + 1] - v[j + 2] * x)
    return abs(more) + abs(turned) <= SETTLED * (normal + abs(tangential))


@compiled
def _crush(point):
    """Return the crush law of a point."""
    returned = point[RESTITUTION] ** 2
    return PointCrush(point[STIFFNESS], point[INITIAL], returned, point[PLATEAU], point[UNLOADING])


@compiled
def _length(point):
    """Return the length of the unloading line [m]."""
    _, _, length, _ = crush_line(_crush(point), point[DEEPEST])
    return length


@compiled
def _normal_force(point, free, inertia):
    """Return the normal force of a point.

    The step ends at the depth `free` [m] without it, and N/inertia less with it.
    """
    crush, deepest, part = _crush(point), point[DEEPEST], point[PART]
    compliance, mean = 0.5 / inertia, 0.5 * (point[EARLIER] + free)
    depth = loading_depth(crush, mean, compliance, part)
    if _length(point) <= 0.0:
        most = part * loading_force(crush, max(depth, deepest))
        return min(max(inertia * (free - max(deepest, point[DEPTH])), 0.0), most)
    return crush_force(crush, deepest, mean, compliance, depth)


@compiled
def _part(point, ahead):
    """Return the part of the step after the touch of a point.

    The step is from half a step ago to half a step ahead. It applies to a force that begins suddenly.
    """
    closing = ahead - point[DEPTH]
    if _length(point) > 0.0 or closing <= 0.0:
        return 1.0
    return min(max(0.5 + (point[DEPTH] - point[DEEPEST]) / closing, 0.0), 1.0)


@compiled
def _count(points, point_owner, motion, active, groups, strikes, number, last, h, t, k, steps_left):
    """Add this step's forces to the strikes, and return their number.

    steps_left: from now to the end, up to 1.
    """
    kick = 0.5 * (last + h)
    part = min(max(steps_left + 0.5 * last / kick, 0.0), 1.0)
    for p in active:
        if points[p, NORMAL] <= 0.0:
            continue
        group = groups[point_owner[p, 1]]
        first, until = _pressed_during(points[p], last, h, t)
        if group[STAMP] < k:
            comes = group[STAMP] < k - 1
            if group[SLOT] < 0.0 or (comes and first >= over_from(group[FIRST], group[LAST])):
                group[SLOT], group[FIRST], group[LAST] = number, first, until
                group[WHOLE] = group[AFTER] = 0.0
                if number < strikes.shape[0]:
                    strikes[number, :] = 0.0
                number += 1
            if group[AFTER] >= LIGHT * group[WHOLE]:
                if comes:
                    group[AFTER] = 0.0
                else:
                    group[LAST] = until
            group[BEFORE] = 0.0 if comes else group[FORCE]
            group[FORCE], group[STAMP] = 0.0, k
        group[FORCE] += points[p, NORMAL]
        group[AFTER] += kick * points[p, NORMAL]
        group[WHOLE] += kick * points[p, NORMAL]
        if group[AFTER] >= LIGHT * group[WHOLE]:
            group[LAST] = max(group[LAST], until)
        if group[SLOT] >= strikes.shape[0]:
            continue
        strike, j = strikes[int(group[SLOT])], 3 * point_owner[p, 0]
        impulse, along = part * kick * points[p, NORMAL], part * kick * points[p, TANGENTIAL]
        strike[0], strike[1], strike[2] = point_owner[p, 1], group[FIRST], group[LAST]
        strike[3] = max(strike[3], group[FORCE] + min(steps_left, 0.0) * (group[FORCE] - group[BEFORE]))
        strike[4] += impulse
        strike[5] += along
        strike[6] += impulse * points[p, ALONG]
        strike[7] += impulse * (motion[0, j] + points[p, X])
        slip, opening = _mean_speeds(points[p], motion, j)
        strike[8] -= impulse * opening
        strike[9] += along * slip
    return number


@compiled
def _pressed_during(point, last, h, t):
    """Return start and end of a point's contact in this step [s].

    They follow from its speed; the start applies to a new contact.
    """
    peak, _, length, _ = crush_line(_crush(point), point[DEEPEST])
    rate = (point[AHEAD] - point[EARLIER]) / (0.5 * last + 1.5 * h)
    beyond = point[DEPTH] - max(point[DEEPEST] - length, 0.0)
    first, until = t, t + h
    if rate > 0.0:
        first = max(t - beyond / rate, t - h, 0.0)
    if length <= 0.0 and peak > 0.0:
        until = t - 0.5 * last + 0.5 * (last + h) * min(point[NORMAL] / peak, 1.0)
    elif rate < 0.0:
        until = min(max(t - beyond / rate, t - 0.5 * h), t + h)
    return first, until


@compiled
def _mean_speeds(point, motion, j):
    """Return mean speeds of a point along and across the wall.

    They are means of both half steps, with which energy is conserved.
    """
    w = motion[1, j + 2] + motion[2, j + 2]
    along, across = motion[1, j] + motion[2, j], motion[1, j + 1] + motion[2, j + 1]
    return 0.5 * (along - w * point[Y]), 0.5 * (across + w * point[X])


@compiled
def _finish(t, k, number, touching, loaded, largest, motion, work, strikes, clock, steered):
    """Return the end of the motion [s], and updated `loaded`, `largest`.

    loaded: last instant at which the vehicle did more than lean on the wall, where its tyres may hold it for seconds;
    largest: force of the wall so far [N]. steered: True with tyres.
    """
    force, is_young = 0.0, True
    if steered:
        force, is_young = _pressing(work.groups, k, t - clock.after)
        largest = max(largest, force)
    if is_young or force > LEANING * largest:
        loaded = t
    open_end = _open_end(
        t, k, loaded, number, touching, motion, work.reach, work.groups, strikes, clock.after, steered
    )
    leaning = loaded + clock.after if loaded < t else np.inf
    finish = min(max(open_end, _all_over(work.groups, k, leaning)), clock.longest)
    if loaded < t:  # a corner that touches lightly again does not end the motion in the past
        finish = max(finish, t)
    return finish, loaded, largest


@compiled
def _open_end(t, k, loaded, number, touching, motion, reach, groups, strikes, after, steered):
    """Return the end of the motion [s], infinite while it is unknown.

    loaded: see `_finish`. steered: with tyres a vehicle that is directed towards the wall will return to it.
    """
    rear = 4 * reach.size - 3  # of a train's last unit
    if reach.size > 1 and number >= 2 and groups[rear, SLOT] >= 0.0:
        if groups[rear, STAMP] != k:
            return groups[rear, LAST] + after
        return loaded + after if loaded < t else np.inf
    if reach.size == 1 and number >= 2:
        end = 0.0
        for s in range(2):
            g = int(strikes[s, 0])
            pressed = groups[g, STAMP] == k and groups[g, SLOT] == s
            if pressed and not loaded < t:
                return np.inf
            end = max(end, loaded if pressed else strikes[s, 2])
        return end + after
    end = max(after, t)
    for u in range(reach.size):
        v = motion[2, 3 * u + 1]
        if touching > 0 or v <= 0.0 or (steered and motion[0, 3 * u + 2] > 0.0):
            return np.inf
        end = max(end, t + max(reach[u] - motion[0, 3 * u + 1], 0.0) / v)
    return end


@compiled
def _pressing(groups, k, recent):
    """Return the normal force of the wall in this step [N].

    Also whether a strike in progress began after `recent`.
    """
    force, is_young = 0.0, False
    for g in range(groups.shape[0]):
        if groups[g, STAMP] == k:
            force += groups[g, FORCE]
            is_young = is_young or groups[g, FIRST] > recent
    return force, is_young


@compiled
def _all_over(groups, k, pressed):
    """Return the instant from which all strikes are over [s].

    pressed: that of strikes with corners in contact.
    """
    latest = 0.0
    for g in range(groups.shape[0]):
        if groups[g, SLOT] >= 0.0:
            over = over_from(groups[g, FIRST], groups[g, LAST])
            latest = max(latest, pressed if groups[g, STAMP] == k else over)
    return latest


@compiled
def _name_cut(groups, k, finish, strikes):
    """Mark the strikes that are not over when the motion ends."""
    for g in range(groups.shape[0]):
        if 0.0 <= groups[g, SLOT] < strikes.shape[0]:
            is_cut = groups[g, STAMP] == k or over_from(groups[g, FIRST], groups[g, LAST]) > finish
            strikes[int(groups[g, SLOT]), CUT] = 1.0 if is_cut else 0.0


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
        part, normal = points[p, PART], points[p, NORMAL]
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
        row[base] += points[p, NORMAL]
        row[base + 1] += points[p, TANGENTIAL]
    for j in range(sums.size):
        row[base + 4 + j] = sums[j]
    _add(points, point_owner, motion, active, early * h, row[base + 4 : base + 4 + sums.size])
    for p in range(points.shape[0]):
        deepest = _deepest(points[p])
        if deepest > 0.0:
            _, absorbed, length, returned = crush_line(_crush(points[p]), deepest)
            length_left = length - deepest + points[p, DEPTH]
            row[base + 3] += (1.0 - returned) * absorbed
            if length_left > 0.0 and length > 0.0:
                row[base + 2] += returned * absorbed * min(length_left / length, 1.0) ** 2


@compiled
def _fill(rows, row, stride, part, impulse):
    """Write the impulse at rows since the last one.

    A step over several rows begins at a row. Returns the number of the next row.
    """
    before, count = row - 1, part // stride - row + 1
    for j in range(1, min(count, rows.shape[0] - row) + 1):
        rows[before + j, 0] = impulse
        if j < count:
            rows[before + j, 0] += (j / count - 1.0) * (impulse - rows[before, 0])
    return min(row + count, rows.shape[0])


@compiled
def _deepest(point):
    """Return the deepest mean up to this step."""
    mean = 0.5 * (point[EARLIER] + point[AHEAD]) if point[NORMAL] > 0.0 else 0.0
    return max(point[DEEPEST], mean)


@compiled
def _add(points, point_owner, motion, active, h, sums):
    """Add impulses and works of the wall's forces over h."""
    for p in active:
        j = 3 * point_owner[p, 0]
        normal, along = h * points[p, NORMAL], h * points[p, TANGENTIAL]
        slip, opening = _mean_speeds(points[p], motion, j)
        sums[0] += normal
        sums[1] += along
        sums[2] += (motion[0, j] + points[p, X]) * normal - (motion[0, j + 1] + points[p, Y]) * along
        sums[3] += along * slip
        sums[4] -= normal * opening
        if sums.size > 5:
            sums[5 + 2 * point_owner[p, 0]] += normal
            sums[6 + 2 * point_owner[p, 0]] += along


@compiled
def _move(points, motion, active, h):
    """Advance points and units to the end of the step."""
    for p in active:
        points[p, DEEPEST] = _deepest(points[p])
    for m in range(motion.shape[1]):
        motion[0, m] += (-h if m % 3 == 2 else h) * motion[2, m]
