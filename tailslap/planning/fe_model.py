"""The finite-element model of a scene: mesh, plate, corner and time step from its tables."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from fem.laws.friction import FRICTION_LAWS
from fem.lazy import cached
from fem.plate.kinds import ELEMENT_KINDS
from tailslap.case.corner.rigid import RigidStages
from tailslap.case.cost import costly_key
from tailslap.errors import InputError
from tailslap.scene.schema import Plate, Scene

if TYPE_CHECKING:
    import meshio

    from fem.model.plate_model import PlateModel
    from fem.plate.kinds import (
        CornerProperties,
        Inertia,
        ModelError,
        PlateProperties,
        StepProperties,
    )

MIN_STEPS = 1000
"""Steps that the rigid motion needs at least, however soft the plate: its own error is then below 1e-6."""

MAX_STEPS = 2_000_000_000
"""A run above this is refused: it would take days, and its instants could not be told apart."""


LARGE = 10_000
"""Elements from which on a mesh is not kept."""

REFERENCE_MODULUS = 1e9
"""Young's modulus [Pa] with which a first frequency is looked for; any would do."""


@dataclass(frozen=True)
class FeInput:
    """What a model is made from, in the terms of `fem`."""

    plate: PlateProperties
    corner: CornerProperties
    step: StepProperties


def fe_input(plan: RigidStages, plate: Plate) -> FeInput:
    """Properties of the plate, its corner and the time step; the plate has a modulus."""
    return FeInput(
        plate_properties(plan.scene, plate),
        _corner(plan),
        step_properties(plan.scene, plan.motion.strike.t / MIN_STEPS),
    )


def make_model(plan: RigidStages, plate: Plate) -> PlateModel:
    """Mesh and assemble. Raises InputError for keys that make no model."""
    from fem.model.plate_model import finished_model

    mesh = fe_mesh(plan.scene, plate)
    plate = resolved_plate(plan.scene, plate, mesh)
    given = fe_input(plan, plate)
    model = finished_model(make_static_model(plan, plate, mesh), given.plate, given.corner, given.step)
    demand_steps(plan, plate, model)
    return model


def make_static_model(plan: RigidStages, plate: Plate, mesh: meshio.Mesh | None = None) -> PlateModel:
    """The model without what needs its frequencies, on this mesh or its own. Raises as `make_model`."""
    from fem.model.plate_model import static_model
    from fem.plate.kinds import ModelError

    mesh = mesh or fe_mesh(plan.scene, plate)
    given = fe_input(plan, resolved_plate(plan.scene, plate, mesh))
    try:
        return static_model(mesh, given.plate, given.corner)
    except ModelError as error:
        raise refusal(plan.scene, plate, error) from None


def resolved_plate(
    scene: Scene, plate: Plate, mesh: meshio.Mesh | None = None, inertia: Inertia | None = None
) -> Plate:
    """The plate with its modulus: its own, or the one that its first frequency asks for. Raises InputError."""
    if plate.youngs_modulus is not None or plate.first_frequency is None:
        return plate
    from fem.model.plate_model import modulus_for
    from fem.plate.kinds import ModelError

    reference = plate_properties(
        scene, plate.model_copy(update={"youngs_modulus": REFERENCE_MODULUS}), inertia
    )
    try:
        modulus = modulus_for(mesh or fe_mesh(scene, plate), reference, plate.first_frequency)
    except ModelError as error:
        raise refusal(scene, plate, error) from None
    return plate.model_copy(update={"youngs_modulus": modulus})


def fe_mesh(scene: Scene, plate: Plate) -> meshio.Mesh:
    """The plate's mesh in its body frame."""
    vehicle, cells = scene.vehicle, ELEMENT_KINDS[plate.element].cells
    make = _mesh if math.prod(plate.counts) < LARGE else _mesh.__wrapped__
    mesh: meshio.Mesh = make(vehicle.length, vehicle.width, plate.counts, cells, plate.distortion)
    return mesh


@cached("mesh")
def _mesh(length: float, width: float, counts: tuple[int, int], cells: str, distortion: float) -> meshio.Mesh:
    from meshes import distorted, plate_mesh

    mesh = plate_mesh(length, width, counts, cells)
    return distorted(mesh, distortion, counts) if distortion else mesh


def same_mesh(plate: Plate, other: Plate) -> bool:
    """Whether two plates of a vehicle have one mesh, whatever nodes their elements add to it."""
    cells = (ELEMENT_KINDS[each.element].cells for each in (plate, other))
    return plate.counts == other.counts and plate.distortion == other.distortion and len(set(cells)) == 1


def refusal(scene: Scene, plate: Plate, error: ModelError) -> InputError:
    """The message that names the scene's key where no model can be made."""
    contact, wall = scene.contact, scene.wall
    patch = contact.patch_length if contact else scene.corner.patch_length
    given = {
        "elements": ("plate.elements", list(plate.counts)),
        "patch_length": (f"{'contact' if contact else 'corner'}.patch_length", patch),
        "inertia": ("vehicle.yaw_inertia", scene.vehicle.yaw_inertia),
        "wall.elements": ("wall.elements", wall and list(wall.elements)),
        "wall.length": ("wall.length", wall and wall.length),
    }
    return InputError(*given[error.wrong], str(error))


def demand_steps(plan: RigidStages, plate: Plate, model: PlateModel) -> None:
    """Raise InputError where a run of the model would never end."""
    if model.loop.time_step * MAX_STEPS > plan.motion.strike.t:
        return
    key, given = costly_key(plan.scene, plan.motion.strike.t)
    raise InputError(
        key,
        given,
        f"the time step would be {model.loop.time_step:.1e} s; allowed are at most {MAX_STEPS:g} steps",
    )


def plate_density(scene: Scene, plate: Plate) -> float:
    """The plate's density [kg/m^3]; left out, the vehicle's mass spread over the plate."""
    vehicle = scene.vehicle
    return plate.density or vehicle.mass / (vehicle.length * vehicle.width * plate.thickness)


def plate_properties(scene: Scene, plate: Plate, inertia: Inertia | None = None) -> PlateProperties:
    """What the plate is made of; inertia: that its masses carry, where it is not the plate's own."""
    from fem.plate.kinds import PlateProperties

    return PlateProperties(
        plate.thickness,
        plate_density(scene, plate),
        plate.modulus,
        plate.poissons_ratio,
        lumping=plate.lumping,
        element=plate.element,
        material=scene.material.law if scene.material else "st-venant-kirchhoff",
        inertia=inertia,
    )


def _corner(plan: RigidStages) -> CornerProperties:
    from fem.plate.kinds import CornerProperties

    corner, angle = plan.scene.corner, plan.start.angle
    return CornerProperties(
        _friction(plan.scene),
        corner.constraint,
        corner.penalty_scale,
        patch_length=corner.patch_length or 0.0,
        damping_ratio=corner.damping_ratio or 0.0,
        angles=(angle, 0.5 * angle, 0.0),
    )


def _friction(scene: Scene) -> Any:
    """Constants of the scene's friction law, or None: then there is no friction code."""
    law, friction = FRICTION_LAWS[scene.corner.reaction], scene.corner_friction
    return law.constants(friction) if friction > 0.0 else None


def step_properties(scene: Scene, longest: float) -> StepProperties:
    """Time step, no longer than this [s], and damping."""
    from fem.plate.kinds import StepProperties

    damping = scene.damping
    return StepProperties(
        scene.time.safety_factor,
        longest,
        damping_ratio=(damping.ratio or 0.0) if damping else 0.0,
        bulk_viscosity=(damping.bulk_viscosity or 0.0) if damping else 0.0,
        elastic_rate=(damping.rate or 0.0) if damping else 0.0,
    )
