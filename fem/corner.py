"""The constrained corner: a two-sided penalty slider with Coulomb friction; compiled.

    gap         y_P, the corner's distance from the wall's line Y = 0
    normal      N = -k y_P, both ways: N < 0 pulls the corner back to the wall
    stopping    the force that would end this step with the corner at rest
    tangential  R, by the friction law: the stopping force, cut to what the law allows

A friction law is a NamedTuple and one function registered for it with `overload(friction_force)`; the law of a
scene without friction is None, and is compiled to nothing.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from numba import types
from numba.extending import overload

from fem.compiled import compiled


class Corner(NamedTuple):
    """Node at corner P and the stiffness [N/m] that holds it on the wall."""

    node: int
    penalty_stiffness: float


class Drag(NamedTuple):
    """R = -mu |N| sign(v_P), or less where that is enough to stop the corner."""

    coefficient: float


class Signed(NamedTuple):
    """R = -mu N sign(v_P): where N < 0 this drives the corner on. Kept to show what the sign does."""

    coefficient: float


def friction_force(law: Any, normal: float, stopping: float) -> float:
    """Tangential force [N] of any law above; compiled code only."""
    raise NotImplementedError(type(law))


def _is(law: Any, kind: type) -> bool:
    return isinstance(law, types.BaseNamedTuple) and law.instance_class is kind


@overload(friction_force)
def _no_friction(law: Any, normal: Any, stopping: Any) -> Any:
    if not isinstance(law, types.NoneType):
        return None

    def force(law: Any, normal: Any, stopping: Any) -> Any:
        return 0.0

    return force


@overload(friction_force)
def _drag(law: Any, normal: Any, stopping: Any) -> Any:
    if not _is(law, Drag):
        return None

    def force(law: Any, normal: Any, stopping: Any) -> Any:
        limit = law.coefficient * abs(normal)
        return min(max(stopping, -limit), limit)

    return force


@overload(friction_force)
def _signed(law: Any, normal: Any, stopping: Any) -> Any:
    if not _is(law, Signed):
        return None

    def force(law: Any, normal: Any, stopping: Any) -> Any:
        limit = law.coefficient * normal
        if limit >= 0.0:
            return min(max(stopping, -limit), limit)
        return limit if stopping > 0.0 else -limit

    return force


@compiled
def add_corner_reaction(positions, velocities, mass, time_step, corner, friction, force):
    """Add the wall's reaction to `force` at the corner; return it as (normal, tangential) [N].

    `force` must already hold the other forces on the corner, and `velocities` those half a step back.
    """
    p = corner.node
    normal = -corner.penalty_stiffness * positions[1, p]
    stopping = -(mass[p] * velocities[0, p] / time_step + force[0, p])
    tangential = friction_force(friction, normal, stopping)
    force[0, p] += tangential
    force[1, p] += normal
    return normal, tangential
