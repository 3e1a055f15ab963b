"""One run of a whole impact as a row of a sweep's table: names of columns and plain values, SI."""

from __future__ import annotations

from typing import Any

from tailslap.impact.answers import ImpactAnswer
from tailslap.impact.plan import ImpactPlan
from tailslap.impact.rigid_text import rigid_impact

STRIKES = (1, 2)
VALUES = ("start", "duration", "peak_force", "impulse")


def answer_columns(model: str, answer: ImpactAnswer) -> dict[str, Any]:
    """Columns of one of the two models, of its first two strikes; what it lacks is missing."""
    row: dict[str, Any] = {f"{model}.strikes": len(answer.strikes)}
    for k, strike in zip(STRIKES, answer.strikes, strict=False):
        row[f"{model}.strike_{k}.corner"] = strike.corner
        row |= {f"{model}.strike_{k}.{name}": float(getattr(strike, name)) for name in VALUES}
    row |= {f"{model}.peak.{name}": float(value) for name, value in answer.peaks.items()}
    return row | {f"{model}.end.{name}": value for name, value in answer.end.items()}


def impact_columns(plan: ImpactPlan) -> dict[str, Any]:
    """The run of a scene with [plate], both models; of one without, the rigid vehicle alone."""
    if plan.scene.plate is None:
        return {"status": "passed", "reason": "", **answer_columns("rigid", rigid_impact(plan))}
    from tailslap.impact.run import run_impact

    outcome = run_impact(plan)
    failed = [check.name for check in outcome.checks if not check.passed]
    return {
        "status": "failed" if failed else "passed",
        "reason": ", ".join(failed),
        **answer_columns("rigid", outcome.rigid),
        **answer_columns("fe", outcome.fe),
        **{f"difference.{name}": value for name, value in outcome.difference.items()},
        "numerical_error": max(map(abs, outcome.mesh_error.values()), default=float("nan")),
        **{"check." + check.name.replace(" ", "_"): float(check.value) for check in outcome.checks},
        "cost.steps": outcome.run.steps,
        "cost.time_step": outcome.fe_plan.model.loop.time_step,
        "cost.setup_s": outcome.setup_s,
        "cost.time_loop_s": outcome.run.time_loop_s,
    }
