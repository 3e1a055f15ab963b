"""The constrained corner: a two-sided slider on the wall with Coulomb friction; compiled.

    place       P is the weighted mean of the corner's nodes: one node, or a patch of the side
    gap         y_P, its distance from the wall's line Y = 0
    normal      N by the hold: a penalty spring, with or without a dashpot, or the exact constraint;
                it acts both ways, N < 0 pulls the corner back to the wall
    stopping    the force that would end this step with the corner at rest
    tangential  R by the friction law: the stopping force, cut to what the law allows

Holds and laws are NamedTuples, each with a function registered for it by `implements`; the law of a scene without
friction is None, and is compiled to nothing.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from fem.compiled import compiled, implements


class Penalty(NamedTuple):
    """N = -k y_P; stiffness [N/m]."""

    stiffness: float


class DampedPenalty(NamedTuple):
    """N = -k y_P - c y_P', the velocity half a step late; stiffness [N/m], damping [N s/m]."""

    stiffness: float
    damping: float


class Exact(NamedTuple):
    """N is whatever ends this step with y_P = 0. Its one member is there because a tuple needs one."""

    gap: float


class Corner(NamedTuple):
    """Nodes that carry the corner and their weights, sum 1; sum of weight^2 / mass [1/kg]; how it is held."""

    nodes: np.ndarray
    weights: np.ndarray
    mobility: float
    hold: Any


class Drag(NamedTuple):
    """R = -mu |N| sign(v_P), or less where that is enough to stop the corner."""

    coefficient: float


class Signed(NamedTuple):
    """R = -mu N sign(v_P): where N < 0 this drives the corner on. Kept to show what the sign does."""

    coefficient: float


def hold_forces(hold: Any, gap: float, rate: float, closing: float) -> tuple[float, float]:
    """Normal force of spring and of dashpot [N] of any hold above; compiled code only."""
    raise NotImplementedError(type(hold))


def hold_energy(hold: Any, gap: float) -> float:
    """Energy [J] in the hold's spring; compiled code only."""
    raise NotImplementedError(type(hold))


def friction_force(law: Any, normal: float, stopping: float) -> float:
    """Tangential force [N] of any law above; compiled code only."""
    raise NotImplementedError(type(law))


@implements(hold_forces, Penalty)
def _penalty(hold, gap, rate, closing):
    return -hold.stiffness * gap, 0.0


@implements(hold_forces, DampedPenalty)
def _damped_penalty(hold, gap, rate, closing):
    return -hold.stiffness * gap, -hold.damping * rate


@implements(hold_forces, Exact)
def _exact(hold, gap, rate, closing):
    return closing, 0.0


@implements(hold_energy, Penalty, DampedPenalty)
def _spring_energy(hold, gap):
    return 0.5 * hold.stiffness * gap * gap


@implements(hold_energy, Exact)
def _no_energy(hold, gap):
    return 0.0


@implements(friction_force, type(None))
def _no_friction(law, normal, stopping):
    return 0.0


@implements(friction_force, Drag)
def _drag(law, normal, stopping):
    limit = law.coefficient * abs(normal)
    return min(max(stopping, -limit), limit)


@implements(friction_force, Signed)
def _signed(law, normal, stopping):
    limit = law.coefficient * normal
    if limit >= 0.0:
        return min(max(stopping, -limit), limit)
    return limit if stopping > 0.0 else -limit


@compiled
def weighted(values, corner):
    """Weighted mean over the corner's nodes of values of shape (nodes,)."""
    total = 0.0
    for i in range(corner.nodes.size):
        total += corner.weights[i] * values[corner.nodes[i]]
    return total


@compiled
def add_corner_reaction(positions, velocities, mass, time_step, corner, friction, force):
    """Add the wall's reaction to `force`.

    `force` must already hold the other forces, and `velocities` those half a step back. Returns normal and
    tangential reaction [N], the corner's slip speed half a step back and ahead [m/s], power of the dashpot [W].
    """
    gap, rate, slip = (
        weighted(positions[1], corner),
        weighted(velocities[1], corner),
        weighted(velocities[0], corner),
    )
    pull_x = pull_y = 0.0
    for i in range(corner.nodes.size):
        node, share = corner.nodes[i], corner.weights[i]
        pull_x += share * force[0, node] / mass[node]
        pull_y += share * force[1, node] / mass[node]
    closing = -((gap / time_step + rate) / time_step + pull_y) / corner.mobility
    spring, dashpot = hold_forces(corner.hold, gap, rate, closing)
    normal = spring + dashpot
    stopping = -(slip / time_step + pull_x) / corner.mobility
    tangential = friction_force(friction, normal, stopping)
    for i in range(corner.nodes.size):
        force[0, corner.nodes[i]] += corner.weights[i] * tangential
        force[1, corner.nodes[i]] += corner.weights[i] * normal
    later_slip = slip + time_step * (pull_x + corner.mobility * tangential)
    later_rate = rate + time_step * (pull_y + corner.mobility * normal)
    return normal, tangential, slip, later_slip, 0.5 * dashpot * (rate + later_rate)
