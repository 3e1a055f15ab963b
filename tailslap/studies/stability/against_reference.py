"""A random cell, compared with a refined model of the same plate."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from postprocess.comparison.comparison import largest
from tailslap.scene_run import Outcome
from tailslap.studies.stability.reference import Reference, find_reference, second_opinion
from tailslap.studies.stability.verdict import CAUGHT, REFUSED, RIGHT, WRONG, Verdict, distance
from tailslap.verification.check import failed_names
from tailslap.verification.checks import reaction_checks
from tailslap.verification.numerical_error import FLOOR, SHARE, distance_in_motion

REACTION_ONLY, GOOD, UNJUDGED = "reaction only", "good but failed", "unjudged"
KINDS = {
    RIGHT: "every check passed, and the five quantities are those of a refined model of the same plate",
    REACTION_ONLY: "right, but the reaction rings, and checks of its history alone say so",
    GOOD: "other checks failed although the five quantities, and the motion before, are right beyond doubt",
    CAUGHT: "a check failed, and the five quantities are off or in doubt",
    REFUSED: "wrong input: a message, and no run",
    UNJUDGED: "no refined model came to a result that can be trusted",
    WRONG: "every check passed, and the five quantities are off",
}
"""Kinds of verdicts and what they mean."""

WRONG_FROM = (1e-3, 0.25)
"""Distance from the reference above which a result is wrong: a part of its own, and a share of the reference's
difference from the rigid motion."""

SAFETY = 3.0
"""Factor of safety on an error that two meshes tell (Roache 1994, ASME V&V 20)."""

GOOD_TO = (FLOOR / SAFETY, SHARE / SAFETY)
"""The same for a result that is good beyond doubt: with this factor its error would still be allowed."""


def against_reference(outcome: Outcome) -> Verdict:
    """The verdict; without a strike there is nothing to compare. Two references say what is good beyond doubt."""
    reference = find_reference(outcome.fe_plan.asked.source, outcome.fe_plan.plate) if outcome.fe else None
    ours = outcome.fe_history, outcome.rigid_history
    oscillates = not outcome.fe_plan.plate.relieved
    apart = (
        distance_in_motion(ours, reference.histories, outcome.rigid, oscillates) if reference else math.nan
    )
    verdict = grade(outcome.difference, failed_names(outcome.checks), reference, apart)
    if reference and verdict.kind == GOOD and not _confirmed(outcome, reference):
        return replace(verdict, kind=CAUGHT)
    return verdict


def _confirmed(outcome: Outcome, reference: Reference) -> bool:
    """Whether another refined model comes to the reference's result."""
    other = second_opinion(outcome.fe_plan.asked.source, outcome.fe_plan.plate, reference)
    if other is None:
        return False
    oscillates = not outcome.fe_plan.plate.relieved
    apart = distance_in_motion(other.histories, reference.histories, outcome.rigid, oscillates)
    off = max(apart, distance(other.difference, reference.difference))
    return off <= _limit(GOOD_TO, largest(reference.difference))


def grade(
    difference: Mapping[str, float], failed: tuple[str, ...], reference: Reference | None, apart: float
) -> Verdict:
    """The verdict on a result, given as differences from the rigid motion; empty where there was no strike.

    apart: on the way; oscillations that agree at the strike alone are right by chance.
    """
    names, found = ", ".join(failed), largest(difference)
    if not math.isfinite(found):
        return Verdict(CAUGHT if failed else WRONG, names)
    if reference is None:
        return Verdict(UNJUDGED, names, difference=found)
    its, moved = largest(reference.difference), distance(difference, reference.difference)
    return Verdict(
        _kind(moved, apart, its, failed),
        names,
        distance=moved,
        allowed=_limit(WRONG_FROM, its),
        difference=found,
        reference=its,
        reference_model=reference.model,
        reference_seconds=reference.seconds,
    )


def _kind(distance: float, apart: float, reference: float, failed: tuple[str, ...]) -> str:
    if not failed:
        return RIGHT if distance <= _limit(WRONG_FROM, reference) else WRONG
    if max(distance, apart) > _limit(GOOD_TO, reference):
        return CAUGHT
    return GOOD if set(failed) - reaction_checks() else REACTION_ONLY


def _limit(parts: tuple[float, float], reference: float) -> float:
    return parts[0] + parts[1] * reference
