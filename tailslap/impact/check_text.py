"""What `tailslap check` says of a whole impact: what a run would use, leave out and cost."""

from __future__ import annotations

import math

from tailslap.case.impact.rigid import RigidImpact
from tailslap.case.report import fe_text, left_out_text
from tailslap.impact.fe_plan import ImpactFePlan, make_impact_fe_plan
from tailslap.scene.schema import Contact, Scene


def contact_words(contact: Contact) -> str:
    """How the vehicle touches the wall."""
    friction = f"friction {contact.friction:g}" if contact.friction else "no friction"
    if contact.stiffness is None:
        how = "a penalty spring" if contact.enforcement == "penalty" else "an exact constraint"
        return f"does not crush: {how} at each node of the boundary, which only pushes; {friction}"
    initial = f"{contact.initial_force / 1e3:g} kN + " if contact.initial_force else ""
    side = (
        f", a layer of {contact.side_stiffness / 1e6:g} MN/m^2 along the sides"
        if contact.side_stiffness
        else ""
    )
    patch = f", spread over {contact.patch_length:g} m" if contact.patch_length else ""
    return (
        f"crushes at its corners by {initial}{contact.stiffness / 1e6:g} MN/m times the depth{patch}{side}, "
        f"restitution {contact.restitution:g}; {friction}; the wall only pushes"
    )


def omitted_parts(scene: Scene, pictures: bool = True) -> list[tuple[str, str]]:
    """Parts that this scene does without, each with the reason."""
    contact, parts = scene.needed_contact, []
    if contact.friction == 0.0:
        parts.append(("friction", "contact.friction is 0: no friction code in the time loop"))
    if contact.crushes and not contact.side_stiffness:
        parts.append(("sides", "no contact.side_stiffness: the four corners alone touch"))
    if scene.damping is None:
        parts.append(("damping", "none is asked for: no damping code in the time loop"))
    if scene.wall is None:
        parts.append(("wall", "the scene has no [wall] table: the wall is rigid"))
    if not pictures:
        parts.append(("pictures", "--no-pictures: no animation"))
    return parts


def check_lines(plan: RigidImpact) -> list[str]:
    """All lines; of a scene without [plate] those that need no mesh."""
    return rigid_part(plan) + (fe_part(make_impact_fe_plan(plan)) if plan.scene.plate else [])


def rigid_part(plan: RigidImpact) -> list[str]:
    """Lines that need no mesh."""
    motion, touch = plan.motion, plan.touch
    strikes = ", ".join(f"{s.corner} at {s.start:.4g} s for {s.duration:.3g} s" for s in motion.strikes)
    lines = [
        f"{plan.scene.name}: the scene is valid",
        f"start        first touch at {math.degrees(touch.theta):.5g} deg, "
        f"{math.hypot(touch.v_gx, touch.v_gy):.5g} m/s",
        f"vehicle      {plan.vehicle.mass:g} kg, centre of mass {plan.vehicle.front_distance:g} m behind the front, "
        f"yaw inertia {plan.vehicle.inertia:.6g} kg m^2",
        f"contact      {contact_words(plan.scene.needed_contact)}",
        f"strikes      expected of the rigid vehicle: {strikes or 'none'}",
        f"end          {motion.t_end:.4g} s",
    ]
    return lines + left_out_text(omitted_parts(plan.scene))


def fe_part(fe_plan: ImpactFePlan) -> list[str]:
    """Lines on the finite-element run."""
    rows = round(fe_plan.case.duration / fe_plan.sample)
    contact = [
        f"points       {fe_plan.model.loop.contact.mobility.size} may touch the wall; their force does not bound the "
        "time step"
    ]
    steps = f", {rows} rows; as many again on richer elements, to tell the mesh's error"
    return fe_text(fe_plan, rows, "", contact, steps)
