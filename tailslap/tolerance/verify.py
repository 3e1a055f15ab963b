"""Checks after the run that the tolerance was met: the expected error is not taken on trust."""

from __future__ import annotations

import math
from dataclasses import replace

from postprocess.comparison.quantities import largest, largest_relative
from tailslap.case.corner.rigid import RigidStages
from tailslap.errors import InputError
from tailslap.scene_run import Outcome, run_scene
from tailslap.tolerance.candidates import candidate, with_modal_quantities
from tailslap.tolerance.choose import RIGID, Choice
from tailslap.tolerance.refinement_levels import RefinementLevel
from tailslap.verification.check import Check

TINY = 1e-15
"""In place of a distance of zero."""

COARSER_SHARE, FINER_SHARE = 1.0 / 3.0, 1.0
"""Least error over the change between two meshes, where the other mesh is half, and twice, as fine: order two."""


def verified(outcome: Outcome, choice: Choice, plan: RigidStages) -> Outcome:
    """The outcome with the check "tolerance"; plan: of the scene as the user gave it."""
    if choice.against == RIGID:
        value, how = largest(outcome.difference), "difference from the exact rigid motion"
    else:
        value, how = _from_limit(outcome, choice, plan)
    check = Check.at_most("tolerance", value, choice.tolerance, f"largest of five: {how}")
    return replace(outcome, checks=(*outcome.checks, check), choice=choice)


def _from_limit(outcome: Outcome, choice: Choice, plan: RigidStages) -> tuple[float, str]:
    """Estimated distance from the limit of fine meshes, by a second run on another mesh."""
    if not outcome.fe:
        return math.nan, "there is no result to judge"
    for level, share in ((choice.level.scaled(0.5), COARSER_SHARE), (choice.level.scaled(2.0), FINER_SHARE)):
        other = _run(plan, level) if level else None
        if other is None or not other.fe:
            continue
        moved = largest_relative(other.fe, outcome.fe)
        along, across = other.fe_plan.plate.counts
        how = f"distance from the limit of fine meshes, estimated from a second run with {along} x {across} elements"
        return max(share, _left_over_moved(outcome, other, choice, plan)) * moved, how
    return math.nan, "no second mesh made a model to judge by"


def _left_over_moved(outcome: Outcome, other: Outcome, choice: Choice, plan: RigidStages) -> float:
    """Distance from the limit over that between the two meshes: of modal results, else of deflection ratios."""
    levels = (choice.level, replace(choice.level, elements=other.fe_plan.plate.counts))
    made = [candidate(plan, level) for level in levels]
    mine, its = (each and with_modal_quantities(each) for each in made)
    if mine and its and choice.limit and mine.quantities and its.quantities:
        left, moved = (largest_relative(mine.quantities, x) for x in (choice.limit, its.quantities))
        return left / max(moved, TINY)
    ratios = outcome.fe_plan.deflection_ratio, other.fe_plan.deflection_ratio
    return abs(ratios[0] - choice.limit_deflection_ratio) / max(abs(ratios[0] - ratios[1]), TINY)


def _run(plan: RigidStages, level: RefinementLevel) -> Outcome | None:
    changed = plan.varied(level.changes)
    try:
        return run_scene(changed)
    except InputError:
        return None
