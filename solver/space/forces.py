"""Compiled forces of the wall on strips of a vehicle in space.

Strip               points of equal length on a line; a point is pushed by the crush law along the normal of the face,
                    in proportion to the part of its length below the wall's top. A point that was above the top
                    behind the face's upper edge is pushed up when it comes down. Friction acts against the sliding in
                    the face or on the top.
"""

import numpy as np

from fem.laws.contact_forces import PointCrush, crush_line, loading_force
from machine_code.compiled import inlined, reordered
from solver.space import state as col
from solver.space.dynamics import cross, rotated, turned_back
from solver.space.stopping import add_sums, centripetal, normal_power, returns_nothing
from solver.space.wall import mean_normal, point_of_face

EDGE = 0.02
"""Least half height of a point of a strip [m].

Over it the point leaves the face at the top and at an edge of the profile.
"""

INWARD = 0.5 / EDGE
"""Part of a point per distance from the edge, within which it lies on the top [1/m]."""

AT_REST = 1e-9
"""Distance from the deepest position within which a point rests there [m]."""

STEEPEST, STICKING = 0.25, 0.25
"""Limits of the slope of unloading times h^2, and of friction over sliding velocity times h, over the effective mass of
a point: the force of a step does not reverse the motion that causes it."""


@reordered
def add_force(b, x, y, z, fx, fy, fz):
    """Add a force at a point of a body.

    Returns the parts across and up in the axes of the body.
    """
    px, py, pz = turned_back(b, fx, fy, fz)
    mx, my, mz = cross(x, y, z, px, py, pz)
    b[col.LOAD] += px
    b[col.LOAD + 1] += py
    b[col.LOAD + 2] += pz
    b[col.LOAD + 3] += mx
    b[col.LOAD + 4] += my
    b[col.LOAD + 5] += mz
    return py, pz


@reordered
def add_axle_force(b, q, centre, x, y, z, fx, fy, fz):
    """Add a force at a point of an axle.

    centre: height of the roll centre in the axes of the body [m].
    """
    across, up = add_force(b, x, y, z, fx, fy, fz)
    q[col.JOINT_LOAD] += up
    q[col.JOINT_LOAD + 1] += y * up - (z - centre) * across


@reordered
def point_velocity(b, x, y, z, uy, uz):
    """Return the velocity in space of a point of a body.

    uy, uz: velocity relative to the body, in its axes [m/s].
    """
    vx, vy, vz = cross(b[col.NOW + 3], b[col.NOW + 4], b[col.NOW + 5], x, y, z)
    vx, vy, vz = rotated(b, vx, vy + uy, vz + uz)
    return b[col.NOW] + vx, b[col.NOW + 1] + vy, b[col.NOW + 2] + vz


@reordered
def press_strips(fleet, i, units, axles, strips, facets, work, h, ahead):
    """Add the wall forces on all strips.

    h: the step, until `ahead` from now [s]. Returns True if a point is behind the face, or has come down on the top.
    """
    touching, first = False, 0
    for k in range(strips.shape[0]):
        u, a, points = fleet.strip_unit[k], fleet.strip_axle[k], fleet.strip_points[k]
        b, q = work.bodies[u], work.joints[max(a, 0)]  # unused of a strip of the body
        if returns_nothing(strips[k]):
            work.pushes[2 * k, col.STOPPED] = work.pushes[2 * k + 1, col.STOPPED] = -1.0
        if b[col.AT + 1] - units[u, col.REACH] <= work.wall[0, 0]:
            centre = axles[a, col.CENTRE] if a >= 0 else np.nan
            of_axle = 1.0 / axles[a, col.AXLE_MASS] if a >= 0 else 0.0
            for side in range(2):
                touches = _press_strip(
                    strips[k], 2.0 * side - 1.0, centre, b, q, work.wall, facets,
                    work.memory[first + side * points : first + (side + 1) * points], work.pushes[2 * k + side],
                    fleet.friction[i], 4.0 / units[u, col.MASS], of_axle, work.bodies[0, col.AT], work.sums, h, ahead,
                )  # fmt: skip
                touching = touching or touches
        first += 2 * points
    return touching


@reordered
def _end(strip, at, side, centre, q):
    """Return position and velocity of an end of a strip.

    Both are in the body's axes. centre: height of the roll centre of its axle at rest, NaN for a strip of the body.
    """
    x, y, z = strip[at], side * strip[at + 1], strip[at + 2]
    if np.isnan(centre):
        return x, y, z, 0.0, 0.0
    c, s = q[col.COSINE], q[col.SINE]
    y, z = y * c - z * s, y * s + z * c
    heave_rate, roll_rate = q[col.JOINT_NOW], q[col.JOINT_NOW + 1]
    return x, y, centre + q[col.JOINT] + z, -z * roll_rate, heave_rate + y * roll_rate


@reordered
def _press_strip(
    strip, side, centre, b, q, wall, facets, memories, push, coefficient, mobility, of_axle, origin, sums, h, ahead
):  # fmt: skip
    """Add the wall forces on a strip.

    Returns True if a point touches. origin: place along the wall from which stations count; mobility, of_axle: inverse
    masses of the body at a point, and of the axle.
    """
    ax, ay, az, auy, auz = _end(strip, col.START, side, centre, q)
    bx, by, bz, buy, buz = _end(strip, col.END, side, centre, q)
    sy, ey = (
        b[3] * ax + b[4] * ay + b[5] * az + b[col.AT + 1],
        b[3] * bx + b[4] * by + b[5] * bz + b[col.AT + 1],
    )
    toe, top, edge = wall[0, 0], wall[facets - 1, 3], wall[facets - 1, 2]
    svx, svy, svz, evx, evy, evz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    early, stops = 0.0, returns_nothing(strip)  # largest gap that closes within the step
    if strip[col.INITIAL] > 0.0:
        svx, svy, svz = point_velocity(b, ax, ay, az, auy, auz)
        evx, evy, evz = point_velocity(b, bx, by, bz, buy, buz)
        early = ahead * (abs(svy) + abs(evy) + abs(svz) + abs(evz))
        toe += early
    if min(sy, ey) > toe:
        if memories[0, col.RAISED] > 0.0:
            for n in range(memories.shape[0]):
                memories[n, col.ABOVE] = 0.0
            memories[0, col.RAISED] = 0.0
        return False
    sx, _, sz = rotated(b, ax, ay, az)
    ex, _, ez = rotated(b, bx, by, bz)
    sz, ez = sz + b[col.AT + 2], ez + b[col.AT + 2]
    points, inner = memories.shape[0], edge - 2.0 * EDGE
    spacing = 1.0 / points
    rise = 0.5 * (ez - sz) * spacing
    half = np.sqrt(rise * rise + strip[col.THICK] * strip[col.THICK])
    if min(sz, ez) - half > top and max(sy, ey) < inner:
        for n in range(points):
            memories[n, col.ABOVE] = 1.0
        memories[0, col.RAISED] = 1.0
        return False
    if stops and early == 0.0:
        svx, svy, svz = point_velocity(b, ax, ay, az, auy, auz)
        evx, evy, evz = point_velocity(b, bx, by, bz, buy, buz)
    upward = 0.5 / half
    crush = _crush_of(strip, strip[col.LENGTH] * spacing)
    stopping = STICKING / (h * points * (mobility + of_axle))
    touches, pressed, begin, end = False, False, points, 0  # points in part on the top
    raised, spread, work, lost = False, 0.0, 0.0, 0.0
    fsx, fsy, fsz, fex, fey, fez = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    nsy, nsz, ney, nez, gap = 0.0, 0.0, 0.0, 0.0, 0.0  # normal forces of a strip that returns nothing
    for column in (col.FACE, col.TOP):
        for n in range(0 if column == col.FACE else begin, points if column == col.FACE else end):
            p = spacing * (n + 0.5)
            o = 1.0 - p
            y, z, memory = o * sy + p * ey, o * sz + p * ez, memories[n]
            share, weight = memory[col.ABOVE], 1.0
            if column == col.FACE:
                if y > toe:  # clear of the wall at any height
                    memory[col.ABOVE] = 0.0
                    continue
                if z + half > top or share > 0.0:
                    if z - half > top and y < inner:
                        memory[col.ABOVE], raised = 1.0, True
                        continue
                    above = min(max(0.5 + (z - top) * upward, 0.0), 1.0)
                    share = min(max(share, above), min(max((edge - y) * INWARD, 0.0), 1.0))
                    memory[col.ABOVE], weight = share, 1.0 - max(above, share)
                    if share > 0.0:
                        raised = True
                        if top - z + half * (2.0 * share - 1.0) > 0.0:
                            begin, end = min(begin, n), n + 1
                    if weight <= 0.0:
                        continue
                face, k = point_of_face(wall, facets, z)
                if face + early <= y:
                    continue
                ny, nz = mean_normal(wall, facets, k, z - half, z + half)
                depth = (face - y) * ny
            else:
                lowest = top - z + half * (2.0 * share - 1.0)  # depth of the lowest part that was above
                sunk = min(lowest, 2.0 * half * share)
                if sunk <= 0.0:
                    continue
                ny, nz, depth, weight = 0.0, 1.0, lowest - 0.5 * sunk, sunk * upward
            touches = touches or depth > 0.0
            inverse = h * h * points * (mobility + nz * nz * of_axle)
            if column == col.FACE and early > 0.0 and memory[column] == 0.0:
                closing = -(o * svy + p * evy) * ny - (o * svz + p * evz) * nz
                force = weight * _first_force(crush, memory, depth, _part(depth, closing, h, ahead))
            elif stops:
                closing = -(o * svy + p * evy) * ny - (o * svz + p * evz) * nz
                beyond, memory[column] = depth - memory[column], max(memory[column], depth)
                part = _part(beyond, closing, h, ahead) if abs(beyond) > AT_REST else 1.0
                force = weight * part * loading_force(crush, memory[column])
                gap -= force * min(beyond, 0.0) / h
            else:
                force = _point_force(crush, memory, column, depth, weight, inverse)
            if force <= 0.0:
                continue
            if stops:
                nsy, nsz = nsy + o * force * ny, nsz + o * force * nz
                ney, nez = ney + p * force * ny, nez + p * force * nz
            if not pressed:
                pressed = True
                svx, svy, svz = point_velocity(b, ax, ay, az, auy, auz)
                evx, evy, evz = point_velocity(b, bx, by, bz, buy, buz)
                sx, ex = sx + b[col.AT] - origin, ex + b[col.AT] - origin
            vx, vy, vz = o * svx + p * evx, o * svy + p * evy, o * svz + p * evz
            fx, fy, fz, approach, loss = _wall_force(vx, vy, vz, ny, nz, force, coefficient * force, stopping)
            fsx, fsy, fsz = fsx + o * fx, fsy + o * fy, fsz + o * fz
            fex, fey, fez = fex + p * fx, fey + p * fy, fez + p * fz
            spread += fy * (o * sx + p * ex) ** 2
            work += force * approach
            lost += loss
    memories[0, col.RAISED] = 1.0 if raised else 0.0
    if not pressed:
        return touches
    for j in range(8 if stops else 0):
        push[col.RESPONSE + j] = -_load(b, q, j)
    _press_ends(b, q, centre, ax, ay, az, bx, by, bz, fsx, fsy - nsy, fsz - nsz, fex, fey - ney, fez - nez)
    added = push[col.ADDED :]
    added[col.LATERAL] = fsy + fey
    added[col.ALONG] = fsx + fex
    added[col.UP] = fsz + fez
    added[col.MOMENT] = fsy * sz + fey * ez
    added[col.STATION] = fsy * sx + fey * ex
    added[col.SPREAD] = spread
    added[col.WALL_WORK] = h * work
    added[col.FRICTION_WORK] = -h * lost
    if not stops:
        add_sums(push, sums, 1.0)
        return touches
    _, asy, asz = centripetal(b, ax, ay, az)
    _, aey, aez = centripetal(b, bx, by, bz)
    turning = 0.5 * h * (nsy * asy + nsz * asz + ney * aey + nez * aez)
    push[col.STOPPED], push[col.GAP] = 0.0, gap + turning
    for j in range(8):
        push[col.NORMAL + j] = -_load(b, q, j)
    _press_ends(b, q, centre, ax, ay, az, bx, by, bz, 0.0, nsy, nsz, 0.0, ney, nez)
    for j in range(8):
        push[col.NORMAL + j] += _load(b, q, j)
        push[col.RESPONSE + j] += _load(b, q, j)
    push[col.CLOSING] = turning - normal_power(push, b, q)
    return touches


@inlined
def _load(b, q, j):
    """Return a load on a body, from 6 on of an axle."""
    return b[col.LOAD + j] if j < 6 else q[col.JOINT_LOAD + j - 6]


@reordered
def _press_ends(b, q, centre, ax, ay, az, bx, by, bz, fsx, fsy, fsz, fex, fey, fez):
    """Add forces at both ends of a strip.

    centre: as of `_end`.
    """
    if np.isnan(centre):
        add_force(b, ax, ay, az, fsx, fsy, fsz)
        add_force(b, bx, by, bz, fex, fey, fez)
    else:
        centre += q[col.JOINT]
        add_axle_force(b, q, centre, ax, ay, az, fsx, fsy, fsz)
        add_axle_force(b, q, centre, bx, by, bz, fex, fey, fez)


@inlined
def _part(depth, closing, h, ahead):
    """Return the part of the step after the touch of a point.

    closing: velocity into the face [m/s]. It applies to a force that begins suddenly.
    """
    if closing <= 0.0:
        return 1.0 if depth > 0.0 else 0.0
    return min(max((ahead + depth / closing) / h, 0.0), 1.0)


@inlined
def _first_force(crush, memory, depth, part):
    """Return the force on a point that has not been pressed [N].

    part: of the step, in which the initial force acts.
    """
    memory[col.FACE] = max(depth, 0.0)
    begun = PointCrush(
        crush.stiffness,
        part * crush.initial_force,
        crush.returned,
        crush.plateau,
        crush.unloading,
        crush.hardening,
    )
    return loading_force(begun, memory[col.FACE])


@inlined
def _crush_of(strip, length):
    """Return the crush law of this length of a strip [m]."""
    stiffness, plateau = strip[col.STIFFNESS] * length, strip[col.PLATEAU] * length
    unloading, hardening = strip[col.UNLOADING] * length, strip[col.HARDENING] * length
    return PointCrush(
        stiffness, strip[col.INITIAL] * length, strip[col.RETURNED], plateau, unloading, hardening
    )


@inlined
def _point_force(crush, memory, column, depth, weight, inverse):
    """Return the force of the crush law on a point [N].

    weight: fraction of its length that is in contact; inverse: square of the step over the effective mass [s^2/kg].
    """
    if depth <= memory[column + col.FOOT]:
        return 0.0
    if depth >= memory[column]:
        memory[column], memory[column + col.SLOPE] = depth, 0.0
        return weight * loading_force(crush, depth)
    if memory[column + col.SLOPE] == 0.0:
        _set_unloading(crush, memory, column, inverse)
    return weight * memory[column + col.SLOPE] * (depth - memory[column + col.FOOT])


@inlined
def _wall_force(vx, vy, vz, ny, nz, force, limit, stopping):
    """Return force of the wall on a point, approach and loss.

    The force has the normal part `force` and friction of at most `limit` [N]. stopping: largest friction over sliding
    velocity [N s/m]. The approach is the velocity along the normal [m/s], the loss the power of friction [W].
    """
    approach = vy * ny + vz * nz
    ty, tz = vy - approach * ny, vz - approach * nz
    sliding = np.sqrt(vx * vx + ty * ty + tz * tz)
    drag = limit / sliding if limit < stopping * sliding else stopping
    return -drag * vx, force * ny - drag * ty, force * nz - drag * tz, approach, drag * sliding * sliding


@reordered
def _set_unloading(crush, memory, column, inverse):
    """Set the line of unloading of a point from its deepest position.

    inverse: square of the step over the effective mass [s^2/kg].
    """
    peak, _, length, _ = crush_line(crush, memory[column])
    length = max(length, peak * inverse / STEEPEST)
    memory[column + col.FOOT] = memory[column] - length
    memory[column + col.SLOPE] = peak / length if length > 0.0 else 0.0
