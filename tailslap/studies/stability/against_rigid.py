"""A cell of the map, compared with the rigid motion; where it differs, refined models must differ likewise."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from typing import Any

from fem.discretisation.element_kinds import ELEMENT_KINDS
from postprocess.comparison.comparison import largest
from tailslap.case.corner.rigid import RigidStages
from tailslap.errors import InputError
from tailslap.scene.schema import Plate, Scene
from tailslap.scene.vary import Changes
from tailslap.scene_run import Outcome, run_scene
from tailslap.studies.stability.reference import FLUTTER_DAMPING, quadratic_and_exact
from tailslap.studies.stability.verdict import (
    CAUGHT,
    FLEXIBLE,
    REFUSED,
    RIGHT,
    WRONG,
    Verdict,
    by_refinement,
    distance,
)
from tailslap.verification.check import failed_names

KINDS = {
    RIGHT: "as the rigid motion",
    FLEXIBLE: "not rigid, confirmed by refinement",
    REFUSED: "wrong input, no run",
    CAUGHT: "failed a check of its own",
    WRONG: "passed every check, and is not right",
}
"""Kinds of verdicts and what they mean."""

SURVIVES = 0.5
"""Share of a difference that refinement may change for it to count as the plate's own."""

BESIDE_THE_POINT = {"reaction against rigid", "friction by ringing"}
"""Checks that a refined model may fail and still confirm the five quantities: if it is corrupted, it disagrees."""


def against_rigid(outcome: Outcome, tolerance: float) -> Verdict:
    """The verdict; tolerance: difference from the rigid motion up to which the cell is right."""
    found = largest(outcome.difference)
    if not outcome.passed:
        return Verdict(CAUGHT, ", ".join(failed_names(outcome.checks)), difference=found)
    if found <= tolerance:
        return Verdict(RIGHT, difference=found)
    return _confirmed(outcome, found, tolerance)


def _confirmed(outcome: Outcome, found: float, tolerance: float) -> Verdict:
    """Flexible if its own error is small beside the difference and the difference survives refinement, else wrong."""
    own, asked = outcome.error, outcome.fe_plan.asked
    # Statics bounds error and flexibility alike: with a bound that is wide, both are.
    if not own.total <= tolerance + SURVIVES * max(found, own.flexibility):
        return Verdict(WRONG, reason=f"its own numerical error is {own.total:.1e}", difference=found)
    verdict = Verdict(WRONG, reason="no refined model came to a result", difference=found)
    for name, refine in REFINEMENTS.items():
        began = time.perf_counter()
        refined = _refined_difference(asked, refine(asked.scene, outcome.fe_plan.plate))
        if refined is None:
            continue
        its, moved = largest(refined), distance(outcome.difference, refined)
        verdict = by_refinement(name, moved, tolerance + SURVIVES * its, found, its, began)
        if verdict.kind == FLEXIBLE:
            break
    return verdict


def _refined_difference(plan: RigidStages, changes: Changes) -> Mapping[str, float] | None:
    """Differences of a refined model from the rigid motion; None where they say nothing."""
    try:
        refined = run_scene(plan.varied(changes))
    except InputError:
        return None
    usable = (
        math.isfinite(largest(refined.difference)) and set(failed_names(refined.checks)) <= BESIDE_THE_POINT
    )
    return refined.difference if usable else None


def _finer(scene: Scene, plate: Plate) -> Changes:
    """Twice the elements each way, half the time step, four times the corner's spring; plate: as the run had it."""
    (along, across), corner = plate.counts, scene.corner
    changes: dict[str, Any] = {"plate.elements": (2 * along, 2 * across), "plate.element": plate.element}
    changes |= {"time.safety_factor": 0.5 * scene.time.safety_factor}
    if corner.constraint == "penalty" and not corner.constraint_is_open:
        changes |= {"corner.penalty_scale": 4.0 * corner.penalty_scale}
    return changes


def _finer_and_damped(scene: Scene, plate: Plate) -> Changes:
    """The same, with damping enough to keep the finer model from fluttering."""
    ratio = (scene.damping.ratio if scene.damping else None) or 0.0
    return {"damping.ratio": max(FLUTTER_DAMPING, ratio), **_finer(scene, plate)}


def _richer(scene: Scene, plate: Plate) -> Changes:
    """Quadratic elements and the exact constraint, on finer elements where they were quadratic already."""
    along, across = plate.counts
    times = 1 if ELEMENT_KINDS[plate.element].richer else 2
    return quadratic_and_exact(plate, (times * along, times * across))


REFINEMENTS = {"finer": _finer, "finer_and_damped": _finer_and_damped, "richer": _richer}
"""Models that a difference must survive, tried until one comes to a result that confirms it."""
