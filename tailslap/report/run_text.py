"""Sentences of the report: what was run, and what it means."""

from __future__ import annotations

import math

from fem.laws.constraints import CONSTRAINTS
from fem.laws.friction import FRICTION_LAWS
from fem.laws.materials import MATERIALS
from fem.start.start_kinds import START_KINDS
from tailslap.case.corner.rigid import RigidStages
from tailslap.scene_run import Outcome
from tailslap.verification.verdict import flutter_sentence


def statements(outcome: Outcome) -> tuple[str, ...]:
    """What a reader must know beside the numbers."""
    plan = outcome.fe_plan.case
    made = [
        _picked(outcome),
        _constraint(plan),
        _material(plan),
        _pull(outcome),
        _plate_mass(outcome),
        *_chosen(outcome),
        _start(outcome),
        _deflection(outcome),
        _error(outcome),
        _convention(plan),
    ]
    return tuple(sentence for sentence in made if sentence)


def diagnosis(outcome: Outcome) -> tuple[str, ...]:
    """What is known of why a run failed: what the program chose, and what it predicted of ringing."""
    chosen = (f"Chosen by the program: {decision.shown}." for decision in outcome.fe_plan.decisions)
    return (*chosen, prediction(outcome))


def prediction(outcome: Outcome) -> str:
    """What was predicted of ringing."""
    return f"Flutter {flutter_sentence(outcome.fe_plan)}."


def is_paper_case(plan: RigidStages) -> bool:
    """Whether vehicle and start are the paper's, so that its Table 3 may stand beside the result."""
    pairs = (
        (plan.body.length, 10.0, 0.0),
        (plan.body.width, 2.438, 0.0),
        (plan.start.angle, 0.26, 0.002),
        (plan.start.omega, 0.707, 2e-4),
        (plan.start.corner_speed, 25.053, 1e-3),
        (plan.scene.corner_friction, 0.47 if plan.scene.corner.reaction == "drag" else 0.0, 0.0),
    )
    return all(math.isclose(value, paper, rel_tol=0.0, abs_tol=off) for value, paper, off in pairs)


def _picked(outcome: Outcome) -> str:
    choice = outcome.choice
    if choice is None:
        return ""
    against = {"rigid": "the exact rigid motion", "limit": "the flexible plate's own limit of fine meshes"}
    return (
        f"Picked for a tolerance of {choice.tolerance:g}: {', '.join(choice.changes)}. Its error against "
        f"{against[choice.against]} was expected to be at most {choice.expected_error:.1e}, in a time loop of "
        f"{choice.expected_seconds:.2g} s. The plate's flexibility moves the result by at most "
        f"{choice.flexibility:.1e}: the rigid solution by itself is as good as that."
    )


def _constraint(plan: RigidStages) -> str:
    law, constraint = FRICTION_LAWS[plan.scene.corner.reaction], CONSTRAINTS[plan.scene.corner.constraint]
    return (
        f"The corner is held on the wall by a two-sided slider, in the FE model by {constraint.text}, with "
        f'{law.text} (reaction "{law.name}"). It is not unilateral contact: a real wall can only push.'
    )


def _material(plan: RigidStages) -> str:
    material = plan.scene.material
    return f"The plate's material: {MATERIALS[material.law].text}." if material else ""


def _pull(outcome: Outcome) -> str:
    normal = outcome.rigid_history["reaction_normal"]
    first, last = normal[0] / 1e3, normal[normal == normal][-1] / 1e3
    return (
        f"The wall's reaction N is negative throughout, {first:.2f} kN at the start and {last:.2f} kN at the end: "
        "it pulls the corner back to the wall. Without that pull the corner would leave it."
    )


def _plate_mass(outcome: Outcome) -> str:
    plate, vehicle = outcome.fe_plan.model.mass, outcome.fe_plan.case.scene.vehicle.mass
    if abs(plate / vehicle - 1.0) < 1e-9:
        return ""
    return (
        f"The plate weighs {plate:.1f} kg, the vehicle {vehicle:.1f} kg. Rigid motion does not depend on the mass; "
        "reactions and energies do, and those of the rigid solution are given for the plate's mass here. "
        "Stages 1 and 3 use the vehicle's."
    )


def _chosen(outcome: Outcome) -> list[str]:
    said = [f"Chosen by the program: {decision.shown}." for decision in outcome.fe_plan.decisions]
    again = "The first run rang; this one was made with more damping."
    return [*said, again] if outcome.attempts > 1 else said


def _start(outcome: Outcome) -> str:
    return f"The plate starts {START_KINDS[outcome.fe_plan.plate.start].text}."


def _deflection(outcome: Outcome) -> str:
    return (
        f"Static deflection ratio {outcome.fe_plan.deflection_ratio:.1e}: so much of its way to the wall the reaction "
        "at the start moves the plate's centre. Differences of that size from the rigid motion are the plate's "
        "flexibility, in inverse proportion to its stiffness."
    )


def _error(outcome: Outcome) -> str:
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


def _convention(plan: RigidStages) -> str:
    other, impact = plan.other_convention(), plan.scene.impact
    if impact is None:
        return ""
    if other is None:
        return (
            f'Stage 1 is given for reference in the convention "{impact.convention}"; [start] overrides it.'
        )
    name, its = other
    return (
        f'Restitution follows the convention "{impact.convention}". With "{name}" the angular velocity after the '
        f"impact would be {its.start.omega:.4f} instead of {plan.start.omega:.4f} rad/s and the peak force "
        f"{its.force.peak_force / 1e3:.0f} instead of {plan.force.peak_force / 1e3:.0f} kN."
    )
