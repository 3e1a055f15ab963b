"""The finite-element model of a scene: mesh, plate, corner and time step from its tables."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tailslap.errors import InputError
from tailslap.plan import Plan
from tailslap.scene import Plate, Scene

if TYPE_CHECKING:
    import meshio

    from fem.model import CornerProperties, PlateModel, PlateProperties, StepProperties

LEAST_STEPS = 1000
"""Steps that the rigid motion needs at least, however soft the plate: its own error is then below 1e-6."""

MOST_STEPS = 2_000_000_000
"""A run above this is refused: it would take days, and its instants could not be told apart."""


REFERENCE_MODULUS = 1e9
"""Young's modulus [Pa] with which a first frequency is looked for; any would do."""


def make_model(plan: Plan, plate: Plate) -> tuple[Plate, PlateModel]:
    """Mesh and assemble; returns the plate with its modulus. Raises InputError for keys that make no model."""
    from fem.model import build_model

    scene = plan.scene
    try:
        mesh = _mesh(plan, plate)
        modulus = _modulus(plan, plate, mesh)
        model = build_model(mesh, _plate(plan, plate, modulus), _corner(plan), _step(plan))
    except ValueError as error:
        key = "corner.patch_length" if "patch" in str(error) else "plate.elements"
        given = scene.corner.patch_length if "patch" in str(error) else list(plate.elements)
        raise InputError(key, given, str(error)) from None
    if not model.loop.time_step * MOST_STEPS > plan.motion.strike.t:
        key = "youngs_modulus" if plate.first_frequency is None else "first_frequency"
        raise InputError(
            f"plate.{key}",
            getattr(plate, key),
            f"the stable time step would be {model.stable_time_step:.1e} s; allowed are at most {MOST_STEPS:g} steps",
        )
    return plate.model_copy(update={"youngs_modulus": modulus}), model


def plate_density(plan: Plan, plate: Plate) -> float:
    """The plate's density [kg/m^3]; left out, the vehicle's mass spread over the plate."""
    vehicle = plan.scene.vehicle
    return plate.density or vehicle.mass / (vehicle.length * vehicle.width * plate.thickness)


def _mesh(plan: Plan, plate: Plate) -> meshio.Mesh:
    from fem.elements import ELEMENT_KINDS
    from meshes import distorted, plate_mesh

    vehicle, cells = plan.scene.vehicle, ELEMENT_KINDS[plate.element].cells
    mesh = plate_mesh(vehicle.length, vehicle.width, plate.elements, cells)
    return distorted(mesh, plate.distortion, plate.elements) if plate.distortion else mesh


def _modulus(plan: Plan, plate: Plate, mesh: meshio.Mesh) -> float:
    """Young's modulus [Pa]: the scene's, or the one that the scene's first frequency asks for."""
    from fem.model import modulus_for

    if plate.youngs_modulus is not None:
        return plate.youngs_modulus
    assert plate.first_frequency is not None
    return modulus_for(mesh, _plate(plan, plate, REFERENCE_MODULUS), plate.first_frequency)


def _plate(plan: Plan, plate: Plate, modulus: float) -> PlateProperties:
    from fem.model import PlateProperties

    return PlateProperties(
        plate.thickness,
        plate_density(plan, plate),
        modulus,
        plate.poissons_ratio,
        lumping=plate.lumping,
        element=plate.element,
        material=plan.scene.material.law if plan.scene.material else "st-venant-kirchhoff",
        hourglass=plate.hourglass,
    )


def _corner(plan: Plan) -> CornerProperties:
    from fem.model import CornerProperties

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
    """The friction law of the scene, or None: then there is no friction code."""
    from fem.corner import Drag, Signed

    laws = {"drag": Drag, "signed": Signed}
    law, friction = laws.get(scene.corner.reaction), scene.corner_friction
    return law(friction) if law and friction > 0.0 else None


def _step(plan: Plan) -> StepProperties:
    from fem.model import StepProperties

    scene, damping = plan.scene, plan.scene.damping
    return StepProperties(
        scene.time.safety_factor,
        plan.motion.strike.t / LEAST_STEPS,
        damping_ratio=(damping.ratio or 0.0) if damping else 0.0,
        bulk_viscosity=(damping.bulk_viscosity or 0.0) if damping else 0.0,
    )
