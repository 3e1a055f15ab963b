"""The rigid vehicle of a whole impact: its contact, first touch and motion."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property

from postprocess.comparison.quantities import STRIKES
from solver import RigidBodyError
from solver.impact import (
    CrushLaw,
    ImpactMotion,
    ImpactState,
    ImpactVehicle,
    WallContact,
    first_touch,
    solve_impact,
)
from tailslap.case.case import WHOLE_IMPACT, Case
from tailslap.errors import InputError, Missing, Verbatim
from tailslap.progress import compiling
from tailslap.scene.schema import Contact, Scene

AFTER_SECOND = 0.1
"""Time [s] after the second strike at which an impact ends that has no time.end."""

LONGEST = 5.0
"""Time [s] after which an impact without a second strike ends."""


@dataclass(frozen=True)
class RigidImpact(Case):
    """A scene with [contact]: the rigid vehicle, its contact and first touch; its impact is solved when asked for."""

    name = WHOLE_IMPACT
    compared = STRIKES

    def __post_init__(self) -> None:
        """Raise InputError, naming the scene's key, where there is no such vehicle, or no impact."""
        if self.scene.impact is None or self.scene.contact is None:
            raise InputError("contact", Missing, "a whole impact needs this table and [impact]")
        _ = self.touch
        assert self.motion.strikes or self.scene.time.end

    @cached_property
    def vehicle(self) -> ImpactVehicle:
        """The rigid vehicle."""
        given = self.scene.vehicle
        with refusals(self.scene):
            return ImpactVehicle(
                given.length, given.width, given.mass, given.centre_of_mass, given.yaw_inertia
            )

    @cached_property
    def contact(self) -> WallContact:
        """Its laws of contact."""
        with refusals(self.scene):
            return wall_contact(self.scene, self.scene.needed_contact)

    @cached_property
    def touch(self) -> ImpactState:
        """State at first touch."""
        vehicle, contact, impact = self.vehicle, self.contact, self.scene.impact
        assert contact
        assert impact
        with refusals(self.scene):
            return first_touch(vehicle, impact.angle, impact.speed)

    @cached_property
    def motion(self) -> ImpactMotion:
        """The rigid vehicle's impact, to the scene's end."""
        return self.motion_until(self.scene.time.end)

    def motion_until(self, end: float | None) -> ImpactMotion:
        """The impact to another end [s]; None: to 0.1 s after the second strike."""
        with refusals(self.scene):
            return solve_impact(
                self.vehicle, self.contact, self.touch, end, AFTER_SECOND, LONGEST, told=compiling
            )

    @property
    def duration(self) -> float:
        """End of the rigid vehicle's impact [s]."""
        return self.motion.t_end


def wall_contact(scene: Scene, contact: Contact) -> WallContact:
    """The rigid vehicle's contact; one that does not crush has the plate's penalty at its corners, elastic."""
    if contact.stiffness is None:
        return WallContact(CrushLaw(_penalty(scene, contact), 0.0, 1.0), contact.friction)
    restitution = contact.restitution or 0.0
    side = CrushLaw(contact.side_stiffness, 0.0, restitution) if contact.side_stiffness else None
    return WallContact(
        CrushLaw(contact.stiffness, contact.initial_force, restitution), contact.friction, side
    )


def _penalty(scene: Scene, contact: Contact) -> float:
    from fem.laws.unilateral import penalty_stiffness

    plate = scene.needed_plate
    return penalty_stiffness(plate.modulus, plate.thickness, contact.penalty_scale)


KEYS = {
    **dict.fromkeys(("length", "width", "mass", "centre_of_mass", "yaw_inertia"), "vehicle"),
    **dict.fromkeys(("stiffness", "initial_force", "restitution", "friction"), "contact"),
    **dict.fromkeys(("angle", "speed"), "impact"),
    "end": "time",
}
"""Tables of the keys behind the inputs of the theory."""


@contextmanager
def refusals(scene: Scene) -> Iterator[None]:
    """Turn what the theory refuses into a message that names the scene's key."""
    try:
        yield
    except RigidBodyError as error:
        table = KEYS.get(error.key)
        key = f"{table}.{error.key}" if table else "impact"
        raise InputError(key, Verbatim(error.given), f"{error.why}; allowed: {error.allowed}") from None
