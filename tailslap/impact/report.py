"""What the run of a whole impact reports: page, summary, histories, and what the terminal says."""

from __future__ import annotations

from pathlib import Path

from postprocess.report.page import Picture, Section
from postprocess.report.report import Report
from postprocess.report.table import Column, Table, pairs
from postprocess.report.units import SI, Units
from tailslap.case.checks import failed_names
from tailslap.case.report import (
    PEAKS,
    checks_section,
    chosen_sentences,
    design_table,
    failed_section,
    keep_fields,
    milliseconds,
    run_page,
    short,
    strikes_table,
    terminal_text,
)
from tailslap.impact.answers import ImpactAnswer
from tailslap.impact.check_text import contact_words, omitted_parts
from tailslap.impact.checks import advice
from tailslap.impact.figures import animation, contact_figures, energy_figure, force_figures, position_strip
from tailslap.impact.outcome import ImpactOutcome
from tailslap.impact.rigid_text import CURVES
from tailslap.impact.summary import impact_histories, impact_summary, wall_numbers

KICKER = "Whole impact: the FE plate beside the rigid vehicle, against a wall that only pushes"
FOOTER = "SI units; X along the wall in the driving direction, Y away from it; strikes by the nearest corner."

FILTERED = (
    Column("curve", "Peak force, by filter"),
    Column("fe", "Lateral, FE", "N", form=".1f", style="strong"),
    Column("rigid", "Lateral, rigid", "N", form=".1f"),
    Column("along", "Longitudinal, FE", "N", form=".1f"),
)
DURATIONS = (
    Column("curve", "Read off"),
    Column("duration", "Valley to valley", "ms", form=milliseconds),
    Column("triangle", "Equal triangle", "ms", form=milliseconds),
    Column("peak_force", "Its peak", "N", form=".0f"),
)
RISK = (
    Column("name", "Measure"),
    Column("value", "Value", form=".3g", style="strong", unit_key="unit"),
    Column("unit", "Unit", is_unit=True),
    Column("time", "At", "s", form=".3f"),
    Column("lacks", "What it lacks"),
)
DURATIONS_NOTE = (
    "The paper takes the duration of the tail-slap from valley to valley around the second peak of a measured curve, "
    "and the force of a triangular pulse from it; here it is computed. A mean over 50 ms lengthens a strike that "
    "stands free by 50 ms."
)


def impact_report(outcome: ImpactOutcome, folder: Path, pictures: bool, units: Units = SI) -> Report:
    """The report of a run; pictures: whether an animation was asked for; units: of it."""
    keep_fields(outcome, folder)
    moving, verdict = [animation(outcome, folder, units)] if pictures else [], headline(outcome)
    omitted = omitted_parts(outcome.fe_plan.case.scene, pictures)
    page = run_page(outcome, KICKER, verdict, _sections(outcome, moving), omitted, FOOTER)
    tables = (peak_table(outcome), short(_design(outcome)), _strikes(outcome))
    said = terminal_text(outcome, verdict, tables, advice)
    return Report(page, impact_summary(outcome, pictures), said, histories=impact_histories(outcome))


def headline(outcome: ImpactOutcome) -> str:
    """The verdict: whether the numbers hold, and how far flexibility moves them."""
    failed = failed_names(outcome.checks)
    if failed:
        return f"Not to be relied on: failed {', '.join(failed)}."
    impulses = [abs(value) for key, value in outcome.difference.items() if key.endswith("impulse")]
    if not impulses:
        return "The checks hold; plate and rigid vehicle do not strike in the same order."
    of_wall = " and the wall's" if outcome.fe_plan.case.scene.wall else ""
    error = max(map(abs, outcome.mesh_error.values()), default=float("nan"))
    return (
        f"The plate's{of_wall} flexibility moves the impulses of the rigid vehicle by up to "
        f"{100 * max(impulses):.2g} %; mesh error at most {100 * error:.2g} %."
    )


def peak_table(outcome: ImpactOutcome) -> Table:
    """Peak force of each strike, and of the whole impact as a mean over 50 ms."""
    fe, rigid = outcome.fe.strikes, outcome.rigid.strikes
    rows = [
        {
            "what": f"Strike {number}, {strike.corner}",
            "fe": strike.peak_force,
            "rigid": rigid[number - 1].peak_force if number <= len(rigid) else None,
        }
        for number, strike in enumerate(fe, 1)
    ]
    mean = {"fe": outcome.fe.peaks["mean_50ms"], "rigid": outcome.rigid.peaks["mean_50ms"]}
    return Table(PEAKS, [*rows, {"what": "Whole impact, 50 ms mean"} | mean])


def _design(outcome: ImpactOutcome) -> Table:
    """Design forces beside the 50 ms mean."""
    return design_table(outcome.fe_plan.case.scene, outcome.fe.peaks["mean_50ms"])


def _strikes(outcome: ImpactOutcome) -> Table:
    answers = {"FE": outcome.fe, "rigid": outcome.rigid}
    return strikes_table({model: answer.numbers()["strikes"] for model, answer in answers.items()})


def filtered_table(outcome: ImpactOutcome) -> Table:
    """Peaks of raw and filtered forces."""
    from postprocess.signals.filters import force_peaks

    peaks = {
        "fe": outcome.fe.peaks,
        "rigid": outcome.rigid.peaks,
        "along": force_peaks(outcome.fe.longitudinal),
    }
    rows = [
        {"curve": label} | {name: its[key] for name, its in peaks.items()} for key, label in CURVES.items()
    ]
    return Table(FILTERED, rows)


def durations_table(answer: ImpactAnswer) -> Table:
    """Duration of the second strike as the paper reads it."""
    rows = [{"curve": CURVES[name], **found} for name, found in answer.second_strike.items()]
    return Table(DURATIONS, rows, notes=(DURATIONS_NOTE,))


def _sections(outcome: ImpactOutcome, moving: list[Picture]) -> list[Section]:
    design = _design(outcome)
    levels = {row["name"]: row["force"] for row in design.rows}
    forces, (loops, along) = force_figures(outcome, levels), contact_figures(outcome)
    return [
        Section("Peak lateral force", tables=[peak_table(outcome), design]),
        Section("Strikes", tables=[_strikes(outcome)]),
        failed_section(outcome.checks, advice, chosen_sentences(outcome.fe_plan)),
        Section("Lateral force over time", figures=forces[:1], layout="wide"),
        Section("Positions along the wall", figures=[position_strip(outcome)], layout="tall"),
        Section("Along the wall, and of the rigid vehicle", figures=forces[1:], layout="wide"),
        Section("Energy, and force along the side", figures=[energy_figure(outcome), *along], layout="wide"),
        Section("Force over crush", figures=loops, layout="narrow"),
        Section("Animation", figures=moving, layout="tall"),
        Section("The wall, which gives", tables=_wall(outcome)),
        Section("Forces by filter", tables=[filtered_table(outcome)], is_folded=True),
        Section("The second strike's duration", tables=[durations_table(outcome.fe)], is_folded=True),
        Section("The paper's method beside it", tables=_paper(outcome), is_folded=True),
        Section(
            "Occupant risk, planar",
            tables=[Table(RISK, outcome.fe.occupant_risk(outcome.fe_plan.model.mass))],
            is_folded=True,
        ),
        Section("What was run", sentences=_statements(outcome), is_folded=True),
        checks_section(outcome.checks, dict.fromkeys((check.name for check in outcome.checks), "")),
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
    beside = outcome.paper_method
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
    plan = outcome.fe_plan.case
    return [
        f"The vehicle {contact_words(plan.scene.needed_contact)}.",
        "The rigid vehicle has the same mass, centre, inertia and contact; what the plate differs by is its "
        f"flexibility (first frequency {outcome.fe_plan.first_frequency:.4g} Hz).",
        *chosen_sentences(outcome.fe_plan),
    ]
