"""What the plate's flexibility, its mesh and its contact spring can do to the answer, by statics."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from fem.laws.friction import FRICTION_LAWS
from fem.plate.kinds import ELEMENT_KINDS
from postprocess.comparison.quantities import largest, relative_difference
from tailslap.case.corner.rigid import RigidStages
from tailslap.errors import InputError
from tailslap.scene.schema import Plate

if TYPE_CHECKING:
    from fem.model.plate_model import PlateModel
    from fem.start.rigid_state import RigidStart

RICHER_UP_TO = 20_000
"""Elements above which the mesh is judged by a coarser one, of at most so many."""

FLAT, STEEP = 0.8, 2.6
"""Change of the result over the deflection ratio: so much at small angles, and so much more per radian of start angle.
Largest ratios seen by `benchmarks/tolerance.py --sensitivity`, with a third on top."""


SWINGS = 0.5
"""Change of the result over the speed that the oscillation's energy would give the whole plate: 0.2 to 0.6 of it."""

RECTIFIED = 0.1
"""Friction that an unstressed plate's oscillation adds, as a share: the reaction swings through zero, and friction goes
with its magnitude. 0.08 to 0.10 where nothing grows, from a tenth to ten times the stiffness of steel."""


def sensitivity(angle: float) -> float:
    """Change of the answer over the deflection ratio, at most, for a start at this angle [rad] by inertia relief."""
    return FLAT + STEEP * angle


def oscillation_lost(plan: RigidStages, energy: float, mass: float, rate: float) -> float:
    """What damping at this rate [1/s] takes off an unstressed plate's oscillation until the strike, as a share of the
    speed of its centre: that oscillation has the energy [J] of the elastic state that the plate starts without."""
    swing = math.sqrt(2.0 * energy / mass) / abs(plan.motion.strike.v_gy)
    return SWINGS * swing * _decayed(plan, rate)


def friction_lost(plan: RigidStages, rate: float) -> float:
    """Largest relative change of the five quantities by the friction that goes with that oscillation."""
    scene = plan.scene
    if FRICTION_LAWS[scene.corner.reaction].impulse != "normal_impulse_magnitude":
        return 0.0
    try:
        more = plan.varied({"corner.friction": (1.0 + RECTIFIED) * scene.corner_friction})
    except InputError:  # so much friction the theory has no solution for
        return math.inf
    return largest(relative_difference(more.tail_slap, plan.tail_slap)) * _decayed(plan, rate)


def _decayed(plan: RigidStages, rate: float) -> float:
    """Share of an oscillation's amplitude that damping at this rate [1/s] takes off until the strike."""
    return -math.expm1(-0.5 * rate * plan.motion.strike.t)


def rigid_start(plan: RigidStages) -> RigidStart:
    """What the plate starts from."""
    from fem.start.rigid_state import RigidStart

    return RigidStart(plan.start.angle, float(plan.start.omega), float(plan.start.corner_speed))


def deflection_ratio(plan: RigidStages, model: PlateModel) -> float:
    """Static deflection of the plate's centre at the start, over its travel to the wall."""
    from fem.start.inertia_relief import static_deflection

    return abs(static_deflection(model, rigid_start(plan))) / centre_travel(plan)


def centre_travel(plan: RigidStages) -> float:
    """Way [m] of the centre of mass towards the wall until the tail-slap."""
    corner_angle = plan.body.corner_angle
    return plan.body.corner_radius * (math.sin(plan.start.angle + corner_angle) - math.sin(corner_angle))


def comparable_plate(plate: Plate) -> Plate:
    """The plate by which the mesh is judged: richer elements, or where that would be large, a coarser mesh."""
    along, across = plate.counts
    if along * across > RICHER_UP_TO:
        while along * across > RICHER_UP_TO:
            along, across = max(1, along // 2), max(1, across // 2)
        return plate.model_copy(update={"elements": (along, across)})
    if richer := ELEMENT_KINDS[plate.element].richer:
        # Row sums give the corners of quadratic triangles no mass.
        return plate.model_copy(update={"element": richer, "lumping": "exact"})
    return plate.model_copy(update={"elements": (2 * along, 2 * across)})
