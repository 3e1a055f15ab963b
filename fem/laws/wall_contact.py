"""Unilateral contact of boundary points with the wall.

Compiled. The face is Y = 0 while it is at rest.

depth       d of a point behind the face, -y if the wall is rigid; the deepest it ever was is stored
normal      N by the contact law
stopping    the force that would end this step with the point at rest along the wall
tangential  R by the friction law: the stopping force, at most mu N; so a point either sticks or slides

Contact needs a few properties of the face at a point (`Surface`). A rigid wall is None, and compiled to nothing.

The deformable wall: linear elasticity on a foundation, in the modes that the time step can follow; compiled.

modes       of the free wall, phi^T m phi = 1. The foundation is spread in proportion to the mass, so that they are its
            modes on the foundation as well, w^2 = w_free^2 + w_0^2, and rigid motion is among them: with any number of
            modes, momentum and moment of momentum are those of the whole wall.
motion      central differences of each mode, as of the plate; at rest at the start, without damping
face        displacements of its nodes, linear between them at a point's place along the wall
reaction    N across the tilted face, (-N slope, N) on the point, and R along the wall; the opposite on the two nodes
            beside it, with the weights of the interpolation. This conserves momentum, and energy as the depth is
            measured.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from fem.laws.constraints import friction_force
from fem.laws.unilateral import CONTACT_LAWS
from machine_code.compiled import by_law, compact, compiled, inlined


class Surface(NamedTuple):
    """Face of the wall at a contact point.

    x is along the wall, y across it. node, weight: the node of the face before the point, and the next node's weight in
    the interpolation; beyond: distance of the point beyond the wall's end [m]; sink: the face's y [m], and slope its
    derivative along the wall [-]; rate: velocity [m/s]; pull: acceleration by the known forces [m/s^2]; mobility
    [1/kg].
    """

    node: int
    weight: float
    beyond: float
    sink: float
    slope: float
    rate_x: float
    rate_y: float
    pull_x: float
    pull_y: float
    mobility_x: float
    mobility_y: float


RIGID = Surface(0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
"""Face of a rigid wall, and of one that no point touches."""


class BoundaryContact(NamedTuple):
    """Contact points of the boundary and constants of their laws.

    friction is None without friction. A point is a node, or the weighted mean of some. first, shape (points + 1,):
    where each point's nodes and weights begin in `nodes` and `weights`; mobility, shape (points,): sum of weight^2 /
    mass [1/kg].
    """

    first: np.ndarray
    nodes: np.ndarray
    weights: np.ndarray
    mobility: np.ndarray
    law: Any
    friction: Any


class ContactState(NamedTuple):
    """State of the contact points, each field of shape (points,).

    deepest: greatest depth in the sense of the law [m]; normal, tangential: impulse of the wall [N s]. Workspace of the
    last step: pushing, sliding: force across and along the wall [N]; mean: depth in the sense of the law [m].
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


@compact
def point_mean(values, contact, i):
    """Return the weighted mean of nodal values at point i."""
    total = 0.0
    for k in range(contact.first[i], contact.first[i + 1]):
        total += contact.weights[k] * values[contact.nodes[k]]
    return total


@compact
def acceleration(force, mass, contact, i):
    """Return the acceleration of point i [m/s^2] by nodal forces."""
    total = 0.0
    for k in range(contact.first[i], contact.first[i + 1]):
        total += contact.weights[k] * force[contact.nodes[k]] / mass[contact.nodes[k]]
    return total


@inlined
def approach(parameters, state, i):
    """Return the wall's face at point i, and the point's relative motion.

    The depth behind the face [m], and the speeds away from it and along it [m/s]. parameters, state: an
    `ImpactLoopParameters` and an `ImpactLoopState`.
    """
    wall, contact = parameters.wall, parameters.contact
    positions, velocities = state.positions, state.velocities
    face = surface_at(wall, state.wall, contact, i, positions, state.origin[0])
    slip = point_mean(velocities[0], contact, i) - face.rate_x
    opening = point_mean(velocities[1], contact, i) - face.rate_y - tilted(wall, face, slip)
    return face, face.sink - point_mean(positions[1], contact, i), opening, slip


@compact
def push_back(parameters, state, force):
    """Add the wall's forces on points to `force`.

    `force` must hold the other forces. They are stored in the state. The inertia is that of a point and of the wall's
    nodes beside it together, which keeps light nodes stable.
    """
    contact, wall, contact_state, wall_motion = parameters.contact, parameters.wall, state.contact, state.wall
    mass, time_step = parameters.mass, parameters.time_step
    set_wall_forces(wall, wall_motion)
    for i in range(contact.mobility.size):
        face, depth, opening, slip = approach(parameters, state, i)
        inertia = 1.0 / ((contact.mobility[i] + face.mobility_y) * time_step**2)
        along = acceleration(force[0], mass, contact, i) - face.pull_x
        away = acceleration(force[1], mass, contact, i) - face.pull_y - tilted(wall, face, along)
        before = depth + time_step * opening
        free = depth - time_step * (opening + time_step * away)
        normal = contact_force(contact.law, i, before, free, contact_state.deepest[i], inertia)
        tilt = tilted(wall, face, normal)
        stopping = tilt - (slip / time_step + along) / (contact.mobility[i] + face.mobility_x)
        tangential = friction_force(contact.friction, normal, stopping) - tilt
        contact_state.pushing[i], contact_state.sliding[i] = normal, tangential
        contact_state.mean[i] = 0.5 * (before + free - normal / inertia)
        add_wall_reaction(wall, wall_motion, face, tangential, normal)
        for k in range(contact.first[i], contact.first[i + 1]):
            force[0, contact.nodes[k]] += contact.weights[k] * tangential
            force[1, contact.nodes[k]] += contact.weights[k] * normal


@compact
def add_contact(parameters, state, force):
    """Add the wall's forces, and advance state and wall.

    Arguments as of `push_back`.
    """
    contact, wall, contact_state, wall_motion = parameters.contact, parameters.wall, state.contact, state.wall
    positions, sums, time_step = state.positions, state.sums, parameters.time_step
    push_back(parameters, state, force)
    for i in range(contact.mobility.size):
        contact_state.deepest[i] = max(contact_state.deepest[i], contact_state.mean[i])
        normal, tangential = contact_state.pushing[i], contact_state.sliding[i]
        if normal == 0.0:
            continue
        contact_state.normal[i] += time_step * normal
        contact_state.tangential[i] += time_step * tangential
        face, _, _, slip = approach(parameters, state, i)
        slip += 0.5 * time_step * (acceleration(force[0], parameters.mass, contact, i) - face.pull_x)
        sums[0] += time_step * (tangential + tilted(wall, face, normal)) * slip
        x = point_mean(positions[0], contact, i) + state.origin[0]
        y = point_mean(positions[1], contact, i)
        sums[2] += time_step * (x * normal - y * tangential)
    advance_wall(wall, wall_motion, time_step)


class ElasticWall(NamedTuple):
    """Deformable wall by its modes.

    start, spacing: of the nodes of the face along the wall [m]; reach: distance from the wall's line up to which points
    are examined [m]; face, shape (2, nodes of the face, modes): their displacements [1/kg^(1/2)]; stiffness, shape
    (modes,): w^2 [1/s^2]; foundation: its part of that, w_0^2 [1/s^2]; momentum, shape (2, modes): of the wall at unit
    velocity of each mode [kg^(1/2)].
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
    """Return the wall before it is touched."""
    modes = wall.stiffness.size
    return WallMotion(np.zeros(modes), np.zeros(modes), np.zeros(modes), np.zeros(2), np.zeros(1))


@inlined
def set_wall_forces(wall, wall_motion):
    """Set the forces of wall and foundation."""
    if wall is None:
        return
    for k in range(wall.stiffness.size):
        wall_motion.force[k] = -wall.stiffness[k] * wall_motion.amplitude[k]


@compiled
def locate(wall, x):
    """Return the node of the face before the place x [m].

    Besides, the weight of the next node, and the distance of x beyond the wall's end [m].
    """
    place, last = (x - wall.start) / wall.spacing, wall.face.shape[1] - 1
    node = min(max(math.floor(place), 0), last - 1)
    return node, min(max(place - node, 0.0), 1.0), wall.spacing * max(-place, place - last, 0.0)


@inlined
def surface_at(wall, wall_motion, contact, i, positions, origin):
    """Return the face at contact point i.

    Positions [m] are relative to the origin.
    """
    if wall is None:
        return RIGID
    if not point_mean(positions[1], contact, i) <= wall.reach:
        return RIGID
    node, weight, beyond = locate(wall, origin + point_mean(positions[0], contact, i))
    x_0, x_1 = wall.face[0, node], wall.face[0, node + 1]
    y_0, y_1 = wall.face[1, node], wall.face[1, node + 1]
    sink_0 = sink_1 = rate_x = rate_y = pull_x = pull_y = mobility_x = mobility_y = 0.0
    for k in range(wall.stiffness.size):
        x, y = x_0[k] + weight * (x_1[k] - x_0[k]), y_0[k] + weight * (y_1[k] - y_0[k])
        sink_0 += y_0[k] * wall_motion.amplitude[k]
        sink_1 += y_1[k] * wall_motion.amplitude[k]
        rate_x += x * wall_motion.rate[k]
        rate_y += y * wall_motion.rate[k]
        pull_x += x * wall_motion.force[k]
        pull_y += y * wall_motion.force[k]
        mobility_x += x * x
        mobility_y += y * y
    sink, slope = sink_0 + weight * (sink_1 - sink_0), (sink_1 - sink_0) / wall.spacing
    return Surface(node, weight, beyond, sink, slope, rate_x, rate_y, pull_x, pull_y, mobility_x, mobility_y)


@inlined
def tilted(wall, face, value):
    """Return the face's slope times a value."""
    if wall is None:
        return 0.0
    return face.slope * value


@inlined
def add_wall_reaction(wall, wall_motion, face, tangential, normal):
    """Add the reaction to a contact point's forces [N] to the face."""
    if wall is None:
        return
    if normal == 0.0:
        return
    wall_motion.beyond[0] = max(wall_motion.beyond[0], face.beyond)
    x_0, x_1 = wall.face[0, face.node], wall.face[0, face.node + 1]
    y_0, y_1 = wall.face[1, face.node], wall.face[1, face.node + 1]
    for k in range(wall.stiffness.size):
        x, y = x_0[k] + face.weight * (x_1[k] - x_0[k]), y_0[k] + face.weight * (y_1[k] - y_0[k])
        wall_motion.force[k] -= x * tangential + y * normal


@compiled
def foundation_force(wall, wall_motion, direction):
    """Return the foundation's force [N] along (0) or across (1)."""
    total = 0.0
    for k in range(wall.stiffness.size):
        total += wall.momentum[direction, k] * wall_motion.amplitude[k]
    return -wall.foundation * total


@inlined
def advance_wall(wall, wall_motion, time_step):
    """Advance the wall, whose forces are complete."""
    if wall is None:
        return
    for direction in range(2):
        wall_motion.impulse[direction] += time_step * foundation_force(wall, wall_motion, direction)
    for k in range(wall.stiffness.size):
        wall_motion.rate[k] += time_step * wall_motion.force[k]
        wall_motion.amplitude[k] += time_step * wall_motion.rate[k]


@inlined
def describe_wall(wall, wall_motion, half):
    """Return energy, largest deflection and foundation impulse of the wall.

    Energy [J] of wall and foundation; largest deflection of the face [m] and its place along the wall [m]; impulse of
    the foundation across the wall [N s]. half: of the time step [s].
    """
    if wall is None:
        return 0.0, 0.0, 0.0, 0.0
    energy = 0.0
    for k in range(wall.stiffness.size):
        energy += 0.5 * wall_motion.rate[k] * (wall_motion.rate[k] + 2.0 * half * wall_motion.force[k])
        energy += 0.5 * wall.stiffness[k] * wall_motion.amplitude[k] ** 2
    deflection, place = 0.0, wall.start
    for node in range(wall.face.shape[1]):
        sink = 0.0
        for k in range(wall.stiffness.size):
            sink += wall.face[1, node, k] * wall_motion.amplitude[k]
        if -sink > deflection:
            deflection, place = -sink, wall.start + node * wall.spacing
    return energy, deflection, place, wall_motion.impulse[1] + half * foundation_force(wall, wall_motion, 1)
