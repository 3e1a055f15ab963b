"""Writes a run's result folder: summary, histories, pictures, report."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

import tailslap
from postprocess.comparison.comparison import PAPER_TABLE_3, ComparisonRow, comparison_rows
from postprocess.contours.contours import ContourField, draw_contours
from postprocess.figures.curves import draw_histories
from postprocess.files.histories import write_history
from postprocess.files.summary import write_summary
from postprocess.pages.report import LeftOut, Picture, ReportContent, Result, write_report
from tailslap.planning.rigid import rigid_answer
from tailslap.progress import announced
from tailslap.report.omitted_parts import left_out
from tailslap.report.report_text import is_paper_case, statements
from tailslap.report.summary import cost, summary
from tailslap.run import Outcome
from tailslap.scene.inputs import resolved_inputs
from tailslap.verification.verdict import verdict_sentence

CAPTIONS = {
    "contour_v_gx": "Velocity along the wall at the tail-slap (the paper's Figure 15).",
    "contour_v_gy": "Velocity across the wall at the tail-slap (the paper's Figure 16).",
    "contour_omega": "Angular velocity, half the curl of the velocity, at the tail-slap (the paper's Figure 17).",
}
UNITS = {"omega": "rad/s", "corner_speed": "m/s", "impulse": "N s", "duration": "s", "peak_force": "N"}
COST_UNITS = {"time_step": "s", "setup_s": "s", "time_loop_s": "s", "pictures_s": "s"}


def write_results(outcome: Outcome, folder: Path, pictures: bool) -> Outcome:
    """Fill the folder; returns the outcome with its pictures."""
    if pictures and outcome.run.strike:
        with announced("Drawing the pictures ..."):
            outcome = _draw(outcome, folder)
    write_history(folder / "history.csv", outcome.fe_history)
    write_history(folder / "rigid.csv", outcome.rigid_history)
    write_report(folder / "report.html", _content(outcome, pictures))
    write_summary(folder / "summary.json", summary(outcome, pictures))
    return outcome


def table_rows(outcome: Outcome) -> tuple[ComparisonRow, ...]:
    """Rows of the comparison, beside the paper's Table 3 where the scene is the paper's."""
    if not outcome.fe:
        return ()
    paper = PAPER_TABLE_3 if is_paper_case(outcome.fe_plan.plan) else None
    return comparison_rows(outcome.fe, outcome.rigid, paper)


def _draw(outcome: Outcome, folder: Path) -> Outcome:
    from fem.discretisation.fields import nodal_spin

    began, fe_plan, strike = time.perf_counter(), outcome.fe_plan, outcome.run.strike
    assert strike is not None
    discretisation, masses, wall = fe_plan.model.discretisation, fe_plan.model.loop.mass, fe_plan.wall
    spin = nodal_spin(discretisation.scalar, strike.positions, strike.velocities)
    drawn = (
        discretisation.cells.max() + 1
    )  # corner nodes; those on the sides of quadratic elements come after
    fields = [
        ContourField("v_gx", "Velocity v_X", "m/s", strike.velocities[0, :drawn]),
        ContourField("v_gy", "Velocity v_Y", "m/s", strike.velocities[1, :drawn]),
        ContourField("omega", "Angular velocity", "rad/s", spin),
    ]
    pictures = draw_contours(
        strike.positions.T[:drawn],
        discretisation.cells,
        fields,
        folder,
        wall_points=None if wall is None else wall.points[:, :2],
        wall_quads=None if wall is None else wall.cells_dict["quad"],
        corner=strike.positions[:, discretisation.corner].tolist(),
        centroid=(strike.positions @ masses / masses.sum()).tolist(),
        scene=fe_plan.plan.scene.name,
        time=strike.values["t"],
    )
    return replace(outcome, pictures=tuple(pictures), pictures_s=time.perf_counter() - began)


def _content(outcome: Outcome, pictures: bool) -> ReportContent:
    plan = outcome.fe_plan.plan
    answer = rigid_answer(plan)
    return ReportContent(
        scene=plan.scene.name,
        version=tailslap.__version__,
        passed=outcome.passed,
        headline=verdict_sentence(outcome),
        comparison=table_rows(outcome),
        statements=statements(outcome),
        checks=outcome.checks,
        metrics=outcome.metrics,
        stage1=_results(answer["stage1"] or {}),
        stage3=_results(answer["stage3"]),
        curves=draw_histories(outcome.fe_history, outcome.rigid_history),
        pictures=tuple(Picture(path, CAPTIONS[path.stem]) for path in outcome.pictures),
        cost=tuple(Result(name, value, COST_UNITS.get(name, "")) for name, value in cost(outcome).items()),
        left_out=tuple(LeftOut(part, why) for part, why in left_out(plan.scene, pictures)),
        inputs=resolved_inputs(plan.scene, plan.source, outcome.fe_plan.plate, _chosen(outcome)),
        scene_text=plan.source.text,
    )


def _chosen(outcome: Outcome) -> frozenset[str]:
    return frozenset(decision.key for decision in outcome.fe_plan.decisions)


def _results(numbers: dict[str, float]) -> tuple[Result, ...]:
    return tuple(Result(name.replace("_", " "), value, UNITS[name]) for name, value in numbers.items())
