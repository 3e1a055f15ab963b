"""From a scene of a whole impact to a plan: the rigid vehicle's impact, solved."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property

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
from tailslap.errors import InputError, Missing, Verbatim
from tailslap.scene.schema import Contact, Scene
from tailslap.scene.vary import Source

AFTER_SECOND = 0.1
"""Time [s] after the second strike at which an impact ends that has no time.end."""

LONGEST = 5.0
"""Time [s] after which an impact without a second strike ends."""


@dataclass(frozen=True)
class ImpactPlan:
    """A scene with everything that follows from it without a mesh.

    Attributes
    ----------
    scene : Scene
        As read, SI.
    source : Source
        Where it came from.
    vehicle : ImpactVehicle
        The rigid vehicle.
    contact : WallContact
        Its laws.
    touch : ImpactState
        State at first touch.
    """

    scene: Scene
    source: Source
    vehicle: ImpactVehicle
    contact: WallContact
    touch: ImpactState

    @cached_property
    def motion(self) -> ImpactMotion:
        """The rigid vehicle's impact, to the scene's end."""
        return self.motion_until(self.scene.time.end)

    def motion_until(self, end: float | None) -> ImpactMotion:
        """The same to another end [s]; None: to 0.1 s after the second strike."""
        with refusals(self.scene):
            return solve_impact(
                self.vehicle, self.contact, self.touch, end, after_second=AFTER_SECOND, longest=LONGEST
            )


def make_impact_plan(scene: Scene, source: Source | None = None) -> ImpactPlan:
    """Solve the rigid vehicle's impact.

    Parameters
    ----------
    scene : Scene
        Of `read_scene`, with [contact].
    source : Source, optional
        Where it came from, for the report.

    Returns
    -------
    ImpactPlan
        Without mesh or finite-element model.

    Raises
    ------
    InputError
        Where there is no such vehicle, or no impact; it names the scene's key.
    """
    given, impact = scene.vehicle, scene.impact
    if impact is None or scene.contact is None:
        raise InputError("contact", Missing, "a whole impact needs this table and [impact]")
    with refusals(scene):
        vehicle = ImpactVehicle(
            given.length, given.width, given.mass, given.centre_of_mass, given.yaw_inertia
        )
        contact = wall_contact(scene, scene.contact)
        plan = ImpactPlan(
            scene,
            source or Source.of(scene),
            vehicle,
            contact,
            first_touch(vehicle, impact.angle, impact.speed),
        )
    assert plan.motion.strikes or scene.time.end
    return plan


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
    from fem.contact.unilateral import penalty_stiffness

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
