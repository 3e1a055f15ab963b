"""The finite-element side of a plan: meshes, model and start, from the scene's tables."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from tailslap.errors import InputError, Missing
from tailslap.plan import Plan
from tailslap.scene import Plate, Scene

if TYPE_CHECKING:
    import meshio

    from fem.model import PlateModel
    from fem.start import RigidStart

LEAST_STEPS = 1000
"""Steps that the rigid motion needs at least, however soft the plate: its own error is then below 1e-6."""

MOST_STEPS = 2_000_000_000
"""A run above this is refused: it would take days, and its instants could not be told apart."""

UPDATES_PER_SECOND = 2e7
"""Element updates a second that the expected cost is reckoned with; `benchmarks/run.py` measures it."""


@dataclass(frozen=True)
class FePlan:
    """What the run integrates, and how far it may be from a rigid plate."""

    plan: Plan
    plate: Plate
    mesh: meshio.Mesh
    wall: meshio.Mesh | None
    model: PlateModel
    start: RigidStart
    give: float  # share of the centre's travel to the wall that the elastic plate gives at the start

    @property
    def expected_steps(self) -> int:
        """Steps to the rigid body's tail-slap."""
        return math.ceil(self.plan.motion.strike.t / self.model.loop.time_step)


def needed_plate(scene: Scene) -> Plate:
    """The scene's plate; InputError where it has none."""
    if scene.plate is None:
        raise InputError("plate", Missing, "a run needs this table; `tailslap rigid` does without it")
    return scene.plate


def make_fe_plan(plan: Plan) -> FePlan:
    """Mesh and assemble. Raises InputError for keys that make no model."""
    from fem.start import RigidStart, elastic_give
    from meshes import plate_mesh

    scene, plate = plan.scene, needed_plate(plan.scene)
    wall = _wall(plan)
    mesh = plate_mesh(scene.vehicle.length, scene.vehicle.width, plate.elements)
    model = _model(plan, plate, mesh)
    start = RigidStart(plan.start.angle, float(plan.start.omega), float(plan.start.corner_speed))
    travel = plan.body.corner_radius * (
        math.sin(start.angle + plan.body.corner_angle) - math.sin(plan.body.corner_angle)
    )
    give = abs(elastic_give(model, start)) / travel
    return FePlan(plan, plate, mesh, wall, model, start, give)


def plate_density(plan: Plan, plate: Plate) -> float:
    """The plate's density [kg/m^3]; left out, the vehicle's mass spread over the plate."""
    vehicle = plan.scene.vehicle
    return plate.density or vehicle.mass / (vehicle.length * vehicle.width * plate.thickness)


def _model(plan: Plan, plate: Plate, mesh: Any) -> PlateModel:
    from fem.model import PlateProperties, StepProperties, build_model

    scene, duration = plan.scene, plan.motion.strike.t
    properties = PlateProperties(
        plate.thickness, plate_density(plan, plate), plate.youngs_modulus, plate.poissons_ratio, plate.lumping
    )
    damping = scene.damping.ratio if scene.damping else 0.0
    step = StepProperties(scene.time.safety_factor, duration / LEAST_STEPS, damping)
    try:
        model = build_model(mesh, properties, scene.corner.penalty_scale, _friction(scene), step)
    except ValueError as error:
        raise InputError(
            "plate.elements", list(plate.elements), f"{error}; allowed are more elements"
        ) from None
    if not model.loop.time_step * MOST_STEPS > duration:
        raise InputError(
            "plate.youngs_modulus",
            plate.youngs_modulus,
            f"the stable time step would be {model.stable_time_step:.1e} s; allowed are at most {MOST_STEPS:g} steps",
        )
    return model


def _friction(scene: Scene) -> Any:
    """The friction law of the scene, or None: then there is no friction code."""
    from fem.corner import Drag, Signed

    laws = {"drag": Drag, "signed": Signed}
    law, friction = laws.get(scene.corner.reaction), scene.corner_friction
    return law(friction) if law and friction > 0.0 else None


def _wall(plan: Plan) -> meshio.Mesh | None:
    """The wall's mesh, with the middle of the corner's path in its middle."""
    from meshes import wall_mesh

    wall, slide = plan.scene.wall, plan.motion.strike.slide
    if wall is None:
        return None
    if wall.length < abs(slide):
        allowed = f"the corner slides {slide:.4g} m along the wall; allowed is a length of at least that"
        raise InputError("wall.length", wall.length, allowed)
    return wall_mesh(0.5 * (slide - wall.length), wall.length, wall.depth, wall.elements)
