"""Finds, reads, changes and validates scenes."""

from __future__ import annotations

import difflib
import tomllib
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from fem.contact.constraints import CONSTRAINTS
from fem.discretisation.element_kinds import ELEMENT_KINDS
from tailslap.errors import InputError, Missing, Verbatim
from tailslap.scene.schema import Damping, Scene


@dataclass(frozen=True)
class Source:
    """Where a scene came from.

    Attributes
    ----------
    text : str
        The file's, changes noted at the end.
    given : dict
        What was given for each table and key, units included.
    changed : frozenset of str
        Dotted keys changed by --set.
    """

    text: str = ""
    given: dict[str, Any] = field(default_factory=dict)
    changed: frozenset[str] = frozenset()


def shipped_scenes() -> dict[str, str]:
    """Scenes that come with the program: name and text."""
    folder = files("tailslap") / "scenes"
    found = sorted(
        (item for item in folder.iterdir() if item.name.endswith(".toml")), key=lambda item: item.name
    )
    return {item.name.removesuffix(".toml"): item.read_text(encoding="utf-8") for item in found}


def title(text: str) -> str:
    """A scene's first line, which is a comment that says what it is."""
    return text.splitlines()[0].lstrip("# ").rstrip()


def read_scene(name: str, changes: tuple[str, ...] = ()) -> tuple[Scene, Source]:
    """Read and validate a scene.

    Parameters
    ----------
    name : str
        Path of a .toml file, or the name of a scene that comes with the program.
    changes : tuple of str
        As given by --set, "plate.thickness=20 mm"; "plate.density=" takes the key out.

    Returns
    -------
    scene : Scene
        SI.
    source : Source
        Where it came from.

    Raises
    ------
    InputError
        For a file that cannot be read, or the first key that is wrong.
    """
    return scene_of_text(scene_text(name), changes, name)


def scene_of_text(text: str, changes: tuple[str, ...] = (), name: str = "SCENE") -> tuple[Scene, Source]:
    """The same for a scene's text, where the file itself may be on another machine; name: what errors call it."""
    data, changed = changed_tables(text, changes, name)
    noted = "".join(f"# changed by --set {change}\n" for change in changes)
    return validate(data), Source(text.rstrip("\n") + "\n" + noted, data, changed)


def changed_tables(
    text: str, changes: tuple[str, ...], name: str = "SCENE"
) -> tuple[dict[str, Any], frozenset[str]]:
    """The tables of a scene's text with the changes put in, and the keys that these change. Raises InputError."""
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(name, "a file that is not TOML", f"the parser says: {error}") from None
    return data, frozenset(_apply(data, change) for change in changes)


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


def scene_text(name: str) -> str:
    """Text of a scene's file, or of a scene that comes with the program. Raises InputError."""
    shipped = shipped_scenes()
    path = Path(name)
    if name in shipped and not path.is_file():
        return shipped[name]
    if path.suffix != ".toml" and not path.exists():
        near = difflib.get_close_matches(name, shipped, 1)
        hint = f'; did you mean "{near[0]}"?' if near else ""
        raise InputError("SCENE", name, f"allowed is a .toml file or one of {', '.join(shipped)}{hint}")
    try:
        return path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise InputError("SCENE", name, "there is no such file") from None
    except (OSError, UnicodeDecodeError) as error:
        raise InputError("SCENE", name, f"the file cannot be read: {error}") from None


def _apply(data: dict[str, Any], change: str) -> str:
    """Put one KEY=VALUE into the tables, or take the key out where there is no value; returns the key."""
    key, equals, value = change.partition("=")
    *tables, last = key.strip().split(".")
    if not equals or not all((*tables, last)):
        raise InputError("--set", change, 'allowed is KEY=VALUE, like plate.youngs_modulus="2 TPa"')
    for table in tables:
        data = data.setdefault(table, {})
        if not isinstance(data, dict):
            raise InputError("--set", change, f'"{table}" is a value, not a table')
    if value.strip():
        data[last] = _value(value.strip())
    elif data.pop(last, None) is None:
        raise InputError("--set", change, "the scene does not give this key: there is nothing to take out")
    return key.strip()


def _value(text: str) -> Any:
    """A TOML value if it is one, else the text itself, for the shell has taken its quotes."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text


def _input_error(error: ValidationError) -> InputError:
    first = error.errors()[0]
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
    return f"allowed are {', '.join(model.model_fields)}"


def _check_together(scene: Scene) -> None:
    """Keys that need or exclude each other."""
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
    _check_plate(scene)


def _check_plate(scene: Scene) -> None:
    """Keys of the finite-element model that need or exclude each other."""
    tables = {
        "material": scene.material,
        "damping": scene.damping,
        "verify": scene.verify,
        "wall": scene.wall,
    }
    for name, table in tables.items():
        if table and not scene.plate:
            raise InputError(name, "a table", "it has no meaning without [plate]; leave it out")
    for key in ("penalty_scale", "damping_ratio"):
        constraint = CONSTRAINTS[scene.corner.constraint]
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
    if plate and not ELEMENT_KINDS[plate.element].hourglass and "hourglass" in plate.model_fields_set:
        needing = " or ".join(f'"{name}"' for name, kind in ELEMENT_KINDS.items() if kind.hourglass)
        raise InputError(
            "plate.hourglass", plate.hourglass, f"only element = {needing} needs it; leave it out"
        )
    if plate and plate.lumping == "row-sum" and not ELEMENT_KINDS[plate.element].row_sums:
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
