"""Whether the tables of a whole impact go together."""

from __future__ import annotations

from tailslap.errors import InputError, Missing
from tailslap.scene.schema import Contact, Scene

OF_THE_CORNER = {
    "corner": "a wall that only pushes has no constrained corner",
    "start": "a whole impact starts at first touch",
    "strike": "a whole impact computes its strikes",
    "verify": "it belongs to a constrained corner",
}
"""Tables that [contact] excludes, and why."""

OF_CRUSH = ("initial_force", "restitution", "side_stiffness", "patch_length")
OF_NO_CRUSH = ("enforcement", "penalty_scale")


def check_impact(scene: Scene, contact: Contact) -> None:
    """Keys of a whole impact that need or exclude each other. Raises InputError."""
    for name, why in OF_THE_CORNER.items():
        if name in scene.model_fields_set and getattr(scene, name) is not None:
            raise InputError(name, "a table", f"{why}; leave out this table or [contact]")
    if scene.impact is None:
        raise InputError("impact", Missing, "a whole impact starts from this table")
    if "convention" in scene.impact.model_fields_set:
        allowed = "restitution is contact.restitution's, by its law; leave it out"
        raise InputError("impact.convention", scene.impact.convention, allowed)
    _check_contact(contact)
    _check_plate(scene, contact)
    for key in ("height", "foundation_stiffness"):
        if scene.wall is not None and getattr(scene.wall, key) is None:
            allowed = "the wall of a whole impact gives, and needs it; without [wall] it is rigid"
            raise InputError(f"wall.{key}", Missing, allowed)


def _check_contact(contact: Contact) -> None:
    excluded = OF_NO_CRUSH if contact.crushes else OF_CRUSH
    why = (
        "with contact.stiffness all that touches crushes" if contact.crushes else "it needs contact.stiffness"
    )
    for key in excluded:
        if key in contact.model_fields_set:
            raise InputError(f"contact.{key}", getattr(contact, key), f"{why}; leave it out")
    if contact.crushes and contact.restitution is None:
        raise InputError("contact.restitution", Missing, "this key is required, from 0 to 1")
    if contact.enforcement == "exact" and "penalty_scale" in contact.model_fields_set:
        allowed = 'enforcement = "exact" has no spring; leave it out'
        raise InputError("contact.penalty_scale", contact.penalty_scale, allowed)


def _check_plate(scene: Scene, contact: Contact) -> None:
    plate = scene.plate
    if plate is None:
        if not contact.crushes:
            allowed = "it is required without [plate]: a rigid vehicle touches by its crush alone"
            raise InputError("contact.stiffness", Missing, allowed)
        return
    if plate.density is not None:
        allowed = "the plate of a whole impact carries vehicle.mass, on which forces depend; leave it out"
        raise InputError("plate.density", plate.density, allowed)
    if "start" in plate.model_fields_set:
        raise InputError(
            "plate.start", plate.start, "a whole impact starts at first touch, unstressed; leave it out"
        )
    if not contact.crushes and plate.youngs_modulus is None:
        allowed = "without contact.stiffness the contact takes its stiffness from this key"
        raise InputError("plate.youngs_modulus", Missing, allowed)
    vehicle = scene.vehicle
    if plate.lumping == "row-sum" and (vehicle.centre_of_mass or vehicle.yaw_inertia):
        allowed = 'with a centre of mass or yaw inertia of its own allowed is "exact"'
        raise InputError("plate.lumping", plate.lumping, allowed)
