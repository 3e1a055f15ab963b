"""Points of the boundary in unilateral contact with the wall's face, Y = 0 while it is at rest; compiled.

depth       d of a point behind the face, -y if the wall is rigid; the deepest it ever was is stored
normal      N by the contact law
stopping    the force that would end this step with the point at rest along the wall
tangential  R by the friction law: the stopping force, cut to mu N; so a point sticks or slides, and nothing between

Contact asks a few things of the face under a point (`Surface`). A rigid wall is None, and compiled to nothing.

The deformable wall: linear elasticity on a foundation, in the modes that the time step can follow; compiled.

modes       of the free wall, phi^T m phi = 1. The foundation is spread in proportion to the mass, so that they are its
            modes on the foundation as well, w^2 = w_free^2 + w_0^2, and rigid motion is among them: however many are
            left out, momentum and moment of momentum are the whole wall's.
motion      central differences of each mode, as of the plate; at rest at the start, without damping
face        displacements of its nodes, linear between them at a point's place along the wall
reaction    N across the tilted face, (-N slope, N) on the point, and R along the wall; the opposite on the two nodes
            beside it, with the weights of the interpolation. So momentum is kept, and energy as the depth is measured.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from fem.laws.constraints import friction_force
from fem.laws.unilateral import CONTACT_LAWS
from machine_code.compiled import by_law, compiled, implements, inlined, optional


class Surface(NamedTuple):
    """The face under a contact point; x along the wall, y across it.

    left, weight: the node of the face before the point, and the next one's weight in the interpolation; beyond: how far
    beyond the wall's end the point is [m]; sink: the face's y [m], and slope its derivative along the wall [-]; rate:
    velocity [m/s]; pull: acceleration by the forces that are known [m/s^2]; give: mobility [1/kg].
    """

    left: int
    weight: float
    beyond: float
    sink: float
    slope: float
    rate_x: float
    rate_y: float
    pull_x: float
    pull_y: float
    give_x: float
    give_y: float


@optional(merged=True)
def resist(wall, moving):
    """Begin the wall's forces of this instant with its own and its foundation's."""


@optional(merged=True)
def under(wall, moving, contact, i, positions, origin):
    """The face under contact point i, positions [m] being counted from the origin."""
    return Surface(0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@optional(merged=True)
def tilted(wall, face, value):
    """The face's slope times a value."""
    return 0.0


@optional(merged=True)
def press(wall, moving, face, tangential, normal):
    """Put the reaction to the forces [N] on a contact point onto the face."""


@optional(merged=True)
def move(wall, moving, time_step):
    """Move the wall on by a step, its forces being complete."""


@optional(merged=True)
def held_by(wall, moving, half):
    """Energy [J] of the wall and its foundation; largest deflection of the face [m] and its place along the wall [m];
    impulse of the foundation across the wall [N s]; half: of the time step [s]."""
    return 0.0, 0.0, 0.0, 0.0


class BoundaryContact(NamedTuple):
    """Contact nodes of the boundary; constants of the contact law, and of the friction law or None.

    A point is a node, or the weighted mean of some. first, shape (points + 1,): where each point's nodes and weights
    begin in `nodes` and `weights`; mobility, shape (points,): sum of weight^2 / mass [1/kg].
    """

    first: np.ndarray
    nodes: np.ndarray
    weights: np.ndarray
    mobility: np.ndarray
    law: Any
    friction: Any


class ContactState(NamedTuple):
    """State of the contact nodes, each of shape (points,).

    deepest: greatest depth, as the law takes it [m]; normal, tangential: impulse of the wall on it [N s]; pushing,
    sliding: force across and along the wall [N], and mean: depth as the law takes it [m], of the last step: workspace.
    """

    deepest: np.ndarray
    normal: np.ndarray
    tangential: np.ndarray
    pushing: np.ndarray
    sliding: np.ndarray
    mean: np.ndarray


contact_force = by_law(CONTACT_LAWS, "force")
stored_energy = by_law(CONTACT_LAWS, "stored")
lost_energy = by_law(CONTACT_LAWS, "lost")


@compiled
def point_mean(values, contact, i):
    """Weighted mean over the nodes of point i of values of shape (nodes,)."""
    total = 0.0
    for k in range(contact.first[i], contact.first[i + 1]):
        total += contact.weights[k] * values[contact.nodes[k]]
    return total


@compiled
def pull_of(force, mass, contact, i):
    """Acceleration of point i [m/s^2] by nodal forces of shape (nodes,)."""
    total = 0.0
    for k in range(contact.first[i], contact.first[i + 1]):
        total += contact.weights[k] * force[contact.nodes[k]] / mass[contact.nodes[k]]
    return total


@inlined
def approach(loop, state, i):
    """The wall's face under point i; the point's depth behind it [m], its speed away from it and along it [m/s].

    loop, state: an `ImpactLoopParameters` and an `ImpactLoopState`.
    """
    wall, contact, positions, velocities = loop.wall, loop.contact, state.positions, state.velocities
    face = under(wall, state.wall, contact, i, positions, state.origin[0])
    slip = point_mean(velocities[0], contact, i) - face.rate_x
    opening = point_mean(velocities[1], contact, i) - face.rate_y - tilted(wall, face, slip)
    return face, face.sink - point_mean(positions[1], contact, i), opening, slip


@compiled
def push_back(loop, state, kept, moving, force):
    """Add the wall's forces on all points to `force`, which must hold the others, and note them in `kept`.

    kept, moving: the fields `contact` and `wall` of the state; as arguments because Numba, where it inlines, drops what
    is written to an array in a tuple within a tuple. What a point and the wall's nodes beside it weigh bears the step
    together: that is what keeps light nodes stable.
    """
    contact, wall, mass, time_step = loop.contact, loop.wall, loop.mass, loop.time_step
    resist(wall, moving)
    for i in range(contact.mobility.size):
        face, depth, opening, slip = approach(loop, state, i)
        inertia = 1.0 / ((contact.mobility[i] + face.give_y) * time_step**2)
        along = pull_of(force[0], mass, contact, i) - face.pull_x
        away = pull_of(force[1], mass, contact, i) - face.pull_y - tilted(wall, face, along)
        before = depth + time_step * opening
        free = depth - time_step * (opening + time_step * away)
        normal = contact_force(contact.law, i, before, free, kept.deepest[i], inertia)
        tilt = tilted(wall, face, normal)
        stopping = tilt - (slip / time_step + along) / (contact.mobility[i] + face.give_x)
        tangential = friction_force(contact.friction, normal, stopping) - tilt
        kept.pushing[i], kept.sliding[i] = normal, tangential
        kept.mean[i] = 0.5 * (before + free - normal / inertia)
        press(wall, moving, face, tangential, normal)
        for k in range(contact.first[i], contact.first[i + 1]):
            force[0, contact.nodes[k]] += contact.weights[k] * tangential
            force[1, contact.nodes[k]] += contact.weights[k] * normal


@compiled
def add_contact(loop, state, kept, moving, force):
    """Add the wall's forces to `force`, what they do to the points' state and to the sums, and move the wall on.

    Arguments: as of `push_back`.
    """
    contact, wall, time_step = loop.contact, loop.wall, loop.time_step
    positions, sums = state.positions, state.sums
    push_back(loop, state, kept, moving, force)
    for i in range(contact.mobility.size):
        kept.deepest[i] = max(kept.deepest[i], kept.mean[i])
        normal, tangential = kept.pushing[i], kept.sliding[i]
        if normal == 0.0:
            continue
        kept.normal[i] += time_step * normal
        kept.tangential[i] += time_step * tangential
        face, _, _, slip = approach(loop, state, i)
        slip += 0.5 * time_step * (pull_of(force[0], loop.mass, contact, i) - face.pull_x)
        sums[0] += time_step * (tangential + tilted(wall, face, normal)) * slip
        x = point_mean(positions[0], contact, i) + state.origin[0]
        y = point_mean(positions[1], contact, i)
        sums[2] += time_step * (x * normal - y * tangential)
    move(wall, moving, time_step)


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
    """Motion of the deformable wall.

    amplitude [m kg^(1/2)], rate half a step back, and force, workspace, each of shape (modes,); impulse of the
    foundation on the wall [N s], shape (2,); distance beyond its end at which it was pressed [m], shape (1,).
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
