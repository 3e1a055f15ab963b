"""The constraint of the corner where the scene leaves it open: the penalty spring as long as it cannot be seen."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tailslap.planning.decisions import Decision, with_tables
from tailslap.planning.flexibility import centre_travel, rigid_start
from tailslap.planning.plan import Plan
from tailslap.scene.schema import Plate

if TYPE_CHECKING:
    from fem.discretisation.model import PlateModel

SOFTEST = 0.01
"""Least multiple of the program's spring."""

UNSEEN = 1e-5
"""Deflection of the spring, over the way of the centre, below which it changes no digit that is reported."""


def decide_constraint(plan: Plan, plate: Plate, model: PlateModel) -> tuple[Plan, tuple[Decision, ...]]:
    """The plan with its constraint: exact where a spring would ring, or be seen beside the plate's flexibility."""
    corner = plan.scene.corner
    if not corner.constraint_is_open:
        return plan, ()
    if plate.start == "unstressed":
        why = "the plate starts unstressed, and a spring would ring with it"
    elif (share := spring_share(plan, model)) > UNSEEN:
        why = f"a spring would give by {share:.1e} of the way, which is seen beside the plate's flexibility"
    else:
        return plan, ()
    exact = corner.model_copy(update={"constraint": "exact"})
    return with_tables(plan, corner=exact), (Decision("corner.constraint", "exact", why),)


def softened_constraint(plan: Plan, model: PlateModel) -> tuple[Plan, tuple[Decision, ...]]:
    """The plan with the softest spring that is not seen: friction then feeds high modes less. As it is where the scene
    gives the constraint, or the exact one was chosen."""
    corner = plan.scene.corner
    scale = max(SOFTEST, spring_share(plan, model) / UNSEEN)
    if not corner.constraint_is_open or scale > 0.5:
        return plan, ()
    why = "friction would make the plate flutter too fast to be damped without harm; a softer spring feeds it less"
    softer = corner.model_copy(update={"penalty_scale": scale})
    return with_tables(plan, corner=softer), (Decision("corner.penalty_scale", scale, why),)


def spring_share(plan: Plan, model: PlateModel) -> float:
    """Deflection of the corner's spring under the start's reaction, over the centre's way to the wall."""
    from fem.start.inertia_relief import relieved_fields

    gap = relieved_fields(model, rigid_start(plan)).gap
    return abs(gap) / centre_travel(plan)
