"""What a run reports: page, summary, histories, and what the terminal says. The answer first; detail folds away."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from fem.explicit.columns import COLUMNS
from postprocess.comparison.quantities import PAPER_SOURCE, PAPER_TABLE_3, comparison_rows
from postprocess.figures.histories import Panel, draw_histories
from postprocess.report.page import Page, Picture, Section
from postprocess.report.report import Report
from postprocess.report.table import Column, Table, pairs
from postprocess.report.units import SI, Units
from solver.strike import strike_force
from tailslap.report.common import footer
from tailslap.report.fields import keep_fields
from tailslap.report.omitted_parts import omitted_parts
from tailslap.report.parts import (
    PEAKS,
    TAIL_SLAP,
    checks_section,
    design_table,
    failed_lines,
    failed_section,
    passed_text,
    record_sections,
    short,
)
from tailslap.report.pictures import draw_pictures
from tailslap.report.run_text import diagnosis, is_paper_case, prediction, statements
from tailslap.report.summary import cost, summary
from tailslap.scene.write import resolved_inputs, scene_text
from tailslap.scene_run import Outcome
from tailslap.verification.check import failed_names
from tailslap.verification.checks import advice
from tailslap.verification.contact_work import CONTACT
from tailslap.verification.crash_practice import ENERGY_RATIO, PRACTICE
from tailslap.verification.mechanics import MECHANICS
from tailslap.verification.verdict import verdict_sentence

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


def report_in_folder(outcome: Outcome, folder: Path, pictures: bool, units: Units = SI) -> Report:
    """The report of a run, whose fields and pictures go into the folder; units: of the pictures."""
    keep_fields(outcome, folder)
    return run_report(draw_pictures(outcome, folder, units) if pictures else outcome, pictures)


def run_report(outcome: Outcome, pictures: bool) -> Report:
    """The report of a run; pictures: whether they were asked for."""
    plan = outcome.fe_plan.case
    page = Page(
        kicker=KICKER,
        title=plan.scene.name,
        headline=headline(outcome),
        sections=sections(outcome, pictures),
        footer=f"{footer()} {FOOTER}",
        scene_text=scene_text(plan.source),
        passed=outcome.passed,
        contents=True,
    )
    return Report(page, summary(outcome, pictures), tuple(_terminal(outcome)), histories=outcome.histories)


def peak_table(outcome: Outcome) -> Table:
    """Peak lateral force of the tail-slap by the formula of Stage 3, with the speed of plate and rigid body."""
    plan, fe = outcome.fe_plan.case, outcome.fe
    mass, duration = plan.scene.vehicle.mass, plan.scene.strike.duration
    found = strike_force(mass, fe["v_gy"], duration).peak_force if fe else None
    what = f"Tail-slap, triangle of {1e3 * duration:g} ms"
    return Table(PEAKS, [{"what": what, "fe": found, "rigid": plan.force.peak_force}])


def comparison(outcome: Outcome, title: str = "") -> Table:
    """FE beside the rigid motion, and the paper's Table 3 where the scene is the paper's."""
    of_paper = is_paper_case(outcome.fe_plan.case)
    paper = PAPER_TABLE_3 if of_paper else None
    rows = comparison_rows(outcome.fe, outcome.rigid, paper) if outcome.fe else ()
    columns = (
        *((replace(TAIL_SLAP[1], label="Tail-slap"), *TAIL_SLAP[2:]) if title else TAIL_SLAP),
        *(PAPER if of_paper else ()),
    )
    note = f"Paper: {PAPER_SOURCE}, whose magnitude of v_GY is given this report's sign."
    return Table(columns, rows, title, notes=(note,) if of_paper and not title else ())


def headline(outcome: Outcome) -> str:
    """The verdict, failed checks in front."""
    failed = failed_names(outcome.checks)
    return (f"Failed: {', '.join(failed)}. " if failed else "") + verdict_sentence(outcome)


def sections(outcome: Outcome, pictures: bool) -> list[Section]:
    """The parts of the page, those without content included."""
    plan, answer = outcome.fe_plan.case, outcome.fe_plan.case.rigid_numbers()
    chosen = frozenset(decision.key for decision in outcome.fe_plan.decisions)
    inputs = resolved_inputs(plan.scene, plan.source, outcome.fe_plan.plate, chosen)
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
        failed_section(outcome.checks, _cure, diagnosis(outcome)),
        Section("The plate at the tail-slap", figures=drawn, layout="tall"),
        *_curves(outcome),
        Section("What was run, and what it means", sentences=statements(outcome), is_folded=True),
        checks_section(outcome.checks, GROUPS),
        Section(
            "FE histories against the rigid ones",
            tables=[Table(METRICS, metrics, notes=(METRICS_NOTE,))],
            is_folded=True,
        ),
        Section("Stages 1 and 3 of the rigid body", tables=stages, is_folded=True),
        *record_sections(cost(outcome), omitted_parts(plan.scene, pictures), inputs),
    ]


def _forces(outcome: Outcome) -> list[Table]:
    peaks = peak_table(outcome)
    (row,) = peaks.rows
    return [peaks, design_table(outcome.fe_plan.case.scene, row["fe"] or row["rigid"])]


def _cure(name: str) -> str:
    return advice([name])


def _curves(outcome: Outcome) -> list[Section]:
    curves = draw_histories(outcome.fe_history, outcome.rigid_history, _panels())
    groups = dict.fromkeys(curve.group for curve in curves)
    return [Section(group, figures=[c for c in curves if c.group == group]) for group in groups]


def _terminal(outcome: Outcome) -> list[Table | str]:
    """The verdict, the forces, the five quantities, what was chosen, the checks that failed, and what it cost."""
    choice, run = outcome.choice, outcome.run
    picked = choice and f"Picked: {', '.join(choice.changes)}; expected error {choice.expected_error:.1e}"
    peaks, design = _forces(outcome)
    return [
        f"{outcome.fe_plan.case.scene.name}: {verdict_sentence(outcome)}",
        "",
        peaks,
        short(design),
        comparison(outcome, " "),
        *([picked] if picked else []),
        *(f"Chosen: {decision.shown}" for decision in outcome.fe_plan.decisions),
        *failed_lines(outcome.checks, _cure, [prediction(outcome)]),
        passed_text(outcome.checks),
        f"Cost:   {run.steps} steps in {run.time_loop_s:.3f} s, set-up {outcome.setup_s:.2f} s, pictures "
        f"{outcome.pictures_s:.2f} s",
    ]


def _panels() -> tuple[Panel, ...]:
    """Plots of the columns that bring one of their own."""
    drawn = [column for column in COLUMNS.values() if column.symbol]
    return tuple(
        Panel(each.name, ((each.name, each.name),), each.symbol, each.unit, "Further columns", each.caption)
        for each in drawn
    )
