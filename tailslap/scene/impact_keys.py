"""Validate the keys of a whole impact."""

from tailslap.errors import InputError, Missing, Verbatim
from tailslap.scene.schema import Scene, value_at
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

ROUNDING = 1e-6
"""Part of its length by which a strip may be behind its unit, in other units."""

HIGHEST = 3.0
"""Height of the top of a vehicle over that of its centre of mass, at most, as of strips."""

MOST_TRAILERS = 7
"""Largest number of trailers of a train."""

CORNER_TABLES = {
    "corner": "unilateral contact excludes a constrained corner",
    "start": "a whole impact starts at first contact",
    "strike": "a whole impact computes the duration of its strikes",
}
"""Tables that [contact] excludes, and why."""

CORNER_KEYS = {
    "verify.tolerance": "this key requires a constrained corner; remove it or [contact]",
    "impact.convention": "the restitution of a whole impact is contact.restitution; remove this key",
    "plate.density": "the density of a whole impact follows from vehicle.mass; remove this key",
    "plate.start": "a whole impact starts unstressed; remove this key",
}
"""Keys that [contact] excludes, and why."""

LAW = ("stiffness", "initial_force", "plateau_force", "restitution", "unloading_stiffness")
OF_CORNERS = ("contact.stiffness", "contact.strike_duration", "contact.initial_force", "contact.plateau_force",
              "contact.unloading_stiffness", "contact.hardening")  # fmt: skip
CRUSH_KEYS = (*(f"contact.{key}" for key in LAW[1:]), "contact.hardening", "contact.patch_length")
UNCRUSHED_KEYS = ("contact.enforcement", "contact.penalty_scale")
"""Names of a crush law, keys of corners' crush, keys that require crush, and keys that crush excludes."""


def refuse(scene: Scene, allowed: str, *keys: str) -> None:
    """Raise InputError for the first of these keys that is set."""
    for key in keys:
        table, _, name = key.rpartition(".")
        values = value_at(scene, table)
        value = getattr(values, name) if values and name in values.model_fields_set else None
        if value is not None:
            raise InputError(key, value, allowed)


def check_impact(scene: Scene, contact: Contact) -> None:
    """Validate keys of a whole impact."""
    for name, why in CORNER_TABLES.items():
        if name in scene.model_fields_set and getattr(scene, name) is not None:
            raise InputError(name, "a table", f"{why}; remove this table or [contact]")
    for key, allowed in CORNER_KEYS.items():
        refuse(scene, allowed, key)
    _check_contact(scene, contact)
    _check_trailers(scene)
    _check_axles(scene)
    _check_strips(scene)
    _check_space(scene)
    _check_sensor(scene)
    _check_plate_of_impact(scene)


def _check_contact(scene: Scene, contact: Contact) -> None:
    """Validate keys that depend on whether the vehicle crushes."""
    if contact.strike_duration is not None:
        _check_strike_duration(scene)
    if scene.crushes:
        refuse(scene, "this key has no effect on what crushes; remove it", *UNCRUSHED_KEYS)
    else:
        refuse(scene, "this key requires contact.stiffness or [[strip]]; remove it", *CRUSH_KEYS)
    if scene.strip and not scene.of_corners:
        refuse(scene, "all units have [[strip]]: no corner has this value; remove it", *OF_CORNERS)
    elif scene.strip and not contact.of_corners:
        unit = scene.of_corners[0]
        why = f"this key is required: unit {unit} has no [[strip]], and touches the wall with its corners"
        raise InputError("contact.stiffness", Missing, why)
    inherits = any(strip.restitution is strip.unloading_stiffness for strip in scene.strip)  # both are None
    if scene.strip and not scene.of_corners and not inherits:
        refuse(scene, "all strips have an unloading of their own; remove this key", "contact.restitution")
    if scene.strip and not scene.has_points:
        refuse(scene, "lines have no patch; remove this key", "contact.patch_length")
    for table in ("contact", *(f"strip.{number}" for number in range(len(scene.strip)))):
        if value_at(scene, f"{table}.restitution") is not None:
            allowed = f"{table}.restitution defines the unloading; remove one of the two (--set {table}.restitution=)"
            refuse(scene, allowed, f"{table}.unloading_stiffness")
    if contact.enforcement == "exact":
        refuse(scene, 'contact.enforcement = "exact" has no spring; remove this key', "contact.penalty_scale")


def _check_strike_duration(scene: Scene) -> None:
    """Refuse keys that define the crush of the corners as well.

    Raises InputError for them and for trains.
    """
    allowed = "contact.strike_duration defines the crush stiffness; remove one of the two"
    refuse(scene, allowed, "contact.stiffness")
    allowed = (
        "contact.strike_duration assumes a crush force in proportion to the depth at the corners; remove one "
        "of the two, or use contact.stiffness in its place"
    )
    refuse(scene, allowed, *(f"contact.{key}" for key in (*LAW[1:3], "hardening", "unloading_stiffness")))
    if scene.trailer:
        allowed = "the effective mass is that of a single vehicle; of a train allowed is contact.stiffness"
        raise InputError("contact.strike_duration", scene.needed_contact.strike_duration, allowed)


def with_crush_stiffness(scene: Scene) -> Scene:
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


def _check_space(scene: Scene) -> None:
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
        refuse(scene, "this key requires [body]; remove it", *of_lists, "wall.profile")
        return
    keys = (*OF_MESH, *ELASTIC_WALL_KEYS[1:])
    refuse(scene, "with [body] the wall is rigid; remove this key", *(f"wall.{key}" for key in keys))
    for unit in range(1, len(scene.units) + 1):
        count, least = sum(axle.unit == unit for axle in scene.axle), 2 if unit == 1 else 1
        if count < least:
            why = f"with [body] unit {unit} of the train requires at least {least}"
            raise InputError("axle", Verbatim(f"{count} tables of this unit"), why)
    if not scene.strip:
        raise InputError("strip", Missing, "with [body] at least one strip of the vehicle can touch the wall")
    refuse(scene, "with [body] strips alone touch the wall; remove this key", *OF_CORNERS)


def _check_strips(scene: Scene) -> None:
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


def _check_trailers(scene: Scene) -> None:
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


def _check_axles(scene: Scene) -> None:
    """Raise InputError for an axle outside its unit, or of none."""
    for number, axle in enumerate(scene.axle):
        if axle.unit > len(scene.units):
            raise InputError(f"axle.{number}.unit", axle.unit, f"allowed are 1 to {len(scene.units)}")
        length = scene.units[axle.unit - 1].length
        if axle.position > length:
            allowed = f"allowed is from 0 to the length of the unit, {length:g} m"
            raise InputError(f"axle.{number}.position", axle.position, allowed)


def _check_sensor(scene: Scene) -> None:
    """Raise InputError for a sensor outside the vehicle, or of a train."""
    sensor, vehicle = scene.sensor, scene.vehicle
    if sensor is None:
        return
    if scene.trailer:
        why = "the inertial estimate is that of a single vehicle; remove this table of a train"
        raise InputError("sensor", Verbatim("a table"), why)
    if sensor.position is not None:
        refuse(scene, "sensor.position defines the place; remove one of the two", "sensor.behind_centre")
        if sensor.position > vehicle.length:
            allowed = f"allowed is from 0 to the length of the vehicle, {vehicle.length:g} m"
            raise InputError("sensor.position", sensor.position, allowed)
    ahead = 0.5 * vehicle.length if vehicle.centre_of_mass is None else vehicle.centre_of_mass
    if sensor.behind_centre is not None and not 0.0 <= ahead + sensor.behind_centre <= vehicle.length:
        ends = f"{-ahead:g} to {vehicle.length - ahead:g} m, from front to rear of the vehicle"
        raise InputError("sensor.behind_centre", sensor.behind_centre, f"allowed is from {ends}")
    if scene.body is None:
        refuse(scene, "this key requires [body]; remove it", "sensor.height")
    elif (sensor.height or 0.0) > (top := HIGHEST * scene.body.centre_height):
        allowed = f"allowed is up to {HIGHEST:g} times the height of the centre of mass, {top:g} m"
        raise InputError("sensor.height", sensor.height, allowed)


def _check_plate_of_impact(scene: Scene) -> None:
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
