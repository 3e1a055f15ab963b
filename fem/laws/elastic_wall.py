"""The deformable wall: linear elasticity on a foundation, in the modes that the time step can follow; compiled.

modes       of the free wall, phi^T m phi = 1. The foundation is spread in proportion to the mass, so that they are its
            modes on the foundation as well, w^2 = w_free^2 + w_0^2, and rigid motion is among them: however many are
            left out, momentum and moment of momentum are the whole wall's.
motion      central differences of each mode, as of the plate; at rest at the start, without damping
face        displacements of its nodes, linear between them at a point's place along the wall
reaction    N across the tilted face, (-N slope, N) on the point, and R along the wall; the opposite on the two nodes
            beside it, with the weights of the interpolation. So momentum is kept, and energy as the depth is measured.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from fem.laws.wall_contact import Surface, held_by, move, point_mean, press, resist, tilted, under
from fem.machine_code.compiled import compiled, implements


class ElasticWall(NamedTuple):
    """The wall in its modes.

    start, spacing: of the nodes of the face along the wall [m]; reach: how far from the wall's line points are looked
    at [m]; face, shape (2, nodes of the face, modes): their displacements [1/kg^(1/2)]; stiffness, shape (modes,): w^2
    [1/s^2]; foundation: its part of that, w_0^2 [1/s^2]; momentum, shape (2, modes): of the wall at unit velocity of
    each mode [kg^(1/2)].
    """

    start: float
    spacing: float
    reach: float
    face: np.ndarray
    stiffness: np.ndarray
    foundation: float
    momentum: np.ndarray


class WallMotion(NamedTuple):
    """Motion of the deformable wall: amplitude [m kg^(1/2)], rate half a step back, and force, workspace, each of
    shape (modes,); impulse of the foundation on the wall [N s], shape (2,); how far beyond its end it was pressed
    [m], shape (1,).
    """

    amplitude: np.ndarray
    rate: np.ndarray
    force: np.ndarray
    impulse: np.ndarray
    beyond: np.ndarray


def at_rest(wall: ElasticWall) -> WallMotion:
    """The wall before it is touched."""
    modes = wall.stiffness.size
    return WallMotion(np.zeros(modes), np.zeros(modes), np.zeros(modes), np.zeros(2), np.zeros(1))


@implements(resist, ElasticWall, merged=True)
def _resist(wall, moving):
    for k in range(wall.stiffness.size):
        moving.force[k] = -wall.stiffness[k] * moving.amplitude[k]


@compiled
def seat(wall, x):
    """Node of the face before the place x [m], the next one's weight, and how far beyond the wall's end x is [m]."""
    place, last = (x - wall.start) / wall.spacing, wall.face.shape[1] - 1
    left = min(max(math.floor(place), 0), last - 1)
    return left, min(max(place - left, 0.0), 1.0), wall.spacing * max(-place, place - last, 0.0)


@implements(under, ElasticWall, merged=True)
def _under(wall, moving, contact, i, positions, origin):
    if not point_mean(positions[1], contact, i) <= wall.reach:
        return Surface(0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    left, weight, beyond = seat(wall, origin + point_mean(positions[0], contact, i))
    x_0, x_1 = wall.face[0, left], wall.face[0, left + 1]
    y_0, y_1 = wall.face[1, left], wall.face[1, left + 1]
    sink_0 = sink_1 = rate_x = rate_y = pull_x = pull_y = give_x = give_y = 0.0
    for k in range(wall.stiffness.size):
        x, y = x_0[k] + weight * (x_1[k] - x_0[k]), y_0[k] + weight * (y_1[k] - y_0[k])
        sink_0 += y_0[k] * moving.amplitude[k]
        sink_1 += y_1[k] * moving.amplitude[k]
        rate_x += x * moving.rate[k]
        rate_y += y * moving.rate[k]
        pull_x += x * moving.force[k]
        pull_y += y * moving.force[k]
        give_x += x * x
        give_y += y * y
    sink, slope = sink_0 + weight * (sink_1 - sink_0), (sink_1 - sink_0) / wall.spacing
    return Surface(left, weight, beyond, sink, slope, rate_x, rate_y, pull_x, pull_y, give_x, give_y)


@implements(tilted, ElasticWall, merged=True)
def _tilted(wall, face, value):
    return face.slope * value


@implements(press, ElasticWall, merged=True)
def _press(wall, moving, face, tangential, normal):
    if normal == 0.0:
        return
    moving.beyond[0] = max(moving.beyond[0], face.beyond)
    x_0, x_1 = wall.face[0, face.left], wall.face[0, face.left + 1]
    y_0, y_1 = wall.face[1, face.left], wall.face[1, face.left + 1]
    for k in range(wall.stiffness.size):
        x, y = x_0[k] + face.weight * (x_1[k] - x_0[k]), y_0[k] + face.weight * (y_1[k] - y_0[k])
        moving.force[k] -= x * tangential + y * normal


@compiled
def foundation_force(wall, moving, direction):
    """Force [N] of the foundation on the wall, along it (0) or across (1)."""
    total = 0.0
    for k in range(wall.stiffness.size):
        total += wall.momentum[direction, k] * moving.amplitude[k]
    return -wall.foundation * total


@implements(move, ElasticWall, merged=True)
def _move(wall, moving, time_step):
    for direction in range(2):
        moving.impulse[direction] += time_step * foundation_force(wall, moving, direction)
    for k in range(wall.stiffness.size):
        moving.rate[k] += time_step * moving.force[k]
        moving.amplitude[k] += time_step * moving.rate[k]


@implements(held_by, ElasticWall, merged=True)
def _held_by(wall, moving, half):
    energy = 0.0
    for k in range(wall.stiffness.size):
        energy += 0.5 * moving.rate[k] * (moving.rate[k] + 2.0 * half * moving.force[k])
        energy += 0.5 * wall.stiffness[k] * moving.amplitude[k] ** 2
    deflection, place = 0.0, wall.start
    for node in range(wall.face.shape[1]):
        sink = 0.0
        for k in range(wall.stiffness.size):
            sink += wall.face[1, node, k] * moving.amplitude[k]
        if -sink > deflection:
            deflection, place = -sink, wall.start + node * wall.spacing
    return energy, deflection, place, moving.impulse[1] + half * foundation_force(wall, moving, 1)
