"""Report of a whole impact on page, terminal and in files."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, replace
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from postprocess.report import tables
from postprocess.report.page import Headline, Section
from postprocess.report.tables import Column, Table, columns
from postprocess.signals import filters
from postprocess.units import Units, force, measure, milliseconds, percent_up
from tailslap.case.check import failed_names, failed_sentence
from tailslap.case.impact import checks, error, figures, run
from tailslap.case.impact.answers import COMPANION, WEIGHT, ImpactAnswer, remarks
from tailslap.case.impact.plan import ImpactPlan
from tailslap.case.impact.rigid import RigidImpact
from tailslap.case.impact.rigid_input import above_wall
from tailslap.case.impact.space import figures as space_figures
from tailslap.case.impact.space.answer import section
from tailslap.case.impact.space.design import MEANING, OVER, sentences
from tailslap.case.report_parts import checks_section, design_ratios, design_table, short, strikes_table
from tailslap.case.run_report import (
    FeReport,
    Lines,
    chosen_sentences,
    fe_lines,
    omitted_lines,
    plate_sentence,
)
from tailslap.scene.schema import Scene

FIRST = ("t", "x_g", "y_g", "theta", "omega", "v_gx", "v_gy", "force_normal", "force_tangential")
"""Columns in front of all others."""

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


LEAST_CHANGE = 1e-6
"""Smallest effect of flexibility that the headline states as a bound [-]."""

WALL_NOTE = (
    "The rigid vehicle strikes a rigid wall. Contact force minus foundation force is the wall's inertia."
)


@dataclass(frozen=True)
class ImpactReport(FeReport):
    """Report of a run of a whole impact."""

    outcome: run.ImpactOutcome

    kicker = "Whole impact, unilateral contact: finite elements compared with the rigid vehicle"
    about = (
        "SI units; X along the wall in the driving direction, Y away from it; strikes by the nearest corner."
    )

    @property
    def headline(self) -> Headline:
        """Largest 50 ms mean, set-up and accuracy."""
        outcome, fe_plan, case = self.outcome, self.outcome.fe_plan, self.outcome.fe_plan.case
        failed = failed_names(outcome.checks)
        uncertain = bool(failed and outcome.mesh_error and set(failed) <= set(checks.MESH_CHECKS.values()))
        sentence = case.force_sentence(outcome.fe, not failed or uncertain, self.band)
        return Headline(
            case.headline().title,
            failed_sentence(outcome.checks) + sentence,
            f"{case.set_up} {plate_sentence(fe_plan)}",
            _uncertain(outcome) if uncertain else _certainty(outcome),
            self.band.sentence,
        )

    @property
    def histories(self) -> dict[str, dict[str, NDArray[np.float64]]]:
        """Histories of plate and rigid vehicle by file name, shape (rows,).

        With [sensor] also that of the vehicle in space.
        """
        case = self.outcome.fe_plan.case
        h = case.recorded(self.outcome.fe)
        ordered = {name: h[name] for name in FIRST} | h | {"energy_error": checks.energy_error(self.outcome)}
        in_space = {"space.csv": case.rigid_history()} if case.space and case.scene.sensor else {}
        return {"history.csv": ordered, "rigid.csv": case.recorded(self.outcome.rigid), **in_space}

    @property
    def sections(self) -> list[Section]:
        """Sections of the page, with empty ones, which are not shown."""
        outcome, case = self.outcome, self.outcome.fe_plan.case
        design = _design_table(outcome)
        levels = {row["name"]: row["force"] for row in design.rows if row["source"]}
        loops, along = figures.contact_figures(outcome)
        positions = figures.position_strip(outcome.fe, case.vehicles)
        is_companion = bool(case.space)
        in_space = section(case.space) if case.space else None
        plane, forces = ", companion in the plane" if is_companion else "", force_table(outcome)
        in_plane = [
            Section(
                f"Strikes{plane}",
                tables=[_strikes(outcome), errors_table(outcome), *([forces] if is_companion else [])],
                is_folded=is_companion,
            ),
            Section(
                f"Motion and force{plane}",
                figures=[positions, figures.force_figure(outcome, levels)],
                layout="tall",
                is_folded=is_companion,
            ),
            Section(
                f"Units and hinges of the train{plane}",
                figures=figures.train_figures(outcome),
                tables=[hinges_table(outcome)],
                layout="wide",
                is_folded=is_companion,
            ),
            Section(
                f"Energy and crush{plane}",
                figures=[figures.energy_figure(outcome), *loops, *along],
                layout="wide",
                is_folded=is_companion,
            ),
            Section("Deformable wall", tables=_wall(outcome)),
            Section(
                f"The second strike's duration{plane}", tables=[durations_table(outcome.fe)], is_folded=True
            ),
        ]
        return [
            _force_section(case, forces),
            _design_section(case, design),
            *(
                [replace(in_space, tables=[*in_space.tables, hinges_table(outcome, True)])]
                if in_space
                else []
            ),
            *in_plane,
            Section("Comparison with the paper's method", tables=_paper(outcome), is_folded=True),
            Section(
                f"Occupant risk, {'in space' if case.space else 'planar'}"
                + (", of the tractor" if outcome.fe.units > 1 else ""),
                tables=[Table(RISK, outcome.occupant_risk)],
                is_folded=True,
            ),
            Section("Model", sentences=_statements(outcome), is_folded=True),
            checks_section(outcome.checks, checks.groups(outcome)),
        ]

    @property
    def tables(self) -> list[Table]:
        """Design loads, strikes, hinges, forces and errors."""
        outcome, space = self.outcome, self.outcome.fe_plan.case.space
        of_motion = strikes_table({"in space": space.strikes}) if space else _strikes(outcome)
        strikes = replace(of_motion, notes=())
        first = short(_design_table(outcome)), strikes, hinges_table(outcome, in_space=True)
        return [*first, force_table(outcome), errors_table(outcome)]

    def omitted(self, pictures: bool) -> list[tuple[str, str]]:
        """List the parts that the scene omits."""
        return omitted_parts(self.outcome.fe_plan.case.scene, pictures)

    def drawn(self, folder: Path, units: Units, size: tuple[int, int] | None) -> ImpactReport:
        """Write the animations into a folder."""
        figures.animation(self.outcome, folder, units, size)
        space = self.outcome.fe_plan.case.space
        if space is not None:
            vehicle, wall = space.inputs.vehicle, space.inputs.wall
            space_figures.animation(vehicle, wall, space.motion, folder, units, size)
        return self

    def summary(self, pictures: bool) -> dict[str, Any]:
        """Return the content of `summary.json`, SI."""
        outcome, case = self.outcome, self.outcome.fe_plan.case
        numbers = case.space.numbers() if case.space else None
        in_space: dict[str, Any] = {}
        if numbers:
            loads = design_ratios(case, numbers["force"]["mean_50ms"])
            in_space = {"space": numbers, "design_forces": loads}
        return super().summary(pictures) | {
            "rigid": outcome.rigid.numbers(),
            "fe": outcome.fe.numbers(),
            **in_space,
            "inertial": case.inertial,
            "impact_severity": case.impact_severity,
            "paper_method": case.paper_method,
            "remarks": remarks(outcome.fe),
            "difference": outcome.difference,
            "numerical_error": {"mesh": outcome.mesh_error}
            | ({"hinges": outcome.hinge_error} if outcome.hinge_error else {}),
            "occupant_risk": list(map(asdict, outcome.occupant_risk)),
            "wall": wall_numbers(outcome),
            "vehicle": {"centre_of_mass": case.vehicle.front_distance, "yaw_inertia": case.vehicle.inertia},
        }


def _certainty(outcome: run.ImpactOutcome) -> str:
    """Return sentences on flexibility and the discretisation error.

    Both are those of the motion in the plane.
    """
    mean_force = force(outcome.fe.peaks["mean_50ms"])
    plane = f"{COMPANION.capitalize()}, {mean_force}. " if outcome.fe_plan.case.space else ""
    heavy = error.of_weight(outcome.difference, outcome.fe.strikes)
    sizes = {name: abs(difference) for name, difference in heavy.items()}
    changes = {
        name: max(LEAST_CHANGE, error.largest(sizes, name)) for name in ("impulse", "duration", "peak_force")
    }
    which = f" of strikes above {100 * WEIGHT:g} % of the largest" if heavy != outcome.difference else ""
    meshed_wall = outcome.fe_plan.case.scene.meshed_wall
    subject = "Flexibility of vehicle and wall" if meshed_wall else "Vehicle flexibility"
    mean = abs(outcome.fe.peaks["mean_50ms"] / outcome.rigid.peaks["mean_50ms"] - 1.0) if heavy else math.nan
    mean = max(LEAST_CHANGE, mean)
    text = (
        f"{plane}{subject} changes the impulses{which} by at most {percent_up(changes['impulse'])}, durations by "
        f"{percent_up(changes['duration'])}, peak forces by {percent_up(changes['peak_force'])}, the largest 50 ms "
        f"mean by {percent_up(mean)}"
    )
    if not heavy:
        text = "Plate and rigid vehicle do not strike in the same order"
    stated = "not estimated"
    if outcome.mesh_error:
        stated = f"at most {percent_up(max(outcome.stated_errors.values()))}"
    return f"{text}; discretisation error {stated}."


def _uncertain(outcome: run.ImpactOutcome) -> str:
    """Describe the errors above the scene's limit."""
    limit = outcome.fe_plan.case.scene.verify.mesh
    errors = {f"{error.STATED[name]}s": value for name, value in outcome.stated_errors.items()}
    parts = [
        f"{words} to {percent_up(value)} (limit {100 * limit:g} %)"
        for words, value in errors.items()
        if not value <= limit
    ]
    if within := {words: value for words, value in errors.items() if value <= limit}:
        parts.append(f"{', '.join(within)} to {percent_up(max(within.values()))}")
    of = f"{COMPANION.capitalize()}, known" if outcome.fe_plan.case.space else "Known"
    return f"{of} within the discretisation error: {'; '.join(parts)}."


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


def _strikes(outcome: run.ImpactOutcome) -> Table:
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


def _force_section(case: RigidImpact, table: Table) -> Section:
    """Return the section of the wall force, in space or planar."""
    if case.space:
        table = Table(FORCE_IN_SPACE, [row | {"curve": row["name"]} for row in case.space.force_rows])
    notes = FORCE_NOTE, *filter(None, [case.inertial_sentence])
    return Section("Force on the wall", tables=[replace(table, notes=notes)])


def durations_table(answer: ImpactAnswer) -> Table:
    """Return the second strike's durations."""
    rows = [{"curve": filters.LABELS[name], **values} for name, values in answer.second_strike.items()]
    return Table(DURATIONS, rows, notes=(DURATIONS_NOTE,))


def _design_table(outcome: run.ImpactOutcome) -> Table:
    """Return the table of 50 ms means and design loads."""
    longitudinal = float(outcome.fe.longitudinal["mean_50ms"].max())
    case = outcome.fe_plan.case
    in_space = case.space.numbers() if case.space else None
    return design_table(case, outcome.mean_force, longitudinal, in_space)


def _design_section(case: RigidImpact, loads: Table) -> Section:
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


def _wall(outcome: run.ImpactOutcome) -> list[Table]:
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


def _paper(outcome: run.ImpactOutcome) -> list[Table]:
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


def _statements(outcome: run.ImpactOutcome) -> list[str]:
    return [
        f"Unilateral contact: {', '.join(outcome.fe_plan.case.details())}.",
        "The rigid vehicle has the same mass, centre of mass, inertia and contact; the plate is flexible (first "
        f"natural frequency {outcome.fe_plan.first_frequency:.4g} Hz).",
        *_companion_sentences(outcome.fe_plan.case),
        *chosen_sentences(outcome.fe_plan),
        *remarks(outcome.fe),
    ]


def _companion_sentences(case: RigidImpact) -> list[str]:
    """Return what differs between the motions in space and in the plane."""
    names = ", ".join(f"strip.{number}" for number in above_wall(case.scene))
    above = f"; {names} above the wall omitted" if names else ""
    return [f"{COMPANION.capitalize()}{above}."] if case.space else []


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


def omitted_parts(scene: Scene, pictures: bool = True) -> list[tuple[str, str]]:
    """List the parts that this scene does not use, with reasons."""
    contact = scene.needed_contact
    parts = [
        (contact.friction, "friction", "contact.friction is 0: no friction code in the time loop"),
        (scene.strip or not scene.crushes, "strips", "no [[strip]]: only the corners make contact"),
        (scene.damping, "damping", "not requested: no damping code in the time loop"),
        (scene.meshed_wall, "wall", "no mesh of the wall: the wall is rigid"),
        (scene.body, "space", "no [body] table: roll and pitch are not computed"),
        (pictures, "pictures", "--no-pictures: no animation"),
    ]
    return [(part, why) for there, part, why in parts if not there]


def _space_lines(scene: Scene) -> Lines:
    """Return the lines of `tailslap check` on [body]."""
    if scene.body is None or scene.wall is None or scene.wall.height is None:
        return {}
    profile = scene.wall.profile or "vertical"
    shape = profile if isinstance(profile, str) else f"{len(profile)} points"
    height = measure(scene.wall.height, "m", ".4g")
    return {
        "space": [f"{len(scene.axle)} axles, {len(scene.strip)} strips; wall of {height}, profile: {shape}"]
    }


def check_lines(case: RigidImpact, fe_plan: ImpactPlan | None) -> Lines:
    """Return the texts of `tailslap check` by label.

    fe_plan: None for a scene without [plate].
    """
    touch, vehicle = case.touch, case.vehicle
    is_planar = case.space is None or case.scene.plate is not None
    strikes = ", ".join(
        f"{s.corner} at {s.start:.4g} s for {'at least ' if s.cut else ''}{s.duration:.3g} s"
        for s in (case.motion.strikes if is_planar else ())
    )
    expected = {
        "companion": _companion_sentences(case) if is_planar else [],
        "strikes": [f"expected of the rigid vehicle: {strikes or 'none'}"] if is_planar else [],
    }
    speed = measure(math.hypot(touch.v_gx, touch.v_gy), "m/s", ".5g")
    lines = {
        "start": [f"first touch at {math.degrees(touch.theta):.5g} deg, {speed}"],
        "vehicle": [
            f"{measure(vehicle.mass, 'kg', 'g')}, centre of mass {measure(vehicle.front_distance, 'm', 'g')} "
            f"behind the front, yaw inertia {measure(vehicle.inertia, 'kg m^2', '.6g')}"
        ],
        **{label: sentences for label, sentences in expected.items() if sentences},
        "end": [f"{case.duration:.4g} s"],
        **_space_lines(case.scene),
        **omitted_lines(omitted_parts(case.scene)),
    }
    if fe_plan is None:
        return lines
    rows, points = round(case.duration / fe_plan.sample), fe_plan.model.parameters.contact.mobility.size
    contact = {"points": [f"{points} may touch the wall; the contact force does not limit the time step"]}
    steps = f", {rows} rows"
    if case.scene.verify.companion:
        steps += "; at least as many on the meshes for the discretisation error"
    return lines | fe_lines(fe_plan, rows, contact, steps=steps)
