"""Tables of the report of a whole impact."""

from __future__ import annotations

from dataclasses import replace
from itertools import zip_longest

import numpy as np

from postprocess.report import tables
from postprocess.report.page import Section
from postprocess.report.tables import Column, Table, columns
from postprocess.signals import filters
from postprocess.units import measure, milliseconds, percent_up
from tailslap.case.impact import error, run
from tailslap.case.impact.answers import ImpactAnswer
from tailslap.case.impact.rigid import RigidImpact
from tailslap.case.impact.space.design import MEANING, OVER, sentences
from tailslap.case.report_parts import design_table, strikes_table

FORCE = (
    Column("curve", "Force on the wall, largest"),
    Column("fe", "Lateral, FE", "N", form="#.4g", style="strong"),
    Column("rigid", "Lateral, rigid", "N", form="#.4g"),
    Column("along", "Along the wall, FE", "N", form="#.3g"),
)
FORCE_IN_SPACE = (
    FORCE[0],
    Column("lateral", "Lateral", "N", form="#.4g", style="strong"),
    *columns({"longitudinal": "Along the wall", "vertical": "Down"}, unit="N", form="#.3g"),
)

FORCE_NOTE = (
    "Total of all contacts; each value is the largest of its own component. Design loads compare with the 50 ms mean: "
    "raw and CFC 60 follow the unloading of a single contact, which the crush law simplifies."
)
DURATIONS = (
    Column("curve", "Curve"),
    *columns({"duration": "Valley to valley", "triangle": "Equal triangle"}, unit="ms", form=milliseconds),
    Column("peak_force", "Peak", "N", form=".0f"),
)
RISK = (
    Column("name", "Measure"),
    Column("value", "Value", form=".3g", style="strong", unit_key="unit"),
    Column("unit", "Unit", is_unit=True),
    Column("time", "At", "s", form=".3f"),
    Column("lacks", "Limitation"),
)
ERRORS = (
    Column("strike", "Stated error"),
    *(Column(name, words.capitalize(), form=percent_up) for name, words in error.QUANTITIES.items()),
)
HINGES = (
    *columns({"title": "Hinge", "model": "Model"}),
    Column("mean_50ms", "Force, 50 ms mean", "N", form="#.4g", style="strong"),
    Column("error", "Stated error", form=lambda error: "–" if error is None else percent_up(error)),
    Column("peak_force", "Peak, unfiltered", "N", form="#.4g"),
    Column("largest_angle", "Largest angle", "rad", form=".2f"),
)
HINGE_NOTE = (
    "The unfiltered peak force of the FE model contains elastic vibrations; its error is not estimated."
)
DURATIONS_NOTE = (
    "The paper reads the duration of the tail-slap from valley to valley around the second peak of a measured curve, "
    "and computes the force of a triangular pulse with it; here the duration is computed. A 50 ms mean extends an "
    "isolated strike by 50 ms."
)


WALL_NOTE = (
    "The rigid vehicle strikes a rigid wall. Contact force minus foundation force is the wall's inertia."
)


def errors_table(outcome: run.ImpactOutcome) -> Table:
    """Return the stated errors of strikes, if any."""
    strikes = error.assessed_strikes(outcome.fe) if outcome.mesh_error else []
    rows = [
        {"strike": f"{1 + outcome.fe.strikes.index(strike)} {strike.corner}"}
        | {name: outcome.mesh_error[f"strike_{number}.{name}"] for name in error.QUANTITIES}
        for number, strike in enumerate(strikes, 1)
    ]
    return Table(ERRORS, rows)


def hinges_table(outcome: run.ImpactOutcome, in_space: bool = False) -> Table:
    """Return force and angle of the hinges of a train.

    in_space: of the motion in space, if there is one.
    """
    models = {"FE": (outcome.fe, outcome.hinge_error), "rigid": (outcome.rigid, [])}
    if in_space and (space := outcome.fe_plan.case.space):
        models = {"in space": (space.answer, [])}
    rows = [
        {"title": f"Hinge {k}", "model": model, "error": error, **hinge}
        for model, (answer, errors) in models.items()
        for k, (hinge, error) in enumerate(zip_longest(answer.hinges, errors), 1)
    ]
    return Table(
        HINGES, sorted(rows, key=lambda row: str(row["title"])), notes=(HINGE_NOTE,) if "FE" in models else ()
    )


def strikes_of_models(outcome: run.ImpactOutcome) -> Table:
    answers = {"FE": outcome.fe, "rigid": outcome.rigid}
    return strikes_table({model: answer.numbers()["strikes"] for model, answer in answers.items()})


def force_table(outcome: run.ImpactOutcome) -> Table:
    """Return the largest forces in the plane by filter and component."""
    fe, rigid, along = outcome.fe.peaks, outcome.rigid.peaks, filters.force_peaks(outcome.fe.longitudinal)
    rows = [
        {"curve": label, "fe": fe[k], "rigid": rigid[k], "along": along[k]}
        for k, label in filters.LABELS.items()
    ]
    return Table(FORCE, rows)


def force_section(case: RigidImpact, table: Table) -> Section:
    """Return the section of the wall force, in space or planar."""
    if case.space:
        table = Table(FORCE_IN_SPACE, [row | {"curve": row["name"]} for row in case.space.force_rows])
    notes = FORCE_NOTE, *filter(None, [case.inertial_sentence])
    return Section("Force on the wall", tables=[replace(table, notes=notes)])


def durations_table(answer: ImpactAnswer) -> Table:
    """Return the second strike's durations."""
    rows = [{"curve": filters.LABELS[name], **values} for name, values in answer.second_strike.items()]
    return Table(DURATIONS, rows, notes=(DURATIONS_NOTE,))


def loads_table(outcome: run.ImpactOutcome) -> Table:
    """Return the table of 50 ms means and design loads."""
    longitudinal = float(outcome.fe.longitudinal["mean_50ms"].max())
    case = outcome.fe_plan.case
    in_space = case.space.numbers() if case.space else None
    return design_table(case, outcome.mean_force, longitudinal, in_space)


def design_section(case: RigidImpact, loads: Table) -> Section:
    """Return what the design of a wall takes from the impact."""
    numbers = case.space.numbers() if case.space else None
    over = numbers["intrusion"] if numbers else []
    rows = [row | {"key": f"strip.{row['strip']}"} for row in over]
    severity = f"Impact severity m (v sin(theta))^2/2: {measure(case.impact_severity, 'J', '.4g')}."
    return Section(
        "For the design",
        tables=[loads, Table(OVER, rows, notes=(MEANING,))],
        sentences=[severity, *(sentences(numbers) if numbers else ())],
    )


def wall_table(outcome: run.ImpactOutcome) -> list[Table]:
    """Return the response of a deformable wall, none for a rigid one."""
    response = wall_numbers(outcome)
    if response is None:
        return []
    rows = [
        ("largest deflection of the face", 1e3 * response["deflection"], "mm"),
        ("position along the wall", response["place"], "m"),
        ("time", response["t"], "s"),
        ("force of the foundation, 50 ms mean", response["foundation_mean_50ms"], "N"),
        ("contact force, 50 ms mean", response["contact_mean_50ms"], "N"),
        ("force of the foundation, largest", response["foundation_force"], "N"),
    ]
    return [tables.pairs(rows, notes=(WALL_NOTE,))]


def paper_table(outcome: run.ImpactOutcome) -> list[Table]:
    """Return the paper's stages for the same vehicle.

    There is none where the scene has not their input.
    """
    beside = outcome.fe_plan.case.paper_method
    if beside is None:
        return []
    rigid = outcome.fe_plan.case.answer
    rear = next((strike for strike in rigid.strikes if strike.corner == "rear"), None)
    rows = [
        ("impulse of the tail-slap, whole mass stopped", beside["impulse"], "N s"),
        ("impulse of the rear strike, computed", rear.impulse if rear else None, "N s"),
        (f"peak force with a duration of {beside['duration']:g} s", beside["peak_force"], "N"),
    ]
    if beside["computed_duration"]:
        read = f"peak force with {1e3 * beside['computed_duration']:.0f} ms, the duration in the computed 50 ms mean"
        rows.append((read, beside["computed_peak_force"], "N"))
    rows.append(("50 ms mean, computed", rigid.peaks["mean_50ms"], "N"))
    note = "Stages 1 to 3 assume a uniform rectangle."
    return [tables.pairs(rows, notes=(note,))]


def wall_numbers(outcome: run.ImpactOutcome) -> dict[str, float] | None:
    """Return deflection and forces of a deformable wall.

    Largest deflection, its place and time, and the largest forces of foundation and contact. None for a rigid wall.
    """
    if outcome.fe_plan.case.scene.meshed_wall is None:
        return None

    h = outcome.run.history
    k = int(np.argmax(h["wall_deflection"]))
    mean = filters.moving_mean(h["force_foundation"][1:], outcome.fe.interval, 0.05)
    return {
        "deflection": float(h["wall_deflection"][k]),
        "place": float(h["wall_deflection_place"][k]),
        "t": float(h["t"][k]),
        "foundation_force": float(h["force_foundation"].max()),
        "foundation_mean_50ms": float(mean.max()),
        "contact_mean_50ms": outcome.fe.peaks["mean_50ms"],
    }
