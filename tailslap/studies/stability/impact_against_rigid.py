"""A cell of the map of a whole impact, held against the rigid vehicle; where it differs, against a refined model."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import replace

from fem.discretisation.element_kinds import ELEMENT_KINDS
from tailslap.case.impact.case import ImpactCase
from tailslap.errors import InputError
from tailslap.impact.checks import failed_but_mesh
from tailslap.impact.outcome import ImpactOutcome, differences
from tailslap.impact.run import make_fe_plan_timed, plain_run, run_impact
from tailslap.scene.schema import Plate, Scene
from tailslap.scene.vary import Changes, Source, vary
from tailslap.studies.stability.verdict import (
    CAUGHT,
    RIGHT,
    WRONG,
    Calculation,
    Verdict,
    by_refinement,
    model_name,
)
from tailslap.verification.check import failed_names

JUDGED = ("impulse", "peak_force")
"""What is judged of each of the first two strikes."""

FACTOR = 3.0
"""Multiples of the error that a run claims by which a refined model may differ from it, beside the tolerance."""


def impact_against_rigid(outcome: ImpactOutcome, tolerance: float) -> Verdict:
    """The verdict; tolerance: difference in impulse and peak up to which the cell is right."""
    found = _largest(outcome.difference)
    if not outcome.passed:
        return Verdict(CAUGHT, ", ".join(failed_names(outcome.checks)), difference=found)
    if found <= tolerance and _all_compared(outcome):
        return Verdict(RIGHT, difference=found)
    return _confirmed(outcome, found, tolerance)


def _confirmed(outcome: ImpactOutcome, found: float, tolerance: float) -> Verdict:
    """Flexible if the refined model has the same strikes, else wrong."""
    began, allowed = time.perf_counter(), tolerance + FACTOR * claimed_error(outcome)
    refined = _refined(outcome)
    if refined is None:
        return Verdict(WRONG, reason="no refined model came to a result", difference=found)
    its, moved = _largest(refined.difference), _distance(outcome, refined)
    verdict = by_refinement(model_name(refined), moved, allowed, found, its, began)
    return replace(verdict, reference_model=model_name(refined))


def _refined(outcome: ImpactOutcome) -> ImpactOutcome | None:
    """The first refined model that comes to a result that its own checks believe."""
    plan = outcome.fe_plan.case
    for refine in (_richer, _finer):
        try:
            changed = plan.varied(refine(plan.scene, outcome.fe_plan.plate))
            refined = plain_run(make_fe_plan_timed(changed))
        except InputError:
            continue
        if not failed_but_mesh(refined):
            return refined
    return None


def _finer(scene: Scene, plate: Plate) -> Changes:
    """Twice the elements each way, half the time step."""
    along, across = plate.counts
    half = 0.5 * scene.time.safety_factor
    return {"plate.elements": (2 * along, 2 * across), "time.safety_factor": half}


def _richer(scene: Scene, plate: Plate) -> Changes:
    """As many elements of twice the order, half the time step."""
    richer = ELEMENT_KINDS[plate.element].richer
    if not richer:
        return _finer(scene, plate)
    changes = {"plate.elements": plate.counts, "plate.element": richer}
    return {**changes, "time.safety_factor": 0.5 * scene.time.safety_factor}


def claimed_error(outcome: ImpactOutcome) -> float:
    """Largest error in impulse and peak that the run says its mesh has."""
    return _largest(outcome.mesh_error)


def _distance(outcome: ImpactOutcome, refined: ImpactOutcome) -> float:
    """Largest change of impulse and peak; infinite where other corners strike."""
    corners = [[strike.corner for strike in one.fe.strikes[:2]] for one in (outcome, refined)]
    if corners[0] != corners[1]:
        return math.inf
    return _largest(differences(outcome.fe, refined.fe))


def _all_compared(outcome: ImpactOutcome) -> bool:
    """Whether both models' first two strikes are of the same corners, so that all differences are told."""
    fe, rigid = ([strike.corner for strike in one.strikes[:2]] for one in (outcome.fe, outcome.rigid))
    return fe == rigid


def _largest(differences: Mapping[str, float]) -> float:
    judged = [abs(value) for name, value in differences.items() if name.endswith(JUDGED)]
    return max(judged, default=math.nan)


def _run(base: Source, changes: Changes) -> ImpactOutcome:
    return run_impact(ImpactCase(*vary(base, changes)))


IMPACTS = Calculation(_run, claimed_error)
"""How a cell of whole impacts is run."""
