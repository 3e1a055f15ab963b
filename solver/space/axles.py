"""Compiled forces of axles and hinges of a vehicle in space.

Spring of an axle   linear with a damper, between body and axle, along the body's z
Tyre                linear and unilateral, upward at the ground above the lowest point of the unloaded wheel; side
                    force of the axle's law (`fem.laws.contact_forces.side_force`) by the speed across there and that
                    ahead of the middle of the axle
Hinge               moment in proportion to the sine of the angle between the lateral axis of the unit ahead and the
                    floor of the unit behind
"""

import numpy as np

from fem.laws.contact_forces import side_force
from machine_code.compiled import reordered
from solver.space import state as col
from solver.space.dynamics import cross, turned_back
from solver.space.forces import add_axle_force, point_velocity


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
