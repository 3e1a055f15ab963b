"""The finite-element side of a plan: model, wall and start."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from tailslap.errors import InputError, Missing
from tailslap.fe_model import make_model, make_static_model, resolved_plate
from tailslap.plan import Plan
from tailslap.scene import Plate, Scene

if TYPE_CHECKING:
    import meshio

    from fem.model import PlateModel
    from fem.start import RigidStart

UPDATES_PER_SECOND = 2e7
"""Element updates a second that the expected cost is reckoned with; `benchmarks/speed.py` measures them."""

RICHER = {"quad4": "quad9", "quad4-reduced": "quad9", "tri3": "tri6"}
"""Elements of twice the order on the same mesh."""

RICHER_UP_TO = 20_000
"""Elements above which the mesh is judged by a coarser one."""


@dataclass(frozen=True)
class FePlan:
    """What the run integrates, and how far it may be from a rigid plate.

    plate: the scene's, with the modulus that its first frequency asks for where the scene gives that instead.
    """

    plan: Plan
    plate: Plate
    wall: meshio.Mesh | None
    model: PlateModel
    start: RigidStart
    travel: float  # way of the centre of mass towards the wall [m]
    give: float  # share of that travel that the elastic plate gives at the start
    other_give: float  # the same with richer elements on this mesh: what it differs by is the mesh's doing

    @cached_property
    def first_frequency(self) -> float:
        """First elastic frequency of the free plate in its plane [Hz]: 2 ms for 147 nodes, 0.7 s for 20 000."""
        from fem.modes import lowest_frequency

        model = self.model
        if self.plate.first_frequency is not None:
            return self.plate.first_frequency
        return lowest_frequency(model.stiffness, model.loop.mass, model.discretisation.positions)

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
    plate, wall = resolved_plate(plan, needed_plate(plan.scene)), _wall(plan)
    model, other = make_model(plan, plate), make_static_model(plan, comparable_plate(plate))
    gives = (share_given(plan, a_model) for a_model in (model, other))
    return FePlan(plan, plate, wall, model, rigid_start(plan), centre_travel(plan), *gives)


def rigid_start(plan: Plan) -> RigidStart:
    """What the plate starts from."""
    from fem.start import RigidStart

    return RigidStart(plan.start.angle, float(plan.start.omega), float(plan.start.corner_speed))


def share_given(plan: Plan, model: PlateModel) -> float:
    """The give of a model of the plate at the start, as a share of the centre's travel to the wall."""
    from fem.start import elastic_give

    return abs(elastic_give(model, rigid_start(plan))) / centre_travel(plan)


def centre_travel(plan: Plan) -> float:
    """Way [m] of the centre of mass towards the wall until the tail-slap."""
    corner_angle = plan.body.corner_angle
    return plan.body.corner_radius * (math.sin(plan.start.angle + corner_angle) - math.sin(corner_angle))


def comparable_plate(plate: Plate) -> Plate:
    """The plate by which the mesh is judged: richer elements, or where that would be large, a coarser mesh."""
    along, across = plate.elements
    if along * across > RICHER_UP_TO:
        return plate.model_copy(update={"elements": (max(1, along // 2), max(1, across // 2))})
    if plate.element in RICHER:
        return plate.model_copy(update={"element": RICHER[plate.element]})
    return plate.model_copy(update={"elements": (2 * along, 2 * across)})


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
