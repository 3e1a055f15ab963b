"""Validation of a scene: each key by itself, and keys that need or exclude each other."""

from __future__ import annotations

import difflib
from typing import Any

from pydantic import ValidationError

from fem.laws import constraints
from fem.plate.kinds import ELEMENT_KINDS, LUMPINGS
from tailslap.errors import InputError, Missing, Verbatim
from tailslap.scene import meanings
from tailslap.scene.schema import Contact, Damping, Scene, Wall

OF_A_WALL_THAT_GIVES = ("height", "foundation_stiffness", "density", "youngs_modulus", "poissons_ratio")


def validate(data: dict[str, Any]) -> Scene:
    """The scene that these tables describe. Raises InputError for the first thing that is wrong."""
    scene = key_by_key(data)
    _check_together(scene)
    return scene


def key_by_key(data: dict[str, Any]) -> Scene:
    """The scene, each key valid by itself, whatever keys that need or exclude each other. Raises InputError."""
    try:
        return Scene.model_validate(data)
    except ValidationError as error:
        raise _input_error(error) from None


def _input_error(error: ValidationError) -> InputError:
    found = error.errors()
    first = next((each for each in found if each["type"] == "extra_forbidden"), found[0])
    key = ".".join(str(part) for part in first["loc"])
    kind = first["type"]
    if kind == "missing":
        return InputError(key, Missing, "this key is required")
    if kind == "extra_forbidden":
        return InputError(key, first["input"], f"there is no such key; {_known(first['loc'])}")
    if kind == "literal_error":
        return InputError(key, first["input"], f"allowed is {first['ctx']['expected']}")
    if kind in ("model_type", "model_attributes_type", "dict_type"):
        return InputError(key, first["input"], f"allowed is a table, [{key}]")
    message = first["msg"].removeprefix("Value error, ")
    return InputError(key, first["input"], message[0].lower() + message[1:])


def _known(location: tuple[int | str, ...]) -> str:
    model: Any = Scene
    for part in location[:-1]:
        kinds = model.model_fields[part].annotation
        model = next(k for k in (kinds, *getattr(kinds, "__args__", ())) if hasattr(k, "model_fields"))
    table = "".join(f"{part}." for part in location[:-1])
    near = difflib.get_close_matches(str(location[-1]), model.model_fields, 1)
    elsewhere = [key for key in meanings.MEANINGS if key.rpartition(".")[2] == location[-1]]
    hint = f"; did you mean {(table + near[0]) if near else elsewhere[0]}?" if near or elsewhere else ""
    return f"allowed are {', '.join(model.model_fields)}{hint}"


def _check_together(scene: Scene) -> None:
    """Keys that need or exclude each other."""
    if scene.contact is not None:
        check_impact(scene, scene.contact)
        _check_plate(scene)
        return
    _check_corner(scene)
    _check_plate(scene)


def _check_corner(scene: Scene) -> None:
    """Keys of the paper's three stages, with a constrained corner."""
    for key in ("vehicle.centre_of_mass", "vehicle.yaw_inertia", "time.end", "verify.mesh"):
        value = _given(scene, key)
        if value is not None:
            raise InputError(key, value, "it belongs to a whole impact, with [contact]; leave it out")
    for key in OF_A_WALL_THAT_GIVES:
        value = getattr(scene.wall, key, None)
        if scene.wall is not None and value != Wall.model_fields[key].default:
            allowed = "a wall that gives belongs to a whole impact, with [contact]; leave it out"
            raise InputError(f"wall.{key}", value, allowed)
    for key in ("friction", "restitution"):
        if scene.impact is not None and getattr(scene.impact, key) is None:
            raise InputError(f"impact.{key}", Missing, "this key is required")
    start = scene.start
    complete = start is not None and None not in (start.angle, start.omega, start.corner_speed)
    if scene.impact is None and not complete:
        raise InputError(
            "impact", Missing, "this table is required unless [start] gives angle, omega and corner_speed"
        )
    friction = scene.corner.friction
    if scene.corner.frictionless and friction is not None:
        allowed = f'it has no meaning with corner.reaction = "{scene.corner.reaction}"; leave it out'
        raise InputError("corner.friction", friction, allowed)
    if not scene.corner.frictionless and friction is None and scene.impact is None:
        raise InputError("corner.friction", Missing, "it is required where there is no impact.friction")


def _given(scene: Scene, key: str) -> Any:
    """The value that the scene gives a key of two parts; None where it leaves that to the default."""
    table, name = key.split(".")
    own = getattr(scene, table)
    return getattr(own, name) if name in own.model_fields_set else None


def _check_plate(scene: Scene) -> None:
    """Keys of the finite-element model that need or exclude each other."""
    tables = {
        "material": scene.material,
        "damping": scene.damping,
        "verify": scene.verify.model_fields_set,
        "wall": scene.wall,
        "output": scene.output,
    }
    for name, table in tables.items():
        if table and not scene.plate:
            raise InputError(name, "a table", "it has no meaning without [plate]; leave it out")
    for key in ("penalty_scale", "damping_ratio"):
        constraint = constraints.CONSTRAINTS[scene.corner.constraint]
        if key not in constraint.keys and key in scene.corner.model_fields_set:
            allowed = f'constraint = "{constraint.name}" has no spring; leave it out'
            raise InputError(f"corner.{key}", getattr(scene.corner, key), allowed)
    plate = scene.plate
    if plate and plate.youngs_modulus is None and plate.first_frequency is None:
        raise InputError("plate.youngs_modulus", Missing, "this key or plate.first_frequency is required")
    if plate and plate.youngs_modulus is not None and plate.first_frequency is not None:
        allowed = (
            "it sets the modulus; leave out this key or plate.youngs_modulus (--set plate.youngs_modulus=)"
        )
        raise InputError("plate.first_frequency", Verbatim(f"{plate.first_frequency:g} Hz"), allowed)
    if plate and LUMPINGS[plate.lumping].row_sums and not ELEMENT_KINDS[plate.element].row_sums:
        why = f"row sums of {plate.element} give its corners no mass"
        allowed = f'{why}; allowed with them is another element, or "exact"'
        raise InputError("plate.lumping", plate.lumping, allowed)
    if scene.damping:
        _check_damping(scene.damping)


def _check_damping(damping: Damping) -> None:
    if not damping.model_fields_set:
        allowed = "it needs kind, ratio or bulk_viscosity; left out, the program decides"
        raise InputError("damping", "an empty table", allowed)
    if damping.rate is not None and damping.kind != "elastic-velocity":
        raise InputError(
            "damping.rate", damping.rate, 'it belongs to kind = "elastic-velocity"; leave it out'
        )
    if damping.rate is None and damping.kind == "elastic-velocity":
        raise InputError(
            "damping.rate", Missing, 'kind = "elastic-velocity" needs it; left out, the program decides'
        )
    given = [key for key in ("ratio", "bulk_viscosity") if getattr(damping, key) is not None]
    if damping.kind == "none" and given:
        allowed = 'kind = "none" forbids all damping; leave out one of the two'
        raise InputError(f"damping.{given[0]}", getattr(damping, given[0]), allowed)


OF_THE_CORNER = {
    "corner": "a wall that only pushes has no constrained corner",
    "start": "a whole impact starts at first touch",
    "strike": "a whole impact computes its strikes",
}
"""Tables that [contact] excludes, and why."""

OF_CRUSH = ("initial_force", "restitution", "side_stiffness", "patch_length")
OF_NO_CRUSH = ("enforcement", "penalty_scale")


def check_impact(scene: Scene, contact: Contact) -> None:
    """Keys of a whole impact that need or exclude each other. Raises InputError."""
    for name, why in OF_THE_CORNER.items():
        if name in scene.model_fields_set and getattr(scene, name) is not None:
            raise InputError(name, "a table", f"{why}; leave out this table or [contact]")
    if scene.verify.tolerance is not None:
        allowed = "it belongs to a constrained corner; leave it out, or [contact]"
        raise InputError("verify.tolerance", scene.verify.tolerance, allowed)
    if scene.impact is None:
        raise InputError("impact", Missing, "a whole impact starts from this table")
    if "convention" in scene.impact.model_fields_set:
        allowed = "restitution is contact.restitution's, by its law; leave it out"
        raise InputError("impact.convention", scene.impact.convention, allowed)
    _check_contact(contact)
    _check_plate_of_impact(scene, contact)
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


def _check_plate_of_impact(scene: Scene, contact: Contact) -> None:
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
