"""The whole impact, as the commands take it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from postprocess.comparison.comparison import STRIKES
from tailslap.analysis import WHOLE_IMPACT, Analysis
from tailslap.impact.plan import ImpactPlan, make_impact_plan
from tailslap.impact.rigid_text import rigid_lines, rigid_numbers
from tailslap.scene.schema import Scene

if TYPE_CHECKING:
    import numpy as np

    from postprocess.report.report import Report
    from tailslap.impact.outcome import ImpactOutcome


def _rigid_history(plan: ImpactPlan, rows: int) -> dict[str, np.ndarray]:
    from tailslap.impact.rigid_text import rigid_impact

    return dict(rigid_impact(plan).history)


def _check_lines(plan: ImpactPlan) -> list[str]:
    from tailslap.impact.check_text import fe_part, rigid_part

    if plan.scene.plate is None:
        return rigid_part(plan)
    from tailslap.impact.fe_plan import make_impact_fe_plan

    return rigid_part(plan) + fe_part(make_impact_fe_plan(plan))


def _run(plan: ImpactPlan, tolerance: float | None) -> ImpactOutcome:
    if tolerance is None:
        from tailslap.impact.run import run_impact

        return run_impact(plan)
    from tailslap.tolerance.impacts import run_impact_to_tolerance

    return run_impact_to_tolerance(plan, tolerance)


def _report(outcome: ImpactOutcome, folder: Path, pictures: bool) -> Report:
    from tailslap.impact.report import impact_report

    if outcome.run.snapshots is not None:
        from tailslap.report.fields import keep_fields

        keep_fields(outcome.fe_plan.model, outcome.run.snapshots, folder)
    return impact_report(outcome, folder, pictures)


def _summary(outcome: ImpactOutcome, pictures: bool) -> dict[str, Any]:
    from tailslap.impact.summary import impact_summary

    return impact_summary(outcome, pictures)


def _histories(outcome: ImpactOutcome) -> dict[str, dict[str, np.ndarray]]:
    from tailslap.impact.summary import impact_histories

    return impact_histories(outcome)


def _columns(plan: ImpactPlan) -> dict[str, Any]:
    from tailslap.impact.columns import impact_columns

    return impact_columns(plan)


def _column_kinds(scene: Scene) -> dict[str, type]:
    from tailslap.impact.columns import impact_column_kinds

    return impact_column_kinds(scene)


IMPACT = Analysis(
    name=WHOLE_IMPACT,
    make_plan=make_impact_plan,
    rigid_numbers=rigid_numbers,
    rigid_lines=rigid_lines,
    rigid_history=_rigid_history,
    check_lines=_check_lines,
    run=_run,
    report=_report,
    summary=_summary,
    histories=_histories,
    duration=lambda plan: plan.motion.t_end,
    columns=_columns,
    column_kinds=_column_kinds,
    compared=STRIKES,
)
