"""Points of the boundary in unilateral contact with the wall's face, Y = 0 while it is at rest; compiled.

depth       d of a point behind the face, -y if the wall is rigid; the deepest it ever was is stored
normal      N by the contact law
stopping    the force that would end this step with the point at rest along the wall
tangential  R by the friction law: the stopping force, cut to mu N; so a point sticks or slides, and nothing between

Contact asks a few things of the face under a point (`Surface`). A rigid wall is None, and compiled to nothing;
`elastic_wall` is loaded with the first deformable wall.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from fem.laws.corner import friction_force
from fem.laws.unilateral import CONTACT_LAWS
from fem.machine_code.compiled import by_law, compiled, implements, inlined


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


def resist(wall: Any, moving: Any) -> None:
    """Begin the wall's forces of this instant with its own and its foundation's; compiled code only."""
    raise NotImplementedError(type(wall))


def under(wall: Any, moving: Any, contact: Any, i: int, positions: Any, origin: float) -> Surface:
    """The face under contact point i, positions [m] being counted from the origin; compiled code only."""
    raise NotImplementedError(type(wall))


def tilted(wall: Any, face: Surface, value: float) -> float:
    """The face's slope times a value; compiled code only."""
    raise NotImplementedError(type(wall))


def press(wall: Any, moving: Any, face: Surface, tangential: float, normal: float) -> None:
    """Put the reaction to the forces [N] on a contact point onto the face; compiled code only."""
    raise NotImplementedError(type(wall))


def move(wall: Any, moving: Any, time_step: float) -> None:
    """Move the wall on by a step, its forces being complete; compiled code only."""
    raise NotImplementedError(type(wall))


def held_by(wall: Any, moving: Any, half: float) -> tuple[float, float, float, float]:
    """Energy [J] of the wall and its foundation; largest deflection of the face [m] and its place along the wall [m];
    impulse of the foundation across the wall [N s]; half: of the time step [s]. Compiled code only."""
    raise NotImplementedError(type(wall))


@implements(resist, type(None), merged=True)
def _nothing_resists(wall, moving):
    return


@implements(under, type(None), merged=True)
def _rigid(wall, moving, contact, i, positions, origin):
    return Surface(0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@implements(tilted, type(None), merged=True)
def _straight(wall, face, value):
    return 0.0


@implements(press, type(None), merged=True)
def _nothing_pressed(wall, moving, face, tangential, normal):
    return


@implements(move, type(None), merged=True)
def _nothing_moves(wall, moving, time_step):
    return


@implements(held_by, type(None), merged=True)
def _nothing_held(wall, moving, half):
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


@by_law(CONTACT_LAWS, "force")
def contact_force(law: Any, i: int, before: float, free: float, deepest: float, inertia: float) -> float:
    """Normal force [N] of point i; compiled code only."""
    raise NotImplementedError(type(law))


@by_law(CONTACT_LAWS, "stored")
def stored_energy(law: Any, i: int, before: float, depth: float, deepest: float, force: float) -> float:
    """Energy [J] of point i that unloading gives back; compiled code only."""
    raise NotImplementedError(type(law))


@by_law(CONTACT_LAWS, "lost")
def lost_energy(law: Any, i: int, deepest: float) -> float:
    """Energy [J] of point i that its crush has taken for good; compiled code only."""
    raise NotImplementedError(type(law))


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
def approach(positions, velocities, contact, wall, moving, origin, i):
    """The wall's face under point i; the point's depth behind it [m], its speed away from it and along it [m/s]."""
    face = under(wall, moving, contact, i, positions, origin)
    slip = point_mean(velocities[0], contact, i) - face.rate_x
    opening = point_mean(velocities[1], contact, i) - face.rate_y - tilted(wall, face, slip)
    return face, face.sink - point_mean(positions[1], contact, i), opening, slip


@compiled
def push_back(positions, velocities, mass, time_step, contact, kept, wall, moving, origin, force):
    """Add the wall's forces on all points to `force`, which must hold the others, and note them in `kept`.

    What a point and the wall's nodes beside it weigh bears the step together: that is what keeps light nodes stable.
    """
    resist(wall, moving)
    for i in range(contact.mobility.size):
        face, depth, opening, slip = approach(positions, velocities, contact, wall, moving, origin, i)
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
def add_contact(positions, velocities, mass, time_step, contact, kept, wall, moving, sums, origin, force):
    """Add the wall's forces to `force`, what they do to the points' state and to the sums, and move the wall on.

    sums: friction work [J] and moment of the impulse about the wall's frame [N m s], as in `ImpactLoopState`.
    """
    push_back(positions, velocities, mass, time_step, contact, kept, wall, moving, origin, force)
    for i in range(contact.mobility.size):
        kept.deepest[i] = max(kept.deepest[i], kept.mean[i])
        normal, tangential = kept.pushing[i], kept.sliding[i]
        if normal == 0.0:
            continue
        kept.normal[i] += time_step * normal
        kept.tangential[i] += time_step * tangential
        face, _, _, slip = approach(positions, velocities, contact, wall, moving, origin, i)
        slip += 0.5 * time_step * (pull_of(force[0], mass, contact, i) - face.pull_x)
        sums[0] += time_step * (tangential + tilted(wall, face, normal)) * slip
        x, y = point_mean(positions[0], contact, i) + origin, point_mean(positions[1], contact, i)
        sums[2] += time_step * (x * normal - y * tangential)
    move(wall, moving, time_step)
