"""What a run reports: page, summary, histories, and what the terminal says."""

from __future__ import annotations

import math

from fem.explicit.columns import COLUMNS
from postprocess.comparison.comparison import (
    PAPER_SOURCE,
    PAPER_TABLE_3,
    ComparisonRow,
    comparison_rows,
    largest,
)
from postprocess.figures.curves import draw_histories
from postprocess.figures.panels import Panel
from postprocess.report.numbers import number, shown
from postprocess.report.page import Page, Picture, Section
from postprocess.report.report import Report
from postprocess.report.table import Column, Table, pairs
from tailslap.planning.rigid import rigid_answer
from tailslap.report.check_text import chosen_lines
from tailslap.report.footer import footer
from tailslap.report.omitted_parts import omitted_parts
from tailslap.report.run_text import is_paper_case, statements
from tailslap.report.summary import cost, summary
from tailslap.scene.inputs import resolved_inputs
from tailslap.scene_run import Outcome
from tailslap.verification.verdict import verdict_sentence

KICKER = "Tail-slap: finite elements against the exact rigid-body solution"
FOOTER = "SI units; X along the wall in the driving direction, Y away from it, ω positive where it closes the angle."
CAPTIONS = {
    "contour_v_gx": "Velocity along the wall at the tail-slap (the paper's Figure 15).",
    "contour_v_gy": "Velocity across the wall at the tail-slap (the paper's Figure 16).",
    "contour_omega": "Angular velocity, half the curl of the velocity, at the tail-slap (the paper's Figure 17).",
}
UNITS = {
    **{"omega": "rad/s", "corner_speed": "m/s", "impulse": "N s", "duration": "s", "peak_force": "N"},
    **dict.fromkeys(("time_step", "setup_s", "time_loop_s", "pictures_s"), "s"),
}

PAPER = (
    Column("paper_analytical", "Paper, analytical", form=number, style="soft"),
    Column("paper_abaqus", "Paper, ABAQUS", form=number, style="soft"),
)
CHECKS = (
    Column("name", "Check"),
    Column("value", "Value", form=".4g"),
    Column("limit", "Limit", form=".4g"),
    Column("passed", "Result", form=lambda passed: "passed" if passed else "failed", style="badge"),
    Column("meaning", "What it means"),
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
INPUTS = (
    Column("key", "Key"),
    Column("given", "As given"),
    Column("value", "SI value", form=lambda value: number(value, 10)),
    Column("unit", "Unit"),
    Column("origin", "From"),
)


def run_report(outcome: Outcome, pictures: bool) -> Report:
    """The report of a run; pictures: whether they were asked for."""
    plan = outcome.fe_plan.plan
    page = Page(
        kicker=KICKER,
        title=plan.scene.name,
        headline=headline(outcome),
        sections=sections(outcome, pictures),
        footer=f"{footer()} {FOOTER}",
        scene_text=plan.source.text,
        passed=outcome.passed,
    )
    histories = {"history.csv": outcome.fe_history, "rigid.csv": outcome.rigid_history}
    return Report(page, summary(outcome, pictures), tuple(_terminal(outcome)), histories=histories)


def comparison(outcome: Outcome, figures: str, title: str = "") -> Table:
    """FE beside the rigid motion, and the paper's Table 3 where the scene is the paper's; figures: format of both."""
    of_paper = is_paper_case(outcome.fe_plan.plan)
    paper = PAPER_TABLE_3 if of_paper else None
    rows = comparison_rows(outcome.fe, outcome.rigid, paper) if outcome.fe else ()
    columns = (
        *((Column("quantity.title", "Quantity"),) if not title else ()),
        Column("quantity.symbol", ""),
        Column("quantity.unit", "Unit"),
        Column("fe", "FE", form=figures),
        Column("rigid", "Rigid, exact", form=figures),
        Column("difference", "FE/rigid − 1", form="+.2e", style="strong"),
        *(PAPER if of_paper else ()),
    )
    note = f"Paper: {PAPER_SOURCE}, whose magnitude of v_GY is given this report's sign."
    return Table(columns, rows, title, notes=(note,) if of_paper and not title else ())


def headline(outcome: Outcome) -> str:
    """The verdict, failed checks in front, and the five differences behind it."""
    failed = [check.name for check in outcome.checks if not check.passed]
    text = (f"Failed: {', '.join(failed)}. " if failed else "") + verdict_sentence(outcome)
    if not outcome.fe:
        return f"{text} There is no comparison: the run did not reach the tail-slap."
    rows: tuple[ComparisonRow, ...] = tuple(comparison(outcome, "").rows)
    most = largest(outcome.difference)
    size = f"by at most {most:.1e}" if math.isfinite(most) else "without bound"
    each = ", ".join(f"{row.quantity.symbol} {shown(row.difference, '+.2e')}" for row in rows)
    return f"{text} At the tail-slap FE differs from the exact rigid-body solution {size} (FE/rigid − 1): {each}."


def sections(outcome: Outcome, pictures: bool) -> list[Section]:
    """The parts of the page, those without content included."""
    plan, answer = outcome.fe_plan.plan, rigid_answer(outcome.fe_plan.plan)
    one, three = ([pairs(_with_units(answer[stage] or {}))] for stage in ("stage1", "stage3"))
    chosen = frozenset(decision.key for decision in outcome.fe_plan.decisions)
    inputs = resolved_inputs(plan.scene, plan.source, outcome.fe_plan.plate, chosen)
    metrics = [{"name": f"`{name}`", **vars(item)} for name, item in outcome.metrics.items()]
    failed = {number: "failed" for number, check in enumerate(outcome.checks) if not check.passed}
    parts = [{"part": part, "why": why} for part, why in omitted_parts(plan.scene, pictures)]
    omitted = [Table((Column("part", "Part"), Column("why", "Why")), parts)]
    drawn = [Picture(path, CAPTIONS[path.stem]) for path in outcome.pictures]
    return [
        Section("At the tail-slap", tables=[comparison(outcome, "#.8g")]),
        Section("What was run, and what it means", sentences=statements(outcome)),
        Section("Checks of the result", tables=[Table(CHECKS, outcome.checks, marks=failed)]),
        Section(
            "FE histories against the rigid ones", tables=[Table(METRICS, metrics, notes=(METRICS_NOTE,))]
        ),
        Section("Stage 1: impulse at the front corner", tables=one, layout="half"),
        Section("Stage 3: lateral force of the tail-slap", tables=three, layout="half"),
        Section("The plate at the tail-slap", figures=drawn, layout="tall"),
        *_curves(outcome),
        Section("Cost", tables=[pairs(_with_units(cost(outcome)))], layout="half"),
        Section("Left out", "" if parts else "Nothing.", tables=omitted, layout="half"),
        Section("Inputs", tables=[Table(INPUTS, inputs)]),
    ]


def _curves(outcome: Outcome) -> list[Section]:
    curves = draw_histories(outcome.fe_history, outcome.rigid_history, _panels())
    groups = dict.fromkeys(curve.group for curve in curves)
    return [Section(group, figures=[c for c in curves if c.group == group]) for group in groups]


def _with_units(numbers: dict[str, float | int]) -> list[tuple[str, float | int, str]]:
    return [(name.replace("_", " "), value, UNITS.get(name, "")) for name, value in numbers.items()]


def _terminal(outcome: Outcome) -> list[Table | str]:
    """The comparison, what was chosen, the checks that failed, the verdict, and what it cost."""
    failed = [check for check in outcome.checks if not check.passed]
    choice, run = outcome.choice, outcome.run
    picked = choice and f"Picked: {', '.join(choice.changes)}; expected error {choice.expected_error:.1e}"
    named = [f"FAILED  {c.name}: {c.value:.3g}, limit {c.limit:.3g} ({c.meaning})" for c in failed]
    return [
        comparison(outcome, ".7g", f"{outcome.fe_plan.plan.scene.name} at the tail-slap"),
        *([picked] if picked else []),
        *(f"Chosen: {decision.shown}" for decision in outcome.fe_plan.decisions),
        *named,
        *(chosen_lines(outcome.fe_plan) if failed else []),
        f"{verdict_sentence(outcome)} Checks: {len(outcome.checks) - len(failed)} of {len(outcome.checks)} passed",
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
