"""Finite-element model of a whole impact."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from fem.laws.contact_forces import PointCrush
from fem.laws.friction import Drag
from fem.plate import kinds
from fem.plate.properties import (
    AxleProperties,
    ContactProperties,
    Inertia,
    ModelError,
    StripProperties,
    UnitProperties,
    WallProperties,
)
from meshes import wall_mesh
from solver.impact import CrushLaw
from solver.impact.strips import strips_of_units
from tailslap.case import plate_input
from tailslap.case.case import FePlan
from tailslap.case.impact.rigid import RigidImpact
from tailslap.scene.model_tables import Plate, Wall
from tailslap.scene.schema import Scene, value_at

if TYPE_CHECKING:
    from fem.model.plate_model import PlateModel
    from fem.run.impact import FirstTouch

ACROSS, ACROSS_LINEAR = 4, 6
"""Elements across the vehicle where the scene has no number, of linear kinds as in the paper's Table 2. They are even,
because the error is estimated by half as many."""

UNSURE = "; with half as many the estimated error exceeds verify.mesh"
"""Reason for a refined mesh, after that for the coarser one."""

REDUCED_FACTOR = 0.7
"""Fraction of the stable time step of quadratic elements: without restitution four of twelve random vehicles gained
more than 1e-3 of their energy at 0.9, and none more than 1e-4 at 0.7."""

SPREAD = 0.5
"""Vehicle widths over which the forces of corners and hinges are spread: two elements. On single nodes they have no
limit of fine meshes, and each strike multiplies the difference: 7 of 100 random trains and 24 of 175 random impacts
with a plateau failed by it."""

ROUNDING = 1e-9
"""Height of the corner over the length, below which it is on the wall."""


@dataclass(frozen=True)
class ImpactPlan(FePlan):
    """Model of a run of a whole impact.

    Attributes
    ----------
    touch : FirstTouch
        Motion at t = 0.
    sample : float
        Time between rows of the history [s].
    """

    case: RigidImpact
    touch: FirstTouch
    sample: float


def make_impact_plan(case: RigidImpact, refinements: int = 0) -> ImpactPlan:
    """Choose omitted values, mesh and assemble.

    Parameters
    ----------
    case : RigidImpact
        With [plate].
    refinements : int
        A chosen mesh has twice as many elements along both sides for each of them.

    Returns
    -------
    ImpactPlan
        Ready to be integrated.

    Raises
    ------
    InputError
        For values without a possible model.
    """
    plate, decisions = chosen_plate(case.scene, refinements)
    factor = safety_factor(case.scene, plate)
    if factor != case.scene.time.safety_factor:
        why = "unloading with low restitution makes the light corner nodes of quadratic elements oscillate"
        decisions += (plate_input.Decision("time.safety_factor", factor, why),)
    why = "the force of a corner or hinge on one node has no limit of fine meshes"
    decisions += tuple(
        plate_input.Decision(key, length, why) for key, length in chosen_lengths(case.scene).items()
    )
    sample = case.sample
    model, plate = impact_model(case, plate, sample)
    plate_input.demand_steps(case.scene, case.duration, model)
    decisions = (
        *decisions,
        *plate_input.threads_decision(case.scene.time.threads, 1, "the time loop of a whole impact uses one"),
    )
    return ImpactPlan(case, plate, decisions, model, _first_touch(case), sample)


def _first_touch(case: RigidImpact) -> FirstTouch:
    """Return the motion of the plate at the rigid vehicle's first touch."""
    from fem.run.impact import FirstTouch

    touch, vehicle = case.touch, case.vehicle
    ahead, aside = vehicle.front_distance * math.sin(touch.theta), 0.5 * vehicle.width * math.cos(touch.theta)
    height = touch.y_g - ahead - aside
    height = height if abs(height) > ROUNDING * vehicle.length else 0.0
    return FirstTouch(touch.theta, touch.v_gx, touch.v_gy, touch.omega, height)


def chosen_plate(scene: Scene, refinements: int) -> tuple[Plate, tuple[plate_input.Decision, ...]]:
    """Return the plate with elements, and the decisions.

    Elements are quadratic where their kind is omitted. refinements: see `make_impact_plan`.
    """
    plate, vehicle = scene.needed_plate, scene.vehicle
    if plate.elements is not None:
        return plate, ()
    chosen = "element" in plate.model_fields_set
    element = plate.element if chosen else "quad9"
    across = ACROSS_LINEAR if kinds.ELEMENT_KINDS[element].higher_order else ACROSS
    along = 2 * max(1, min(200, round(0.5 * across * vehicle.length / vehicle.width)))
    along, across = along * 2**refinements, across * 2**refinements
    why = f"square elements, {across} across{UNSURE if refinements else ''}"
    counts = plate_input.Decision("plate.elements", (along, across), why)
    kind = plate_input.Decision("plate.element", element, "linear elements are too stiff in bending")
    plate = plate.model_copy(update={"elements": (along, across), "element": element})
    return plate, (counts,) if chosen else (counts, kind)


def chosen_lengths(scene: Scene) -> dict[str, float]:
    """Return the lengths over which forces are spread [m], by key.

    They are those of points that crush and of hinges, in a scene that has neither lengths nor elements.
    """
    if scene.needed_plate.elements is not None:
        return {}
    length = min(SPREAD * scene.vehicle.width, *(unit.length for unit in scene.units))
    keys = [f"trailer.{number}.hitch_length" for number in range(len(scene.trailer))]
    keys += ["contact.patch_length"] if scene.crushes and scene.has_points else []
    return {key: length for key in keys if value_at(scene, key) is None}


def safety_factor(scene: Scene, plate: Plate) -> float:
    """Return the fraction of the stable time step.

    It is the value of the scene, or one for this plate.
    """
    left_open = "safety_factor" not in scene.time.model_fields_set and scene.crushes
    linear = kinds.ELEMENT_KINDS[plate.element].higher_order
    return scene.time.safety_factor if linear or not left_open else REDUCED_FACTOR


def impact_model(
    case: RigidImpact, plate: Plate, longest_step: float, part: float = 1.0
) -> tuple[PlateModel, Plate]:
    """Return the model of a plate with elements.

    Besides, the plate with its modulus. part: of the time step that is taken. Raises InputError.
    """
    from fem.model.impact_model import build_impact_model

    scene = case.scene
    plate = plate_input.resolved_plate(scene, plate, plate_input.fe_mesh(scene, plate), _inertia(case, 0))
    step = plate_input.step_properties(scene, part * longest_step)
    step = replace(step, safety_factor=part * safety_factor(scene, plate))
    units = [_unit(case, plate, number) for number in range(len(scene.units))]
    try:
        wall = wall_properties(case, scene.meshed_wall) if scene.meshed_wall else None
        return build_impact_model(units, step, wall), plate
    except ModelError as error:
        raise plate_input.refusal(scene, plate, error) from None


def _inertia(case: RigidImpact, number: int) -> Inertia | None:
    """Return the inertia of a unit, None for the uniform rectangle."""
    unit, vehicle = case.scene.units[number], case.vehicles[number]
    uniform = unit.centre_of_mass is None and unit.yaw_inertia is None
    return None if uniform else Inertia(vehicle.front_distance, vehicle.inertia)


def _unit(case: RigidImpact, plate: Plate, number: int) -> UnitProperties:
    """Return a unit on this plate."""
    scene, inertia = case.scene, _inertia(case, number)
    chosen = chosen_lengths(scene)
    properties = plate_input.plate_properties(scene, plate, inertia, number)
    mesh, contact = plate_input.fe_mesh(scene, plate, number), contact_properties(case, number)
    contact = replace(contact, patch_length=chosen.get("contact.patch_length", contact.patch_length))
    axles = tuple(
        AxleProperties(axle.position, load, axle.friction, axle.cornering)
        for axle, load in zip(case.axles, case.loads, strict=True)
        if axle.unit == number
    )
    if number == 0:
        return UnitProperties(mesh, properties, contact, axles=axles)
    trailer = scene.trailer[number - 1]
    spread = trailer.hitch_length or chosen.get(f"trailer.{number - 1}.hitch_length", 0.0)
    return UnitProperties(mesh, properties, contact, trailer.hitch, trailer.kingpin, spread, axles)


def wall_properties(case: RigidImpact, wall: Wall) -> WallProperties:
    """Return a deformable wall about the rigid strikes."""
    places = [strike.position for strike in case.motion.strikes] or [0.0]
    length, depth, elements = wall.mesh
    start = 0.5 * (min(places) + max(places) - length)
    assert wall.height is not None
    assert wall.foundation_stiffness is not None
    mesh = wall_mesh(start, length, depth, elements)
    material = wall.density, wall.youngs_modulus, wall.poissons_ratio
    return WallProperties(mesh, wall.height, *material, wall.foundation_stiffness)


def contact_properties(case: RigidImpact, number: int) -> ContactProperties:
    """Return the contact properties of a unit's boundary."""
    contact = case.scene.needed_contact
    friction = Drag(contact.friction) if contact.friction > 0.0 else None
    if not case.scene.crushes:
        return ContactProperties(friction, contact.enforcement, penalty_scale=contact.penalty_scale)
    strips = strips_of_units(case.contact, case.lengths)[number]
    properties = tuple(
        StripProperties(float(strip.at[0]), float(strip.at[1]), float(strip.inset), _point_crush(strip.law))
        for strip in strips
    )
    return ContactProperties(friction, "crush", properties, patch_length=contact.patch_length or 0.0)


def _point_crush(law: CrushLaw) -> PointCrush:
    """Return the crush of a strip for the plate."""
    returned, slopes = law.restitution**2, (law.unloading_stiffness, law.hardening)
    return PointCrush(*map(float, (law.stiffness, law.initial_force, returned, law.plateau_force, *slopes)))
