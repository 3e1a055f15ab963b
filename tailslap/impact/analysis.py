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
    from postprocess.report.report import Report


def _check_lines(plan: ImpactPlan) -> list[str]:
    from tailslap.impact.check_text import fe_part, rigid_part

    if plan.scene.plate is None:
        return rigid_part(plan)
    from tailslap.impact.fe_plan import make_impact_fe_plan

    return rigid_part(plan) + fe_part(make_impact_fe_plan(plan))


def _run_report(plan: ImpactPlan, folder: Path, tolerance: float | None, pictures: bool) -> Report:
    from tailslap.impact.report import impact_report
    from tailslap.impact.run import run_impact
    from tailslap.impact.tolerance import run_impact_to_tolerance

    outcome = run_impact(plan) if tolerance is None else run_impact_to_tolerance(plan, tolerance)
    return impact_report(outcome, folder, pictures)


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
    check_lines=_check_lines,
    run_report=_run_report,
    duration=lambda plan: plan.motion.t_end,
    columns=_columns,
    column_kinds=_column_kinds,
    compared=STRIKES,
)
