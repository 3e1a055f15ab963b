"""Page, summary and terminal text of a run of a constrained corner. The answer first; detail folds away."""

from __future__ import annotations

import time
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from fem.explicit.columns import COLUMNS
from postprocess.comparison.quantities import KEYS, PAPER_SOURCE, PAPER_TABLE_3, comparison_rows
from postprocess.fields.contours import ContourField, Situation, draw_contours
from postprocess.figures.histories import Panel, draw_histories
from postprocess.report.page import Picture, Section
from postprocess.report.report import Report
from postprocess.report.table import Column, Table, pairs
from postprocess.units import SI, Units
from solver.stage_3 import strike_force
from tailslap.case import report
from tailslap.case.checks import advice, failed_names
from tailslap.case.corner.checks import CHECKS, CONTACT, ENERGY_RATIO, MECHANICS, PRACTICE
from tailslap.case.corner.run import CornerOutcome
from tailslap.case.corner.text import (
    diagnosis,
    is_paper_case,
    omitted_parts,
    prediction,
    statements,
    verdict_sentence,
)
from tailslap.progress import announced

KICKER = "Tail-slap: finite elements against the exact rigid-body solution"
FOOTER = "SI units; X along the wall in the driving direction, Y away from it, ω positive where it closes the angle."
CAPTIONS = {
    "contour_v_gx": "Velocity along the wall at the tail-slap (the paper's Figure 15).",
    "contour_v_gy": "Velocity across the wall at the tail-slap (the paper's Figure 16).",
    "contour_omega": "Angular velocity, half the curl of the velocity, at the tail-slap (the paper's Figure 17).",
}
STAGES = {
    "omega": ("angular velocity", "rad/s"),
    "corner_speed": ("corner speed", "m/s"),
    "impulse": ("impulse", "N s"),
    "duration": ("duration", "s"),
    "peak_force": ("peak force", "N"),
}
GROUPS = {
    **{kind.name: "Mechanics" for kind in MECHANICS},
    **{kind.name: "Work of the contact" for kind in CONTACT},
    **{kind.name: "Customary in crash analysis" for kind in (ENERGY_RATIO, *PRACTICE)},
}
"""Under which heading a check stands."""

PAPER = (
    Column("paper_analytical", "Paper, analytical", form=".5g", style="soft", unit_key="quantity.unit"),
    Column("paper_abaqus", "Paper, ABAQUS", form=".5g", style="soft", unit_key="quantity.unit"),
)
METRICS = (
    Column("name", "History"),
    Column("magnitude", "Magnitude, M", form="+.2e"),
    Column("phase", "Phase, P", form=".3g"),
    Column("combined", "Combined, C", form=".3g"),
    Column("mean_residual", "Mean residual", form="+.2e"),
    Column("deviation", "Deviation of residuals", form=".3g"),
)
METRICS_NOTE = (
    "M, P and C by Sprague and Geers, with integrals over time; residuals are FE − rigid over the rigid history's "
    "peak, as in the analysis of variance of NCHRP W179. All are 0 where the two histories are equal. Their customary "
    "limits are loose; the tight ones are this program's own: numerical error, reaction against rigid."
)


def corner_report(outcome: CornerOutcome, pictures: bool) -> Report:
    """The report of a run; pictures: whether they were asked for."""
    verdict, peaks, design = verdict_sentence(outcome), *_forces(outcome)
    failed = failed_names(outcome.checks)
    page = report.run_page(
        outcome,
        KICKER,
        (f"Failed: {', '.join(failed)}. " if failed else "") + verdict,
        sections(outcome),
        omitted_parts(outcome.fe_plan.case.scene, pictures),
        FOOTER,
        {"pictures_s": outcome.pictures_s},
    )
    said = report.terminal_text(
        outcome,
        verdict,
        (peaks, report.short(design), comparison(outcome, " ")),
        _cure,
        [prediction(outcome)],
        f", pictures {outcome.pictures_s:.2f} s",
    )
    return Report(
        page, corner_summary(outcome, pictures), said, histories=outcome.fe_plan.case.histories(outcome)
    )


def corner_summary(outcome: CornerOutcome, pictures: bool) -> dict[str, Any]:
    """Content of `summary.json`, SI; what was not reached is NaN, which is written as null."""
    fe_plan = outcome.fe_plan
    alike = report.run_summary(outcome, omitted_parts(fe_plan.case.scene, pictures))
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
        "cost": {**alike["cost"], "pictures_s": outcome.pictures_s},
        **{stage: answer[stage] for stage in ("stage1", "start", "stage3")},
        "plate": {
            **alike["plate"],
            "deflection_ratio": fe_plan.deflection_ratio,
            "penalty_stiffness": fe_plan.model.loop.corner.spring or None,
        },
        "tolerance": next((check.limit for check in outcome.checks if check.name == "tolerance"), None),
    }


def peak_table(outcome: CornerOutcome) -> Table:
    """Peak lateral force of the tail-slap by the formula of Stage 3, with the speed of plate and rigid body."""
    plan, fe = outcome.fe_plan.case, outcome.fe
    mass, duration = plan.scene.vehicle.mass, plan.scene.strike.duration
    found = strike_force(mass, fe["v_gy"], duration).peak_force if fe else None
    what = f"Tail-slap, triangle of {1e3 * duration:g} ms"
    return Table(report.PEAKS, [{"what": what, "fe": found, "rigid": plan.force.peak_force}])


def comparison(outcome: CornerOutcome, title: str = "") -> Table:
    """FE beside the rigid motion, and the paper's Table 3 where the scene is the paper's."""
    of_paper = is_paper_case(outcome.fe_plan.case)
    paper = PAPER_TABLE_3 if of_paper else None
    rows = comparison_rows(outcome.fe, outcome.rigid, paper) if outcome.fe else ()
    columns = (
        *(
            (replace(report.TAIL_SLAP[1], label="Tail-slap"), *report.TAIL_SLAP[2:])
            if title
            else report.TAIL_SLAP
        ),
        *(PAPER if of_paper else ()),
    )
    note = f"Paper: {PAPER_SOURCE}, whose magnitude of v_GY is given this report's sign."
    return Table(columns, rows, title, notes=(note,) if of_paper and not title else ())


def sections(outcome: CornerOutcome) -> list[Section]:
    """The parts of the page, those without content included."""
    answer = outcome.fe_plan.case.rigid_numbers()
    metrics = [{"name": f"`{name}`", **vars(item)} for name, item in outcome.metrics.items()]
    drawn = [Picture(path, CAPTIONS[path.stem]) for path in outcome.pictures]
    stages = [
        pairs(
            [(STAGES[name][0], value, STAGES[name][1]) for name, value in (answer[key] or {}).items()],
            title=title,
        )
        for key, title in (
            ("stage1", "Stage 1: impulse at the front corner"),
            ("stage3", "Stage 3: tail-slap"),
        )
    ]
    return [
        Section("Peak lateral force", tables=_forces(outcome)),
        Section("At the tail-slap", tables=[comparison(outcome)]),
        report.failed_section(outcome.checks, _cure, diagnosis(outcome)),
        Section("The plate at the tail-slap", figures=drawn, layout="tall"),
        *_curves(outcome),
        Section("What was run, and what it means", sentences=statements(outcome), is_folded=True),
        report.checks_section(outcome.checks, GROUPS),
        Section(
            "FE histories against the rigid ones",
            tables=[Table(METRICS, metrics, notes=(METRICS_NOTE,))],
            is_folded=True,
        ),
        Section("Stages 1 and 3 of the rigid body", tables=stages, is_folded=True),
    ]


def _forces(outcome: CornerOutcome) -> list[Table]:
    peaks = peak_table(outcome)
    (row,) = peaks.rows
    return [peaks, report.design_table(outcome.fe_plan.case.scene, row["fe"] or row["rigid"])]


def _cure(name: str) -> str:
    return advice(CHECKS, [name])


def _curves(outcome: CornerOutcome) -> list[Section]:
    curves = draw_histories(outcome.fe_history, outcome.rigid_history, _panels())
    groups = dict.fromkeys(curve.group for curve in curves)
    return [Section(group, figures=[c for c in curves if c.group == group]) for group in groups]


def _panels() -> tuple[Panel, ...]:
    """Plots of the columns that bring one of their own."""
    drawn = [column for column in COLUMNS.values() if column.symbol]
    return tuple(
        Panel(each.name, ((each.name, each.name),), each.symbol, each.unit, "Further columns", each.caption)
        for each in drawn
    )


def draw_pictures(outcome: CornerOutcome, folder: Path, units: Units = SI) -> CornerOutcome:
    """The outcome with contour pictures of the plate at the tail-slap, in these units; as it is where it was not
    reached."""
    from fem.plate.elements import nodal_spin

    began, fe_plan, strike = time.perf_counter(), outcome.fe_plan, outcome.run.strike
    if strike is None:
        return outcome
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
    with announced("Drawing the pictures ..."):
        situation = Situation(
            (strike.positions.T[:drawn], discretisation.cells),
            wall=None if wall is None else (wall.points[:, :2], wall.cells_dict["quad"]),
            corner=strike.positions[:, discretisation.corner].tolist(),
            centroid=(strike.positions @ masses / masses.sum()).tolist(),
            scene=fe_plan.case.scene.name,
            time=strike.values["t"],
        )
        pictures = draw_contours(situation, fields, folder, units)
    return replace(outcome, pictures=tuple(pictures), pictures_s=time.perf_counter() - began)
