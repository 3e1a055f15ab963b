"""Texts on a constrained corner: headline of a run, its page, summary and terminal text, lines of `tailslap check`."""

import math
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np

from fem.laws import constraints, friction, materials
from fem.plate import kinds
from fem.start import start_kinds
from postprocess.comparison import quantities
from postprocess.report import tables
from postprocess.report.command_report import Report
from postprocess.report.page import Headline, Section
from postprocess.report.tables import Column, Table
from postprocess.units import SI, Units, measure, percent_up
from tailslap.case import run_report
from tailslap.case.case import failed_names, failed_sentence, unreliable
from tailslap.case.corner import corner_checks, decisions, rigid_stages
from tailslap.case.corner.corner_figures import curves, draw_pictures, shown_pictures
from tailslap.case.corner.corner_plan import CornerPlan
from tailslap.case.corner.numerical_error import FLOOR
from tailslap.case.corner.outcome import CornerOutcome
from tailslap.scene.schema import Scene

KICKER = "Constrained corner: finite elements compared with the exact rigid-body solution"
FOOTER = "SI units; X along the wall in the driving direction, Y away from it, ω positive where it closes the angle."
GROUPS = {
    **{kind.name: "Mechanics" for kind in corner_checks.MECHANICS},
    **{kind.name: "Work of the contact" for kind in corner_checks.CONTACT},
    **{
        kind.name: "Customary in crash analysis"
        for kind in (corner_checks.ENERGY_RATIO, *corner_checks.PRACTICE)
    },
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
    "peak, as in the analysis of variance of NCHRP W179. All are 0 for equal histories. Customary limits are wide; "
    "the program's own checks of numerical error and reaction are narrower."
)


def filled_report(
    outcome: CornerOutcome,
    folder: Path,
    pictures: bool,
    units: Units = SI,
    size: tuple[int, int] | None = None,
) -> Report:
    """Report of a run; its fields and pictures, in these units and of this size [pixels], go into the folder."""
    run_report.keep_fields(outcome, folder)
    return corner_report(draw_pictures(outcome, folder, units, size) if pictures else outcome, pictures)


def corner_report(outcome: CornerOutcome, pictures: bool) -> Report:
    """The report of a run; pictures: whether they were asked for."""
    (peaks, design), omitted = _forces(outcome), omitted_parts(outcome.fe_plan.case.scene, pictures)
    spent, why = {"pictures_s": outcome.pictures_s}, diagnosis(outcome)
    parts = sections(outcome)
    page = run_report.run_page(outcome, KICKER, headline(outcome), parts, omitted, FOOTER, why, spent)
    tables = (peaks, run_report.short(design), comparison(outcome, " "))
    drawn = f", pictures {outcome.pictures_s:.2f} s"
    lines = run_report.terminal_text(outcome, tables, [prediction(outcome)], drawn)
    return Report(page, summary(outcome, pictures), lines, histories=histories(outcome))


def histories(outcome: CornerOutcome) -> dict[str, dict[str, np.ndarray]]:
    """Histories of FE plate and rigid body by the names of their files."""
    return {"history.csv": outcome.fe_history, "rigid.csv": outcome.rigid_history}


def summary(outcome: CornerOutcome, pictures: bool) -> dict[str, Any]:
    """Content of `summary.json`, SI; what was not reached is NaN, which is written as null."""
    fe_plan = outcome.fe_plan
    alike = run_report.run_summary(outcome, headline(outcome), omitted_parts(fe_plan.case.scene, pictures))
    nothing = dict.fromkeys(quantities.KEYS, float("nan"))
    answer = fe_plan.case.rigid_numbers()
    return {
        **alike,
        "rigid": outcome.rigid,
        "fe": outcome.fe or nothing,
        "difference": outcome.difference or nothing,
        "peak_force": {"fe": outcome.lateral_force, "rigid": float(fe_plan.case.force.peak_force)},
        "numerical_error": {"total": outcome.error.total, **asdict(outcome.error)},
        "companions": [asdict(each) for each in outcome.companions],
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
    """Peak lateral force of the tail-slap by the formula of Stage 3, with the speed of plate and rigid body; and that
    of a rigid body whose restitution at the first impact follows the other convention."""
    case = outcome.fe_plan.case
    what = f"Tail-slap, triangle of {1e3 * case.scene.strike.duration:g} ms"
    found = outcome.lateral_force if outcome.fe else None
    rows: list[dict[str, Any]] = [{"what": what, "fe": found, "rigid": case.force.peak_force}]
    if other := case.other_convention():
        convention, its = other
        rows.append(
            {
                "what": f"With {rigid_stages.CONVENTIONS[convention]}",
                "fe": None,
                "rigid": its.force.peak_force,
            }
        )
    return Table(run_report.PEAKS, rows)


def comparison(outcome: CornerOutcome, title: str = "") -> Table:
    """FE beside the rigid motion, and the paper's Table 3 where the scene is the paper's."""
    of_paper = is_paper_case(outcome.fe_plan.case)
    paper = quantities.PAPER_TABLE_3 if of_paper else None
    rows = quantities.comparison_rows(outcome.fe, outcome.rigid, paper) if outcome.fe else ()
    columns = run_report.TAIL_SLAP + (PAPER if of_paper else ())
    if title:
        return Table((replace(columns[1], label="Tail-slap"), *columns[2:]), rows, title)
    note = f"Paper: {quantities.PAPER_SOURCE}, whose magnitude of v_GY is given this report's sign."
    return Table(columns, rows, notes=(note,) if of_paper else ())


def sections(outcome: CornerOutcome) -> list[Section]:
    """The parts of the page, those without content included."""
    answer = outcome.fe_plan.case.rigid_numbers()
    metrics = [{"name": f"`{name}`", **vars(item)} for name, item in outcome.metrics.items()]
    compared = Table(METRICS, metrics, notes=(METRICS_NOTE,))
    titles = {"stage1": "Stage 1: impulse at the front corner", "stage3": "Stage 3: tail-slap"}
    stages = []
    for key, title in titles.items():
        numbers = [(*rigid_stages.LABELS[name], value) for name, value in (answer[key] or {}).items()]
        stages.append(tables.pairs([(label, value, unit) for label, unit, value in numbers], title=title))
    return [
        Section("Peak lateral force", tables=_forces(outcome)),
        Section("At the tail-slap", tables=[comparison(outcome)]),
        Section("The plate at the tail-slap", figures=shown_pictures(outcome), layout="tall"),
        *curves(outcome),
        Section("Model and interpretation", sentences=statements(outcome), is_folded=True),
        run_report.checks_section(outcome.checks, GROUPS),
        Section("Histories compared with the rigid body", tables=[compared], is_folded=True),
        Section("Stages 1 and 3 of the rigid body", tables=stages, is_folded=True),
    ]


def _forces(outcome: CornerOutcome) -> list[Table]:
    return [peak_table(outcome), run_report.design_table(outcome.fe_plan.case, outcome.lateral_force)]


def omitted_parts(scene: Scene, pictures: bool = True) -> list[tuple[str, str]]:
    """Parts that this scene does without, each with the reason."""
    corner, plate = scene.corner, scene.plate
    fault = plate and kinds.LUMPINGS[plate.lumping].fault
    start, lumping = (plate.start, plate.lumping) if plate else ("", "")
    unstressed = f'plate.start is "{start}": no initial elastic state'
    no_friction = "the coefficient of friction is 0"
    if corner.frictionless:
        no_friction = f'corner.reaction is "{corner.reaction}"'
    no_impact = "no [impact] table; [start] defines the state after the impact"
    parts = [
        (scene.impact, "stage 1", no_impact),
        (
            scene.corner_friction and not corner.frictionless,
            "friction",
            f"{no_friction}: no friction code in the time loop",
        ),
        (scene.damping, "damping", "neither requested nor required: no damping code in the time loop"),
        (not plate or plate.relieved, "inertia relief", unstressed),
        (not fault, "exact inertia", f'plate.lumping is "{lumping}": {fault}'),
        (scene.wall, "wall", "no [wall] table: the wall is the line Y = 0"),
        (pictures, "pictures", "--no-pictures, or no picture could be drawn"),
    ]
    return [(part, why) for there, part, why in parts if not there]


def rigid_text(case: rigid_stages.RigidStages) -> list[str]:
    """Lines of `tailslap check` that need no mesh."""
    start, strike, reaction = case.start, case.motion.strike, case.scene.corner.reaction
    computed = "" if case.stage1 is None else " (see `tailslap rigid`)"
    return [
        f"start        angle {start.angle:.6g} rad, omega {start.omega:.6g} rad/s, "
        f"corner speed {measure(start.corner_speed, 'm/s', '.6g')}{computed}",
        f"reaction     {reaction}, friction {case.scene.corner_friction:g}: {friction.FRICTION_LAWS[reaction].text}",
        f"tail-slap    expected at {strike.t:.6g} s after {measure(strike.slide, 'm', '.5g')} of sliding",
        *run_report.omitted_text(omitted_parts(case.scene)),
    ]


def check_text(case: rigid_stages.RigidStages, fe_plan: CornerPlan | None) -> list[str]:
    """All lines of `tailslap check`; of a scene without [plate] those that need no mesh."""
    if fe_plan is None:
        return rigid_text(case)
    model, corner = fe_plan.model, fe_plan.model.loop.corner
    where = "one node" if len(corner.nodes) == 1 else f"a patch of {len(corner.nodes)} nodes"
    stiffness = "" if corner.is_exact else f" of {measure(corner.stiffness, 'N/m', '.4g')}"
    contact = [
        f"corner       {where}, {corner.text}{stiffness}",
        f"frequency    {model.highest_frequency:.6g} rad/s, the highest, with the corner's constraint",
    ]
    flexibility = (
        f"flexibility  static deflection ratio {fe_plan.deflection_ratio:.1e}: static deflection of the centre under "
        "the initial reaction, over its travel to the wall; expected order of the differences from the rigid motion"
    )
    rows, start = fe_plan.case.scene.time.rows, f", {fe_plan.plate.start} start"
    return [
        *rigid_text(fe_plan.case),
        *run_report.fe_text(fe_plan, rows, start, contact, more=[flexibility]),
        f"flutter      {flutter_sentence(fe_plan)}",
    ]


def headline(outcome: CornerOutcome) -> Headline:
    """Peak force of the tail-slap, the set-up, and the distance from rigid body and fine meshes."""
    fe_plan, case = outcome.fe_plan, outcome.fe_plan.case
    failed = set(failed_names(outcome.checks))
    sentence = case.force_sentence(outcome.lateral_force) if outcome.fe else "No tail-slap within the run."
    if outcome.fe and failed - corner_checks.reaction_checks() - {"agreement with rigid"}:
        sentence = unreliable(sentence)
    return Headline(
        case.headline().title,
        failed_sentence(outcome.checks) + sentence,
        f"{case.set_up} {run_report.plate_sentence(fe_plan)}",
        _certainty(outcome) if outcome.fe else "",
    )


def _certainty(outcome: CornerOutcome) -> str:
    difference, stated = quantities.largest(outcome.difference), "not estimated"
    if outcome.companions:
        stated = f"at most {percent_up(outcome.error.total)}"
    text = f"Finite elements and rigid-body method agree within {percent_up(difference)}"
    if not difference <= FLOOR:
        text = f"Vehicle flexibility changes the motion by at most {percent_up(difference)}"
    rings = " The motion is reliable, the history of the reaction is not."
    rings = rings if set(failed_names(outcome.checks)) & corner_checks.reaction_checks() else ""
    return f"{text}; discretisation error {stated}.{rings}{outcome.fe_plan.case.other_force()}"


def flutter_sentence(fe_plan: CornerPlan) -> str:
    """Prediction of oscillations by friction or by rounding, and the measure against them."""
    growth, damping = fe_plan.growth, fe_plan.case.scene.damping
    judged = ", judged on coarser meshes" if growth.stand_in else ""
    needed = decisions.suppressing_rate(growth)
    if math.isnan(growth.rate):
        return "not analysed: no coarser mesh is available; the checks of the run detect it"
    if not needed > 0.0 and not growth.harmless:
        return "none: without friction nothing grows"
    if not needed > 0.0:
        return f"harmless: no mode grows by more than exp({growth.harmless:g}) during the run{judged}"
    text = f"the fastest mode grows by up to exp({growth.exponent:.0f}) during the run{judged}"
    if not growth.rate > 0.0:
        text = f"rounding errors make the reaction oscillate by {100.0 * growth.ripple:.2g} %"
    if damping is not None and (damping.rate or 0.0) >= 0.5 * needed:
        return f"suppressed by damping.rate = {damping.rate:.3g} 1/s; without it {text}"
    if decisions.damping_is_open(fe_plan.asked.scene):
        return f"possible: {text}; a run in which the checks detect it is repeated with damping"
    return (
        f'EXPECTED, the run will fail its checks: {text}; damping.kind = "elastic-velocity" with '
        f"damping.rate = {needed:.3g} suppresses it, as does removing damping.kind"
    )


def statements(outcome: CornerOutcome) -> list[str]:
    """Sentences on the model and its interpretation."""
    fe_plan, case, material = outcome.fe_plan, outcome.fe_plan.case, outcome.fe_plan.case.scene.material
    law = friction.FRICTION_LAWS[case.scene.corner.reaction]
    constraint = constraints.CONSTRAINTS[case.scene.corner.constraint]
    normal = outcome.rigid_history["reaction_normal"]
    first, last = normal[0] / 1e3, normal[normal == normal][-1] / 1e3
    made = [
        f"The corner is held on the wall by a two-sided slider, in the FE model by {constraint.text}, with "
        f'{law.text} (reaction "{law.name}"). It is not unilateral contact: a real wall can only push.',
        f"The plate's material: {materials.MATERIALS[material.law].text}." if material else "",
        f"The wall's reaction N is negative throughout, {measure(first, 'kN', '.2f')} at the start and "
        f"{measure(last, 'kN', '.2f')} at the end: "
        "it pulls the corner towards the wall. With unilateral contact the corner would separate from it.",
        _plate_mass(fe_plan.model.mass, case.scene.vehicle.mass),
        *run_report.chosen_sentences(fe_plan),
        "The first run oscillated; this run has more damping." if outcome.attempts > 1 else "",
        f"The plate starts {start_kinds.START_KINDS[fe_plan.plate.start].text}.",
        f"Static deflection ratio {fe_plan.deflection_ratio:.1e}: static deflection of the centre under the initial "
        "reaction, over its travel to the wall. Differences of this order from the rigid motion are due to the plate's "
        "flexibility and inversely proportional to its stiffness.",
        _error(outcome),
        _convention(case),
    ]
    return [sentence for sentence in made if sentence]


def diagnosis(outcome: CornerOutcome) -> list[str]:
    """Sentences on the cause of a failure: choices of the program, and predicted oscillations."""
    return [*run_report.chosen_sentences(outcome.fe_plan), prediction(outcome)]


def prediction(outcome: CornerOutcome) -> str:
    """Sentence on the predicted oscillations."""
    return f"Flutter {flutter_sentence(outcome.fe_plan)}."


def is_paper_case(case: rigid_stages.RigidStages) -> bool:
    """True where vehicle and start are the paper's, so that its Table 3 may stand beside the result."""
    pairs = (
        (case.body.length, 10.0, 0.0),
        (case.body.width, 2.438, 0.0),
        (case.start.angle, 0.26, 0.002),
        (case.start.omega, 0.707, 2e-4),
        (case.start.corner_speed, 25.053, 1e-3),
        (case.scene.corner_friction, 0.47 if case.scene.corner.reaction == "drag" else 0.0, 0.0),
    )
    return all(math.isclose(value, paper, rel_tol=0.0, abs_tol=off) for value, paper, off in pairs)


def _plate_mass(plate: float, vehicle: float) -> str:
    if abs(plate / vehicle - 1.0) < 1e-9:
        return ""
    return (
        f"The plate weighs {measure(plate, 'kg', '.1f')}, the vehicle {measure(vehicle, 'kg', '.1f')}. "
        "Rigid motion does not depend on the mass; "
        "reactions and energies of the rigid solution are computed with the mass of the plate, "
        "Stages 1 and 3 with that of the vehicle."
    )


def _error(outcome: CornerOutcome) -> str:
    error = outcome.error
    if not outcome.companions:
        wanted = outcome.fe_plan.case.scene.verify.companion
        why = "no other mesh is available" if wanted and outcome.fe else "the run has no result"
        why = why if wanted else "verify.companion is false"
        return f"The numerical error is not estimated: {why}."
    meshes = " and ".join(each.mesh for each in outcome.companions)
    return (
        f"Numerical error of the five quantities at most {error.total:.1e}: mesh {error.mesh:.1e} (compared with "
        f"{meshes}), contact spring {error.contact_spring:.1e}, damping {error.damping:.1e}, rounding "
        f"{error.rounding:.1e}."
    )


def _convention(case: rigid_stages.RigidStages) -> str:
    other, impact = case.other_convention(), case.scene.impact
    if impact is None:
        return ""
    if other is None:
        return f'Stage 1, for reference, follows the convention "{impact.convention}"; [start] overrides it.'
    name, its = other
    return (
        f'Restitution follows the convention "{impact.convention}". With "{name}" the angular velocity after the '
        f"impact would be {its.start.omega:.4f} instead of {case.start.omega:.4f} rad/s and the peak force "
        f"{measure(its.force.peak_force, 'N', '.0f', named=False)} instead of "
        f"{measure(case.force.peak_force, 'N', '.0f')}."
    )
