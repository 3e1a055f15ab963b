"""Compiled equations of motion of bodies with solid axles.

A unit is a rigid body with axles that slide along its z axis and roll about their roll centre. With the accelerations
a of the body and w' of its spin, and j'' of the joints of its axles (heave and roll),

    [M  A] [a, w']   [load]
    [A' D] [ j'' ] = [joint load]

in the body's axes. The joints are eliminated axle by axle: (M - A D^-1 A') [a, w'] = load - A D^-1 joint load. Gravity
accelerates all masses equally and is added to a. Hinges close by impulses at the end of a step. Positions follow the
velocities of the middle of a step, the rotation by the exponential of its spin: second order.
"""

import numpy as np

from machine_code.compiled import reordered
from solver.body import GRAVITY
from solver.rotation import sine_and_versine
from solver.space.state import (
    AT,
    AXLE_INERTIA,
    AXLE_MASS,
    BELOW,
    CENTRE,
    COLUMN,
    COSINE,
    HITCH_X,
    HITCH_Z,
    I_X,
    I_XZ,
    I_Y,
    I_Z,
    JOINT,
    JOINT_LOAD,
    JOINT_NOW,
    JOINT_RATE,
    JOINT_SPEED,
    KING_X,
    KING_Z,
    LOAD,
    MASS,
    MATRIX,
    NOW,
    PLACE,
    RATE,
    SHARE,
    SINE,
    SPEED,
    SPIN,
    TURN,
)


@reordered
def set_rotation(b):
    """Set a body's rotation matrix by its quaternion."""
    w, x, y, z = b[TURN], b[TURN + 1], b[TURN + 2], b[TURN + 3]
    b[0], b[1], b[2] = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)
    b[3], b[4], b[5] = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
    b[6], b[7], b[8] = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)


@reordered
def rotated(b, x, y, z):
    """Rotate a vector from body axes to space."""
    return b[0] * x + b[1] * y + b[2] * z, b[3] * x + b[4] * y + b[5] * z, b[6] * x + b[7] * y + b[8] * z


@reordered
def turned_back(b, x, y, z):
    """Rotate a vector from space to body axes."""
    return b[0] * x + b[3] * y + b[6] * z, b[1] * x + b[4] * y + b[7] * z, b[2] * x + b[5] * y + b[8] * z


@reordered
def cross(ax, ay, az, bx, by, bz):
    """Return the vector product."""
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@reordered
def begin_step(bodies, joints, last):
    """Set rotations and velocities of this instant, and clear the loads.

    last: the last step [s]; the velocities are those of half a step before.
    """
    for u in range(bodies.shape[0]):
        b = bodies[u]
        set_rotation(b)
        for j in range(3):
            b[NOW + j] = b[SPEED + j] + 0.5 * last * b[RATE + j]
            b[NOW + 3 + j] = b[SPIN + j] + 0.5 * last * b[RATE + 3 + j]
            b[LOAD + j], b[LOAD + 3 + j] = 0.0, 0.0
    for a in range(joints.shape[0]):
        for j in range(2):
            joints[a, JOINT_NOW + j] = joints[a, JOINT_SPEED + j] + 0.5 * last * joints[a, JOINT_RATE + j]
            joints[a, JOINT_LOAD + j] = 0.0
        joints[a, COSINE], joints[a, SINE] = np.cos(joints[a, JOINT + 1]), np.sin(joints[a, JOINT + 1])


@reordered
def assemble(units, axles, axle_unit, bodies, joints):
    """Set masses, and subtract the terms of velocity from the loads.

    The joints are eliminated; the mass of each unit is factored.
    """
    for u in range(units.shape[0]):
        body, b = units[u], bodies[u]
        for j in range(36):
            b[MATRIX + j] = 0.0
        for j in range(3):
            b[MATRIX + 7 * j] = body[MASS]
        b[MATRIX + 21], b[MATRIX + 28], b[MATRIX + 35] = body[I_X], body[I_Y], body[I_Z]
        b[MATRIX + 23] = -body[I_XZ]
        wx, wy, wz = b[NOW + 3], b[NOW + 4], b[NOW + 5]
        hx, hy, hz = body[I_X] * wx - body[I_XZ] * wz, body[I_Y] * wy, body[I_Z] * wz - body[I_XZ] * wx
        mx, my, mz = cross(wx, wy, wz, hx, hy, hz)
        b[LOAD + 3] -= mx
        b[LOAD + 4] -= my
        b[LOAD + 5] -= mz
    for a in range(axles.shape[0]):
        _add_axle(axles[a], bodies[axle_unit[a]], joints[a])
    for u in range(units.shape[0]):
        factor(bodies[u], MATRIX, 6, 6)


@reordered
def _add_axle(axle, b, q):
    """Add mass and load of an axle to those of its body.

    Its joints are eliminated.
    """
    m, inertia, e = axle[AXLE_MASS], axle[AXLE_INERTIA], axle[BELOW]
    c, s = q[COSINE], q[SINE]
    heave_rate, roll_rate = q[JOINT_NOW], q[JOINT_NOW + 1]
    x, y, z = axle[PLACE], e * s, axle[CENTRE] + q[JOINT] - e * c
    by, bz = e * c, e * s
    wx, wy, wz = b[NOW + 3], b[NOW + 4], b[NOW + 5]
    # Terms of velocity: centripetal, Coriolis, and of the roll about the roll centre.
    px, py, pz = cross(wx, wy, wz, x, y, z)
    ax, ay, az = cross(wx, wy, wz, px, py, pz)
    uy, uz = by * roll_rate, heave_rate + bz * roll_rate
    ax += 2.0 * (wy * uz - wz * uy)
    ay += -2.0 * wx * uz - e * s * roll_rate * roll_rate
    az += 2.0 * wx * uy + e * c * roll_rate * roll_rate
    # A rod along n: J = I (1 - n n').
    ny, nz = c, s
    ox = wx + roll_rate
    along = ny * wy + nz * wz
    jx, jy, jz = inertia * ox, inertia * (wy - ny * along), inertia * (wz - nz * along)
    hx, hy, hz = cross(ox, wy, wz, jx, jy, jz)
    ty, tz = roll_rate * wz, -roll_rate * wy
    along = ny * ty + nz * tz
    hy, hz = hy + inertia * (ty - ny * along), hz + inertia * (tz - nz * along)
    mx, my, mz = cross(x, y, z, m * ax, m * ay, m * az)
    b[LOAD] -= m * ax
    b[LOAD + 1] -= m * ay
    b[LOAD + 2] -= m * az
    b[LOAD + 3] -= mx + hx
    b[LOAD + 4] -= my + hy
    b[LOAD + 5] -= mz + hz
    q[JOINT_LOAD] -= m * az
    q[JOINT_LOAD + 1] -= m * (by * ay + bz * az) + hx
    for j in range(3):
        b[MATRIX + 7 * j] += m
    b[MATRIX + 4] += m * z
    b[MATRIX + 5] -= m * y
    b[MATRIX + 9] -= m * z
    b[MATRIX + 11] += m * x
    b[MATRIX + 15] += m * y
    b[MATRIX + 16] -= m * x
    b[MATRIX + 21] += m * (y * y + z * z) + inertia
    b[MATRIX + 28] += m * (x * x + z * z) + inertia * (1.0 - ny * ny)
    b[MATRIX + 35] += m * (x * x + y * y) + inertia * (1.0 - nz * nz)
    b[MATRIX + 22] -= m * x * y
    b[MATRIX + 23] -= m * x * z
    b[MATRIX + 29] -= m * y * z + inertia * ny * nz
    q[COLUMN], q[COLUMN + 1], q[COLUMN + 2] = 0.0, 0.0, m
    q[COLUMN + 3], q[COLUMN + 4], q[COLUMN + 5] = m * y, -m * x, 0.0
    q[COLUMN + 6], q[COLUMN + 7], q[COLUMN + 8] = 0.0, m * by, m * bz
    q[COLUMN + 9], q[COLUMN + 10], q[COLUMN + 11] = m * (y * bz - z * by) + inertia, -m * x * bz, m * x * by
    d12, d22 = m * bz, m * e * e + inertia
    determinant = m * d22 - d12 * d12
    q[SHARE], q[SHARE + 1], q[SHARE + 2] = d22 / determinant, -d12 / determinant, m / determinant
    q0 = q[SHARE] * q[JOINT_LOAD] + q[SHARE + 1] * q[JOINT_LOAD + 1]
    q1 = q[SHARE + 1] * q[JOINT_LOAD] + q[SHARE + 2] * q[JOINT_LOAD + 1]
    for j in range(1, 6):  # both joints slide across the first axis
        heave, roll = q[COLUMN + j], q[COLUMN + 6 + j]
        b[LOAD + j] -= heave * q0 + roll * q1
        f0, f1 = q[SHARE] * heave + q[SHARE + 1] * roll, q[SHARE + 1] * heave + q[SHARE + 2] * roll
        for k in range(j, 6):
            b[MATRIX + 6 * j + k] -= f0 * q[COLUMN + k] + f1 * q[COLUMN + 6 + k]


@reordered
def factor(m, start, n, width):
    """Factor a symmetric positive definite matrix in place.

    The lower part becomes L of L D L', the diagonal the inverse of D, and the upper part D L'. m: flat; the matrix
    begins at `start` and has rows of this width.
    """
    for i in range(n):
        row = start + width * i
        for j in range(i, n):
            entry = m[row + j]
            for k in range(i):
                entry -= m[row + k] * m[start + width * k + j]
            m[row + j] = entry
        inverse = 1.0 / m[row + i]
        for j in range(i + 1, n):
            m[start + width * j + i] = inverse * m[row + j]
        m[row + i] = inverse


@reordered
def solve_factored(m, start, n, width, x, first, stride):
    """Replace entries of x by the solution for a matrix of `factor`."""
    for i in range(n):
        value = x[first + stride * i]
        for k in range(i):
            value -= m[start + width * i + k] * x[first + stride * k]
        x[first + stride * i] = value
    for i in range(n - 1, -1, -1):
        value = x[first + stride * i] * m[start + (width + 1) * i]
        for k in range(i + 1, n):
            value -= m[start + width * k + i] * x[first + stride * k]
        x[first + stride * i] = value


@reordered
def joint_response(q, x, start, heave, roll):
    """Return the accelerations of an axle's joints.

    x: accelerations of its body, from `start`; heave, roll: loads on the joints.
    """
    for j in range(6):
        heave -= q[COLUMN + j] * x[start + j]
        roll -= q[COLUMN + 6 + j] * x[start + j]
    return q[SHARE] * heave + q[SHARE + 1] * roll, q[SHARE + 1] * heave + q[SHARE + 2] * roll


@reordered
def kick(axle_unit, bodies, joints, h):
    """Advance the velocities over h by gravity and the loads."""
    for u in range(bodies.shape[0]):
        b = bodies[u]
        solve_factored(b, MATRIX, 6, 6, b, LOAD, 1)
        x, y, z = rotated(b, b[LOAD], b[LOAD + 1], b[LOAD + 2])
        b[RATE], b[RATE + 1], b[RATE + 2] = x, y, z - GRAVITY
        for j in range(3):
            b[RATE + 3 + j] = b[LOAD + 3 + j]
            b[SPEED + j] += h * b[RATE + j]
            b[SPIN + j] += h * b[RATE + 3 + j]
    for a in range(joints.shape[0]):
        q, b = joints[a], bodies[axle_unit[a]]
        q[JOINT_RATE], q[JOINT_RATE + 1] = joint_response(q, b, LOAD, q[JOINT_LOAD], q[JOINT_LOAD + 1])
        for j in range(2):
            q[JOINT_SPEED + j] += h * q[JOINT_RATE + j]


@reordered
def move(bodies, joints, h):
    """Advance places, rotations and joints over h."""
    for u in range(bodies.shape[0]):
        b = bodies[u]
        for j in range(3):
            b[AT + j] += h * b[SPEED + j]
        x, y, z = b[SPIN], b[SPIN + 1], b[SPIN + 2]
        square = 0.25 * h * h * (x * x + y * y + z * z)  # of half the angle
        sine, versine = sine_and_versine(square)
        c, scale = 1.0 - 0.5 * square * versine, 0.5 * h * sine
        x, y, z = scale * x, scale * y, scale * z
        w, i, j, k = b[TURN], b[TURN + 1], b[TURN + 2], b[TURN + 3]
        w, i, j, k = (
            w * c - i * x - j * y - k * z,
            w * x + i * c + j * z - k * y,
            w * y - i * z + j * c + k * x,
            w * z + i * y - j * x + k * c,
        )
        norm = 1.5 - 0.5 * (w * w + i * i + j * j + k * k)  # of rounding alone, which it removes
        b[TURN], b[TURN + 1], b[TURN + 2], b[TURN + 3] = norm * w, norm * i, norm * j, norm * k
    for a in range(joints.shape[0]):
        for j in range(2):
            joints[a, JOINT + j] += h * joints[a, JOINT_SPEED + j]


@reordered
def close_hinges(units, axle_unit, work, last, h):
    """Correct the velocities so that the hinges close.

    last: the step of the correction [s], over which the accelerations are corrected too; h: the step ahead [s].
    """
    effect, tie, bodies = work.effect, work.tie, work.bodies
    hinges = units.shape[0] - 1
    size, width = 3 * hinges, 3 * hinges + 1
    tie[:] = 0.0
    for k in range(hinges):
        for side in range(2):
            b = bodies[k + side]
            x, z = _hinge(units[k + side], side)
            for i in range(3):
                response = effect[6 * k + 3 * side + i]
                fx, fy, fz = b[3 * i], b[3 * i + 1], b[3 * i + 2]
                response[0], response[1], response[2] = fx, fy, fz
                response[3], response[4], response[5] = -z * fy, z * fx - x * fz, x * fy
                solve_factored(b, MATRIX, 6, 6, response, 0, 1)
    for k in range(hinges):
        for side in range(2):
            u, sign = k + side, 1.0 - 2.0 * side
            b = bodies[u]
            x, z = _hinge(units[u], side)
            px, py, pz = rotated(b, x, 0.0, z)
            vx, vy, vz = _point_change(b, b[SPIN], b[SPIN + 1], b[SPIN + 2], x, z)
            for i, rate, place in ((0, vx, px), (1, vy, py), (2, vz, pz)):
                tie[width * (3 * k + i) + size] -= sign * (b[SPEED + i] + rate + (b[AT + i] + place) / h)
            for hinge in range(max(u - 1, 0), min(u + 1, hinges)):  # those on the same unit
                far = u - hinge
                both = sign * (1.0 - 2.0 * far)
                for j in range(3):
                    y = effect[6 * hinge + 3 * far + j]
                    vx, vy, vz = _point_change(b, y[3], y[4], y[5], x, z)
                    ax, ay, az = rotated(b, y[0], y[1], y[2])
                    for i, value in ((0, ax + vx), (1, ay + vy), (2, az + vz)):
                        tie[width * (3 * k + i) + 3 * hinge + j] += both * value
    factor(tie, 0, size, width)
    solve_factored(tie, 0, size, width, tie, size, width)
    for k in range(hinges):
        for side in range(2):
            for i in range(3):
                impulse = (1.0 - 2.0 * side) * tie[width * (3 * k + i) + size]
                work.pulls[0, 3 * k + i] += impulse / last if side == 0 else 0.0
                add_impulse(k + side, axle_unit, work, impulse, effect[6 * k + 3 * side + i], last, -1)


@reordered
def add_impulse(u, axle_unit, work, impulse, response, last, own):
    """Add the velocities of a unit by an impulse.

    response, shape (6 or 8,): accelerations of its body by a unit force, and the loads on the joints of the axle `own`;
    last: the step whose accelerations are corrected too [s].
    """
    _add_response(work.bodies[u], impulse, response, last)
    for a in range(axle_unit.size):
        if axle_unit[a] == u:
            q = work.joints[a]
            heave, roll = joint_response(q, response, 0, 0.0, 0.0)
            if a == own:
                heave, roll = joint_response(q, response, 0, response[6], response[7])
            for j, value in ((0, impulse * heave), (1, impulse * roll)):
                q[JOINT_SPEED + j] += value
                q[JOINT_RATE + j] += value / last


@reordered
def _hinge(unit, side):
    """Return the position of a hinge on one of its units.

    side: 0 for the unit ahead of the hinge, 1 for the unit behind.
    """
    return (unit[HITCH_X], unit[HITCH_Z]) if side == 0 else (unit[KING_X], unit[KING_Z])


@reordered
def _point_change(b, wx, wy, wz, x, z):
    """Return the velocity in space of a point of the middle plane.

    It is the cross product of the spin and the point.
    """
    vx, vy, vz = cross(wx, wy, wz, x, 0.0, z)
    return rotated(b, vx, vy, vz)


@reordered
def _add_response(b, impulse, response, last):
    """Add the velocities of a body by an impulse."""
    x, y, z = rotated(b, response[0], response[1], response[2])
    for j, value in ((0, impulse * x), (1, impulse * y), (2, impulse * z)):
        b[SPEED + j] += value
        b[RATE + j] += value / last
    for j in range(3):
        b[SPIN + j] += impulse * response[3 + j]
        b[RATE + 3 + j] += impulse / last * response[3 + j]
