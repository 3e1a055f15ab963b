"""Models of the plate with a constrained corner, and what statics tells of its flexibility, mesh and damping."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from fem.laws.friction import FRICTION_LAWS
from fem.plate.properties import CornerProperties, ModelError, PlateProperties, StepProperties
from postprocess.comparison import quantities
from tailslap.case.corner.rigid_stages import RigidStages
from tailslap.case.plate_input import plate_properties, refusal, resolved_plate, step_properties
from tailslap.errors import InputError
from tailslap.scene.schema import Plate

if TYPE_CHECKING:
    import meshio

    from fem.model.plate_model import PlateModel

MIN_STEPS = 1000
"""Steps that the rigid motion needs at least, however soft the plate: its own error is then below 1e-6."""

SWINGS = 0.5
"""Change of the result over the speed that the oscillation's energy would give the whole plate: 0.2 to 0.6 of it."""

RECTIFIED = 0.1
"""Friction that an unstressed plate's oscillation adds, as a fraction: the reaction swings through zero, and friction
goes with its magnitude. 0.08 to 0.10 where nothing grows, from a tenth to ten times the stiffness of steel."""


def fe_input(case: RigidStages, plate: Plate) -> tuple[PlateProperties, CornerProperties, StepProperties]:
    """Properties of the plate, which has a modulus, its corner and the time step, in the terms of `fem`."""
    scene, corner, angle = case.scene, case.scene.corner, case.start.angle
    properties, step = plate_properties(scene, plate), step_properties(scene, case.duration / MIN_STEPS)
    friction = None  # no friction code
    if scene.corner_friction > 0.0:
        friction = FRICTION_LAWS[corner.reaction].constants(scene.corner_friction)
    given = corner.constraint, corner.penalty_scale, corner.patch_length or 0.0, corner.damping_ratio or 0.0
    return properties, CornerProperties(friction, *given, angles=(angle, 0.5 * angle, 0.0)), step


def static_models(
    case: RigidStages, plates: Sequence[Plate], meshes: Sequence[meshio.Mesh]
) -> list[PlateModel]:
    """The models of plates, without what needs their frequencies, on these meshes. Raises InputError."""
    from fem.model import plate_model

    resolved = [resolved_plate(case.scene, *each) for each in zip(plates, meshes, strict=True)]
    inputs, models = [fe_input(case, plate) for plate in resolved], []
    for plate, mesh, (properties, corner, _) in zip(resolved, meshes, inputs, strict=True):
        try:
            models.append(plate_model.static_model(mesh, properties, corner))
        except ModelError as error:
            raise refusal(case.scene, plate, error) from None
    return models


def oscillation_lost(case: RigidStages, energy: float, mass: float, rate: float) -> float:
    """Estimate what damping at this rate [1/s] takes off an unstressed plate's oscillation until the strike, as a
    fraction of the speed of its centre: that oscillation has the energy [J] of the elastic state that the plate starts
    without."""
    swing = math.sqrt(2.0 * energy / mass) / abs(case.motion.strike.v_gy)
    return SWINGS * swing * _decayed(case, rate)


def friction_lost(case: RigidStages, rate: float) -> float:
    """Largest relative change of the five quantities by the friction that goes with that oscillation."""
    scene = case.scene
    if FRICTION_LAWS[scene.corner.reaction].impulse != "normal_impulse_magnitude":
        return 0.0
    try:
        more = case.varied({"corner.friction": (1.0 + RECTIFIED) * scene.corner_friction})
    except InputError:  # so much friction the theory has no solution for
        return math.inf
    changed = quantities.relative_difference(more.tail_slap, case.tail_slap)
    return quantities.largest(changed) * _decayed(case, rate)


def _decayed(case: RigidStages, rate: float) -> float:
    """Fraction of an oscillation's amplitude that damping at this rate [1/s] takes off until the strike."""
    return -math.expm1(-0.5 * rate * case.motion.strike.t)


def deflection_ratio(case: RigidStages, model: PlateModel) -> float:
    """Static deflection of the plate's centre at the start, over its travel to the wall."""
    from fem.start import inertia_relief

    return abs(inertia_relief.statics(model, case.start).deflection) / centre_travel(case)


def centre_travel(case: RigidStages) -> float:
    """Distance [m] that the centre of mass moves towards the wall until the tail-slap."""
    corner_angle = case.body.corner_angle
    return case.body.corner_radius * (math.sin(case.start.angle + corner_angle) - math.sin(corner_angle))
