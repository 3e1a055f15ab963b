"""The constraint of the corner where the scene leaves it open: the penalty spring as long as it cannot be seen."""

from __future__ import annotations

from tailslap.case.corner.rigid import RigidStages
from tailslap.planning.decisions import Decision
from tailslap.scene.schema import Plate

SOFTEST = 0.01
"""Least multiple of the program's spring."""

UNSEEN = 1e-5
"""Share of the centre's way to the wall that the spring may give under the reaction at the start: no reported digit
changes."""


def decide_constraint(
    plan: RigidStages, plate: Plate, spring_share: float
) -> tuple[RigidStages, tuple[Decision, ...]]:
    """The plan with its constraint: exact where a spring would ring, or be seen beside the plate's flexibility."""
    corner = plan.scene.corner
    if not corner.constraint_is_open:
        return plan, ()
    if not plate.relieved:
        why = "the plate starts unstressed, and a spring would ring with it"
    elif spring_share > UNSEEN:
        why = f"a spring would deflect by {spring_share:.1e} of the way, which is seen beside the plate's flexibility"
    else:
        return plan, ()
    return _decided(plan, Decision("corner.constraint", "exact", why))


def softened_constraint(plan: RigidStages, spring_share: float) -> tuple[RigidStages, tuple[Decision, ...]]:
    """The plan with the softest spring that is not seen: friction then feeds high modes less. As it is where the scene
    gives the constraint, or the exact one was chosen."""
    corner = plan.scene.corner
    scale = max(SOFTEST, spring_share / UNSEEN)
    if not corner.constraint_is_open or scale > 0.5:
        return plan, ()
    why = "friction would make the plate flutter too fast to be damped without harm; a softer spring feeds it less"
    return _decided(plan, Decision("corner.penalty_scale", scale, why))


def _decided(plan: RigidStages, decision: Decision) -> tuple[RigidStages, tuple[Decision, ...]]:
    return plan.with_changes({decision.key: decision.value}), (decision,)
