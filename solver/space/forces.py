"""Compiled forces of strips, axles and hinges of a vehicle in space.

Strip               points of equal length on a line; a point is pushed by the crush law along the normal of the face,
                    in proportion to the part of its length below the wall's top. A point that was above the top
                    behind the face's upper edge is pushed up when it comes down. Friction acts against the sliding in
                    the face or on the top.
Spring of an axle   linear with a damper, between body and axle, along the body's z
Tyre                linear and unilateral, upward at the ground above the lowest point of the unloaded wheel; side
                    force of the axle's law (`fem.laws.contact_forces.side_force`) by the speed across there and that
                    ahead of the middle of the axle
Hinge               moment in proportion to the sine of the angle between the lateral axis of the unit ahead and the
                    floor of the unit behind
"""

import numpy as np

from fem.laws.contact_forces import side_force
from machine_code.compiled import inlined, reordered
from solver.space import state as col
from solver.space.dynamics import cross, rotated, turned_back
from solver.space.points import EDGE, Crest, Ends, law_of, press_points
from solver.space.stopping import add_sums, centripetal, normal_power, returns_nothing


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
            for n in range(4):
                work.pushes[4 * k + n, col.STOPPED] = -1.0
        if b[col.AT + 1] - units[u, col.REACH] <= work.wall[0, 0]:
            centre = axles[a, col.CENTRE] if a >= 0 else np.nan
            of_axle = 1.0 / axles[a, col.AXLE_MASS] if a >= 0 else 0.0
            for side in range(2):
                row, point = 4 * k + 2 * side, first + side * points
                touches = _press_strip(
                    strips[k], 2.0 * side - 1.0, centre, b, q, work.wall, facets,
                    work.memory[point : point + points], work.pushes[row : row + 2],
                    fleet.friction[i], 4.0 / units[u, col.MASS], of_axle, work.bodies[0, col.AT], work.sums, h, ahead,
                )  # fmt: skip
                touching = touching or touches
        first += 2 * points
    return touching


@inlined
def _ends(strip, side, centre, q):
    """Return positions and velocities of both ends, see `_end`."""
    ax, ay, az, auy, auz = _end(strip, col.START, side, centre, q)
    bx, by, bz, buy, buz = _end(strip, col.END, side, centre, q)
    return Ends(ax, ay, az, bx, by, bz), Ends(0.0, auy, auz, 0.0, buy, buz)


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
    strip, side, centre, b, q, wall, facets, memories, pushes, coefficient, mobility, of_axle, origin, sums, h, ahead
):  # fmt: skip
    """Add the wall forces on a strip.

    Returns True if a point touches. origin: place along the wall from which stations count; mobility, of_axle: inverse
    masses of the body at a point, and of the axle.
    """
    ends, moving = _ends(strip, side, centre, q)
    sy = b[3] * ends.ax + b[4] * ends.ay + b[5] * ends.az + b[col.AT + 1]
    ey = b[3] * ends.bx + b[4] * ends.by + b[5] * ends.bz + b[col.AT + 1]
    rates, early = moving, 0.0
    if strip[col.INITIAL] > 0.0:
        rates = _velocities(b, ends, moving)
        early = ahead * (abs(rates.ay) + abs(rates.by) + abs(rates.az) + abs(rates.bz))
    if min(sy, ey) > wall[0, 0] + early:
        if memories[0, col.RAISED] > 0.0:
            _set_above(memories, 0.0)
        return False
    sx, _, sz = rotated(b, ends.ax, ends.ay, ends.az)
    ex, _, ez = rotated(b, ends.bx, ends.by, ends.bz)
    places = Ends(
        sx + b[col.AT] - origin, sy, sz + b[col.AT + 2], ex + b[col.AT] - origin, ey, ez + b[col.AT + 2]
    )
    rise = 0.5 * (places.bz - places.az) * (1.0 / memories.shape[0])
    half = np.sqrt(rise * rise + strip[col.THICK] * strip[col.THICK])
    crest = Crest(wall[0, 0] + early, wall[facets - 1, 3], wall[facets - 1, 2], half, 0.5 / half)
    if min(places.az, places.bz) - half > crest.top and max(sy, ey) < crest.edge - 2.0 * EDGE:
        _set_above(memories, 1.0)
        return False
    if early == 0.0:
        rates = _velocities(b, ends, moving)
    law = law_of(strip, memories.shape[0], mobility, of_axle, coefficient, early, h, ahead)
    press, over, touches = press_points(law, memories, places, rates, crest, wall, facets)
    if press.presses:
        _add_press(press, law, b, q, centre, ends, moving, places, pushes[0], pushes[0], sums)
    if over.presses:
        _add_press(over, law, b, q, centre, ends, moving, places, pushes[1], pushes[0], sums)
    return touches


@inlined
def _set_above(memories, part):
    """Set the part above the top of all points."""
    for n in range(memories.shape[0]):
        memories[n, col.ABOVE] = part
    memories[0, col.RAISED] = part


@inlined
def _velocities(b, ends, moving):
    """Return the velocities of both ends in space [m/s].

    moving: relative to the body, in its axes [m/s].
    """
    ax, ay, az = point_velocity(b, ends.ax, ends.ay, ends.az, moving.ay, moving.az)
    bx, by, bz = point_velocity(b, ends.bx, ends.by, ends.bz, moving.by, moving.bz)
    return Ends(ax, ay, az, bx, by, bz)


@reordered
def _add_press(press, law, b, q, centre, ends, moving, places, push, shown, sums):
    """Add the forces on points to loads and sums.

    The normal force of a strip that returns no energy is added apart, because a part of it may be taken away.
    shown: as of `add_sums`.
    """
    force, normal = press.force, press.normal
    for j in range(8 if law.stops else 0):
        push[col.RESPONSE + j] = -_load(b, q, j)
    rest = Ends(
        force.ax, force.ay - normal.ay, force.az - normal.az, force.bx, force.by - normal.by, force.bz - normal.bz
    )  # fmt: skip
    _press_ends(b, q, centre, ends, rest)
    added = push[col.ADDED :]
    added[col.LATERAL] = force.ay + force.by
    added[col.ALONG] = force.ax + force.bx
    added[col.UP] = force.az + force.bz
    added[col.MOMENT] = force.ay * places.az + force.by * places.bz
    added[col.STATION] = force.ay * places.ax + force.by * places.bx
    added[col.SPREAD] = press.spread
    added[col.WALL_WORK] = law.h * press.work
    added[col.FRICTION_WORK] = -law.h * press.lost
    if not law.stops:
        add_sums(push, shown, sums, 1.0)
        return
    rate = 0.0 if np.isnan(centre) else q[col.JOINT_NOW + 1]
    heaving = 0.0 if np.isnan(centre) else q[col.JOINT_NOW]
    _, asy, asz = centripetal(b, rate, heaving, ends.ax, ends.ay, ends.az, moving.ay, moving.az)
    _, aey, aez = centripetal(b, rate, heaving, ends.bx, ends.by, ends.bz, moving.by, moving.bz)
    turning = 0.5 * law.h * (normal.ay * asy + normal.az * asz + normal.by * aey + normal.bz * aez)
    push[col.STOPPED], push[col.GAP] = 0.0, press.gap + turning
    for j in range(8):
        push[col.NORMAL + j] = -_load(b, q, j)
    _press_ends(b, q, centre, ends, normal)
    for j in range(8):
        push[col.NORMAL + j] += _load(b, q, j)
        push[col.RESPONSE + j] += _load(b, q, j)
    push[col.CLOSING] = turning - normal_power(push, b, q)


@inlined
def _load(b, q, j):
    """Return a load on a body, from 6 on of an axle."""
    return b[col.LOAD + j] if j < 6 else q[col.JOINT_LOAD + j - 6]


@reordered
def _press_ends(b, q, centre, ends, force):
    """Add forces at both ends of a strip.

    centre: as of `_end`.
    """
    if np.isnan(centre):
        add_force(b, ends.ax, ends.ay, ends.az, force.ax, force.ay, force.az)
        add_force(b, ends.bx, ends.by, ends.bz, force.bx, force.by, force.bz)
    else:
        centre += q[col.JOINT]
        add_axle_force(b, q, centre, ends.ax, ends.ay, ends.az, force.ax, force.ay, force.az)
        add_axle_force(b, q, centre, ends.bx, ends.by, ends.bz, force.bx, force.by, force.bz)


@reordered
def press_axles(axles, axle_unit, bodies, joints, sums, h):
    """Add forces of springs, dampers and tyres, and works over h."""
    for a in range(axles.shape[0]):
        _press_axle(axles[a], bodies[axle_unit[a]], joints[a], sums, h)


@reordered
def _press_axle(axle, b, q, sums, h):
    """Add the forces on one axle."""
    heave, c, s = q[col.JOINT], q[col.COSINE], q[col.SINE]
    heave_rate, roll_rate = q[col.JOINT_NOW], q[col.JOINT_NOW + 1]
    for sign in (-1.0, 1.0):
        arm = sign * axle[col.HALF_SPACING]
        rate = heave_rate + arm * c * roll_rate
        damping = axle[col.DAMPER] * rate
        force = -axle[col.PRELOAD] - axle[col.SPRING] * (heave + arm * s) - damping
        q[col.JOINT_LOAD] += force
        q[col.JOINT_LOAD + 1] += force * arm * c
        sums[col.DAMPING_WORK] -= h * damping * rate
    scale = 1.0 / np.sqrt(b[0] * b[0] + b[3] * b[3])
    hx, hy = scale * b[0], scale * b[3]
    vx, vy, _ = point_velocity(b, axle[col.PLACE], 0.0, axle[col.CENTRE] + heave, 0.0, heave_rate)
    ahead = vx * hx + vy * hy
    for side in range(2):
        arm = (2.0 * side - 1.0) * axle[col.HALF_TRACK]
        y, dz = arm * c + axle[col.LOWEST] * s, arm * s - axle[col.LOWEST] * c
        x, z = axle[col.PLACE], axle[col.CENTRE] + heave + dz
        depth = -(b[col.AT + 2] + b[6] * x + b[7] * y + b[8] * z)
        q[col.WHEEL + side] = axle[col.TYRE] * max(depth, 0.0)
        if depth > 0.0:
            # The forces act at the ground, above the lowest point of the unloaded tyre.
            x, y, z, dz = x + depth * b[6], y + depth * b[7], z + depth * b[8], dz + depth * b[8]
            vx, vy, _ = point_velocity(b, x, y, z, -dz * roll_rate, heave_rate + y * roll_rate)
            across = vy * hx - vx * hy
            normal = axle[col.TYRE] * depth
            force = side_force(normal, axle[col.FRICTION], axle[col.CORNERING], ahead, across)
            add_axle_force(b, q, axle[col.CENTRE] + heave, x, y, z, -force * hy, force * hx, normal)
            sums[col.TYRE_WORK] += h * force * across


@reordered
def twist_hinges(units, bodies):
    """Add the moments of the hinges in roll."""
    for u in range(1, units.shape[0]):
        ahead, behind = bodies[u - 1], bodies[u]
        yx, yy, yz, zx, zy, zz = ahead[1], ahead[4], ahead[7], behind[2], behind[5], behind[8]
        moment = -units[u, col.TWIST] * (yx * zx + yy * zy + yz * zz)
        mx, my, mz = cross(zx, zy, zz, yx, yy, yz)
        for b, sign in ((behind, 1.0), (ahead, -1.0)):
            px, py, pz = turned_back(b, sign * moment * mx, sign * moment * my, sign * moment * mz)
            b[col.LOAD + 3] += px
            b[col.LOAD + 4] += py
            b[col.LOAD + 5] += pz
