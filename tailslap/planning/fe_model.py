"""The finite-element model of a scene: mesh, plate, corner and time step from its tables."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from tailslap.errors import InputError
from tailslap.planning.plan import Plan
from tailslap.scene.schema import Plate, Scene

if TYPE_CHECKING:
    import meshio

    from fem.discretisation.model import CornerProperties, PlateModel, PlateProperties, StepProperties

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


def held(plan: Plan, plate: Plate, static: PlateModel) -> PlateModel:
    """The static model with its corner held as the plan's scene now has it."""
    from fem.discretisation.model import held_model

    return held_model(static, _plate(plan, plate), _corner(plan))


def damped(plan: Plan, plate: Plate, model: PlateModel) -> PlateModel:
    """The model with the damping of elastic velocities that the plan's scene now has. Raises InputError."""
    from fem.discretisation.model import with_elastic_damping

    return _within_steps(plan, plate, with_elastic_damping(model, _step(plan)))


@contextmanager
def _refusals(scene: Scene, plate: Plate) -> Iterator[None]:
    """Turn what no model can be made of into a message that names the scene's key."""
    try:
        yield
    except ValueError as error:
        key = "corner.patch_length" if "patch" in str(error) else "plate.elements"
        given = scene.corner.patch_length if "patch" in str(error) else list(plate.counts)
        raise InputError(key, given, str(error)) from None


def plate_density(plan: Plan, plate: Plate) -> float:
    """The plate's density [kg/m^3]; left out, the vehicle's mass spread over the plate."""
    vehicle = plan.scene.vehicle
    return plate.density or vehicle.mass / (vehicle.length * vehicle.width * plate.thickness)


def _mesh(plan: Plan, plate: Plate) -> meshio.Mesh:
    from fem.discretisation.elements import ELEMENT_KINDS
    from meshes import distorted, plate_mesh

    vehicle, cells = plan.scene.vehicle, ELEMENT_KINDS[plate.element].cells
    mesh = plate_mesh(vehicle.length, vehicle.width, plate.counts, cells)
    return distorted(mesh, plate.distortion, plate.counts) if plate.distortion else mesh


def _plate(plan: Plan, plate: Plate) -> PlateProperties:
    from fem.discretisation.model import PlateProperties

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
    from fem.discretisation.model import CornerProperties

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
    from fem.contact.corner import Drag, Signed

    laws = {"drag": Drag, "signed": Signed}
    law, friction = laws.get(scene.corner.reaction), scene.corner_friction
    return law(friction) if law and friction > 0.0 else None


def _step(plan: Plan) -> StepProperties:
    from fem.discretisation.model import StepProperties

    scene, damping = plan.scene, plan.scene.damping
    return StepProperties(
        scene.time.safety_factor,
        plan.motion.strike.t / LEAST_STEPS,
        damping_ratio=(damping.ratio or 0.0) if damping else 0.0,
        bulk_viscosity=(damping.bulk_viscosity or 0.0) if damping else 0.0,
        elastic_rate=(damping.rate or 0.0) if damping else 0.0,
    )
