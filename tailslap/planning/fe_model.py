"""The finite-element model of a scene: mesh, plate, corner and time step from its tables."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from fem.contact.friction import FRICTION_LAWS
from fem.discretisation.element_kinds import ELEMENT_KINDS
from tailslap.errors import InputError
from tailslap.planning.plan import Plan
from tailslap.scene.schema import Plate, Scene

if TYPE_CHECKING:
    import meshio

    from fem.discretisation.model import PlateModel
    from fem.discretisation.properties import CornerProperties, PlateProperties, StepProperties

LEAST_STEPS = 1000
"""Steps that the rigid motion needs at least, however soft the plate: its own error is then below 1e-6."""

MOST_STEPS = 2_000_000_000
"""A run above this is refused: it would take days, and its instants could not be told apart."""


REFERENCE_MODULUS = 1e9
"""Young's modulus [Pa] with which a first frequency is looked for; any would do."""


def make_model(plan: Plan, plate: Plate) -> PlateModel:
    """Mesh and assemble. Raises InputError for keys that make no model."""
    plate = resolved_plate(plan, plate)
    return finished(plan, plate, make_static_model(plan, plate))


def _within_steps(plan: Plan, plate: Plate, model: PlateModel) -> PlateModel:
    """The model, unless a run of it would never end. Raises InputError."""
    if not model.loop.time_step * MOST_STEPS > plan.motion.strike.t:
        key = "youngs_modulus" if plate.first_frequency is None else "first_frequency"
        raise InputError(
            f"plate.{key}",
            getattr(plate, key),
            f"the stable time step would be {model.stable_time_step:.1e} s; allowed are at most {MOST_STEPS:g} steps",
        )
    return model


def make_static_model(plan: Plan, plate: Plate) -> PlateModel:
    """The model without what needs its frequencies. Raises InputError for keys that make no model."""
    from fem.discretisation.model import static_model

    plate = resolved_plate(plan, plate)
    with _refusals(plan.scene, plate):
        return static_model(_mesh(plan, plate), _plate(plan, plate), _corner(plan))


def resolved_plate(plan: Plan, plate: Plate) -> Plate:
    """The plate with its modulus: its own, or the one that its first frequency asks for. Raises InputError."""
    from fem.discretisation.model import modulus_for

    if plate.youngs_modulus is not None or plate.first_frequency is None:
        return plate
    reference = plate.model_copy(update={"youngs_modulus": REFERENCE_MODULUS})
    with _refusals(plan.scene, plate):
        modulus = modulus_for(_mesh(plan, plate), _plate(plan, reference), plate.first_frequency)
    return plate.model_copy(update={"youngs_modulus": modulus})


def finished(plan: Plan, plate: Plate, static: PlateModel) -> PlateModel:
    """The static model of this plate with what a run needs. Raises InputError."""
    from fem.discretisation.model import finished_model

    model = finished_model(static, _plate(plan, plate), _corner(plan), _step(plan))
    return _within_steps(plan, plate, model)


def constrained(plan: Plan, plate: Plate, static: PlateModel) -> PlateModel:
    """The static model with the constraint that the plan's scene now has."""
    from fem.discretisation.model import with_constraint

    return with_constraint(static, _plate(plan, plate), _corner(plan))


def damped(plan: Plan, plate: Plate, model: PlateModel) -> PlateModel:
    """The model with the damping of elastic velocities that the plan's scene now has. Raises InputError."""
    from fem.discretisation.model import with_elastic_damping

    return _within_steps(plan, plate, with_elastic_damping(model, _step(plan)))


@contextmanager
def _refusals(scene: Scene, plate: Plate) -> Iterator[None]:
    """Turn what no model can be made of into a message that names the scene's key."""
    from fem.discretisation.properties import ModelError

    keys = {
        "elements": ("plate.elements", list(plate.counts)),
        "patch_length": ("corner.patch_length", scene.corner.patch_length),
    }
    try:
        yield
    except ModelError as error:
        raise InputError(*keys[error.wrong], str(error)) from None


def plate_density(plan: Plan, plate: Plate) -> float:
    """The plate's density [kg/m^3]; left out, the vehicle's mass spread over the plate."""
    vehicle = plan.scene.vehicle
    return plate.density or vehicle.mass / (vehicle.length * vehicle.width * plate.thickness)


def _mesh(plan: Plan, plate: Plate) -> meshio.Mesh:
    from meshes import distorted, plate_mesh

    vehicle, cells = plan.scene.vehicle, ELEMENT_KINDS[plate.element].cells
    mesh = plate_mesh(vehicle.length, vehicle.width, plate.counts, cells)
    return distorted(mesh, plate.distortion, plate.counts) if plate.distortion else mesh


def _plate(plan: Plan, plate: Plate) -> PlateProperties:
    from fem.discretisation.properties import PlateProperties

    assert plate.youngs_modulus is not None

    return PlateProperties(
        plate.thickness,
        plate_density(plan, plate),
        plate.youngs_modulus,
        plate.poissons_ratio,
        lumping=plate.lumping,
        element=plate.element,
        material=plan.scene.material.law if plan.scene.material else "st-venant-kirchhoff",
        hourglass=plate.hourglass,
    )


def _corner(plan: Plan) -> CornerProperties:
    from fem.discretisation.properties import CornerProperties

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


def _step(plan: Plan) -> StepProperties:
    from fem.discretisation.properties import StepProperties

    scene, damping = plan.scene, plan.scene.damping
    return StepProperties(
        scene.time.safety_factor,
        plan.motion.strike.t / LEAST_STEPS,
        damping_ratio=(damping.ratio or 0.0) if damping else 0.0,
        bulk_viscosity=(damping.bulk_viscosity or 0.0) if damping else 0.0,
        elastic_rate=(damping.rate or 0.0) if damping else 0.0,
    )
