"""`summary.json`: the numbers of a run by the names that other programs hold on to."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import tailslap
from tailslap.planning.rigid import COMPARED, rigid_answer
from tailslap.report.omitted_parts import omitted_parts
from tailslap.scene_run import Outcome
from tailslap.verification.verdict import verdict_sentence

if TYPE_CHECKING:
    from tailslap.tolerance.choose import Choice


def summary(outcome: Outcome, pictures: bool) -> dict[str, Any]:
    """The whole summary, SI; what was not reached is NaN, which is written as null."""
    plan = outcome.fe_plan.plan
    nothing = dict.fromkeys(COMPARED, float("nan"))
    answer = rigid_answer(plan)
    return {
        "scene": plan.scene.name,
        "version": tailslap.__version__,
        "passed": outcome.passed,
        "rigid": outcome.rigid,
        "fe": outcome.fe or nothing,
        "difference": outcome.difference or nothing,
        "verdict": verdict_sentence(outcome),
        "numerical_error": {"total": outcome.error.total, **asdict(outcome.error)},
        "chosen": [asdict(decision) for decision in outcome.fe_plan.decisions],
        "attempts": outcome.attempts,
        "checks": [asdict(check) for check in outcome.checks],
        "metrics": {name: asdict(metrics) for name, metrics in outcome.metrics.items()},
        "cost": cost(outcome),
        "left_out": [{"part": part, "why": why} for part, why in omitted_parts(plan.scene, pictures)],
        "stage1": answer["stage1"],
        "start": answer["start"],
        "stage3": answer["stage3"],
        "plate": {
            "mass": outcome.fe_plan.model.mass,
            "youngs_modulus": outcome.fe_plan.plate.youngs_modulus,
            "first_frequency": outcome.fe_plan.first_frequency,
            "deflection_ratio": outcome.fe_plan.deflection_ratio,
            "highest_frequency": outcome.fe_plan.model.highest_frequency,
            "stable_time_step": outcome.fe_plan.model.stable_time_step,
            "penalty_stiffness": outcome.fe_plan.model.loop.corner.spring or None,
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
    """Sizes and times of a run."""
    loop = outcome.fe_plan.model.loop
    return {
        "elements": int(loop.table.connectivity.shape[1]),
        "nodes": int(loop.mass.size),
        "steps": outcome.run.steps,
        "time_step": loop.time_step,
        "setup_s": outcome.setup_s,
        "time_loop_s": outcome.run.time_loop_s,
        "pictures_s": outcome.pictures_s,
    }
