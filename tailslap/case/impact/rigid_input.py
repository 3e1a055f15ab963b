"""Inputs of the theory of whole impacts from a scene."""

import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from typing import Any, NamedTuple

from fem.laws.unilateral import penalty_stiffness
from solver import RigidBodyError, impact
from solver.impact.crush_law import LAW
from solver.impact.strips import SCALED
from tailslap.errors import InputError, Verbatim
from tailslap.scene.schema import Scene, value_at
from tailslap.scene.vehicle_tables import Vehicle

ARGUMENTS = (
    *(f"vehicle.{name}" for name in ("length", "width", "mass", "centre_of_mass")),
    *("impact.speed", "impact.angle"),
    *(f"contact.{name}" for name in ("stiffness", "initial_force", "restitution", "friction")),
)
"""Keys of the scene that a rigid vehicle's impact depends on, those of corners included."""

OF_CORNERS = tuple(f"contact.{key}" for key in LAW)
KEYS = {key.split(".")[1]: key for key in (*ARGUMENTS, *OF_CORNERS, "vehicle.yaw_inertia", "time.end")}
KEYS["axle"] = "axle"
"""Keys of the scene by names of the theory's inputs."""

KEY_OF_STRIP = {key: "plateau" if key == "plateau_force" else key for key in LAW}
"""Keys of a strip by names of its law."""


BEHIND_CENTRE, SENSOR_HEIGHT = 0.25, 0.95
"""Assumed place of a sensor behind the centre of mass, between 0 and 0.5 m, and its height on a truck's frame [m]."""


class Touching(NamedTuple):
    """Part of a scene that touches the wall.

    number: of its [[strip]], or None of a corner by [contact]. keys: those of its law, by name in `LAW`; of a corner
    behind the first one they end with "@" and its name, by which samples vary it alone.
    """

    number: int | None
    unit: int
    is_front: bool
    keys: Mapping[str, str]


def above_wall(scene: Scene) -> list[int]:
    """Return the numbers of strips that pass over the wall.

    In the plane they do not touch it; a unit without any other keeps its own.
    """
    top = (scene.wall and scene.wall.height) or math.inf
    above = [n for n, strip in enumerate(scene.strip) if strip.height and min(strip.height) > top]
    units_below = {strip.unit for n, strip in enumerate(scene.strip) if n not in above}
    return [n for n in above if scene.strip[n].unit in units_below]


def touching(scene: Scene) -> list[Touching]:
    """Return what touches in the plane, in the order of `strips_of_units`."""
    parts, above = [], above_wall(scene)
    for unit in range(1, 1 + len(scene.units)):
        for number, strip in enumerate(scene.strip):
            if strip.unit == unit and number not in above:
                keys = {name: f"strip.{number}.{key}" for name, key in KEY_OF_STRIP.items()}
                parts.append(Touching(number, unit, False, keys))
        if unit in scene.of_corners:
            trailer = f"trailer {unit - 1} " if unit > 2 else "trailer " if unit > 1 else ""
            for end in ("front", "rear"):
                of_first = unit == 1 and end == "front"
                keys = {key: f"contact.{key}" + ("" if of_first else f"@{trailer}{end}") for key in LAW}
                parts.append(Touching(None, unit, end == "front", keys))
    return parts


def rigid_vehicle(unit: Vehicle) -> impact.ImpactVehicle:
    """Return the rigid body of a unit.

    Raises RigidBodyError.
    """
    sides = unit.length, unit.width
    return impact.ImpactVehicle(*sides, unit.mass, unit.centre_of_mass, unit.yaw_inertia)


def wall_contact(scene: Scene, values: Mapping[str, Any] | None = None) -> impact.WallContact:
    """Return the contact of a vehicle or a train.

    values: of samples, in place of those of the scene, by the keys of `touching` and "contact.friction" [SI]. Corners
    that do not crush have the elastic penalty of the plate. A strip with heights is its projection on the plane: an
    upright one is a point. Raises InputError for a law that is not possible.
    """
    contact, values = scene.needed_contact, values or {}
    friction = values.get("contact.friction", contact.friction)
    if not scene.crushes:
        plate = scene.needed_plate
        penalty = penalty_stiffness(plate.modulus, plate.thickness, contact.penalty_scale)
        return impact.WallContact(impact.CrushLaw(penalty, 0.0, 1.0), friction)
    strips = list[impact.Strip]()
    for part in touching(scene):
        law = _crush_law(scene, part, values)
        if part.number is None:
            length = values.get(_length(part.unit), scene.units[part.unit - 1].length)
            place = 0.0 * length if part.is_front else length
            strips.append(impact.Strip((place, place), law, unit=part.unit - 1))
        else:
            strip = scene.strip[part.number]
            inset = values.get(f"strip.{part.number}.inset", strip.inset)
            strips.append(impact.Strip(strip.at, law, inset, part.unit - 1))
    return impact.WallContact(None, friction, tuple(strips))


def _length(unit: int) -> str:
    """Return the key of a unit's length."""
    return f"trailer.{unit - 2}.length" if unit > 1 else "vehicle.length"


def _crush_law(scene: Scene, part: Touching, values: Mapping[str, Any]) -> impact.CrushLaw:
    """Return the crush of a part, its lengths upwards included.

    Raises InputError with the key that is not possible.
    """
    law = {name: value for name in LAW if (value := _value(scene, values, part, name)) is not None}
    upright = 1.0
    if part.number is not None:
        strip = scene.strip[part.number]
        if strip.height is not None and strip.at[0] == strip.at[1]:
            upright = strip.height[1] - strip.height[0]
    try:
        stated = impact.CrushLaw(**law)
        return replace(stated, **{name: law[name] * upright for name in SCALED if name in law})
    except RigidBodyError as error:
        key = part.keys.get(error.key, error.key)
        base = key.partition("@")[0]
        if value_at(scene, base) is None and error.key == "restitution":
            base = "contact.restitution"
        raise InputError(base, Verbatim(error.value), f"{error.why}; allowed: {error.allowed}") from None


def _value(scene: Scene, values: Mapping[str, Any], part: Touching, name: str) -> Any:
    """Return a parameter of a law, None where it has its default.

    That of a sample comes first, then that of the scene. Restitution and slope of unloading replace each other; those
    of a strip without both are the restitution of [contact].
    """
    key = part.keys[name]
    base = key.partition("@")[0]
    for source in (key, base):
        if source in values:
            return values[source]
    other = {"restitution": "unloading_stiffness", "unloading_stiffness": "restitution"}.get(name)
    if other and (part.keys[other] in values or part.keys[other].partition("@")[0] in values):
        return None
    own = value_at(scene, base)
    unloading = part.number is not None and value_at(scene, part.keys["unloading_stiffness"])
    if own is None and name == "restitution" and part.number is not None and not unloading:
        return values.get("contact.restitution", scene.needed_contact.restitution)
    return own


def sensor_position(scene: Scene, values: Mapping[str, Any]) -> Any:
    """Return the distance of the sensor behind the front [m].

    values: of samples, in place of those of the scene [SI].
    """

    def value(key: str, default: Any) -> Any:
        result = values.get(key, value_at(scene, key))
        return default if result is None else result

    if (position := value("sensor.position", None)) is not None:
        return position
    centre = value("vehicle.centre_of_mass", 0.5 * value("vehicle.length", None))
    return centre + value("sensor.behind_centre", BEHIND_CENTRE)


def at_table(values: Mapping[str, Any], tables: tuple[str, ...]) -> dict[str, Any]:
    """Return the values of keys in these tables by name."""
    split = {key: key.rpartition(".") for key in values}
    return {name: values[key] for key, (table, _, name) in split.items() if table in tables}


@contextmanager
def refusals(scene: Scene, unit: str = "vehicle") -> Iterator[None]:
    """Turn errors of the theory into messages with the scene's key.

    unit: the table of the body.
    """
    try:
        yield
    except RigidBodyError as error:
        key = error.key if "." in error.key else KEYS.get(error.key, "impact").replace("vehicle", unit)
        raise InputError(key, Verbatim(error.value), f"{error.why}; allowed: {error.allowed}") from None
