"""The one way to vary a scene: dotted keys with typed values, validated as a scene file is.

Text of the command line becomes values once, in `parse_changes`; from there on a change is a value in SI, a word, or
None for a key that is taken out. Changes are plain data and travel to workers as they are.

Validation of a scene: each key by itself, and keys that need or exclude each other.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from pydantic import ValidationError

from fem.laws import constraints
from fem.plate.kinds import ELEMENT_KINDS, LUMPINGS
from tailslap.errors import InputError, Missing, Verbatim, nearest
from tailslap.scene import schema

OF_A_WALL_THAT_GIVES = ("height", "foundation_stiffness", "density", "youngs_modulus", "poissons_ratio")


def validate(data: dict[str, Any]) -> schema.Scene:
    """The scene that these tables describe. Raises InputError for the first thing that is wrong."""
    scene = key_by_key(data)
    _check_together(scene)
    return scene


def key_by_key(data: dict[str, Any]) -> schema.Scene:
    """The scene, each key valid by itself, whatever keys that need or exclude each other. Raises InputError."""
    try:
        return schema.Scene.model_validate(data)
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
    if kind == "tuple_type" and key in schema.LISTED:
        return InputError(
            key, first["input"], f"allowed is a list of tables, [[{key}]], each by its number: {key}.0"
        )
    if kind in ("model_type", "model_attributes_type", "dict_type"):
        return InputError(key, first["input"], f"allowed is a table, [{key}]")
    message = first["msg"].removeprefix("Value error, ")
    return InputError(key, first["input"], message[0].lower() + message[1:])


def _known(location: tuple[int | str, ...]) -> str:
    *table, name = map(str, location)
    known = (schema.TABLES[table[0]] if table else schema.Scene).model_fields
    elsewhere = [key for key in schema.MEANINGS if key.rpartition(".")[2] == name]
    hint = nearest(name, known, ".".join([*table, "{}"]))
    return (
        f"allowed are {', '.join(known)}{hint or ''.join(f'; did you mean {key}?' for key in elsewhere[:1])}"
    )


def _check_together(scene: schema.Scene) -> None:
    """Keys that need or exclude each other."""
    if scene.contact is not None:
        check_impact(scene, scene.contact)
        _check_plate(scene)
        return
    _check_corner(scene)
    _check_plate(scene)


def _check_corner(scene: schema.Scene) -> None:
    """Keys of the paper's three stages, with a constrained corner."""
    _refuse(scene, "it belongs to a whole impact, with [contact]; leave it out", *OF_A_WHOLE_IMPACT)
    if scene.trailer:
        why = "a constrained corner turns one rigid body about itself; a train takes [contact] in place of [corner]"
        raise InputError("trailer", f"{len(scene.trailer)} tables", why)
    for key in OF_A_WALL_THAT_GIVES:
        value = getattr(scene.wall, key, None)
        if scene.wall is not None and value != schema.Wall.model_fields[key].default:
            allowed = "a wall that gives belongs to a whole impact, with [contact]; leave it out"
            raise InputError(f"wall.{key}", value, allowed)
    for key in ("friction", "restitution"):
        if scene.impact is not None and getattr(scene.impact, key) is None:
            raise InputError(f"impact.{key}", Missing, "this key is required")
    start = scene.start
    complete = start is not None and None not in (start.angle, start.omega, start.corner_speed)
    if scene.impact is None and not complete:
        why = "this table is required unless [start] gives angle, omega and corner_speed"
        raise InputError("impact", Missing, why)
    friction = scene.corner.friction
    if scene.corner.frictionless and friction is not None:
        allowed = f'it has no meaning with corner.reaction = "{scene.corner.reaction}"; leave it out'
        raise InputError("corner.friction", friction, allowed)
    if not scene.corner.frictionless and friction is None and scene.impact is None:
        raise InputError("corner.friction", Missing, "it is required where there is no impact.friction")


def _refuse(scene: schema.Scene, allowed: str, *keys: str) -> None:
    """Raise InputError for the first of these keys of two parts that the scene gives."""
    for key in keys:
        table, name = key.split(".")
        own = getattr(scene, table)
        value = getattr(own, name) if own and name in own.model_fields_set else None
        if value is not None:
            raise InputError(key, value, allowed)


def _check_plate(scene: schema.Scene) -> None:
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
    constraint = constraints.CONSTRAINTS[scene.corner.constraint]
    of_springs = [f"corner.{key}" for key in ("penalty_scale", "damping_ratio") if key not in constraint.keys]
    _refuse(scene, f'constraint = "{constraint.name}" has no spring; leave it out', *of_springs)
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


def _check_damping(damping: schema.Damping) -> None:
    if not damping.model_fields_set:
        allowed = "it needs kind, ratio or bulk_viscosity; left out, the program decides"
        raise InputError("damping", "an empty table", allowed)
    if damping.rate is not None and damping.kind != "elastic-velocity":
        why = 'it belongs to kind = "elastic-velocity"; leave it out'
        raise InputError("damping.rate", damping.rate, why)
    if damping.rate is None and damping.kind == "elastic-velocity":
        why = 'kind = "elastic-velocity" needs it; left out, the program decides'
        raise InputError("damping.rate", Missing, why)
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

OF_A_WHOLE_IMPACT = ("vehicle.centre_of_mass", "vehicle.yaw_inertia", "time.end", "verify.mesh")
OF_A_CORNER = {
    "verify.tolerance": "it belongs to a constrained corner; leave it out, or [contact]",
    "impact.convention": "restitution is contact.restitution's, by its law; leave it out",
    "plate.density": "the plate of a whole impact carries vehicle.mass, on which forces depend; leave it out",
    "plate.start": "a whole impact starts at first touch, unstressed; leave it out",
}
"""Keys of scenes with [contact] alone; of those without, and why [contact] excludes them."""

OF_CRUSH = tuple(f"contact.{k}" for k in ("initial_force", "restitution", "side_stiffness", "patch_length"))
OF_NO_CRUSH = ("contact.enforcement", "contact.penalty_scale")


def check_impact(scene: schema.Scene, contact: schema.Contact) -> None:
    """Keys of a whole impact that need or exclude each other. Raises InputError."""
    for name, why in OF_THE_CORNER.items():
        if name in scene.model_fields_set and getattr(scene, name) is not None:
            raise InputError(name, "a table", f"{why}; leave out this table or [contact]")
    if scene.impact is None:
        raise InputError("impact", Missing, "a whole impact starts from this table")
    for key, allowed in OF_A_CORNER.items():
        _refuse(scene, allowed, key)
    _check_contact(scene, contact)
    _check_trailers(scene, contact)
    _check_plate_of_impact(scene, contact)
    for key in ("height", "foundation_stiffness"):
        if scene.wall is not None and getattr(scene.wall, key) is None:
            allowed = "the wall of a whole impact gives, and needs it; without [wall] it is rigid"
            raise InputError(f"wall.{key}", Missing, allowed)


def _check_contact(scene: schema.Scene, contact: schema.Contact) -> None:
    if contact.crushes:
        _refuse(scene, "with contact.stiffness all that touches crushes; leave it out", *OF_NO_CRUSH)
    else:
        _refuse(scene, "it needs contact.stiffness; leave it out", *OF_CRUSH)
    if contact.crushes and contact.restitution is None:
        raise InputError("contact.restitution", Missing, "this key is required, from 0 to 1")
    if contact.enforcement == "exact":
        _refuse(scene, 'enforcement = "exact" has no spring; leave it out', "contact.penalty_scale")


MOST_TRAILERS = 7


def _check_trailers(scene: schema.Scene, contact: schema.Contact) -> None:
    """Raise InputError for hinges that are not within both units, a drawbar of the trailer's length included."""
    if len(scene.trailer) > MOST_TRAILERS:
        allowed = f"allowed are {MOST_TRAILERS}, a train of {MOST_TRAILERS + 1} units"
        raise InputError("trailer", Verbatim(f"{len(scene.trailer)} tables"), allowed)
    for number, (ahead, unit) in enumerate(zip(scene.units, scene.trailer, strict=False)):
        if unit.hitch > ahead.length:
            allowed = f"allowed is from 0 to the length of the unit ahead, {ahead.length:g} m"
            raise InputError(f"trailer.{number}.hitch", unit.hitch, allowed)
        least = 0.0 if scene.plate else -unit.length
        if not least <= unit.kingpin <= unit.length:
            why = (
                "; its plate has no drawbar, which `tailslap rigid` without [plate] takes"
                if scene.plate
                else ""
            )
            allowed = f"allowed is from {least:g} to the trailer's length, {unit.length:g} m{why}"
            raise InputError(f"trailer.{number}.kingpin", unit.kingpin, allowed)
        if unit.stiffness is not None and not contact.crushes:
            raise InputError(
                f"trailer.{number}.stiffness", unit.stiffness, "it needs contact.stiffness; leave it out"
            )


def _check_plate_of_impact(scene: schema.Scene, contact: schema.Contact) -> None:
    plate = scene.plate
    if plate is None:
        if not contact.crushes:
            allowed = "it is required without [plate]: a rigid vehicle touches by its crush alone"
            raise InputError("contact.stiffness", Missing, allowed)
        return
    if not contact.crushes and plate.youngs_modulus is None:
        allowed = "without contact.stiffness the contact takes its stiffness from this key"
        raise InputError("plate.youngs_modulus", Missing, allowed)
    own = any(unit.centre_of_mass or unit.yaw_inertia for unit in scene.units)
    if plate.lumping == "row-sum" and own:
        allowed = 'with a centre of mass or yaw inertia of its own allowed is "exact"'
        raise InputError("plate.lumping", plate.lumping, allowed)


KEY = r"[^.\s]{1,80}(\.[^.\s]{1,80}){0,3}"
"""A dotted key on the command line, as a regular expression."""

LOOSE_NUMBER = re.compile(r"[+-]?([0-9]+\.|\.[0-9]+)([eE][+-]?[0-9]+)?")
"""Numbers like .5 and 10., which TOML does not have."""

MAX_TEXT = 1000
"""Characters of a value on the command line."""

Changes = Mapping[str, Any]
"""Values by dotted key, in the order in which they are put in; None takes the key, or a whole table, out."""


@dataclass(frozen=True)
class Source:
    """Origin of a scene: its file, the tables as given, the keys changed since.

    Attributes
    ----------
    text : str
        The file's, changes noted at the end.
    given : dict
        What was given for each table and key, units included.
    changed : frozenset of str
        Dotted keys changed since the file was read.
    """

    text: str = ""
    given: dict[str, Any] = field(default_factory=dict)
    changed: frozenset[str] = frozenset()

    @classmethod
    def of(cls, scene: schema.Scene) -> Source:
        """A source of what the scene's keys say, in SI."""
        return cls(given=scene.model_dump(exclude_unset=True))


def vary(source: Source, changes: Changes) -> tuple[schema.Scene, Source]:
    """The validated scene with these changes, and its source, which notes them. Raises InputError.

    A key that the scene does not give may be taken out: nothing is noted then.
    """
    tables, noted = changed_tables(source.given, changes)
    text = "".join(f"# changed by --set {change}\n" for change in shown(noted))
    return validate(tables), Source(source.text + text, tables, source.changed | noted.keys())


def varied(scene: schema.Scene, changes: Changes) -> schema.Scene:
    """Return the validated scene with these changes. Raises InputError."""
    return vary(Source.of(scene), changes)[0]


def value_at(scene: Any, key: str) -> Any:
    """The value of a dotted key of a scene, "trailer.0.mass" of a list of tables."""
    for name in key.split("."):
        scene = scene[int(name)] if isinstance(scene, tuple) else getattr(scene, name)
    return scene


def changed_tables(given: Mapping[str, Any], changes: Changes) -> tuple[dict[str, Any], dict[str, Any]]:
    """The tables with the changes put in, the given ones left alone; and those that changed anything."""
    tables = dict(given)
    noted = {key: value for key, value in changes.items() if _put(tables, key, value)}
    return tables, noted


def parse_changes(texts: Iterable[str], given: Mapping[str, Any]) -> dict[str, Any]:
    """Values by key of KEY=VALUE texts, for a scene that gives these tables. Raises InputError."""
    found: dict[str, Any] = {}
    for text in texts:
        key, equals, value = (part.strip() for part in text.partition("="))
        if not equals or not re.fullmatch(KEY, key):
            raise InputError("--set", text, 'allowed is KEY=VALUE, like plate.youngs_modulus="2 TPa"')
        found.pop(key, None)  # the last one counts, in its place
        found[key] = parse_value(value) if value else None
        _demand_effect(found, key, text, given)
    return found


def _demand_effect(changes: Changes, key: str, text: str, given: Mapping[str, Any]) -> None:
    """Raise InputError where the last change, typed as this text, cannot be put in, or takes out what is not there."""
    try:
        noted = changed_tables(given, changes)[1]
    except InputError as error:
        raise InputError("--set", text, error.allowed) from None
    if key not in noted:
        allowed = "the scene does not give this key: there is nothing to take out"
        raise InputError("--set", text, allowed)


def parse_value(text: str) -> Any:
    """A TOML value if it is one, else the text itself, for the shell has taken its quotes.

    Text with a comment or a second line is no value: part of it would be dropped without a word.
    """
    if re.search(r"[#\r\n]", text) or len(text) > MAX_TEXT:
        return text
    if LOOSE_NUMBER.fullmatch(text):
        return float(text)
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except (ValueError, RecursionError):
        return text


def depth_exceeds(value: Any, most: int) -> bool:
    """True if tables and lists are nested deeper than this."""
    level = [value]
    for _ in range(most + 1):
        level = [
            inner
            for outer in level
            if isinstance(outer, Mapping | list)
            for inner in (outer.values() if isinstance(outer, Mapping) else outer)
        ]
    return bool(level)


def shown(changes: Changes) -> tuple[str, ...]:
    """The changes as --set takes them."""
    return tuple(f"{key}={_shown(value)}" for key, value in changes.items())


def _shown(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    return str(list(value)) if isinstance(value, tuple) else str(value)


def _put(tables: Any, key: str, value: Any) -> bool:
    """Put a value in, tables on the way to it copied; whether that changes anything."""
    *path, last = key.split(".")
    for name in path:
        place = _place(tables, name, key, value)
        if isinstance(tables, dict) and place not in tables:
            if value is None:
                return False
            tables[place] = {}
        inner = tables[place]
        if not isinstance(inner, Mapping) and not _lists_tables(inner):
            raise InputError(key, value, f'"{name}" is a value, not a table')
        tables[place] = tables = dict(inner) if isinstance(inner, Mapping) else list(inner)
    place = _place(tables, last, key, value)
    if value is None:
        return (tables.pop(place) if isinstance(tables, list) else tables.pop(place, None)) is not None
    tables[place] = value
    return True


def _lists_tables(value: Any) -> bool:
    return isinstance(value, list | tuple) and bool(value) and isinstance(value[0], Mapping)


def _place(tables: Any, name: str, key: str, value: Any) -> Any:
    """Name of an entry of a table, or number of one of a list of tables."""
    if not isinstance(tables, list):
        return name
    if not name.isdecimal() or int(name) >= len(tables):
        raise InputError(key, value, f"tables of a list have numbers; allowed are 0 to {len(tables) - 1}")
    return int(name)
