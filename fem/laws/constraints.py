"""Constraints of the corner on the wall's line.

Each is one object, registered here or in any other file.

A constraint computes the normal force N [N] from the gap [m], its rate half a step back [m/s], and the closing force
that would end the step with no gap. It acts in both directions: N < 0 pulls the corner back to the wall.

The constrained corner is a two-sided slider on the wall; compiled.

    place       P is the weighted mean of the corner's nodes: one node, or a support patch of the side
    gap         y_P, its distance from the wall's line Y = 0
    normal      N by the constraint
    stopping    the force that would end this step with the corner at rest
    tangential  R by the friction law: the stopping force, within the limits of the law

The law of a scene without friction is None, and is compiled to nothing.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from fem.laws.friction import FRICTION_LAWS
from fem.registry import Law, LawRegistry
from machine_code.compiled import by_law, compact

CONSTRAINTS: "LawRegistry[Constraint]" = LawRegistry("constraint")
"""Constraints by their names in a scene."""


@dataclass(frozen=True)
class ConstraintInput:
    """Input for the constants of a constraint.

    Attributes
    ----------
    youngs_modulus : float
        Young's modulus of the plate [Pa].
    thickness : float
        Thickness of the plate [m].
    mobility : float
        Sum of weight^2 / mass over the corner's nodes [1/kg].
    penalty_scale : float
        Multiple of the program's stiffness [-].
    damping_ratio : float
        Damping of the dashpot over critical damping [-].
    """

    youngs_modulus: float
    thickness: float
    mobility: float
    penalty_scale: float = 1.0
    damping_ratio: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Constraint(Law):
    """Constraint of the corner.

    Attributes
    ----------
    make : callable
        Constants from a `ConstraintInput`.
    forces : callable
        Kernel (constants, gap, rate, closing) -> normal force of spring and of dashpot [N].
    energy : callable
        Kernel (constants, gap) -> energy [J] in the spring.
    stiffness, damping : callable
        Stiffness [N/m] and damping [N s/m] of its constants; an exact constraint is infinitely stiff.
    text : str
        Description for reports.
    keys : tuple of str
        Keys of the scene's [corner] that it takes.
    """

    make: Callable[[ConstraintInput], Any]
    forces: Callable[[Any, float, float, float], tuple[float, float]]
    energy: Callable[[Any, float], float]
    stiffness: Callable[[Any], float]
    damping: Callable[[Any], float] = field(default_factory=lambda: lambda constants: 0.0)
    text: str
    keys: tuple[str, ...] = ()


class Penalty(NamedTuple):
    """Spring and dashpot, N = -k y_P - c y_P'.

    The velocity is that of half a step before. stiffness [N/m]; damping [N s/m].
    """

    stiffness: float
    damping: float = 0.0


def penalty(inputs: ConstraintInput) -> Penalty:
    """Return the program's spring and dashpot.

    The stiffness is 0.3 times Young's modulus times thickness times the scale. A spring as stiff as the elements brings
    the corner's frequency among the plate's: with friction the two flutter sooner, and the time step falls by 14 %. A
    much softer one shows in the results, and flutters with the plate's lowest modes, which stiffness-proportional
    damping hardly reaches.
    """
    stiffness = inputs.penalty_scale * 0.3 * inputs.youngs_modulus * inputs.thickness
    return Penalty(stiffness, inputs.damping_ratio * 2.0 * math.sqrt(stiffness / inputs.mobility))


CONSTRAINTS.register(
    Constraint(
        name="penalty",
        constants=Penalty,
        make=penalty,
        forces=lambda constants, gap, rate, closing: (-constants.stiffness * gap, -constants.damping * rate),
        energy=lambda constants, gap: 0.5 * constants.stiffness * gap * gap,
        stiffness=lambda constants: constants.stiffness,
        damping=lambda constants: constants.damping,
        text="a penalty spring",
        keys=("penalty_scale", "damping_ratio"),
    )
)


class Exact(NamedTuple):
    """Constraint whose force N ends the step with y_P = 0.

    gap: unused; a tuple needs a member.
    """

    gap: float


CONSTRAINTS.register(
    Constraint(
        name="exact",
        constants=Exact,
        make=lambda inputs: Exact(0.0),
        forces=lambda constants, gap, rate, closing: (closing, 0.0),
        energy=lambda constants, gap: 0.0,
        stiffness=lambda constants: math.inf,
        text="an exact constraint",
    )
)


class CornerConstraint(NamedTuple):
    """Nodes of the corner and its constraint's constants.

    weights: of the nodes, of sum 1; mobility: sum of weight^2 / mass [1/kg]. The properties are for Python; compiled
    code calls the constraint's kernels.
    """

    nodes: np.ndarray
    weights: np.ndarray
    mobility: float
    constraint: Any

    @property
    def text(self) -> str:
        """Name of the constraint in reports."""
        return CONSTRAINTS.of(self.constraint).text + (" with a dashpot" if self.dashpot else "")

    @property
    def stiffness(self) -> float:
        """Stiffness [N/m] of the constraint, infinite if exact."""
        return CONSTRAINTS.of(self.constraint).stiffness(self.constraint)

    @property
    def is_exact(self) -> bool:
        """True if the constraint has no spring."""
        return self.stiffness == np.inf

    @property
    def spring(self) -> float:
        """Stiffness [N/m] of the spring, 0 without one."""
        return 0.0 if self.is_exact else self.stiffness

    @property
    def dashpot(self) -> float:
        """Damping of the dashpot [N s/m], or 0."""
        return CONSTRAINTS.of(self.constraint).damping(self.constraint)


constraint_forces = by_law(CONSTRAINTS, "forces")
constraint_energy = by_law(CONSTRAINTS, "energy")
friction_force = by_law(FRICTION_LAWS, "force")


@compact
def weighted(values, corner):
    """Return the weighted mean of nodal values over the corner's nodes."""
    total = 0.0
    for i in range(corner.nodes.size):
        total += corner.weights[i] * values[corner.nodes[i]]
    return total


@compact
def add_corner_reaction(positions, velocities, mass, time_step, corner, friction, force):
    """Add the wall's reaction to `force`.

    `force` must already hold the other forces, and `velocities` those half a step back. Returns normal and
    tangential reaction [N], the corner's slip speed half a step back and ahead [m/s], power of the dashpot [W].
    """
    gap, rate = weighted(positions[1], corner), weighted(velocities[1], corner)
    slip = weighted(velocities[0], corner)
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
