"""Static models of the constrained plate."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from fem.laws.friction import FRICTION_LAWS
from fem.plate.properties import CornerProperties, ModelError, PlateProperties, StepProperties
from postprocess.comparison import quantities
from tailslap.case.corner.rigid_stages import RigidStages
from tailslap.case.plate_input import plate_properties, refusal, resolved_plate, step_properties
from tailslap.errors import InputError
from tailslap.scene.model_tables import Plate

if TYPE_CHECKING:
    import meshio

    from fem.model.plate_model import PlateModel

MIN_STEPS = 1000
"""Least number of time steps of the rigid motion, whose own error is then below 1e-6."""

CHANGE_BY_OSCILLATION = 0.5
"""Change of the result over the speed of a plate with the energy of the oscillation: 0.2 to 0.6 were measured."""

ADDED_FRICTION = 0.1
"""Increase of friction on |N| by the oscillation of an unstressed plate: 0.08 to 0.10 were measured without growth,
from a tenth to ten times the stiffness of steel."""


def fe_input(case: RigidStages, plate: Plate) -> tuple[PlateProperties, CornerProperties, StepProperties]:
    """Return properties of plate, corner and time step.

    plate: with its Young's modulus.
    """
    scene, corner, angle = case.scene, case.scene.corner, case.start.angle
    properties, step = plate_properties(scene, plate), step_properties(scene, case.duration / MIN_STEPS)
    friction = None  # compiles no friction code
    if scene.corner_friction > 0.0:
        friction = FRICTION_LAWS[corner.reaction].constants(scene.corner_friction)
    patch, ratio = corner.patch_length or 0.0, corner.damping_ratio or 0.0
    support = corner.constraint, corner.penalty_scale, patch, ratio
    return properties, CornerProperties(friction, *support, angles=(angle, 0.5 * angle, 0.0)), step


def static_model(case: RigidStages, plate: Plate, mesh: meshio.Mesh) -> PlateModel:
    """Return the model of a plate on a mesh, without its frequency.

    Raises InputError.
    """
    from fem.model import plate_model

    plate = resolved_plate(case.scene, plate, mesh)
    properties, corner, _ = fe_input(case, plate)
    try:
        return plate_model.static_model(mesh, properties, corner)
    except ModelError as error:
        raise refusal(case.scene, plate, error) from None


def oscillation_lost(case: RigidStages, energy: float, mass: float, rate: float) -> float:
    """Estimate how much damping reduces the oscillation of an unstressed plate.

    As a fraction of the speed of its centre, up to the tail-slap. energy: of the oscillation [J], that of the elastic
    state which the plate starts without; mass: of the plate [kg]; rate: of the damping [1/s].
    """
    speed = math.sqrt(2.0 * energy / mass) / abs(case.motion.strike.v_gy)
    return CHANGE_BY_OSCILLATION * speed * _decayed(case, rate)


def friction_lost(case: RigidStages, rate: float) -> float:
    """Estimate the effect of friction that damping removes.

    It is the effect on the quantities at the tail-slap of the friction by the oscillation of an unstressed plate, see
    `ADDED_FRICTION`. rate: of the damping [1/s].
    """
    scene = case.scene
    if FRICTION_LAWS[scene.corner.reaction].impulse != "normal_impulse_magnitude":
        return 0.0
    try:
        rougher = case.varied({"corner.friction": (1.0 + ADDED_FRICTION) * scene.corner_friction})
    except InputError:  # the theory has no solution for that much friction
        return math.inf
    changed = quantities.relative_difference(rougher.tail_slap, case.tail_slap)
    return quantities.largest(changed) * _decayed(case, rate)


def _decayed(case: RigidStages, rate: float) -> float:
    """Return the lost fraction of an oscillation's amplitude at the tail-slap."""
    return -math.expm1(-0.5 * rate * case.motion.strike.t)


def deflection_ratio(case: RigidStages, model: PlateModel) -> float:
    """Return the static deflection of the centre over its travel.

    The deflection is that at the start, the travel that to the wall.
    """
    from fem.start import inertia_relief

    travel, start = centre_travel(case), case.start
    return abs(inertia_relief.statics(model, start).deflection) / travel


def centre_travel(case: RigidStages) -> float:
    """Return the travel of the centre of mass to the wall [m]."""
    corner_angle = case.body.corner_angle
    return case.body.corner_radius * (math.sin(case.start.angle + corner_angle) - math.sin(corner_angle))
