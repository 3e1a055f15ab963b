"""The finite-element side of a plan: model, wall and start."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from tailslap.case.corner.rigid import RigidStages
from tailslap.errors import InputError
from tailslap.planning.decide_constraint import decide_constraint, softened_constraint
from tailslap.planning.decide_damping import Growth, decide_damping, harms, predict_growth
from tailslap.planning.decide_mesh import Mesh, decide_mesh
from tailslap.planning.decide_threads import decide_threads
from tailslap.planning.decisions import Decision
from tailslap.planning.fe_model import demand_steps, fe_input
from tailslap.planning.flexibility import centre_travel, deflection_ratio, rigid_start
from tailslap.scene.schema import Plate

if TYPE_CHECKING:
    import meshio

    from fem.model.plate_model import PlateModel
    from fem.start.rigid_state import RigidStart


@dataclass(frozen=True)
class FePlan:
    """What the run integrates, and how far it may be from a rigid plate.

    Attributes
    ----------
    asked : RigidStages
        As given.
    case : RigidStages
        Its scene has no open ends any more.
    decisions : tuple of Decision
        What the program filled in, and why.
    growth : Growth
        Of the fastest mode by friction.
    plate : Plate
        The scene's, with the modulus that its first frequency asks for where the scene gives that instead.
    model : PlateModel
        Mesh, masses, stiffness, parameters of the time loop.
    start : RigidStart
        Rigid state at the start of Stage 2.
    travel : float
        Way of the centre of mass towards the wall [m].
    deflection_ratio : float
        Static deflection under the reaction at the start over `travel` [-].
    other_deflection_ratio : float
        The same with richer elements or another mesh [-]; what it differs by is the discretisation error.
    rang : bool
        Whether a run with less damping rang.
    """

    asked: RigidStages
    case: RigidStages
    decisions: tuple[Decision, ...]
    growth: Growth
    plate: Plate
    model: PlateModel
    start: RigidStart
    travel: float
    deflection_ratio: float
    other_deflection_ratio: float
    rang: bool = False

    @cached_property
    def first_frequency(self) -> float:
        """First elastic frequency of the free plate in its plane [Hz]: 2 ms for 147 nodes, 0.7 s for 20 000."""
        from fem.plate.elastic import lowest_frequency

        if self.plate.first_frequency is not None:
            return self.plate.first_frequency
        return lowest_frequency(self.model.elastic)

    @property
    def wall(self) -> meshio.Mesh | None:
        """The wall's mesh, with the middle of the corner's path in its middle: for pictures, the wall is rigid."""
        from meshes import wall_mesh

        wall, slide = self.case.scene.wall, self.case.motion.strike.slide
        if wall is None:
            return None
        return wall_mesh(0.5 * (slide - wall.length), wall.length, wall.depth, wall.elements)

    @cached_property
    def damping_lag(self) -> float:
        """What the damping of elastic velocities holds the corner back by, over the centre's way to the wall."""
        from fem.start.inertia_relief import damping_lag

        return damping_lag(self.model, self.start) / self.travel

    @cached_property
    def elastic_energy(self) -> float:
        """Energy [J] of the quasi-static elastic state at the start, the corner's spring included."""
        from fem.start.inertia_relief import elastic_energy

        return elastic_energy(self.model, self.start)

    @cached_property
    def spring_share(self) -> float:
        """Deflection of the corner's spring at the start over the centre's way to the wall; 0 where there is none."""
        stiffness = self.model.loop.corner.stiffness
        normal = self.case.motion_of_mass(self.model.mass).at(0.0).reaction_normal
        return abs(float(normal)) / stiffness / self.travel

    @property
    def expected_steps(self) -> int:
        """Steps to the rigid body's tail-slap."""
        return math.ceil(self.case.motion.strike.t / self.model.loop.time_step)


def make_fe_plan(plan: RigidStages, more_damping: float = 1.0) -> FePlan:
    """Decide what the scene leaves open, mesh and assemble.

    Parameters
    ----------
    plan : RigidStages
        With [plate].
    more_damping : float
        Factor on the damping that is predicted to be needed [-]; above 1 the first run rang, see `decide_damping`.

    Returns
    -------
    FePlan
        Ready to be integrated.

    Raises
    ------
    InputError
        For keys that make no model.
    """
    from fem.model.plate_model import with_elastic_damping

    asked, given = plan, plan.scene.needed_plate
    mesh, mesh_decisions = decide_mesh(plan, given)
    plate, start, travel = mesh.plate, rigid_start(plan), centre_travel(plan)
    plan = plan.with_changes({"plate.elements": plate.elements, "plate.element": plate.element})
    plan, thread_decisions = decide_threads(plan, plate)
    plan, constraint_decisions = decide_constraint(plan, plate, mesh.spring_share)
    normal = float(plan.motion_of_mass(mesh.mass).at(0.0).reaction_normal)
    model, growth = _completed(plan, mesh, normal)
    if growth.overdamps and not constraint_decisions:
        plan, constraint_decisions = softened_constraint(plan, mesh.spring_share)
        if constraint_decisions:
            model, growth = _completed(plan, mesh, normal)
    ratio = deflection_ratio(plan, model) if constraint_decisions else mesh.deflection_ratio
    harmful = harms(plan, plate, model, growth, ratio)
    plan, damping_decisions = decide_damping(plan, growth, more_damping, harmful)
    if damping_decisions:
        model = with_elastic_damping(model, fe_input(plan, plate).step)
        demand_steps(plan, plate, model)
    _demand_wall(plan)
    return FePlan(
        asked=asked,
        case=plan,
        decisions=(*mesh_decisions, *thread_decisions, *constraint_decisions, *damping_decisions),
        growth=growth,
        plate=plate,
        model=model,
        start=start,
        travel=travel,
        deflection_ratio=ratio,
        other_deflection_ratio=mesh.other_deflection_ratio,
        rang=more_damping > 1.0,
    )


def _completed(plan: RigidStages, mesh: Mesh, normal: float) -> tuple[PlateModel, Growth]:
    """The model with the plan's constraint and all that a run needs, and what is predicted to grow in it."""
    from fem.model.plate_model import finished_model, with_constraint

    given = fe_input(plan, mesh.plate)
    model = with_constraint(mesh.model, given.plate, given.corner)
    model = finished_model(model, given.plate, given.corner, given.step)
    demand_steps(plan, mesh.plate, model)
    return model, predict_growth(plan, mesh.plate, model, normal)


def _demand_wall(plan: RigidStages) -> None:
    """Raise InputError where the corner slides beyond the wall."""
    wall, slide = plan.scene.wall, plan.motion.strike.slide
    if wall is not None and wall.length < abs(slide):
        allowed = f"the corner slides {slide:.4g} m along the wall; allowed is a length of at least that"
        raise InputError("wall.length", wall.length, allowed)
