"""Settings with their models, and what can be said of them without a run."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from postprocess.comparison.quantities import largest_relative
from tailslap.case.corner.rigid import RigidStages
from tailslap.case.cost import loop_seconds
from tailslap.errors import InputError, Verbatim
from tailslap.planning.decide_damping import Growth
from tailslap.planning.fe_model import make_model, resolved_plate
from tailslap.planning.fe_plan import FePlan
from tailslap.planning.flexibility import centre_travel, deflection_ratio, rigid_start
from tailslap.scene.schema import Scene
from tailslap.tolerance.refinement_levels import RefinementLevel, refinement_levels

if TYPE_CHECKING:
    from fem.model.plate_model import PlateModel


@dataclass(frozen=True, eq=False)
class Candidate:
    """A level with its model, its deflection ratio, and the expected time of its loop [s].

    quantities: the five quantities by the modal model of this mesh, where that was asked for and can be had.
    """

    level: RefinementLevel
    plan: RigidStages
    model: PlateModel
    deflection_ratio: float
    seconds: float
    quantities: Mapping[str, float] = field(default_factory=dict)

    def distance(self, other: Candidate, sensitivity: float) -> float:
        """How far apart the two results are expected to be, relatively: by modes, else by deflection ratios."""
        if self.quantities and other.quantities:
            return largest_relative(self.quantities, other.quantities)
        return BESIDE_THE_DEFLECTION * sensitivity * abs(self.deflection_ratio - other.deflection_ratio)


BESIDE_THE_DEFLECTION = 3.0
"""What is left near the limit is not in proportion to the deflection: there is vibration, and what hardly moves."""


def constraints(scene: Scene) -> tuple[str, ...]:
    """Constraints to try: the scene's own if it says anything of it."""
    return ("penalty", "exact") if scene.corner.constraint_is_open else (scene.corner.constraint,)


def candidate(plan: RigidStages, level: RefinementLevel) -> Candidate | None:
    """The level's candidate, or None where the mesh cannot carry the inertia or the patch."""
    try:
        plan = plan.with_changes(level.changes)
        model = make_model(plan, plan.scene.needed_plate)
    except InputError:
        return None
    steps = math.ceil(plan.motion.strike.t / model.loop.time_step)
    seconds = loop_seconds(plan.scene, level.element, level.elements, steps, plan.scene.time.rows)
    return Candidate(level, plan, model, deflection_ratio(plan, model), seconds)


def coarsest(plan: RigidStages, constraint: str) -> list[Candidate]:
    """The coarsest mesh that makes a model, with linear elements and with quadratic ones, which do not lock."""
    levels = refinement_levels(plan.scene, constraint)
    for linear, quadratic in zip(levels, levels, strict=True):
        found = [made for level in (linear, quadratic) if (made := candidate(plan, level))]
        if len(found) == 2:
            return found
    raise InputError(
        "plate.elements", Verbatim("none"), "no mesh of the refinement_levels makes a model of this vehicle"
    )


def with_modal_quantities(made: Candidate) -> Candidate:
    """The candidate with its modal quantities; without them where the modal model lacks what the scene asks for."""
    from tailslap.modal_analysis.run import modal_run

    plan, plate = made.plan, resolved_plate(made.plan.scene, made.plan.scene.needed_plate)
    none = Growth(0.0, 0.0, 0.0)  # modes do not flutter
    fe_plan = FePlan(
        plan,
        plan,
        (),
        none,
        plate,
        made.model,
        rigid_start(plan),
        centre_travel(plan),
        made.deflection_ratio,
        math.nan,
    )
    try:
        return replace(made, quantities=modal_run(fe_plan, tolerance=1.0).values)
    except InputError:
        return made
