"""One run of a whole impact as a row of a sweep's table: names of columns and plain values, SI."""

from __future__ import annotations

from typing import Any

from solver.impact import Strike
from tailslap.case.checks import check_columns
from tailslap.case.impact.rigid import RigidImpact
from tailslap.case.report import run_cost
from tailslap.impact.answers import END, ImpactAnswer, strike_numbers
from tailslap.impact.outcome import COMPARED, ImpactOutcome
from tailslap.impact.rigid_text import CURVES, rigid_impact
from tailslap.scene.schema import Scene

STRIKES = (1, 2)
VALUES = ("start", "duration", "peak_force", "mean_50ms", "impulse")
SPENT = {"cost.steps": int, "cost.time_step": float}


def impact_column_kinds(scene: Scene) -> dict[str, type]:
    """Columns that the table of a sweep has whatever its rows, checks beside, and the type of their values."""
    models = ("rigid",) if scene.plate is None else ("rigid", "fe")
    kinds: dict[str, type] = {}
    for model in models:
        kinds[f"{model}.strikes"] = int
        for k in STRIKES:
            kinds[f"{model}.strike_{k}.corner"] = str
            kinds |= {f"{model}.strike_{k}.{name}": float for name in VALUES}
        kinds |= {f"{model}.peak.{name}": float for name in CURVES}
        kinds |= {f"{model}.end.{name}": float for name in END}
    if scene.plate is None:
        return kinds
    names = [f"difference.strike_{k}.{name}" for k in STRIKES for name in COMPARED]
    return {**kinds, **dict.fromkeys([*names, "numerical_error"], float), **SPENT}


def answer_columns(model: str, answer: ImpactAnswer) -> dict[str, Any]:
    """Columns of one of the two models, of its first two strikes; what it lacks is missing."""
    row: dict[str, Any] = {f"{model}.strikes": len(answer.strikes)}
    for k, strike in zip(STRIKES, answer.strikes, strict=False):
        row[f"{model}.strike_{k}.corner"] = strike.corner
        values = {"mean_50ms": _mean_peak(answer, strike), **strike_numbers(strike)}
        row |= {f"{model}.strike_{k}.{name}": float(values[name]) for name in VALUES}
    row |= {f"{model}.peak.{name}": float(value) for name, value in answer.peaks.items()}
    return row | {f"{model}.end.{name}": value for name, value in answer.end.items()}


def _mean_peak(answer: ImpactAnswer, strike: Strike) -> float:
    """Largest 50 ms mean of the lateral force [N] about an instant of the strike."""
    t, mean = answer.history["t"][1:], answer.lateral["mean_50ms"]
    during = (t >= strike.start) & (t - answer.interval <= strike.end)
    return float(mean[during].max())


def impact_row(plan: RigidImpact, outcome: ImpactOutcome | None) -> dict[str, Any]:
    """The run of a scene with [plate], both models; of one without, the rigid vehicle alone."""
    if outcome is None:
        return {"status": "passed", "reason": "", **answer_columns("rigid", rigid_impact(plan))}
    return {
        **check_columns(outcome.checks),
        **answer_columns("rigid", outcome.rigid),
        **answer_columns("fe", outcome.fe),
        **{f"difference.{name}": value for name, value in outcome.difference.items()},
        "numerical_error": max(map(abs, outcome.mesh_error.values()), default=float("nan")),
        **{f"cost.{name}": value for name, value in run_cost(outcome).items()},
    }
