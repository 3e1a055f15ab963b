"""A run in a sentence: whether its numbers hold, how far the plate is from a rigid body, and how sure that is."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from postprocess.comparison.quantities import largest
from tailslap.planning.decide_damping import damping_is_open, suppressing_rate
from tailslap.verification.check import failed_names
from tailslap.verification.checks import reaction_checks
from tailslap.verification.numerical_error import FLOOR

if TYPE_CHECKING:
    from tailslap.planning.fe_plan import FePlan
    from tailslap.scene_run import Outcome


def verdict_sentence(outcome: Outcome) -> str:
    """The verdict on a run."""
    of_the_reaction = reaction_checks()
    failed = set(failed_names(outcome.checks))
    if not outcome.fe:
        return "The run did not reach the tail-slap."
    if failed - of_the_reaction - {"agreement with rigid"}:
        return "Not to be relied on: a check of the run failed."
    text = _comparison(outcome)
    if failed & of_the_reaction:
        text += " The motion is right, but the history of the reaction is not: it rings."
    if "agreement with rigid" in failed:
        text += " It does not agree with the rigid motion as closely as the scene demands."
    return text


def _comparison(outcome: Outcome) -> str:
    difference, error = largest(outcome.difference), outcome.error.total
    if difference <= FLOOR:
        return f"The rigid motion is confirmed to {difference:.1e}; numerical error at most {error:.1e}."
    return (
        f"The flexible plate differs from the rigid motion by {100.0 * difference:.2g} %, "
        f"numerical error at most {error:.1e}."
    )


def flutter_sentence(fe_plan: FePlan) -> str:
    """What is predicted of a plate that rings, by friction or by rounding, and what is done against it."""
    growth, damping = fe_plan.growth, fe_plan.case.scene.damping
    judged = ", judged on coarser meshes" if growth.stand_in else ""
    needed = suppressing_rate(growth)
    if math.isnan(growth.rate):
        return "not analysed: no coarser mesh makes a model; the run's own checks watch for it"
    if not needed > 0.0 and not growth.counts:
        return "none: without friction nothing grows"
    if not needed > 0.0:
        return f"harmless: no mode grows by more than exp({growth.harmless:g}) during the run{judged}"
    text = f"the fastest mode grows by up to exp({growth.exponent:.0f}) during the run{judged}"
    if not growth.rate > 0.0:
        text = f"rounding makes the reaction ring by {100.0 * growth.ripple:.2g} %"
    if damping is not None and (damping.rate or 0.0) >= 0.5 * needed:
        return f"suppressed by damping.rate = {damping.rate:.3g} 1/s; without it {text}"
    if damping_is_open(fe_plan.asked.scene):
        return f"possible: {text}; the checks watch for it, and a run that rings is made again with damping"
    return (
        f'EXPECTED, the run will fail its checks: {text}; damping.kind = "elastic-velocity" with '
        f"damping.rate = {needed:.3g} suppresses it, and so does leaving out damping.kind"
    )
