"""The paper's method beside a whole impact: its three stages, of the uniform rectangle, with its own restitution."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from tailslap.impact.answers import ImpactAnswer
from tailslap.scene.schema import Scene

if TYPE_CHECKING:
    pass

OF_A_WHOLE_IMPACT = (
    "contact",
    "plate",
    "material",
    "damping",
    "wall",
    "time",
    "vehicle.centre_of_mass",
    "vehicle.yaw_inertia",
    "impact.test_level",
)
"""What the scene of the paper's method does without."""


@dataclass(frozen=True)
class PaperMethod:
    """What the paper's method gives for the same vehicle and impact, of the uniform rectangle.

    Attributes
    ----------
    omega : float
        After Stage 1 [rad/s].
    t : float
        Time of the tail-slap [s].
    impulse : float
        Of the tail-slap, the whole mass stopped [N s].
    duration : float
        That the paper reads off crash tests [s].
    peak_force : float
        With it [N].
    computed_duration, computed_peak_force : float or None
        With the duration of the second strike as the paper would read it off the computed 50 ms mean [s], [N].
    """

    omega: float
    t: float
    impulse: float
    duration: float
    peak_force: float
    computed_duration: float | None
    computed_peak_force: float | None


def paper_method(scene: Scene, answer: ImpactAnswer) -> PaperMethod | None:
    """The paper's method beside an impact; None where [impact] does not give its friction and restitution, or where it
    has no answer."""
    from tailslap.case.corner.case import CornerCase
    from tailslap.errors import InputError
    from tailslap.scene.vary import Source, vary

    impact = scene.impact
    if impact is None or impact.friction is None or impact.restitution is None:
        return None
    try:
        plan = CornerCase(*vary(Source.of(scene), dict.fromkeys(OF_A_WHOLE_IMPACT)))
    except InputError:
        return None
    read = answer.second_strike.get("mean_50ms", {}).get("duration")
    force = plan.force
    return PaperMethod(
        float(plan.start.omega),
        float(plan.motion.strike.t),
        float(force.impulse),
        float(force.duration),
        float(force.peak_force),
        read,
        2.0 * float(force.impulse) / read if read else None,
    )
