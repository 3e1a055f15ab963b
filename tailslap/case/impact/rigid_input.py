"""Inputs of the theory of whole impacts from a scene."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from fem.laws.unilateral import penalty_stiffness
from solver import RigidBodyError, impact
from solver.impact import crush_law
from tailslap.errors import InputError, Verbatim
from tailslap.scene.schema import Scene, Vehicle, value_at

ARGUMENTS = (
    *(f"vehicle.{name}" for name in ("length", "width", "mass", "centre_of_mass")),
    *("impact.speed", "impact.angle"),
    *(f"contact.{name}" for name in ("stiffness", "initial_force", "restitution", "friction")),
)
"""Keys of the scene that the rigid vehicle's impact depends on, by the corners alone."""

OF_LAW = tuple(f"contact.{key}" for key in crush_law.LAW)
KEYS = {key.split(".")[1]: key for key in (*ARGUMENTS, *OF_LAW, "vehicle.yaw_inertia", "time.end")}
"""Keys of the scene by names of the theory's inputs."""


def rigid_vehicle(unit: Vehicle) -> impact.ImpactVehicle:
    """Return the rigid body of a unit.

    Raises RigidBodyError.
    """
    sides = unit.length, unit.width
    return impact.ImpactVehicle(*sides, unit.mass, unit.centre_of_mass, unit.yaw_inertia)


def wall_contact(scene: Scene, number: int = 0) -> impact.WallContact:
    """Return the contact of a unit.

    A unit that does not crush has the elastic penalty of the plate at its corners. Raises InputError for a law that is
    not possible.
    """
    contact = scene.needed_contact
    if contact.stiffness is None:
        plate = scene.needed_plate
        penalty = penalty_stiffness(plate.modulus, plate.thickness, contact.penalty_scale)
        return impact.WallContact(impact.CrushLaw(penalty, 0.0, 1.0), contact.friction)
    keys = {*crush_law.LAW, "rear"}
    units = [table.model_dump(include=keys) for table in (contact, *scene.trailer)]
    trailer = [f"trailer.{number - 1}"] if number else []
    behind = [*(f"{table}.rear" for table in trailer), *trailer, "contact.rear", "contact"]
    ahead, rear = crush_law.unit_laws(units)[number]
    front, back = _crush_law(scene, ahead, [*trailer, "contact"]), _crush_law(scene, rear, behind)
    side = None
    if contact.side_stiffness:
        slope = (contact.unloading_stiffness or 0.0) * contact.side_stiffness / contact.stiffness
        restitution = contact.restitution or 0.0
        side = impact.CrushLaw(contact.side_stiffness, 0.0, restitution, unloading_stiffness=slope)
    return impact.WallContact(front, contact.friction, side, rear=None if back == front else back)


def _crush_law(scene: Scene, law: Mapping[str, Any], tables: list[str]) -> impact.CrushLaw:
    """Return a crush law.

    Each value is from the first of these tables that contains it. Raises InputError.
    """
    try:
        return impact.CrushLaw(**law)
    except RigidBodyError as error:
        keys = [f"{table}.{error.key}" for table in tables]
        key = next((key for key in keys if value_at(scene, key) is not None), keys[-1])
        raise InputError(key, Verbatim(error.value), f"{error.why}; allowed: {error.allowed}") from None


def at_table(values: Mapping[str, Any], tables: tuple[str, ...]) -> dict[str, Any]:
    """Return the values of keys in these tables by name.

    Under "rear" stand those of their tables of that name.
    """
    split = {key: key.rpartition(".") for key in values}
    values_by_name = {name: values[key] for key, (table, _, name) in split.items() if table in tables}
    behind = {
        name: values[key]
        for key, (table, _, name) in split.items()
        if table.removesuffix(".rear") in tables and table not in tables
    }
    return values_by_name | ({"rear": behind} if behind else {})


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
