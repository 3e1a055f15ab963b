"""The constrained corner: a two-sided slider on the wall; compiled.

    place       P is the weighted mean of the corner's nodes: one node, or a support patch of the side
    gap         y_P, its distance from the wall's line Y = 0
    normal      N by the constraint
    stopping    the force that would end this step with the corner at rest
    tangential  R by the friction law: the stopping force, cut to what the law allows

The law of a scene without friction is None, and is compiled to nothing.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from fem.laws.constraints import CONSTRAINTS
from fem.laws.friction import FRICTION_LAWS
from fem.machine_code.compiled import by_law, compiled


class CornerConstraint(NamedTuple):
    """Nodes that carry the corner and their weights, sum 1; sum of weight^2 / mass [1/kg]; its constraint's constants.

    The properties are for Python; compiled code asks the constraint's kernels.
    """

    nodes: np.ndarray
    weights: np.ndarray
    mobility: float
    constraint: Any

    @property
    def stiffness(self) -> float:
        """Stiffness [N/m] of the constraint; infinite where it is exact."""
        return CONSTRAINTS.of(self.constraint).stiffness(self.constraint)

    @property
    def is_exact(self) -> bool:
        """True if the constraint has no spring."""
        return self.stiffness == np.inf

    @property
    def spring(self) -> float:
        """Stiffness [N/m] of the constraint's spring; 0 where it has none."""
        return 0.0 if self.is_exact else self.stiffness

    @property
    def dashpot(self) -> float:
        """Damping [N s/m] of the constraint's dashpot; 0 where it has none."""
        return CONSTRAINTS.of(self.constraint).damping(self.constraint)


@by_law(CONSTRAINTS, "forces")
def constraint_forces(constraint: Any, gap: float, rate: float, closing: float) -> tuple[float, float]:
    """Normal force of spring and of dashpot [N]; compiled code only."""
    raise NotImplementedError(type(constraint))


@by_law(CONSTRAINTS, "energy")
def constraint_energy(constraint: Any, gap: float) -> float:
    """Energy [J] in the constraint's spring; compiled code only."""
    raise NotImplementedError(type(constraint))


@by_law(FRICTION_LAWS, "force")
def friction_force(law: Any, normal: float, stopping: float) -> float:
    """Tangential force [N]; compiled code only."""
    raise NotImplementedError(type(law))


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
        node, fraction = corner.nodes[i], corner.weights[i]
        pull_x += fraction * force[0, node] / mass[node]
        pull_y += fraction * force[1, node] / mass[node]
    closing = -((gap / time_step + rate) / time_step + pull_y) / corner.mobility
    spring, dashpot = constraint_forces(corner.constraint, gap, rate, closing)
    normal = spring + dashpot
    stopping = -(slip / time_step + pull_x) / corner.mobility
    tangential = friction_force(friction, normal, stopping)
    for i in range(corner.nodes.size):
        force[0, corner.nodes[i]] += corner.weights[i] * tangential
        force[1, corner.nodes[i]] += corner.weights[i] * normal
    later_slip = slip + time_step * (pull_x + corner.mobility * tangential)
    later_rate = rate + time_step * (pull_y + corner.mobility * normal)
    return normal, tangential, slip, later_slip, 0.5 * dashpot * (rate + later_rate)
