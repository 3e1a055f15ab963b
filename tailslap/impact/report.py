"""What the run of a whole impact reports: page, summary, histories, and what the terminal says."""

from __future__ import annotations

from pathlib import Path

from postprocess.report.page import Page, Section
from postprocess.report.report import Report
from postprocess.report.table import Column, Table, pairs
from postprocess.signals.design_forces import design_forces
from tailslap.impact.answers import ImpactAnswer
from tailslap.impact.check_text import contact_words, omitted_parts
from tailslap.impact.figures import (
    animation,
    contact_figures,
    energy_figure,
    force_figures,
    position_strip,
)
from tailslap.impact.outcome import ImpactOutcome
from tailslap.impact.paper_method import paper_method
from tailslap.impact.rigid_text import CURVES
from tailslap.impact.summary import impact_cost, impact_histories, impact_summary, wall_numbers
from tailslap.report.footer import footer
from tailslap.report.run_report import CHECKS, INPUTS
from tailslap.scene.inputs import resolved_inputs

KICKER = "Whole impact: the FE plate beside the rigid vehicle, against a wall that only pushes"
FOOTER = "SI units; X along the wall in the driving direction, Y away from it; strikes by the nearest corner."

STRIKES = (
    Column("corner", "Strike"),
    Column("model", "Model"),
    Column("start", "Start", "s", form=".4f"),
    Column("duration", "Duration", "ms", form=".1f"),
    Column("peak", "Peak", "kN", form=".1f", style="strong"),
    Column("impulse", "Impulse", "kN s", form=".2f"),
    Column("attack", "Behind the front", "m", form=".2f"),
)
PEAKS = (
    Column("curve", "Peak lateral force"),
    Column("fe", "FE", "kN", form=".1f", style="strong"),
    Column("rigid", "Rigid", "kN", form=".1f"),
    Column("along", "Longitudinal, FE", "kN", form=".1f"),
)
DESIGN = (
    Column("name", "Design force"),
    Column("force", "Lateral", "kN", form=".0f"),
    Column("share", "50 ms mean of FE over it", form=".2f", style="strong"),
    Column("source", "Source", style="soft"),
)
DURATIONS = (
    Column("curve", "Read off"),
    Column("duration", "Valley to valley", "ms", form=".0f"),
    Column("triangle", "Equal triangle", "ms", form=".0f"),
    Column("peak", "Its peak", "kN", form=".0f"),
)
RISK = (
    Column("name", "Measure"),
    Column("value", "Value", form=".3g", style="strong"),
    Column("unit", "Unit"),
    Column("time", "At", "s", form=".3f"),
    Column("lacks", "What it lacks"),
)
DURATIONS_NOTE = (
    "The paper takes the duration of the tail-slap from valley to valley around the second peak of a measured curve, "
    "and the force of a triangular pulse from it; here it is computed. A mean over 50 ms lengthens a strike that "
    "stands free by 50 ms."
)


def impact_report(outcome: ImpactOutcome, folder: Path, pictures: bool) -> Report:
    """The report of a run; pictures: whether an animation was asked for."""
    plan = outcome.fe_plan.plan
    page = Page(
        kicker=KICKER,
        title=plan.scene.name,
        headline=headline(outcome),
        sections=_sections(outcome, folder, pictures),
        footer=f"{footer()} {FOOTER}",
        scene_text=plan.source.text,
        passed=outcome.passed,
    )
    said = tuple(_terminal(outcome))
    return Report(page, impact_summary(outcome, pictures), said, histories=impact_histories(outcome))


def headline(outcome: ImpactOutcome) -> str:
    """The verdict, the forces, and how far flexibility moves them."""
    failed = [check.name for check in outcome.checks if not check.passed]
    if failed:
        return f"Not to be relied on: failed {', '.join(failed)}."
    fe, rigid = outcome.fe, outcome.rigid
    of_wall = " and the wall's" if outcome.fe_plan.plan.scene.wall else ""
    strikes = "; ".join(
        f"{s.corner} {s.peak_force / 1e3:.0f} kN for {1e3 * s.duration:.0f} ms" for s in fe.strikes[:2]
    )
    impulses = [abs(v) for k, v in outcome.difference.items() if k.endswith("impulse")]
    flexible = (
        f" The plate's{of_wall} flexibility moves the impulses by up to {100 * max(impulses):.2g} %"
        if impulses
        else ""
    )
    error = max(map(abs, outcome.mesh_error.values()), default=float("nan"))
    return (
        f"Peak lateral force {fe.peaks['mean_50ms'] / 1e3:.0f} kN as a 50 ms mean (rigid vehicle "
        f"{rigid.peaks['mean_50ms'] / 1e3:.0f} kN). Strikes: {strikes}.{flexible}"
        f"{', mesh error at most ' + format(100 * error, '.2g') + ' %' if impulses else ''}."
    )


def strikes_table(outcome: ImpactOutcome, title: str = "") -> Table:
    """Strikes of both models, in order of time."""
    rows = []
    for model, answer in (("FE", outcome.fe), ("rigid", outcome.rigid)):
        for number, strike in enumerate(answer.strikes, 1):
            rows.append(
                {
                    "order": (number, model),
                    "corner": f"{number} {strike.corner}",
                    "model": model,
                    "start": strike.start,
                    "duration": 1e3 * strike.duration,
                    "peak": strike.peak_force / 1e3,
                    "impulse": strike.impulse / 1e3,
                    "attack": strike.point_of_attack,
                }
            )
    return Table(STRIKES, sorted(rows, key=lambda row: str(row["order"])), title)


def peaks_table(outcome: ImpactOutcome, title: str = "") -> Table:
    """Peaks of raw and filtered forces."""
    from postprocess.signals.peaks import force_peaks

    along = force_peaks(outcome.fe.longitudinal)
    rows = [
        {
            "curve": label,
            "fe": outcome.fe.peaks[key] / 1e3,
            "rigid": outcome.rigid.peaks[key] / 1e3,
            "along": along[key] / 1e3,
        }
        for key, label in CURVES.items()
    ]
    return Table(PEAKS, rows, title)


def design_table(outcome: ImpactOutcome) -> Table:
    """Design forces of the scene's test level; none without one."""
    impact = outcome.fe_plan.plan.scene.impact
    level = impact.test_level if impact else None
    mean = outcome.fe.peaks["mean_50ms"]
    forces = design_forces(level) if level else ()
    rows = [
        {"name": each.name, "force": each.force / 1e3, "share": mean / each.force, "source": each.source}
        for each in forces
    ]
    return Table(DESIGN, rows)


def durations_table(answer: ImpactAnswer) -> Table:
    """Duration of the second strike as the paper reads it."""
    rows = [
        {
            "curve": CURVES[name],
            "duration": 1e3 * found["duration"],
            "triangle": 1e3 * found["triangle"],
            "peak": found["peak_force"] / 1e3,
        }
        for name, found in answer.second_strike.items()
    ]
    return Table(DURATIONS, rows, notes=(DURATIONS_NOTE,))


def _sections(outcome: ImpactOutcome, folder: Path, pictures: bool) -> list[Section]:
    fe_plan, plan = outcome.fe_plan, outcome.fe_plan.plan
    design = design_table(outcome)
    levels = {row["name"]: 1e3 * row["force"] for row in design.rows}
    chosen = frozenset(decision.key for decision in fe_plan.decisions)
    inputs = resolved_inputs(plan.scene, plan.source, fe_plan.plate, chosen)
    failed = {number: "failed" for number, check in enumerate(outcome.checks) if not check.passed}
    omitted = [{"part": part, "why": why} for part, why in omitted_parts(plan.scene, pictures)]
    forces, (loops, along) = force_figures(outcome, levels), contact_figures(outcome)
    moving = [animation(outcome, folder)] if pictures else []
    return [
        Section("Strikes", tables=[strikes_table(outcome)]),
        Section("Forces on the wall", tables=[peaks_table(outcome), design]),
        Section("The second strike's duration", tables=[durations_table(outcome.fe)]),
        Section("The wall, which gives", tables=_wall(outcome)),
        Section("The paper's method beside it", tables=_paper(outcome)),
        Section("Positions along the wall", figures=[position_strip(outcome)], layout="tall"),
        Section("Lateral force over time", figures=forces[:1], layout="tall"),
        Section("Along the wall, and of the rigid vehicle", figures=forces[1:], layout="wide"),
        Section("Energy, and force along the side", figures=[energy_figure(outcome), *along], layout="wide"),
        Section("Force over crush", figures=loops, layout="narrow"),
        Section("Animation", figures=moving, layout="tall"),
        Section("What was run", sentences=_statements(outcome)),
        Section("Checks of the result", tables=[Table(CHECKS, outcome.checks, marks=failed)]),
        Section("Occupant risk, planar", tables=[Table(RISK, outcome.fe.occupant_risk(fe_plan.model.mass))]),
        Section(
            "Cost",
            tables=[pairs([(k.replace("_", " "), v) for k, v in impact_cost(outcome).items()])],
            layout="half",
        ),
        Section(
            "Left out", tables=[Table((Column("part", "Part"), Column("why", "Why")), omitted)], layout="half"
        ),
        Section("Inputs", tables=[Table(INPUTS, inputs)]),
    ]


def _wall(outcome: ImpactOutcome) -> list[Table]:
    """What the wall does; nothing for a rigid one."""
    found = wall_numbers(outcome)
    if found is None:
        return []
    rows = [
        ("largest deflection of its face", round(1e3 * found["deflection"], 3), "mm"),
        ("at", round(found["place"], 2), "m along the wall"),
        ("at", round(found["t"], 4), "s"),
        ("force of the foundation, 50 ms mean", round(found["foundation_mean_50ms"] / 1e3, 1), "kN"),
        ("contact force, 50 ms mean", round(found["contact_mean_50ms"] / 1e3, 1), "kN"),
        ("force of the foundation, largest", round(found["foundation_force"] / 1e3, 1), "kN"),
    ]
    note = (
        "The rigid vehicle strikes a rigid wall. What the foundation does not carry, the wall's inertia does."
    )
    return [pairs(rows, notes=(note,))]


def _paper(outcome: ImpactOutcome) -> list[Table]:
    """The three stages of the paper for the same vehicle, where the scene feeds them."""
    beside = paper_method(outcome.fe_plan.plan.scene, outcome.rigid)
    if beside is None:
        return []
    rigid = outcome.rigid
    rear = next((strike for strike in rigid.strikes if strike.corner == "rear"), None)
    rows = [
        ("impulse of the tail-slap, all of the mass stopped", beside.impulse / 1e3, "kN s"),
        ("impulse of the rear strike, computed", rear.impulse / 1e3 if rear else None, "kN s"),
        (f"peak force with a duration of {beside.duration:g} s", beside.peak_force / 1e3, "kN"),
    ]
    if beside.computed_duration and beside.computed_peak_force:
        read = f"peak force with {1e3 * beside.computed_duration:.0f} ms, read off the computed 50 ms mean"
        rows.append((read, beside.computed_peak_force / 1e3, "kN"))
    rows.append(("50 ms mean, computed", rigid.peaks["mean_50ms"] / 1e3, "kN"))
    note = "Stages 1 to 3 are those of the uniform rectangle, whatever its centre of mass and yaw inertia are here."
    return [pairs([(what, value and round(value, 1), unit) for what, value, unit in rows], notes=(note,))]


def _statements(outcome: ImpactOutcome) -> list[str]:
    plan = outcome.fe_plan.plan
    contact = plan.scene.contact
    assert contact is not None
    return [
        f"The vehicle {contact_words(contact)}.",
        "The rigid vehicle has the same mass, centre, inertia and contact; what the plate differs by is its "
        f"flexibility (first frequency {outcome.fe_plan.first_frequency:.4g} Hz).",
        *(f"Chosen by the program: {decision.shown}." for decision in outcome.fe_plan.decisions),
    ]


def _terminal(outcome: ImpactOutcome) -> list[Table | str]:
    failed = [check for check in outcome.checks if not check.passed]
    run = outcome.run
    return [
        strikes_table(outcome, outcome.fe_plan.plan.scene.name),
        peaks_table(outcome, "Forces on the wall"),
        *(f"Chosen: {decision.shown}" for decision in outcome.fe_plan.decisions),
        *(f"FAILED  {c.name}: {c.value:.3g}, limit {c.limit:.3g} ({c.meaning})" for c in failed),
        f"{headline(outcome)} Checks: {len(outcome.checks) - len(failed)} of {len(outcome.checks)} passed",
        f"Cost:   {run.steps} steps in {run.time_loop_s:.3f} s, set-up {outcome.setup_s:.2f} s",
    ]
