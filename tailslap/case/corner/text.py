"""Sentences on a constrained corner: what `tailslap check` says, the verdict on a run, and what it means."""

from __future__ import annotations

import math

from fem.laws.constraints import CONSTRAINTS
from fem.laws.friction import FRICTION_LAWS
from fem.laws.materials import MATERIALS
from fem.plate.kinds import LUMPINGS
from fem.start.start_kinds import START_KINDS
from postprocess.comparison.quantities import largest
from postprocess.units import measure
from tailslap.case.checks import failed_names
from tailslap.case.corner.checks import reaction_checks
from tailslap.case.corner.decisions import damping_is_open, suppressing_rate
from tailslap.case.corner.error import FLOOR
from tailslap.case.corner.plan import CornerPlan
from tailslap.case.corner.rigid import RigidStages
from tailslap.case.corner.run import CornerOutcome
from tailslap.case.report import chosen_sentences, fe_text, left_out_text
from tailslap.scene.schema import Scene


def omitted_parts(scene: Scene, pictures: bool = True) -> list[tuple[str, str]]:
    """Parts that this scene does without, each with the reason."""
    parts = []
    if scene.impact is None:
        parts.append(("stage 1", "the scene has no [impact] table; [start] gives the state after the impact"))
    if scene.corner.frictionless:
        parts.append(
            ("friction", f'corner.reaction is "{scene.corner.reaction}": no friction code in the time loop')
        )
    elif scene.corner_friction == 0.0:
        parts.append(("friction", "the coefficient of friction is 0: no friction code in the time loop"))
    if scene.damping is None:
        parts.append(("damping", "none is asked for and none is needed: no damping code in the time loop"))
    if scene.plate and not scene.plate.relieved:
        parts.append(
            (
                "inertia relief",
                f'plate.start is "{scene.plate.start}": the plate starts without its elastic state',
            )
        )
    if scene.plate and (fault := LUMPINGS[scene.plate.lumping].fault):
        parts.append(("exact inertia", f'plate.lumping is "{scene.plate.lumping}": {fault}'))
    if scene.wall is None:
        parts.append(("wall", "the scene has no [wall] table: no wall mesh, the wall is the line Y = 0"))
    if not pictures:
        parts.append(("pictures", "--no-pictures, or none could be drawn: VTK has no part in this result"))
    return parts


def rigid_text(case: RigidStages) -> list[str]:
    """Lines of `tailslap check` that need no mesh."""
    start, strike, reaction = case.start, case.motion.strike, case.scene.corner.reaction
    computed = "" if case.stage1 is None else " (see `tailslap rigid`)"
    return [
        f"{case.scene.name}: the scene is valid",
        f"start        angle {start.angle:.6g} rad, omega {start.omega:.6g} rad/s, "
        f"corner speed {measure(start.corner_speed, 'm/s', '.6g')}{computed}",
        f"reaction     {reaction}, friction {case.scene.corner_friction:g}: {FRICTION_LAWS[reaction].text}",
        f"tail-slap    expected at {strike.t:.6g} s after {measure(strike.slide, 'm', '.5g')} of sliding",
        *left_out_text(omitted_parts(case.scene)),
    ]


def check_text(fe_plan: CornerPlan) -> list[str]:
    """All lines of `tailslap check`."""
    model, corner = fe_plan.model, fe_plan.model.loop.corner
    where = "one node" if len(corner.nodes) == 1 else f"a patch of {len(corner.nodes)} nodes"
    stiffness = "" if corner.is_exact else f" of {measure(corner.stiffness, 'N/m', '.4g')}"
    contact = [
        f"corner       {where}, {CONSTRAINTS.of(corner.constraint).text}{stiffness}",
        f"frequency    {model.highest_frequency:.6g} rad/s, the highest, with the corner's constraint",
    ]
    flexibility = (
        f"flexibility  static deflection ratio {fe_plan.deflection_ratio:.1e}: the reaction moves the centre by that "
        "share of its way to the wall; expect differences of that size"
    )
    rows, start = fe_plan.case.scene.time.rows, f", {fe_plan.plate.start} start"
    return [
        *rigid_text(fe_plan.case),
        *fe_text(fe_plan, rows, start, contact, more=[flexibility]),
        f"flutter      {flutter_sentence(fe_plan)}",
    ]


def verdict_sentence(outcome: CornerOutcome) -> str:
    """The verdict on a run."""
    of_the_reaction = reaction_checks()
    failed = set(failed_names(outcome.checks))
    if not outcome.fe:
        return "The run did not reach the tail-slap."
    if failed - of_the_reaction - {"agreement with rigid"}:
        return "Not to be relied on: a check of the run failed."
    text = _comparison(outcome)
    if failed & of_the_reaction:
        text += " The motion is right, but the history of the reaction is not: it rings."
    if "agreement with rigid" in failed:
        text += " It does not agree with the rigid motion as closely as the scene demands."
    return text


def _comparison(outcome: CornerOutcome) -> str:
    difference, error = largest(outcome.difference), outcome.error.total
    if difference <= FLOOR:
        return f"The rigid motion is confirmed to {difference:.1e}; numerical error at most {error:.1e}."
    return (
        f"The flexible plate differs from the rigid motion by {100.0 * difference:.2g} %, "
        f"numerical error at most {error:.1e}."
    )


def flutter_sentence(fe_plan: CornerPlan) -> str:
    """Say what is predicted of a plate that rings, by friction or by rounding, and what is done against it."""
    growth, damping = fe_plan.growth, fe_plan.case.scene.damping
    judged = ", judged on coarser meshes" if growth.stand_in else ""
    needed = suppressing_rate(growth)
    if math.isnan(growth.rate):
        return "not analysed: no coarser mesh makes a model; the run's own checks watch for it"
    if not needed > 0.0 and not growth.counts:
        return "none: without friction nothing grows"
    if not needed > 0.0:
        return f"harmless: no mode grows by more than exp({growth.harmless:g}) during the run{judged}"
    text = f"the fastest mode grows by up to exp({growth.exponent:.0f}) during the run{judged}"
    if not growth.rate > 0.0:
        text = f"rounding makes the reaction ring by {100.0 * growth.ripple:.2g} %"
    if damping is not None and (damping.rate or 0.0) >= 0.5 * needed:
        return f"suppressed by damping.rate = {damping.rate:.3g} 1/s; without it {text}"
    if damping_is_open(fe_plan.asked.scene):
        return f"possible: {text}; the checks watch for it, and a run that rings is made again with damping"
    return (
        f'EXPECTED, the run will fail its checks: {text}; damping.kind = "elastic-velocity" with '
        f"damping.rate = {needed:.3g} suppresses it, and so does leaving out damping.kind"
    )


def statements(outcome: CornerOutcome) -> list[str]:
    """Sentences that a reader needs beside the numbers: what was run, and what it means."""
    fe_plan, case, material = outcome.fe_plan, outcome.fe_plan.case, outcome.fe_plan.case.scene.material
    law, constraint = FRICTION_LAWS[case.scene.corner.reaction], CONSTRAINTS[case.scene.corner.constraint]
    normal = outcome.rigid_history["reaction_normal"]
    first, last = normal[0] / 1e3, normal[normal == normal][-1] / 1e3
    made = [
        f"The corner is held on the wall by a two-sided slider, in the FE model by {constraint.text}, with "
        f'{law.text} (reaction "{law.name}"). It is not unilateral contact: a real wall can only push.',
        f"The plate's material: {MATERIALS[material.law].text}." if material else "",
        f"The wall's reaction N is negative throughout, {measure(first, 'kN', '.2f')} at the start and "
        f"{measure(last, 'kN', '.2f')} at the end: "
        "it pulls the corner back to the wall. Without that pull the corner would leave it.",
        _plate_mass(fe_plan.model.mass, case.scene.vehicle.mass),
        *chosen_sentences(fe_plan),
        "The first run rang; this one was made with more damping." if outcome.attempts > 1 else "",
        f"The plate starts {START_KINDS[fe_plan.plate.start].text}.",
        f"Static deflection ratio {fe_plan.deflection_ratio:.1e}: so much of its way to the wall the reaction "
        "at the start moves the plate's centre. Differences of that size from the rigid motion are the plate's "
        "flexibility, in inverse proportion to its stiffness.",
        _error(outcome),
        _convention(case),
    ]
    return [sentence for sentence in made if sentence]


def diagnosis(outcome: CornerOutcome) -> list[str]:
    """Sentences on why a run failed: choices of the program, and its prediction of ringing."""
    return [*chosen_sentences(outcome.fe_plan), prediction(outcome)]


def prediction(outcome: CornerOutcome) -> str:
    """Sentence on the ringing that was predicted."""
    return f"Flutter {flutter_sentence(outcome.fe_plan)}."


def is_paper_case(case: RigidStages) -> bool:
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
        "reactions and energies do, and those of the rigid solution are given for the plate's mass here. "
        "Stages 1 and 3 use the vehicle's."
    )


def _error(outcome: CornerOutcome) -> str:
    error, second = outcome.error, outcome.second
    if second is not None:
        mesh = f"a second run ({second.mesh}) with the exact constraint"
        parts = f"{error.second_run:.1e} by {mesh}, {error.damping:.1e} by damping, {error.ringing:.1e} by ringing"
    else:
        parts = (
            f"{error.mesh:.1e} by the mesh, {error.contact_spring:.1e} by the contact spring, {error.time_step:.1e} by "
            f"the time step, {error.damping:.1e} by damping, {error.ringing:.1e} by ringing"
        )
    return f"Numerical error of the five quantities at most {error.total:.1e}: {parts}."


def _convention(case: RigidStages) -> str:
    other, impact = case.other_convention(), case.scene.impact
    if impact is None:
        return ""
    if other is None:
        return (
            f'Stage 1 is given for reference in the convention "{impact.convention}"; [start] overrides it.'
        )
    name, its = other
    return (
        f'Restitution follows the convention "{impact.convention}". With "{name}" the angular velocity after the '
        f"impact would be {its.start.omega:.4f} instead of {case.start.omega:.4f} rad/s and the peak force "
        f"{measure(its.force.peak_force, 'N', '.0f', named=False)} instead of "
        f"{measure(case.force.peak_force, 'N', '.0f')}."
    )
