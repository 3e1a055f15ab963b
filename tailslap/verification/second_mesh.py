"""The other mesh of a plate, and the exact constraint in place of the scene's spring, by which a run is judged that
statics cannot judge."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from fem.plate.kinds import ELEMENT_KINDS
from tailslap.case.corner.rigid import RigidStages
from tailslap.planning.fe_plan import FePlan
from tailslap.scene.schema import Plate

FINER_UP_TO = 400
"""Elements up to which the second mesh is the finer one; above, one of about as many nodes as the first."""


def second_meshes(fe_plan: FePlan) -> Iterator[Plate]:
    """Plates to try in turn: quadratic elements where the run has linear ones, for a mesh that locks may agree with one
    that locks a little less; else another number of elements."""
    plate = fe_plan.plate
    along, across = plate.counts
    finer, coarser = (2 * along, 2 * across), (max(1, along // 2), max(1, across // 2))
    few, richer = math.prod(plate.counts) <= FINER_UP_TO, ELEMENT_KINDS[plate.element].richer
    counts = (plate.counts, finer) if few and richer else (finer, coarser) if few else (coarser, finer)
    for elements in counts:
        yield plate.model_copy(update={"elements": elements, "element": richer or plate.element})


def on_mesh(fe_plan: FePlan, plate: Plate) -> RigidStages:
    """The plan as asked for on the mesh of this plate, the exact constraint in place of a spring that is given."""
    changes: dict[str, Any] = {"plate.elements": plate.elements, "plate.element": plate.element}
    changes |= {"plate.distortion": 0.0, "plate.lumping": "exact", "output": None}
    if not fe_plan.asked.scene.corner.constraint_is_open:
        changes |= {
            "corner.constraint": "exact",
            "corner.penalty_scale": None,
            "corner.damping_ratio": None,
        }
    return fe_plan.asked.with_changes(changes)


def damped_alike(plan: RigidStages, fe_plan: FePlan) -> RigidStages:
    """The plan with the elastic velocities damped as in this run."""
    damping = fe_plan.model.loop.elastic_damping
    if damping is not None:
        return plan.with_changes({"damping.kind": "elastic-velocity", "damping.rate": damping.rate})
    return plan if plan.scene.damping else plan.with_changes({"damping.kind": "none"})


def damped_freely(plan: RigidStages) -> RigidStages:
    """The plan with its damping left to the program, but for what is in proportion to the stiffness."""
    damping = plan.scene.damping
    if damping is None or damping.kind is None:
        return plan
    own = {"damping.kind": None, "damping.rate": None}
    return plan.with_changes(own if damping.ratio or damping.bulk_viscosity else {"damping": None})
