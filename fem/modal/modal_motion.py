"""Accelerations of the modal model, and what is read off its state; compiled. The equations: docs/modal.md.

A place is x and y of the corner as the kept modes alone put it [m], the frame's turn [rad], which is minus the angle
to the wall, and the modes' coordinates [sqrt(kg) m]: shape (3 + modes,). A speed is its rate.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from fem.compiled import compiled, implements
from fem.contact.corner import Drag, Signed

MEASURED = ("theta", "omega", "v_gx", "v_gy", "slide", "reaction_normal", "energy")
"""What `measure_rows` fills in, SI: as in `fem.explicit.measures`; `energy`: kinetic and elastic."""


class Reaction(NamedTuple):
    """The wall's reaction, and the flexibility it follows from, turned to the wall's frame.

    normal: N [N]; slope: R over N; give: of hold and modes left out, by which N closes the gap [m/N]. z_xx, z_xy,
    z_yy: displacement of the corner by a force on it [m/N]; d_x, d_y: by the squared spin [m s^2].
    """

    normal: float
    slope: float
    give: float
    z_xx: float
    z_xy: float
    z_yy: float
    d_x: float
    d_y: float


def friction_slope(law, normal, speed):
    """R over N of any law of `fem.contact.corner` while the corner slides; compiled code only."""
    raise NotImplementedError(type(law))


@implements(friction_slope, type(None))
def _no_friction(law, normal, speed):
    return 0.0


@implements(friction_slope, Drag)
def _drag(law, normal, speed):
    return -law.coefficient * np.sign(normal) * np.sign(speed)


@implements(friction_slope, Signed)
def _signed(law, normal, speed):
    return -law.coefficient * np.sign(speed)


@compiled
def reaction(place, speed, model):
    """The `Reaction`: N is what keeps the corner, moved by it and the spin, on the wall or its spring."""
    cosine, sine, z = math.cos(place[2]), math.sin(place[2]), model.flexibility
    z_xx = cosine * cosine * z[0, 0] - 2.0 * cosine * sine * z[0, 1] + sine * sine * z[1, 1]
    z_yy = sine * sine * z[0, 0] + 2.0 * cosine * sine * z[0, 1] + cosine * cosine * z[1, 1]
    z_xy = cosine * sine * (z[0, 0] - z[1, 1]) + (cosine * cosine - sine * sine) * z[0, 1]
    d_x, d_y = cosine * z[0, 2] - sine * z[1, 2], sine * z[0, 2] + cosine * z[1, 2]
    gap = place[1] + speed[2] * speed[2] * d_y
    slope = friction_slope(model.friction, -gap, speed[0])
    give = model.hold + z_yy + slope * z_xy
    return Reaction(-gap / give, slope, give, z_xx, z_xy, z_yy, d_x, d_y)


@compiled
def accelerate(place, speed, model, room, result):
    """Fill `result` with the accelerations, shape (3 + modes,); room: to work in, shape (2, modes)."""
    wall, spin = reaction(place, speed, model), speed[2]
    normal, tangential, square = wall.normal, wall.slope * wall.normal, spin * spin
    cosine, sine = math.cos(place[2]), math.sin(place[2])
    force_x, force_y = cosine * tangential + sine * normal, cosine * normal - sine * tangential
    arm_x, arm_y, rate_x, rate_y = model.arm[0], model.arm[1], 0.0, 0.0
    inertia, growing, pushed, swept = model.inertia, 0.0, 0.0, 0.0
    for k in range(model.squares.size):
        q, rate, sweep, swirl = place[3 + k], speed[3 + k], 0.0, 0.0
        for other in range(model.squares.size):
            sweep += model.turning[k, other] * place[3 + other]
            swirl += model.turning[k, other] * speed[3 + other]
        arm_x += model.corner[0, k] * q
        arm_y += model.corner[1, k] * q
        rate_x += model.corner[0, k] * rate
        rate_y += model.corner[1, k] * rate
        force = model.corner[0, k] * force_x + model.corner[1, k] * force_y - model.squares[k] * q
        force += square * (model.growth[k] + q) + 2.0 * spin * swirl
        room[0, k], room[1, k] = sweep, force
        inertia += (2.0 * model.growth[k] + q) * q
        growing += 2.0 * (model.growth[k] + q) * rate
        pushed += sweep * force
        swept += sweep * sweep
    a_x, a_y = cosine * arm_x - sine * arm_y, sine * arm_x + cosine * arm_y
    # The modes left out: they lengthen the arm, and grow the inertia with N and the spin.
    full_x = a_x + wall.z_xx * tangential + wall.z_xy * normal + square * wall.d_x
    full_y = a_y + wall.z_xy * tangential + wall.z_yy * normal + square * wall.d_y
    shift, across = wall.d_y + wall.slope * wall.d_x, wall.d_x - wall.slope * wall.d_y
    softening = spin * (2.0 * wall.z_xy + wall.slope * (wall.z_xx - wall.z_yy))
    climb = -(speed[1] + square * spin * wall.d_x + normal * softening) / wall.give
    inertia += 2.0 * (shift * normal + square * model.flexibility[2, 2])
    growing += 2.0 * (shift * climb + spin * across * normal)
    own = 4.0 * square * (model.flexibility[2, 2] - shift * wall.d_y / wall.give)
    torque = full_x * normal - full_y * tangential - spin * growing + pushed
    angular = torque / (inertia + own - swept)
    bend_x = bend_y = 0.0
    for k in range(model.squares.size):
        result[3 + k] = room[1, k] + angular * room[0, k]
        bend_x += model.corner[0, k] * result[3 + k]
        bend_y += model.corner[1, k] * result[3 + k]
    bend_x -= 2.0 * spin * rate_y
    bend_y += 2.0 * spin * rate_x
    result[0] = tangential / model.mass - angular * a_y - square * a_x + cosine * bend_x - sine * bend_y
    result[1] = normal / model.mass + angular * a_x - square * a_y + sine * bend_x + cosine * bend_y
    result[2] = angular


@compiled
def measure_rows(table, model, result):
    """Fill `result`, shape (rows, MEASURED), from the times, places and speeds of `table`."""
    modes = model.squares.size
    for row in range(table.shape[0]):
        place, speed = table[row, 1 : 4 + modes], table[row, 4 + modes :]
        wall, spin = reaction(place, speed, model), speed[2]
        normal, tangential = wall.normal, wall.slope * wall.normal
        cosine, sine, square = math.cos(place[2]), math.sin(place[2]), spin * spin
        arm_x, arm_y, rate_x, rate_y = model.arm[0], model.arm[1], 0.0, 0.0
        inertia, momentum, energy = model.inertia, 0.0, 0.0
        for k in range(modes):
            q, rate = place[3 + k], speed[3 + k]
            for other in range(modes):
                momentum += q * model.turning[k, other] * speed[3 + other]
            arm_x += model.corner[0, k] * q
            arm_y += model.corner[1, k] * q
            rate_x += model.corner[0, k] * rate
            rate_y += model.corner[1, k] * rate
            inertia += (2.0 * model.growth[k] + q) * q
            energy += 0.5 * (rate * rate + model.squares[k] * q * q)
        rate_x, rate_y = rate_x - spin * arm_y, rate_y + spin * arm_x
        v_x, v_y = speed[0] - cosine * rate_x + sine * rate_y, speed[1] - sine * rate_x - cosine * rate_y
        pull_x = wall.z_xx * tangential + wall.z_xy * normal
        pull_y = wall.z_xy * tangential + wall.z_yy * normal
        energy += 0.5 * (model.mass * (v_x * v_x + v_y * v_y) + inertia * square) + spin * momentum
        energy += 0.5 * (pull_x * tangential + pull_y * normal + model.hold * normal * normal)
        swing = wall.d_x * tangential + wall.d_y * normal
        energy += square * (2.0 * swing + 1.5 * square * model.flexibility[2, 2])
        inertia += 2.0 * (swing + square * model.flexibility[2, 2])
        result[row, 0], result[row, 1] = -place[2], spin + momentum / inertia
        result[row, 2], result[row, 3] = v_x, v_y
        result[row, 4] = place[0] + pull_x + square * wall.d_x
        result[row, 5], result[row, 6] = normal, energy
