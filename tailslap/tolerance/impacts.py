"""`tailslap run SCENE --tolerance X` on a whole impact: finer meshes until the mesh's error meets it."""

from __future__ import annotations

from dataclasses import replace

from tailslap.case.impact.rigid import RigidImpact
from tailslap.errors import InputError
from tailslap.impact.outcome import ImpactOutcome
from tailslap.impact.run import run_impact
from tailslap.verification.check import Check

MOST_ELEMENTS = 20_000
"""Of the finest mesh that is tried."""


def run_impact_to_tolerance(plan: RigidImpact, tolerance: float) -> ImpactOutcome:
    """Run with meshes twice as fine each time until richer elements change impulse, peak and duration of the first two
    strikes by less than the tolerance; the last outcome has a check that says whether they do. Raises InputError."""
    if not 1e-6 <= tolerance < 1.0:
        raise InputError("--tolerance", tolerance, "allowed is 1e-6 to below 1 for a whole impact")
    while True:
        outcome = run_impact(plan)
        error = max(map(abs, outcome.mesh_error.values()), default=float("nan"))
        along, across = outcome.fe_plan.plate.counts
        finest = 4 * along * across > MOST_ELEMENTS
        if error <= tolerance or not outcome.mesh_error or finest:
            break
        plan = plan.varied({"plate.elements": (2 * along, 2 * across)})
    meaning = f"mesh error on {along} x {across} elements; the tolerance that was asked for"
    return replace(outcome, checks=(*outcome.checks, Check.at_most("tolerance", error, tolerance, meaning)))
