"""Validate keys and combinations of keys."""

import re
from collections.abc import Callable, Mapping
from typing import Any

from pydantic import ValidationError

from fem.laws import constraints
from fem.laws.friction import FRICTION_LAWS
from fem.plate.kinds import ELEMENT_KINDS, LUMPINGS
from tailslap.errors import InputError, Missing, Verbatim, nearest
from tailslap.scene import schema
from tailslap.scene.model_tables import Damping, Wall
from tailslap.scene.parapet_keys import check_parapet
from tailslap.scene.types import STIFFNESS_BOUNDS
from tailslap.scene.vehicle_tables import Contact

ELASTIC_WALL_KEYS = ("height", "foundation_stiffness", "density", "youngs_modulus", "poissons_ratio")
OF_MESH = ("length", "depth", "elements")
"""Keys of [wall] that require an elastic wall, and those of its mesh."""

SPACE_KEYS = {
    "trailer": ("centre_height", "roll_inertia", "pitch_inertia", "hitch_height", "roll_stiffness"),
    "axle": ("track", "radius", "mass", "spring", "spacing", "damping_ratio", "tyre", "roll_centre"),
}
"""Keys of lists of tables that require [body]."""

SPACE_REQUIRED = {
    "trailer": ("hitch_height",),
    "axle": ("track", "radius", "mass", "spring", "spacing", "tyre"),
}
"""Keys of lists of tables that are required with [body]."""

ROUNDING = 1e-6
"""Part of its length by which a strip may be behind its unit, in other units."""

HIGHEST = 3.0
"""Height of the top of a vehicle over that of its centre of mass, at most, as of strips."""

MOST_TRAILERS = 7
"""Largest number of trailers of a train."""

SUBSTITUTES = {
    "impact.speed": "[start] with angle, omega and corner_speed may replace [impact]",
    "plate.youngs_modulus": "plate.first_frequency may replace plate.youngs_modulus",
    "contact.stiffness": "contact.strike_duration may replace it; neither is required with [plate], or where [[strip]] "
    "says what of each unit can touch the wall",
    "contact.restitution": "contact.unloading_stiffness may replace it",
    "wall.height": "without [wall] the wall of a whole impact is rigid",
}
"""Alternatives to missing keys."""

CORNER_TABLES = {
    "corner": "unilateral contact excludes a constrained corner",
    "start": "a whole impact starts at first contact",
    "strike": "a whole impact computes the duration of its strikes",
}
"""Tables that [contact] excludes, and why."""

IMPACT_KEYS = ("vehicle.centre_of_mass", "vehicle.yaw_inertia", "time.end", "verify.mesh")
CORNER_KEYS = {
    "verify.tolerance": "this key requires a constrained corner; remove it or [contact]",
    "impact.convention": "the restitution of a whole impact is contact.restitution; remove this key",
    "plate.density": "the density of a whole impact follows from vehicle.mass; remove this key",
    "plate.start": "a whole impact starts unstressed; remove this key",
}
"""Keys that require [contact]; keys that [contact] excludes, and why."""

LAW = ("stiffness", "initial_force", "plateau_force", "restitution", "unloading_stiffness")
OF_CORNERS = ("contact.stiffness", "contact.strike_duration", "contact.initial_force", "contact.plateau_force",
              "contact.unloading_stiffness", "contact.hardening")  # fmt: skip
CRUSH_KEYS = (*(f"contact.{key}" for key in LAW[1:]), "contact.hardening", "contact.patch_length")
UNCRUSHED_KEYS = ("contact.enforcement", "contact.penalty_scale")
"""Names of a crush law, keys of corners' crush, keys that require crush, and keys that crush excludes."""

FORMER_KEYS = re.compile(rf"contact\.(rear|side_stiffness)|trailer\.\d+\.({'|'.join(LAW)}|rear)(\.\w+)?")
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
        _check_impact(scene, scene.contact)
    else:
        _check_corner(scene)
    _check_plate(scene)
    if scene.parapet is not None:
        check_parapet(scene, scene.parapet)
    return _with_crush_stiffness(scene)


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
        missing += absent(*(f"wall.{key}" for key in OF_MESH))
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
        return absent(*(f"wall.{key}" for key in (*OF_MESH, "height", "foundation_stiffness")))
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
    _refuse(scene, "this key requires [contact]; remove it", *IMPACT_KEYS)
    if scene.body:
        raise InputError("body", Verbatim("a table"), "this table requires [contact]; remove it")
    if scene.sensor:
        raise InputError("sensor", Verbatim("a table"), "this table requires [contact]; remove it")
    for name in ("axle", "strip"):
        if tables := getattr(scene, name):
            why = "these tables require [contact]; remove them"
            raise InputError(name, Verbatim(f"{len(tables)} tables"), why)
    if scene.trailer:
        why = (
            "a constrained corner is that of one rigid body; a train requires [contact] in place of [corner]"
        )
        raise InputError("trailer", f"{len(scene.trailer)} tables", why)
    for key in ELASTIC_WALL_KEYS:
        value = getattr(scene.wall, key, None)
        if scene.wall is not None and value != Wall.model_fields[key].default:
            allowed = "an elastic wall requires [contact]; remove this key"
            raise InputError(f"wall.{key}", value, allowed)
    friction = scene.corner.friction
    if scene.corner.frictionless and friction is not None:
        allowed = f'this key has no effect with corner.reaction = "{scene.corner.reaction}"; remove it'
        raise InputError("corner.friction", friction, allowed)


def _refuse(scene: schema.Scene, allowed: str, *keys: str) -> None:
    """Raise InputError for the first of these keys that is set."""
    for key in keys:
        table, _, name = key.rpartition(".")
        values = schema.value_at(scene, table)
        value = getattr(values, name) if values and name in values.model_fields_set else None
        if value is not None:
            raise InputError(key, value, allowed)


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
    _refuse(scene, f'corner.constraint = "{constraint.name}" has no spring; remove this key', *of_springs)
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


def _check_impact(scene: schema.Scene, contact: Contact) -> None:
    """Validate keys of a whole impact."""
    for name, why in CORNER_TABLES.items():
        if name in scene.model_fields_set and getattr(scene, name) is not None:
            raise InputError(name, "a table", f"{why}; remove this table or [contact]")
    for key, allowed in CORNER_KEYS.items():
        _refuse(scene, allowed, key)
    _check_contact(scene, contact)
    _check_trailers(scene)
    _check_axles(scene)
    _check_strips(scene)
    _check_space(scene)
    _check_sensor(scene)
    _check_plate_of_impact(scene, contact)


def _check_contact(scene: schema.Scene, contact: Contact) -> None:
    """Validate keys that depend on whether the vehicle crushes."""
    if contact.strike_duration is not None:
        _check_strike_duration(scene)
    if scene.crushes:
        _refuse(scene, "this key has no effect on what crushes; remove it", *UNCRUSHED_KEYS)
    else:
        _refuse(scene, "this key requires contact.stiffness or [[strip]]; remove it", *CRUSH_KEYS)
    if scene.strip and not scene.of_corners:
        _refuse(scene, "all units have [[strip]]: no corner has this value; remove it", *OF_CORNERS)
    elif scene.strip and not contact.of_corners:
        unit = scene.of_corners[0]
        why = f"this key is required: unit {unit} has no [[strip]], and touches the wall with its corners"
        raise InputError("contact.stiffness", Missing, why)
    inherits = any(strip.restitution is strip.unloading_stiffness for strip in scene.strip)  # both are None
    if scene.strip and not scene.of_corners and not inherits:
        _refuse(scene, "all strips have an unloading of their own; remove this key", "contact.restitution")
    if scene.strip and not scene.has_points:
        _refuse(scene, "lines have no patch; remove this key", "contact.patch_length")
    for table in ("contact", *(f"strip.{number}" for number in range(len(scene.strip)))):
        if schema.value_at(scene, f"{table}.restitution") is not None:
            allowed = f"{table}.restitution defines the unloading; remove one of the two (--set {table}.restitution=)"
            _refuse(scene, allowed, f"{table}.unloading_stiffness")
    if contact.enforcement == "exact":
        _refuse(
            scene, 'contact.enforcement = "exact" has no spring; remove this key', "contact.penalty_scale"
        )


def _check_strike_duration(scene: schema.Scene) -> None:
    """Refuse keys that define the crush of the corners as well.

    Raises InputError for them and for trains.
    """
    allowed = "contact.strike_duration defines the crush stiffness; remove one of the two"
    _refuse(scene, allowed, "contact.stiffness")
    allowed = (
        "contact.strike_duration assumes a crush force in proportion to the depth at the corners; remove one "
        "of the two, or use contact.stiffness in its place"
    )
    _refuse(scene, allowed, *(f"contact.{key}" for key in (*LAW[1:3], "hardening", "unloading_stiffness")))
    if scene.trailer:
        allowed = "the effective mass is that of a single vehicle; of a train allowed is contact.stiffness"
        raise InputError("contact.strike_duration", scene.needed_contact.strike_duration, allowed)


def _with_crush_stiffness(scene: schema.Scene) -> schema.Scene:
    """Return the scene with the crush stiffness of contact.strike_duration.

    Raises InputError for a stiffness out of bounds.
    """
    contact, body = scene.contact, scene.vehicle
    if contact is None or contact.strike_duration is None:
        return scene
    from solver.impact import stiffness_of_duration

    centre = 0.5 * body.length if body.centre_of_mass is None else body.centre_of_mass
    vehicle = (body.mass, body.yaw_inertia, body.length, body.width, centre)
    stiffness = stiffness_of_duration(contact.strike_duration, contact.restitution or 0.0, *vehicle)
    low, high = STIFFNESS_BOUNDS
    if not low <= stiffness <= high:
        allowed = f"the crush stiffness would be {stiffness:.3g} N/m; allowed is {low:g} to {high:g} N/m"
        raise InputError("contact.strike_duration", contact.strike_duration, allowed)
    values = dict(contact) | {"stiffness": stiffness}
    # The stiffness is not marked as set, so that variations of the scene compute it again.
    derived = Contact.model_construct(_fields_set=contact.model_fields_set, **values)
    return scene.model_copy(update={"contact": derived})


def _check_space(scene: schema.Scene) -> None:
    """Validate keys of the vehicle in space.

    Bounds that depend on other values are those of `solver.space`. Raises InputError.
    """
    if scene.body is None:
        of_lists = [
            f"{name}.{number}.{key}"
            for name, keys in SPACE_KEYS.items()
            for number in range(len(getattr(scene, name)))
            for key in keys
        ]
        _refuse(scene, "this key requires [body]; remove it", *of_lists, "wall.profile")
        return
    keys = (*OF_MESH, *ELASTIC_WALL_KEYS[1:])
    _refuse(scene, "with [body] the wall is rigid; remove this key", *(f"wall.{key}" for key in keys))
    for unit in range(1, len(scene.units) + 1):
        count, least = sum(axle.unit == unit for axle in scene.axle), 2 if unit == 1 else 1
        if count < least:
            why = f"with [body] unit {unit} of the train requires at least {least}"
            raise InputError("axle", Verbatim(f"{count} tables of this unit"), why)
    if not scene.strip:
        raise InputError("strip", Missing, "with [body] at least one strip of the vehicle can touch the wall")
    _refuse(scene, "with [body] strips alone touch the wall; remove this key", *OF_CORNERS)


def _check_strips(scene: schema.Scene) -> None:
    """Validate what touches the wall.

    Raises InputError.
    """
    for number, strip in enumerate(scene.strip):
        key = f"strip.{number}"
        if strip.unit > len(scene.units):
            raise InputError(f"{key}.unit", strip.unit, f"allowed are 1 to {len(scene.units)}")
        length, width = scene.units[strip.unit - 1].length, scene.units[strip.unit - 1].width
        for place in strip.at:
            if place > length * (1.0 + ROUNDING):
                raise InputError(
                    f"{key}.at", place, f"allowed is from 0 to the length of the unit, {length:g} m"
                )
        if strip.at[1] < strip.at[0]:
            raise InputError(
                f"{key}.at", list(strip.at), "allowed are two places, the second one behind the first"
            )
        if not strip.inset < 0.5 * width:
            raise InputError(
                f"{key}.inset", strip.inset, f"allowed is less than half of the width, {0.5 * width:g} m"
            )
        if strip.height and strip.at[0] == strip.at[1] and not strip.height[1] > strip.height[0]:
            why = "allowed are two heights upwards, of a strip at one place"
            raise InputError(f"{key}.height", list(strip.height), why)
        if scene.body is None and strip.axle is not None:
            raise InputError(f"{key}.axle", strip.axle, "this key requires [body]; remove it")
        contact = scene.needed_contact
        if strip.restitution is None and strip.unloading_stiffness is None and contact.restitution is None:
            why = f"this key is required, unless contact.restitution or {key}.unloading_stiffness is given"
            raise InputError(f"{key}.restitution", Missing, why)


def _check_trailers(scene: schema.Scene) -> None:
    """Validate the hinges of a train."""
    if len(scene.trailer) > MOST_TRAILERS:
        allowed = f"allowed are at most {MOST_TRAILERS}"
        raise InputError("trailer", Verbatim(f"{len(scene.trailer)} tables"), allowed)
    for number, (ahead, unit) in enumerate(zip(scene.units, scene.trailer, strict=False)):
        longest = 2.0 * ahead.length  # a tow ball or a drawbar of the unit ahead
        if unit.hitch > longest:
            allowed = f"allowed is from 0 to twice the length of the unit ahead, {longest:g} m"
            raise InputError(f"trailer.{number}.hitch", unit.hitch, allowed)
        if not -unit.length <= unit.kingpin <= unit.length:
            ends = f"{-unit.length:g}, a drawbar, to the trailer's length, {unit.length:g} m"
            raise InputError(f"trailer.{number}.kingpin", unit.kingpin, f"allowed is from {ends}")
    if scene.trailer and scene.damping and scene.damping.kind == "elastic-velocity":
        allowed = "it would damp the hinges; of a train allowed are damping.ratio and damping.bulk_viscosity"
        raise InputError("damping.kind", scene.damping.kind, allowed)


def _check_axles(scene: schema.Scene) -> None:
    """Raise InputError for an axle outside its unit, or of none."""
    for number, axle in enumerate(scene.axle):
        if axle.unit > len(scene.units):
            raise InputError(f"axle.{number}.unit", axle.unit, f"allowed are 1 to {len(scene.units)}")
        length = scene.units[axle.unit - 1].length
        if axle.position > length:
            allowed = f"allowed is from 0 to the length of the unit, {length:g} m"
            raise InputError(f"axle.{number}.position", axle.position, allowed)


def _check_sensor(scene: schema.Scene) -> None:
    """Raise InputError for a sensor outside the vehicle, or of a train."""
    sensor, vehicle = scene.sensor, scene.vehicle
    if sensor is None:
        return
    if scene.trailer:
        why = "the inertial estimate is that of a single vehicle; remove this table of a train"
        raise InputError("sensor", Verbatim("a table"), why)
    if sensor.position is not None:
        _refuse(scene, "sensor.position defines the place; remove one of the two", "sensor.behind_centre")
        if sensor.position > vehicle.length:
            allowed = f"allowed is from 0 to the length of the vehicle, {vehicle.length:g} m"
            raise InputError("sensor.position", sensor.position, allowed)
    ahead = 0.5 * vehicle.length if vehicle.centre_of_mass is None else vehicle.centre_of_mass
    if sensor.behind_centre is not None and not 0.0 <= ahead + sensor.behind_centre <= vehicle.length:
        ends = f"{-ahead:g} to {vehicle.length - ahead:g} m, from front to rear of the vehicle"
        raise InputError("sensor.behind_centre", sensor.behind_centre, f"allowed is from {ends}")
    if scene.body is None:
        _refuse(scene, "this key requires [body]; remove it", "sensor.height")
    elif (sensor.height or 0.0) > (top := HIGHEST * scene.body.centre_height):
        allowed = f"allowed is up to {HIGHEST:g} times the height of the centre of mass, {top:g} m"
        raise InputError("sensor.height", sensor.height, allowed)


def _check_plate_of_impact(scene: schema.Scene, contact: Contact) -> None:
    """Validate keys of the plate in a whole impact."""
    plate = scene.plate
    if plate is None:
        return
    if not scene.crushes and plate.youngs_modulus is None:
        allowed = "this key is required without contact.stiffness: it defines the contact stiffness"
        raise InputError("plate.youngs_modulus", Missing, allowed)
    uneven = any(unit.centre_of_mass or unit.yaw_inertia for unit in scene.units)
    if plate.lumping == "row-sum" and uneven:
        allowed = 'with centre_of_mass or yaw_inertia of a unit allowed is "exact"'
        raise InputError("plate.lumping", plate.lumping, allowed)
