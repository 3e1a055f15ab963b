"""`summary.json`: the numbers of a run by the names that other programs hold on to."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from postprocess.comparison.quantities import KEYS
from tailslap.report.common import run_cost, run_summary
from tailslap.report.omitted_parts import omitted_parts
from tailslap.scene_run import Outcome
from tailslap.verification.verdict import verdict_sentence

if TYPE_CHECKING:
    from tailslap.tolerance.choose import Choice


def summary(outcome: Outcome, pictures: bool) -> dict[str, Any]:
    """The whole summary, SI; what was not reached is NaN, which is written as null."""
    fe_plan = outcome.fe_plan
    alike = run_summary(outcome, omitted_parts(fe_plan.case.scene, pictures))
    nothing = dict.fromkeys(KEYS, float("nan"))
    answer = fe_plan.case.rigid_numbers()
    return {
        **alike,
        "rigid": outcome.rigid,
        "fe": outcome.fe or nothing,
        "difference": outcome.difference or nothing,
        "verdict": verdict_sentence(outcome),
        "numerical_error": {"total": outcome.error.total, **asdict(outcome.error)},
        "attempts": outcome.attempts,
        "metrics": {name: asdict(metrics) for name, metrics in outcome.metrics.items()},
        "cost": cost(outcome),
        **{stage: answer[stage] for stage in ("stage1", "start", "stage3")},
        "plate": {
            **alike["plate"],
            "deflection_ratio": fe_plan.deflection_ratio,
            "penalty_stiffness": fe_plan.model.loop.corner.spring or None,
        },
        "tolerance": outcome.choice and _picked(outcome.choice),
    }


def _picked(choice: Choice) -> dict[str, Any]:
    """What --tolerance picked, and what was expected of it."""
    return {
        "tolerance": choice.tolerance,
        "against": choice.against,
        "changes": choice.changes,
        "expected_error": choice.expected_error,
        "expected_time_loop_s": choice.expected_seconds,
        "flexibility": choice.flexibility,
    }


def cost(outcome: Outcome) -> dict[str, float | int]:
    """Sizes and times of a run and its pictures."""
    return run_cost(outcome) | {"pictures_s": outcome.pictures_s}
