"""Validate keys and combinations of keys."""

import re
from collections.abc import Callable, Mapping
from typing import Any

from pydantic import ValidationError

from fem.laws import constraints
from fem.laws.friction import FRICTION_LAWS
from fem.plate.kinds import ELEMENT_KINDS, LUMPINGS
from tailslap.errors import InputError, Missing, Verbatim, nearest
from tailslap.scene import impact_keys, schema
from tailslap.scene.model_tables import Damping, Wall
from tailslap.scene.parapet_keys import check_parapet

SPACE_REQUIRED = {
    "trailer": ("hitch_height",),
    "axle": ("track", "radius", "mass", "spring", "spacing", "tyre"),
}
"""Keys of lists of tables that are required with [body]."""

SUBSTITUTES = {
    "impact.speed": "[start] with angle, omega and corner_speed may replace [impact]",
    "plate.youngs_modulus": "plate.first_frequency may replace plate.youngs_modulus",
    "contact.stiffness": "contact.strike_duration may replace it; neither is required with [plate], or where [[strip]] "
    "says what of each unit can touch the wall",
    "contact.restitution": "contact.unloading_stiffness may replace it",
    "wall.height": "without [wall] the wall of a whole impact is rigid",
}
"""Alternatives to missing keys."""

IMPACT_KEYS = ("vehicle.centre_of_mass", "vehicle.yaw_inertia", "time.end", "verify.mesh")
"""Keys that require [contact]."""

FORMER_KEYS = re.compile(
    rf"contact\.(rear|side_stiffness)|trailer\.\d+\.({'|'.join(impact_keys.LAW)}|rear)(\.\w+)?"
)
"""Keys of contacts that `[[strip]]` replaced."""


def validate(data: Mapping[str, object]) -> schema.Scene:
    """Return the scene of these tables.

    Raises InputError for missing keys or the first invalid one.
    """
    _demand_heights(data)
    scene = key_by_key(data)
    if missing := missing_keys(data):
        raise _missing_error(missing)
    if scene.contact is not None:
        impact_keys.check_impact(scene, scene.contact)
    else:
        _check_corner(scene)
    _check_plate(scene)
    if scene.parapet is not None:
        check_parapet(scene, scene.parapet)
    return impact_keys.with_crush_stiffness(scene)


def _demand_heights(data: Mapping[str, object]) -> None:
    """Require heights of all strips with [body], and of none without it.

    A strip without heights has other units, so that this comes first. Raises InputError.
    """
    strips = data.get("strip")
    for number, strip in enumerate(strips if isinstance(strips, list | tuple) else ()):
        height = strip.get("height") if isinstance(strip, Mapping) else None
        if height is None and data.get("body") and isinstance(strip, Mapping):
            raise InputError(
                f"strip.{number}.height", Missing, "this key is required: with [body] a strip has heights"
            )
        if height is not None and not data.get("body"):
            raise InputError(f"strip.{number}.height", height, "this key requires [body]; remove it")


def key_by_key(data: Mapping[str, object]) -> schema.Scene:
    """Return the scene with separately validated keys.

    Raises InputError.
    """
    try:
        return schema.Scene.model_validate(data)
    except ValidationError as error:
        raise _input_error(error, data) from None


def missing_keys(tables: Mapping[str, object]) -> list[str]:
    """Return dotted names of missing keys."""

    def absent(*keys: str) -> list[str]:
        return [key for key in keys if value_in(tables, key) is None]

    present = {"vehicle"} | {name for name in schema.TABLES if tables.get(name) not in (None, [], ())}
    if absent("start.angle", "start.omega", "start.corner_speed") or "contact" in present:
        present.add("impact")
    frictionless = [law.name for law in FRICTION_LAWS.values() if law.frictionless]
    missing = absent("name")
    for name in (name for name in schema.TABLES if name in present):
        units = tables[name] if name in schema.LISTED else ()
        places = [f"{name}.{i}" for i in range(len(units))] if isinstance(units, list | tuple) else []
        required = [key for key, field in schema.TABLES[name].model_fields.items() if field.is_required()]
        missing += absent(*(f"{place}.{key}" for place in places or [name] for key in required))
    if "contact" in present:
        unloads = len(absent("contact.restitution", "contact.unloading_stiffness")) < 2
        crushes = len(absent("contact.stiffness", "contact.strike_duration")) < 2
        missing += absent("contact.restitution") if crushes and not unloads else []
        missing += absent("contact.stiffness") if not {"plate", "strip"} & present and not crushes else []
        missing += _missing_of_wall(present, absent)
        if "body" in present:
            missing += [
                f"{name}.{number}.{key}"
                for name, keys in SPACE_REQUIRED.items()
                for number in range(len(tables.get(name) or ()))  # type: ignore[arg-type]  # lists of tables
                for key in keys
                if value_in(tables, f"{name}.{number}.{key}") is None
            ]
    elif "impact" in present:
        missing += absent("impact.friction", "impact.restitution")
    elif value_in(tables, "corner.reaction") not in frictionless:
        missing += absent("corner.friction")
    if "wall" in present and "contact" not in present:
        missing += absent(*(f"wall.{key}" for key in impact_keys.OF_MESH))
    if "plate" in present and absent("plate.first_frequency"):
        missing += absent("plate.youngs_modulus")
    if value_in(tables, "damping.kind") == "elastic-velocity":
        missing += absent("damping.rate")
    return missing


def _missing_of_wall(present: set[str], absent: Callable[..., list[str]]) -> list[str]:
    """Return missing keys of the wall of a whole impact."""
    if "body" in present:
        return absent("wall.height")
    if "wall" in present:
        return absent(*(f"wall.{key}" for key in (*impact_keys.OF_MESH, "height", "foundation_stiffness")))
    return []


def value_in(tables: object, key: str) -> Any:
    """Return the value of a dotted key of tables, None without it."""
    for name in key.split("."):
        if isinstance(tables, list | tuple):
            tables = dict(enumerate(tables)).get(int(name)) if name.isdecimal() else None
        else:
            tables = tables.get(name) if isinstance(tables, Mapping) else None
    return tables


def _missing_error(keys: list[str]) -> InputError:
    """Return the error for missing keys."""
    first, *more = keys
    required = f"this key is required, and so are {', '.join(more)}" if more else "this key is required"
    return InputError(
        first, Missing, "; ".join([required, *(SUBSTITUTES[k] for k in keys if k in SUBSTITUTES)])
    )


def _input_error(error: ValidationError, data: Mapping[str, object]) -> InputError:
    """Return the error for an unknown key, else the first error."""
    details = error.errors()
    first = next((detail for detail in details if detail["type"] == "extra_forbidden"), details[0])
    key = ".".join(str(part) for part in first["loc"])
    kind = first["type"]
    if kind == "missing":
        return _missing_error(missing_keys(data))
    if kind == "extra_forbidden" and FORMER_KEYS.fullmatch(key):
        return InputError(key, first["input"], _replacement(first["loc"]))
    if kind == "extra_forbidden":
        return InputError(key, first["input"], f"this key does not exist; {_allowed_keys(first['loc'])}")
    if kind == "literal_error":
        return InputError(key, first["input"], f"allowed is {first['ctx']['expected']}")
    if kind == "tuple_type" and key in schema.LISTED:
        return InputError(
            key, first["input"], f"allowed is a list of tables, [[{key}]], numbered {key}.0, {key}.1, ..."
        )
    if kind in ("model_type", "model_attributes_type", "dict_type"):
        return InputError(key, first["input"], f"allowed is a table, [{key}]")
    message = first["msg"].removeprefix("Value error, ")
    return InputError(key, first["input"], message[0].lower() + message[1:])


def _replacement(location: tuple[int | str, ...]) -> str:
    """Return the keys of [[strip]] that replace a former key."""
    unit = int(location[1]) + 2 if location[0] == "trailer" else 1
    places = (
        'at = "0 m" and at = its length' if location[0] == "trailer" else "at = the length of the vehicle"
    )
    if location[-1] == "side_stiffness":
        places = "at = two places"
    name = {"plateau_force": "plateau", "rear": "stiffness", "side_stiffness": "stiffness"}
    key = name.get(str(location[-1]), location[-1])
    of_unit = f"unit = {unit}, " if unit > 1 else ""
    with_keys = f"{of_unit}{places}, and {key}"
    return f"this key is replaced by [[strip]] with {with_keys}; a unit with strips has no other contacts"


def _allowed_keys(location: tuple[int | str, ...]) -> str:
    """List the allowed keys of the table of an unknown key."""
    *table, name = map(str, location)
    place = ".".join(part for part in table if not part.isdecimal())
    keys = (schema.TABLES[place] if table else schema.Scene).model_fields
    elsewhere = [key for key in schema.MEANINGS if key.rpartition(".")[2] == name]
    hint = nearest(name, keys, ".".join([*table, "{}"]))
    return (
        f"allowed are {', '.join(keys)}{hint or ''.join(f'; did you mean {key}?' for key in elsewhere[:1])}"
    )


def _check_corner(scene: schema.Scene) -> None:
    """Validate keys of a constrained corner."""
    impact_keys.refuse(scene, "this key requires [contact]; remove it", *IMPACT_KEYS)
    for name in ("body", "sensor"):
        if getattr(scene, name):
            raise InputError(name, Verbatim("a table"), "this table requires [contact]; remove it")
    for name in ("axle", "strip"):
        if tables := getattr(scene, name):
            why = "these tables require [contact]; remove them"
            raise InputError(name, Verbatim(f"{len(tables)} tables"), why)
    if scene.trailer:
        why = (
            "a constrained corner is that of one rigid body; a train requires [contact] in place of [corner]"
        )
        raise InputError("trailer", f"{len(scene.trailer)} tables", why)
    for key in impact_keys.ELASTIC_WALL_KEYS:
        value = getattr(scene.wall, key, None)
        if scene.wall is not None and value != Wall.model_fields[key].default:
            allowed = "an elastic wall requires [contact]; remove this key"
            raise InputError(f"wall.{key}", value, allowed)
    friction = scene.corner.friction
    if scene.corner.frictionless and friction is not None:
        allowed = f'this key has no effect with corner.reaction = "{scene.corner.reaction}"; remove it'
        raise InputError("corner.friction", friction, allowed)


def _check_plate(scene: schema.Scene) -> None:
    """Validate keys of the finite-element model."""
    tables = {
        "material": scene.material,
        "damping": scene.damping,
        "verify": scene.verify.model_fields_set,
        "wall": scene.wall if scene.body is None else None,
        "output": scene.output,
    }
    for name, table in tables.items():
        if table and not scene.plate:
            raise InputError(name, "a table", "this table has no effect without [plate]; remove it")
    constraint = constraints.CONSTRAINTS[scene.corner.constraint]
    of_springs = [f"corner.{key}" for key in ("penalty_scale", "damping_ratio") if key not in constraint.keys]
    impact_keys.refuse(
        scene, f'corner.constraint = "{constraint.name}" has no spring; remove this key', *of_springs
    )
    plate = scene.plate
    if plate and plate.youngs_modulus is not None and plate.first_frequency is not None:
        allowed = (
            "it defines the modulus; remove this key or plate.youngs_modulus (--set plate.youngs_modulus=)"
        )
        raise InputError("plate.first_frequency", Verbatim(f"{plate.first_frequency:g} Hz"), allowed)
    if plate and LUMPINGS[plate.lumping].row_sums and not ELEMENT_KINDS[plate.element].row_sums:
        why = f"row sums of {plate.element} are zero at its corner nodes"
        allowed = f'{why}; allowed is "exact", or another element'
        raise InputError("plate.lumping", plate.lumping, allowed)
    if scene.damping:
        _check_damping(scene.damping)


def _check_damping(damping: Damping) -> None:
    """Validate combinations of the keys of [damping]."""
    if not damping.model_fields_set:
        allowed = "kind, ratio or bulk_viscosity is required; without this table damping is automatic"
        raise InputError("damping", "an empty table", allowed)
    if damping.rate is not None and damping.kind != "elastic-velocity":
        why = 'this key requires damping.kind = "elastic-velocity"; remove it'
        raise InputError("damping.rate", damping.rate, why)
    excluded = [key for key in ("ratio", "bulk_viscosity") if getattr(damping, key) is not None]
    if damping.kind == "none" and excluded:
        allowed = 'damping.kind = "none" excludes this key; remove one of the two'
        raise InputError(f"damping.{excluded[0]}", getattr(damping, excluded[0]), allowed)
