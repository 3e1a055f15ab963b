"""What `tailslap check` says: what a run would use, leave out and cost."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from fem.laws.constraints import CONSTRAINTS
from fem.laws.friction import FRICTION_LAWS
from tailslap.case.corner.rigid import RigidStages
from tailslap.case.cost import loop_seconds
from tailslap.planning.decisions import Decision
from tailslap.planning.fe_plan import FePlan, make_fe_plan
from tailslap.report.omitted_parts import omitted_parts
from tailslap.verification.verdict import flutter_sentence

LABEL = 13
"""Columns of a label."""


def check_lines(plan: RigidStages) -> list[str]:
    """All lines; of a scene without [plate] those that need no mesh."""
    if plan.scene.plate is None:
        return rigid_part(plan)
    fe_plan = make_fe_plan(plan)
    return rigid_part(fe_plan.case) + fe_part(fe_plan)


def rigid_part(plan: RigidStages) -> list[str]:
    """Lines of `tailslap check` that need no mesh."""
    start, strike = plan.start, plan.motion.strike
    lines = [
        f"{plan.scene.name}: the scene is valid",
        f"start        angle {start.angle:.6g} rad, omega {start.omega:.6g} rad/s, "
        f"corner speed {start.corner_speed:.6g} m/s"
        + ("" if plan.stage1 is None else " (see `tailslap rigid`)"),
        f"reaction     {plan.scene.corner.reaction}, friction {plan.scene.corner_friction:g}: "
        f"{FRICTION_LAWS[plan.scene.corner.reaction].text}",
        f"tail-slap    expected at {strike.t:.6g} s after {strike.slide:.5g} m of sliding",
    ]
    return lines + [f"left out     {part}: {why}" for part, why in omitted_parts(plan.scene)]


def fe_part(fe_plan: FePlan) -> list[str]:
    """Lines of `tailslap check` on the finite-element run."""
    model, steps = fe_plan.model, fe_plan.expected_steps
    elements = model.loop.table.connectivity.shape[1]
    rows = fe_plan.case.scene.time.rows
    seconds = loop_seconds(fe_plan.case.scene, fe_plan.plate.element, fe_plan.plate.counts, steps, rows)
    return [
        f"plate        {elements} elements, {model.loop.mass.size} nodes, {model.mass:.1f} kg, "
        f"{fe_plan.plate.element}, {fe_plan.plate.lumping} masses, {fe_plan.plate.start} start",
        f"stiffness    {_stiffness(fe_plan)}",
        f"corner       {_constraint(model.loop.corner)}",
        f"frequency    {model.highest_frequency:.6g} rad/s, the highest, with the corner's constraint",
        f"time step    {model.loop.time_step:.4g} s, {model.loop.time_step / model.stable_time_step:.2f} of the "
        f"stable {model.stable_time_step:.4g} s",
        f"steps        {steps}, about {seconds:.2g} s in the time loop",
        f"flexibility  static deflection ratio {fe_plan.deflection_ratio:.1e}: the reaction moves the centre by that "
        "share of its way to the wall; expect differences of that size",
        *chosen_lines(fe_plan.decisions),
        f"flutter      {flutter_sentence(fe_plan)}",
    ]


def chosen_lines(decisions: Iterable[Decision]) -> list[str]:
    """What the program chose where the scene leaves it open."""
    return [f"chosen       {decision.shown}" for decision in decisions]


def as_numbers(scene: str, lines: list[str]) -> dict[str, Any]:
    """What the lines say, by their labels: lists of texts."""
    said: dict[str, Any] = {"scene": scene, "valid": True}
    for line in lines[1:]:
        said.setdefault(line[:LABEL].strip(), []).append(line[LABEL:])
    return said


def _stiffness(fe_plan: FePlan) -> str:
    """The modulus, and the first frequency of the free plate in its plane."""
    modulus, frequency = fe_plan.plate.youngs_modulus, fe_plan.first_frequency
    return (
        f"Young's modulus {modulus:.6g} Pa, first frequency of the free plate in its plane {frequency:.4g} Hz"
    )


def _constraint(corner: Any) -> str:
    where = "one node" if len(corner.nodes) == 1 else f"a patch of {len(corner.nodes)} nodes"
    text = CONSTRAINTS.of(corner.constraint).text
    return f"{where}, {text}" if corner.is_exact else f"{where}, {text} of {corner.stiffness:.4g} N/m"
