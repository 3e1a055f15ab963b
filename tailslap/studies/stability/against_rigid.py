"""A cell of the map, held against the rigid motion; where it differs, refined models must differ likewise."""

from __future__ import annotations

import copy
import math
import time
from collections.abc import Mapping

from fem.discretisation.element_kinds import ELEMENT_KINDS
from postprocess.comparison.comparison import largest
from tailslap.errors import InputError
from tailslap.planning.plan import make_plan
from tailslap.run import Outcome, run_scene
from tailslap.scene.files import validate
from tailslap.scene.schema import Plate
from tailslap.studies.stability.axes import Tables
from tailslap.studies.stability.reference import FLUTTER_DAMPING, quadratic_and_exact
from tailslap.studies.stability.verdict import (
    CAUGHT,
    REFUSED,
    RIGHT,
    WRONG,
    Verdict,
    distance,
    failed_checks,
)

FLEXIBLE = "flexible"
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


def against_rigid(tables: Tables, outcome: Outcome, tolerance: float) -> Verdict:
    """The verdict; tolerance: difference from the rigid motion up to which the cell is right."""
    found = largest(outcome.difference)
    if not outcome.passed:
        return Verdict(CAUGHT, ", ".join(failed_checks(outcome)), difference=found)
    if found <= tolerance:
        return Verdict(RIGHT, difference=found)
    return _confirmed(tables, outcome, found, tolerance)


def _confirmed(tables: Tables, outcome: Outcome, found: float, tolerance: float) -> Verdict:
    """Flexible if its own error is small beside the difference and the difference survives refinement, else wrong."""
    own = outcome.error
    # Statics bounds error and flexibility alike: with a bound that is wide, both are.
    if not own.total <= tolerance + SURVIVES * max(found, own.flexibility):
        return Verdict(WRONG, reason=f"its own numerical error is {own.total:.1e}", difference=found)
    verdict = Verdict(WRONG, reason="no refined model came to a result", difference=found)
    for name, refine in REFINEMENTS.items():
        began = time.perf_counter()
        refined = _refined_difference(refine(copy.deepcopy(tables), outcome.fe_plan.plate))
        if refined is None:
            continue
        its, moved = largest(refined), distance(outcome.difference, refined)
        allowed, seconds = tolerance + SURVIVES * its, time.perf_counter() - began
        right = moved <= allowed
        kind, reason = (FLEXIBLE, name) if right else (WRONG, f"{name} changes it by {moved:.1e}")
        verdict = Verdict(kind, "", reason, moved, allowed, found, its, reference_seconds=seconds)
        if right:
            break
    return verdict


def _refined_difference(tables: Tables) -> Mapping[str, float] | None:
    """Differences of a refined model from the rigid motion; None where they say nothing."""
    try:
        refined = run_scene(make_plan(validate(tables)))
    except InputError:
        return None
    usable = math.isfinite(largest(refined.difference)) and set(failed_checks(refined)) <= BESIDE_THE_POINT
    return refined.difference if usable else None


def _finer(tables: Tables, plate: Plate) -> Tables:
    """Twice the elements each way, half the time step, four times the corner's spring; plate: as the run had it."""
    along, across = plate.counts
    tables["plate"] |= {"elements": (2 * along, 2 * across), "element": plate.element}
    time, corner = tables.setdefault("time", {}), tables.setdefault("corner", {})
    time["safety_factor"] = 0.5 * time.get("safety_factor", 0.9)
    if corner.keys() & {"penalty_scale", "damping_ratio"} or corner.get("constraint") == "penalty":
        corner["penalty_scale"] = 4.0 * corner.get("penalty_scale", 1.0)
    return tables


def _finer_and_damped(tables: Tables, plate: Plate) -> Tables:
    """The same, with damping enough to keep the finer model from fluttering."""
    damping = tables.setdefault("damping", {})
    damping["ratio"] = max(FLUTTER_DAMPING, damping.get("ratio", 0.0))
    return _finer(tables, plate)


def _richer(tables: Tables, plate: Plate) -> Tables:
    """Quadratic elements and the exact constraint, on finer elements where they were quadratic already."""
    along, across = plate.counts
    times = 1 if ELEMENT_KINDS[plate.element].richer else 2
    return quadratic_and_exact(tables, plate, (times * along, times * across))


REFINEMENTS = {"finer": _finer, "finer_and_damped": _finer_and_damped, "richer": _richer}
"""Models that a difference must survive, tried until one comes to a result that confirms it."""
