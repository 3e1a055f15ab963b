"""Plan of a run of a constrained corner."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from fem.plate.properties import RigidStart
from meshes import wall_mesh
from tailslap.case.case import FePlan
from tailslap.case.corner import decisions
from tailslap.case.corner.rigid_stages import RigidStages
from tailslap.case.corner.static_models import centre_travel, deflection_ratio, fe_input
from tailslap.case.plate_input import demand_steps
from tailslap.errors import InputError

if TYPE_CHECKING:
    import meshio

    from fem.model.plate_model import PlateModel


@dataclass(frozen=True)
class CornerPlan(FePlan):
    """The model of a run, with estimates of its flexibility.

    The scene of its case has no open keys.

    Attributes
    ----------
    original : RigidStages
        The case before the decisions.
    growth : decisions.Growth
        Predicted growth of oscillations.
    deflection_ratio : float
        Static deflection under the reaction at the start over the centre's travel to the wall [-].
    mesh : decisions.Mesh
        The plate with its static deflections.
    rang : bool
        Whether a run with less damping oscillated.
    """

    case: RigidStages
    original: RigidStages
    growth: decisions.Growth
    deflection_ratio: float
    mesh: decisions.Mesh
    rang: bool = False

    @property
    def start(self) -> RigidStart:
        """Rigid state at the start of Stage 2."""
        return self.case.start

    @cached_property
    def first_frequency(self) -> float:
        """First elastic frequency of the free plate in its plane [Hz]."""
        return self.plate.first_frequency or super().first_frequency

    @property
    def wall(self) -> meshio.Mesh | None:
        """Mesh of the wall for pictures, centred on the corner's path."""
        wall, slide = self.case.scene.wall, self.case.motion.strike.slide
        if wall is None:
            return None
        length, depth, elements = wall.mesh
        return wall_mesh(0.5 * (slide - length), length, depth, elements)

    @cached_property
    def damping_lag(self) -> float:
        """Deflection by damping over the centre's travel to the wall [-]."""
        from fem.start.inertia_relief import damping_lag

        return damping_lag(self.model, self.start) / centre_travel(self.case)

    @cached_property
    def elastic_energy(self) -> float:
        """Static elastic energy at the start [J].

        It includes that of the corner's spring.
        """
        from fem.start.inertia_relief import elastic_energy

        return elastic_energy(self.model, self.start)

    @cached_property
    def spring_ratio(self) -> float:
        """Deflection of the spring over the centre's travel to the wall [-].

        It is 0 without a spring.
        """
        stiffness = self.model.parameters.corner.stiffness
        normal = self.case.motion_of_mass(self.model.mass).first.reaction_normal
        return abs(normal) / stiffness / centre_travel(self.case)


def make_corner_plan(
    case: RigidStages, more_damping: float = 1.0, growth: decisions.Growth | None = None
) -> CornerPlan:
    """Decide open keys, and make the model of a run.

    case: with [plate]; more_damping: factor on the predicted damping, above 1 after a run that oscillated, see
    `decisions.open_damping`. growth: of oscillations, predicted where it is None. Raises InputError for keys that make
    no model.
    """
    from fem.model import plate_model

    original = case
    mesh, chosen = decisions.decide_mesh(case, case.scene.needed_plate)
    plate = mesh.plate
    case = case.with_changes({"plate.elements": plate.elements, "plate.element": plate.element})
    threads = decisions.open_threads(case, plate)
    constraint = decisions.open_constraint(case, plate, mesh.spring_ratio)
    case = case.decided(threads + constraint)
    normal = case.motion_of_mass(mesh.mass).first.reaction_normal
    model, growth = _completed(case, mesh, normal, growth)
    softer = decisions.softer_constraint(case, mesh.spring_ratio) if growth.overdamps else ()
    if softer and not constraint:
        constraint, case = softer, case.decided(softer)
        model, growth = _completed(case, mesh, normal)
    ratio = deflection_ratio(case, model) if constraint else mesh.deflection_ratio
    harmful = decisions.harms(case, plate, model, growth, ratio)
    damping = decisions.open_damping(case, growth, more_damping, harmful)
    if damping:
        case = case.decided(damping)
        model = plate_model.with_elastic_damping(model, fe_input(case, plate)[2])
        demand_steps(case.scene, case.duration, model)
    _demand_wall(case)
    return CornerPlan(
        case=case,
        plate=plate,
        decisions=chosen + threads + constraint + damping,
        model=model,
        original=original,
        growth=growth,
        deflection_ratio=ratio,
        mesh=mesh,
        rang=more_damping > 1.0,
    )


def _completed(
    case: RigidStages, mesh: decisions.Mesh, normal: float, growth: decisions.Growth | None = None
) -> tuple[PlateModel, decisions.Growth]:
    """Return the finished model and the predicted growth of oscillations."""
    from fem.model import plate_model

    plate, corner, step = fe_input(case, mesh.plate)
    constrained = plate_model.with_constraint(mesh.model, plate, corner)
    model = plate_model.finished_model(constrained, plate, corner, step)
    demand_steps(case.scene, case.duration, model)
    return model, growth or decisions.predict_growth(case, mesh.plate, model, normal)


def _demand_wall(case: RigidStages) -> None:
    """Raise InputError for sliding beyond the wall."""
    wall, slide = case.scene.wall, case.motion.strike.slide
    if wall is not None and wall.mesh[0] < abs(slide):
        allowed = f"the corner slides {slide:.4g} m along the wall; allowed is a length of at least that"
        raise InputError("wall.length", wall.length, allowed)
