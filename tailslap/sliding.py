"""The paper's calculation, the corner sliding along the wall, as the commands take it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from postprocess.comparison.comparison import TAIL_SLAP
from tailslap.analysis import CORNER, Analysis
from tailslap.planning.plan import Plan, make_plan
from tailslap.planning.rigid import rigid_answer, rigid_lines
from tailslap.scene.schema import Scene

if TYPE_CHECKING:
    import numpy as np

    from postprocess.report.report import Report
    from tailslap.scene_run import Outcome


def _rigid_history(plan: Plan, rows: int) -> dict[str, np.ndarray]:
    import numpy as np

    from fem.explicit.columns import COLUMNS

    state = plan.motion.at(np.linspace(0.0, plan.motion.strike.t, rows))
    names = [name for name in ("t", *COLUMNS) if hasattr(state, name)]
    return {name: getattr(state, name) for name in names}


def _check_lines(plan: Plan) -> list[str]:
    from tailslap.report.check_text import chosen_lines, fe_part, rigid_part

    if plan.scene.plate is None:
        return rigid_part(plan)
    from tailslap.planning.fe_plan import make_fe_plan

    fe_plan = make_fe_plan(plan)
    return rigid_part(fe_plan.plan) + fe_part(fe_plan) + chosen_lines(fe_plan)


def _run(plan: Plan, tolerance: float | None) -> Outcome:
    if tolerance is None:
        from tailslap.scene_run import run_scene

        return run_scene(plan)
    from tailslap.tolerance import run_to_tolerance

    return run_to_tolerance(plan, tolerance)


def _report(outcome: Outcome, folder: Path, pictures: bool) -> Report:
    from tailslap.report.run_report import run_report

    if outcome.run.snapshots is not None:
        from tailslap.report.fields import keep_fields

        keep_fields(outcome.fe_plan.model, outcome.run.snapshots, folder)
    if pictures:
        from tailslap.report.pictures import draw_pictures

        outcome = draw_pictures(outcome, folder)
    return run_report(outcome, pictures)


def _summary(outcome: Outcome, pictures: bool) -> dict[str, Any]:
    from tailslap.report.summary import summary

    return summary(outcome, pictures)


def _histories(outcome: Outcome) -> dict[str, dict[str, np.ndarray]]:
    return {"history.csv": outcome.fe_history, "rigid.csv": outcome.rigid_history}


def _columns(plan: Plan) -> dict[str, Any]:
    from tailslap.scene_run import run_scene
    from tailslap.sweeps.corner_columns import outcome_columns

    return outcome_columns(run_scene(plan))


def _column_kinds(scene: Scene) -> dict[str, type]:
    from tailslap.planning.fe_plan import needed_plate
    from tailslap.sweeps.corner_columns import corner_column_kinds

    needed_plate(scene)
    return corner_column_kinds(scene)


SLIDING = Analysis(
    name=CORNER,
    make_plan=make_plan,
    rigid_numbers=rigid_answer,
    rigid_lines=rigid_lines,
    rigid_history=_rigid_history,
    check_lines=_check_lines,
    run=_run,
    report=_report,
    summary=_summary,
    histories=_histories,
    duration=lambda plan: plan.motion.strike.t,
    columns=_columns,
    column_kinds=_column_kinds,
    compared=TAIL_SLAP,
)
