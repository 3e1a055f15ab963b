"""The other mesh of a plate, and the exact constraint, by which a run is judged that statics cannot judge."""

from __future__ import annotations

import math
from collections.abc import Iterator

from tailslap.decisions import with_tables
from tailslap.fe_plan import FePlan
from tailslap.numerical_error import COARSER, FINER
from tailslap.plan import Plan

FINER_UP_TO = 400
"""Elements up to which the second mesh is twice as fine; it costs eight times the run."""


def second_meshes(fe_plan: FePlan) -> Iterator[tuple[tuple[int, int], float]]:
    """Elements along and across to try in turn, each with the factor from the distance to the error."""
    along, across = fe_plan.plate.counts
    finer, coarser = ((2 * along, 2 * across), FINER), ((along // 2, across // 2), COARSER)
    first_finer = math.prod((along, across)) <= FINER_UP_TO or min(coarser[0]) < 2
    yield from (finer, coarser) if first_finer else (coarser, finer)


def on_mesh(fe_plan: FePlan, elements: tuple[int, int]) -> Plan:
    """The plan as asked for, on this mesh of the same elements, its corner held exactly; damping is decided anew."""
    scene = fe_plan.asked.scene
    assert scene.plate is not None
    changes = {"elements": elements, "element": fe_plan.plate.element}
    corner = {"constraint": "exact", "penalty_scale": 1.0, "damping_ratio": None}
    return with_tables(
        fe_plan.asked,
        plate=scene.plate.model_copy(update=changes),
        corner=scene.corner.model_copy(update=corner),
    )
