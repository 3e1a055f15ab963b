"""A random cell, compared with a refined model of the same plate."""

from __future__ import annotations

import math
from collections.abc import Mapping

from postprocess.comparison.comparison import largest
from tailslap.scene_run import Outcome
from tailslap.studies.stability.reference import Reference, find_reference
from tailslap.studies.stability.verdict import CAUGHT, REFUSED, RIGHT, WRONG, Verdict, distance
from tailslap.verification.check import failed_names
from tailslap.verification.checks import reaction_checks
from tailslap.verification.numerical_error import late_distance

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

GOOD_TO = (5e-4, 0.1)
"""The same for a result that is good beyond doubt."""


def against_reference(outcome: Outcome) -> Verdict:
    """The verdict; without a strike there is nothing to compare."""
    reference = find_reference(outcome.fe_plan.asked.source, outcome.fe_plan.plate) if outcome.fe else None
    ours = outcome.fe_history, outcome.rigid_history
    apart = late_distance(ours, reference.histories, outcome.rigid) if reference else math.nan
    return grade(outcome.difference, failed_names(outcome.checks), reference, apart)


def grade(
    difference: Mapping[str, float], failed: tuple[str, ...], reference: Reference | None, apart: float
) -> Verdict:
    """The verdict on a result, given as differences from the rigid motion; empty where there was no strike.

    apart: over the last tenth of the motion; oscillations that agree at the strike alone are right by chance.
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
