"""Compiled forces of the wall on the points of a train.

The law of a point, and the forces of all points in a step by Gauss-Seidel; see `solver.impact.step`.
"""

from fem.laws.contact_forces import (
    PointCrush,
    coulomb_force,
    crush_line,
    line_force,
    loading_depth,
    loading_force,
)
from machine_code.compiled import compiled
from solver.impact import state as col

SWEEPS = 200
SETTLED = 1e-13
"""Relative change of a force at which Gauss-Seidel ends; SWEEPS: largest number of sweeps."""

AT_REST = 1e-9
"""Force that stops a point over that of the law, up to which it is rounding at a point that is at rest."""


@compiled
def press(points, point_owner, motion, masses, ties, effect, active, kick, h):
    """Solve for the wall's forces and the velocities.

    Returns the number of points that may touch.
    """
    v, touching = motion[2], 0
    for p in range(points.shape[0]):
        j = 3 * point_owner[p, 0]
        x, y, w = points[p, col.X], points[p, col.Y], motion[1, j + 2]
        ahead = points[p, col.DEPTH] + h * (0.5 * h * w * w * y - v[j + 1] - v[j + 2] * x)
        if ahead <= points[p, col.FOOT] and points[p, col.DEPTH] <= points[p, col.FOOT]:
            points[p, col.NORMAL] = points[p, col.TANGENTIAL] = 0.0
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
        points[p, col.PART] = 1.0 if points[p, col.NORMAL] > 0.0 else h / kick * _part(points[p], ahead)
        active[touching] = p
        touching += 1
    for a in range(touching):
        p = active[a]
        _push(kick * points[p, col.TANGENTIAL], kick * points[p, col.NORMAL], effect[p], v)
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
    x, y = point[col.X], point[col.Y]
    mobility = kick * h * (effect[1, j + 1] + x * effect[1, j + 2])
    ahead = point[col.DEPTH] + h * (0.5 * h * w * w * y - v[j + 1] - v[j + 2] * x)
    normal = _normal_force(point, ahead + point[col.NORMAL] * mobility, mobility)
    normal_change = normal - point[col.NORMAL]
    _push(0.0, kick * normal_change, effect, v)
    slip = v[j] - v[j + 2] * y - 0.5 * h * w * w * x
    stopping = point[col.TANGENTIAL] - slip / (kick * (effect[0, j] - y * effect[0, j + 2]))
    tangential = coulomb_force(stopping, point[col.FRICTION] * normal)
    tangential_change = tangential - point[col.TANGENTIAL]
    _push(kick * tangential_change, 0.0, effect, v)
    point[col.NORMAL], point[col.TANGENTIAL] = normal, tangential
    point[col.AHEAD] = point[col.DEPTH] + h * (0.5 * h * w * w * y - v[j + 1] - v[j + 2] * x)
    return abs(normal_change) + abs(tangential_change) <= SETTLED * (normal + abs(tangential))


@compiled
def crush_of(point):
    """Return the crush law of a point."""
    returned = point[col.RESTITUTION] ** 2
    unloading, hardening = point[col.UNLOADING], point[col.HARDENING]
    return PointCrush(
        point[col.STIFFNESS], point[col.INITIAL], returned, point[col.PLATEAU], unloading, hardening
    )


@compiled
def set_line(point):
    """Set the line of unloading from the deepest point."""
    point[col.PEAK], _, point[col.LINE], _ = crush_line(crush_of(point), point[col.DEEPEST])


@compiled
def _normal_force(point, free, mobility):
    """Return the normal force of a point.

    The step ends at the depth `free` from the deepest without it, and mobility N less with it.
    """
    crush, deepest, part = crush_of(point), point[col.DEEPEST], point[col.PART]
    compliance, beyond = 0.5 * mobility, 0.5 * (point[col.EARLIER] + free)
    depth = loading_depth(crush, deepest + beyond, compliance, part)
    if point[col.LINE] <= 0.0:
        most = part * loading_force(crush, max(depth, deepest))
        stopping = (free - max(point[col.DEPTH], 0.0)) / mobility
        return min(stopping, most) if stopping > AT_REST * most else 0.0
    if depth > deepest:
        return loading_force(crush, depth)
    return line_force(point[col.PEAK], point[col.LINE], beyond, compliance)


@compiled
def _part(point, ahead):
    """Return the part of the step after the touch of a point.

    The step is from half a step ago to half a step ahead. It applies to a force that begins suddenly.
    """
    closing = ahead - point[col.DEPTH]
    if point[col.LINE] > 0.0 or closing <= 0.0:
        return 1.0
    return min(max(0.5 + point[col.DEPTH] / closing, 0.0), 1.0)


@compiled
def deepening(point):
    """Return the mean depth of a point beyond the deepest so far."""
    return max(0.5 * (point[col.EARLIER] + point[col.AHEAD]), 0.0) if point[col.NORMAL] > 0.0 else 0.0


@compiled
def mean_speeds(point, motion, j):
    """Return mean speeds of a point along and across the wall.

    They are means of both half steps, with which energy is conserved.
    """
    w = motion[1, j + 2] + motion[2, j + 2]
    along, across = motion[1, j] + motion[2, j], motion[1, j + 1] + motion[2, j + 1]
    return 0.5 * (along - w * point[col.Y]), 0.5 * (across + w * point[col.X])
