"""Report of a whole impact on page, terminal and in files."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from postprocess.report.page import Headline, Section
from postprocess.report.tables import Table
from postprocess.units import Units, force, measure, percent_up
from tailslap.case import run_report
from tailslap.case.check import failed_names, failed_sentence
from tailslap.case.impact import checks, error, figures, run
from tailslap.case.impact import report_tables as tables
from tailslap.case.impact.answers import COMPANION, WEIGHT, remarks
from tailslap.case.impact.plan import ImpactPlan
from tailslap.case.impact.rigid import RigidImpact
from tailslap.case.impact.rigid_input import above_wall
from tailslap.case.impact.space import figures as space_figures
from tailslap.case.impact.space.answer import section
from tailslap.case.report_parts import checks_section, design_ratios, short, strikes_table
from tailslap.scene.schema import Scene

FIRST = ("t", "x_g", "y_g", "theta", "omega", "v_gx", "v_gy", "force_normal", "force_tangential")
"""Columns in front of all others."""

LEAST_CHANGE = 1e-6
"""Smallest effect of flexibility that the headline states as a bound [-]."""


@dataclass(frozen=True)
class ImpactReport(run_report.FeReport):
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
            f"{case.set_up} {run_report.plate_sentence(fe_plan)}",
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
        loads, forces, in_space = tables.loads_table(outcome), tables.force_table(outcome), list[Section]()
        if case.space:
            motion = section(case.space)
            in_space = [replace(motion, tables=[*motion.tables, tables.hinges_table(outcome, True)])]
        risk = f"Occupant risk, {'in space' if case.space else 'planar'}"
        risk += ", of the tractor" if outcome.fe.units > 1 else ""
        return [
            tables.force_section(case, forces),
            tables.design_section(case, loads),
            *in_space,
            *self._sections_in_plane(loads, forces),
            Section("Comparison with the paper's method", tables=tables.paper_table(outcome), is_folded=True),
            Section(risk, tables=[Table(tables.RISK, outcome.occupant_risk)], is_folded=True),
            Section("Model", sentences=_statements(outcome), is_folded=True),
            checks_section(outcome.checks, checks.groups(outcome)),
        ]

    def _sections_in_plane(self, loads: Table, forces: Table) -> list[Section]:
        """Return the sections of the motion in the plane.

        They are folded for a companion of the motion in space.
        """
        outcome, case = self.outcome, self.outcome.fe_plan.case
        plane = ", companion in the plane" if case.space else ""
        levels = {row["name"]: row["force"] for row in loads.rows if row["source"]}
        loops, along = figures.contact_figures(outcome)
        energy = [figures.energy_figure(outcome), *loops, *along]
        motion = [figures.position_strip(outcome.fe, case.vehicles), figures.force_figure(outcome, levels)]
        strikes = [tables.strikes_of_models(outcome), tables.errors_table(outcome)]
        strikes += [forces] if case.space else []
        train, hinges = figures.train_figures(outcome), [tables.hinges_table(outcome)]
        sections = (
            Section(f"Strikes{plane}", tables=strikes),
            Section(f"Motion and force{plane}", figures=motion, layout="tall"),
            Section(f"Units and hinges of the train{plane}", figures=train, tables=hinges, layout="wide"),
            Section(f"Energy and crush{plane}", figures=energy, layout="wide"),
        )
        durations = [tables.durations_table(outcome.fe)]
        return [
            *(replace(section, is_folded=bool(case.space)) for section in sections),
            Section("Deformable wall", tables=tables.wall_table(outcome)),
            Section(f"The second strike's duration{plane}", tables=durations, is_folded=True),
        ]

    @property
    def tables(self) -> list[Table]:
        """Design loads, strikes, hinges, forces and errors."""
        outcome, space = self.outcome, self.outcome.fe_plan.case.space
        of_motion = strikes_table({"in space": space.strikes}) if space else tables.strikes_of_models(outcome)
        return [
            short(tables.loads_table(outcome)),
            replace(of_motion, notes=()),
            tables.hinges_table(outcome, in_space=True),
            tables.force_table(outcome),
            tables.errors_table(outcome),
        ]

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
        in_space: dict[str, Any] = {}
        if case.space:
            numbers = case.space.numbers()
            in_space = {"space": numbers, "design_forces": design_ratios(case, numbers["force"]["mean_50ms"])}
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
            "wall": tables.wall_numbers(outcome),
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


def _statements(outcome: run.ImpactOutcome) -> list[str]:
    return [
        "The rigid vehicle has the same mass, centre of mass, inertia and contact; the plate is flexible.",
        *_companion_sentences(outcome.fe_plan.case),
        *run_report.chosen_sentences(outcome.fe_plan),
        *remarks(outcome.fe),
    ]


def _companion_sentences(case: RigidImpact) -> list[str]:
    """Return what differs between the motions in space and in the plane."""
    names = ", ".join(f"strip.{number}" for number in above_wall(case.scene))
    above = f"; {names} above the wall omitted" if names else ""
    return [f"{COMPANION.capitalize()}{above}."] if case.space else []


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


def _space_lines(scene: Scene) -> run_report.Lines:
    """Return the lines of `tailslap check` on [body]."""
    if scene.body is None or scene.wall is None or scene.wall.height is None:
        return {}
    profile = scene.wall.profile or "vertical"
    shape = profile if isinstance(profile, str) else f"{len(profile)} points"
    height = measure(scene.wall.height, "m", ".4g")
    return {
        "space": [f"{len(scene.axle)} axles, {len(scene.strip)} strips; wall of {height}, profile: {shape}"]
    }


def check_lines(case: RigidImpact, fe_plan: ImpactPlan | None) -> run_report.Lines:
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
        **run_report.omitted_lines(omitted_parts(case.scene)),
    }
    if fe_plan is None:
        return lines
    rows, points = round(case.duration / fe_plan.sample), fe_plan.model.parameters.contact.mobility.size
    contact = {"points": [f"{points} may touch the wall; the contact force does not limit the time step"]}
    steps = f", {rows} rows"
    if case.scene.verify.companion:
        steps += "; at least as many on the meshes for the discretisation error"
    return lines | run_report.fe_lines(fe_plan, rows, contact, steps=steps)
