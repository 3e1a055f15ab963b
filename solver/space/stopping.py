"""Compiled forces of strips that return no energy.

Such a strip is pushed by its loading curve as long as it crushes. Where all other forces press it to the wall, its
force is then the part that ends the step with its points at their deepest positions, as in the plane
(`solver.impact.contact`); where they take it off, the force acts until it stops. The step is made with the whole
force, and the part of it that would push the strip back is taken away: strip by strip, apart for the face and the top,
by Gauss-Seidel, for the sum of the normal velocities of its points, weighted with their forces. The scheme remains of
second order.
"""

from machine_code.compiled import inlined, reordered
from solver.space import state as col
from solver.space.dynamics import add_impulse, cross, joint_response, rotated, solve_factored, turned_back

SWEEPS, SETTLED, LEAST = 50, 1e-10, 1e-9
"""Largest number of sweeps, the change of the parts at which they end, and the least part of a force that remains."""


@inlined
def returns_nothing(strip):
    """Return True for a strip whose force drops at once."""
    return strip[col.RETURNED] == 0.0 and strip[col.UNLOADING] == 0.0


@reordered
def stop_strips(fleet, strips, work, h, again):
    """Reduce the forces of strips that would go back.

    h: the step [s]; again: True after hinges of this step have closed.
    """
    for sweep in range(SWEEPS):
        largest = 0.0
        for k in range(strips.shape[0]):
            for n in range(4 if returns_nothing(strips[k]) else 0):
                push = work.pushes[4 * k + n]
                if push[col.STOPPED] >= 0.0:
                    u, a = fleet.strip_unit[k], fleet.strip_axle[k]
                    if sweep == 0 and not again:
                        _respond(push[col.RESPONSE :], work.bodies[u], work.joints[max(a, 0)], a >= 0)
                    largest = max(largest, _stop(push, u, a, fleet.axle_unit, work, h))
        if largest <= SETTLED:
            break


@reordered
def _respond(response, b, q, is_axle):
    """Replace loads by a strip by accelerations of its body."""
    if is_axle:
        heave, roll = response[6], response[7]
        q0, q1 = (
            q[col.SHARE] * heave + q[col.SHARE + 1] * roll,
            q[col.SHARE + 1] * heave + q[col.SHARE + 2] * roll,
        )
        for j in range(6):
            response[j] -= q[col.COLUMN + j] * q0 + q[col.COLUMN + 6 + j] * q1
    solve_factored(b, col.MATRIX, 6, 6, response, 0, 1)


@reordered
def _stop(push, u, a, axle_unit, work, h):
    """Reduce the force of one strip.

    u, a: its unit, and its axle or -1. Returns the change of its part.
    """
    b, q, response = work.bodies[u], work.joints[max(a, 0)], push[col.RESPONSE :]
    rate, n = 0.0, push[col.NORMAL :]
    for j in range(6):
        rate += n[j] * response[j]
    if a >= 0:
        heave, roll = joint_response(q, response, 0, response[6], response[7])
        rate += n[6] * heave + n[7] * roll
    if rate <= 0.0:
        return 0.0
    opening = push[col.GAP] + normal_power(push, b, q)
    without_strip = opening + push[col.CLOSING] - h * rate * (1.0 - push[col.STOPPED])
    part = push[col.STOPPED] + opening / (h * rate)
    if without_strip > 0.0:
        part = 1.0 - push[col.CLOSING] / (h * rate + without_strip)
    part = min(max(part, 0.0), 1.0)
    part = 1.0 if part > 1.0 - LEAST else part
    change = part - push[col.STOPPED]
    push[col.STOPPED] = part
    add_impulse(u, axle_unit, work, -change * h, response, h, a)
    return abs(change)


@reordered
def add_stopped(strips, work):
    """Add forces and works of these strips to a row."""
    for k in range(strips.shape[0]):
        for n in range(4 if returns_nothing(strips[k]) else 0):
            push = work.pushes[4 * k + n]
            if push[col.STOPPED] >= 0.0:
                add_sums(push, work.pushes[4 * k + n - n % 2], work.sums, 1.0 - push[col.STOPPED])


@inlined
def add_sums(push, shown, sums, part):
    """Add this part of a strip's forces and works to a row.

    shown: the forces on the strip with the lateral force of the row.
    """
    for j in range(8):
        sums[j] += part * push[col.ADDED + j]
    shown[col.PUSH] += part * push[col.ADDED + col.LATERAL]


@reordered
def centripetal(b, roll_rate, heave_rate, x, y, z, uy, uz):
    """Return the acceleration of a point by constant rates, in space.

    uy, uz: velocity relative to the body, of the joint rates of an axle, in its axes [m/s].
    """
    wx, wy, wz = b[col.NOW + 3], b[col.NOW + 4], b[col.NOW + 5]
    vx, vy, vz = cross(wx, wy, wz, x, y, z)
    ax, ay, az = cross(wx, wy, wz, vx, vy + 2.0 * uy, vz + 2.0 * uz)
    return rotated(b, ax, ay - roll_rate * (uz - heave_rate), az + roll_rate * uy)


@reordered
def normal_power(push, b, q):
    """Return the power of a strip's normal force [W].

    Velocities are those between two instants.
    """
    vx, vy, vz = turned_back(b, b[col.SPEED], b[col.SPEED + 1], b[col.SPEED + 2])
    n = push[col.NORMAL :]
    power = n[0] * vx + n[1] * vy + n[2] * vz + n[6] * q[col.JOINT_SPEED] + n[7] * q[col.JOINT_SPEED + 1]
    for j in range(3):
        power += n[3 + j] * b[col.SPIN + j]
    return power
