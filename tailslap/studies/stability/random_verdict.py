"""The verdict on a random cell: its answer against that of a refined model of the same plate."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

from postprocess.comparison.comparison import largest
from tailslap.errors import InputError
from tailslap.planning.plan import make_plan
from tailslap.run import Outcome, run_scene
from tailslap.scene.files import validate
from tailslap.studies.stability.axes import Tables
from tailslap.studies.stability.reference import Reference, find_reference
from tailslap.verification.checks import reaction_checks

RIGHT, REACTION_ONLY, GOOD, CAUGHT, REFUSED, UNJUDGED, WRONG = KINDS = (
    *("right", "reaction only", "good but failed", "caught", "refused", "unjudged", "wrong"),
)

WRONG_FROM = (1e-3, 0.25)
"""Distance from the reference above which an answer is wrong: a part of its own, and a share of the reference's
difference from the rigid motion."""

GOOD_TO = (5e-4, 0.1)
"""The same for an answer that is good beyond doubt."""


@dataclass(frozen=True)
class RandomVerdict:
    """How a cell ended. distance: of its five quantities from the reference's, the largest; allowed: what makes it
    wrong; difference, reference: its own and the reference's, largest from the rigid motion; error: its own estimate.
    """

    kind: str
    failed: str = ""
    distance: float = math.nan
    allowed: float = math.nan
    difference: float = math.nan
    reference: float = math.nan
    error: float = math.nan
    model: str = ""
    reference_model: str = ""
    steps: int = 0
    seconds: float = 0.0
    reference_seconds: float = 0.0


def judge_draw(tables: Tables) -> dict[str, Any]:
    """Run the cell that the tables describe, and its reference."""
    began = time.perf_counter()
    try:
        outcome = run_scene(make_plan(validate(tables)))
    except InputError as error:
        return asdict(RandomVerdict(REFUSED, str(error)))
    except Exception as error:  # whatever it is, a program that breaks has not refused
        return asdict(RandomVerdict(WRONG, f"broke: {type(error).__name__}: {error}"))
    seconds = time.perf_counter() - began
    return asdict(replace(_against_reference(tables, outcome), seconds=seconds))


def _against_reference(tables: Tables, outcome: Outcome) -> RandomVerdict:
    failed = tuple(check.name for check in outcome.checks if not check.passed)
    plate = outcome.fe_plan.plate
    try:
        reference = find_reference(tables, plate) if outcome.fe else None
    except Exception as error:  # the reference breaks, and with it the program
        return RandomVerdict(WRONG, f"reference broke: {type(error).__name__}: {error}")
    verdict = grade(outcome.difference, failed, reference)
    model = f"{plate.element} {plate.counts[0]} x {plate.counts[1]}"
    return replace(verdict, error=outcome.error.total, model=model, steps=outcome.run.steps)


def grade(
    difference: Mapping[str, float], failed: tuple[str, ...], reference: Reference | None
) -> RandomVerdict:
    """The verdict on an answer, given as differences from the rigid motion; empty where there was no strike."""
    names, found = ", ".join(failed), largest(difference)
    if not math.isfinite(found):
        return RandomVerdict(CAUGHT if failed else WRONG, names)
    if reference is None:
        return RandomVerdict(UNJUDGED, names, difference=found)
    its = largest(reference.difference)
    distance = max(abs(value - reference.difference[name]) for name, value in difference.items())
    verdict = RandomVerdict(
        _kind(distance, its, failed), names, distance, _limit(WRONG_FROM, its), found, its
    )
    return replace(verdict, reference_model=reference.model, reference_seconds=reference.seconds)


def _kind(distance: float, reference: float, failed: tuple[str, ...]) -> str:
    if not failed:
        return RIGHT if distance <= _limit(WRONG_FROM, reference) else WRONG
    if distance > _limit(GOOD_TO, reference):
        return CAUGHT
    return GOOD if set(failed) - reaction_checks() else REACTION_ONLY


def _limit(parts: tuple[float, float], reference: float) -> float:
    return parts[0] + parts[1] * reference
