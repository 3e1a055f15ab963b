"""Compiled rows of a motion in space, and largest means over them."""

import numpy as np

from machine_code.compiled import compiled
from solver.body import GRAVITY
from solver.space import state as col
from solver.space.dynamics import rotated
from solver.space.forces import point_velocity


@compiled
def end_row(sums, before, first, parts, means):
    """Set the mean forces of a row that ends with this step.

    Half of the step belongs to this row, half to the next one.
    """
    for j in range(means.size):
        change = sums[j] - before[j]
        means[j] = 0.0 if first else (before[j] + 0.5 * change) / parts
        sums[j] = 0.5 * change


@compiled
def means(windows, sums, window, interval, answer):
    """Set the largest means of lateral force, its moment, and acceleration.

    sums: overwritten.
    """
    gain = 0.0
    for k in range(windows.shape[0]):
        gain = max(gain, windows[k, col.SENSED] - windows[max(k - window, 0), col.SENSED])
        answer[col.RAW] = max(answer[col.RAW], windows[k, col.LATERAL])
    answer[col.INERTIAL] = gain / (window * interval)
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
def record(units, axles, axle_unit, work, first, parts, row):
    """Fill this instant's row except for its first columns.

    Works have half of the change in this step at the instant.
    """
    for j in range(6, 10):
        row[j + 1] = work.before[j] + (0.0 if first else 0.5 * (work.sums[j] - work.before[j]))
    pushes = row[row.size - work.pushes.shape[0] // 2 :]
    for p in range(pushes.size):
        push = work.pushes[2 * p]
        end_row(push[col.PUSH :], push[col.BEFORE :], first, parts, pushes[p : p + 1])
    kinetic, gravity, spring, tyre = 0.0, 0.0, 0.0, 0.0
    column = 15
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
    hinged = work.pulls.shape[1]
    end_row(work.pulls[0], work.pulls[1], first, parts, row[column : column + hinged])
    row[11], row[12], row[13], row[14] = kinetic, gravity, spring, tyre


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
