"""Scenes as text: the scene of a run, a new scene with every key, and the table of inputs."""

import json
import tomllib
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, get_args

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from fem.laws import materials
from postprocess.units import measure
from tailslap.arguments import checked_arguments
from tailslap.errors import InputError, place_error
from tailslap.scene import schema, units, validate, vary


def scene_text(source: vary.Source) -> str:
    """Scene file that reproduces this run: the original file, or all tables where keys were changed."""
    if not source.changed:
        return source.text
    title = source.text.partition("\n")[0]
    changed = f"# changed: {', '.join(sorted(source.changed))}"
    return "\n".join([*([title] if title.startswith("#") else []), changed, *_lines(source.given)]) + "\n"


def scene_file(tables: Mapping[str, Any], title: str) -> str:
    """Text of a scene file with a title and these tables; values are numbers in SI."""
    return "\n".join([f"# {title}", *_lines(tables)]) + "\n"


def _lines(tables: Mapping[str, Any]) -> list[str]:
    lines, below = [], list[str]()
    for name, value in tables.items():
        if isinstance(value, Mapping):
            below += ["", f"[{name}]", *_lines(value)]
        elif name in schema.LISTED:
            below += [line for table in value for line in ("", f"[[{name}]]", *_lines(table))]
        elif value is not None:
            lines.append(f"{name} = {toml_value(value)}")
    return lines + below


def toml_value(value: Any) -> str:
    """Value in TOML."""
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(toml_value, value))}]"
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str | bool) else repr(value)


EXAMPLE: Mapping[str, Mapping[str, Any]] = {
    "vehicle": {"length": "10 m", "width": "2438 mm", "mass": "9979 kg"},
    "impact": {
        "speed": "56 mph",
        "angle": "15 deg",
        "friction": 0.47,
        "restitution": 0.22,
        "test_level": "TL-4",
    },
    "plate": {"thickness": "53 mm", "youngs_modulus": "200 GPa", "poissons_ratio": 0.3},
}
"""Values of a new scene; all other keys are comments."""

UNIT = {
    "centre_height": "1.35 m",
    "roll_inertia": "12000 kg m^2",
    "track": "1.85 m",
    "suspension": "1.4 MN/m",
}
OPTIONAL: Mapping[str, Mapping[str, str]] = {
    "vehicle": {"centre_of_mass": "5 m"},
    "trailer": {
        "length": "48 ft",
        "width": "102 in",
        "mass": "61910 lb",
        "centre_of_mass": "6.8 m",
        "yaw_inertia": "500000 kg m^2",
        "hitch_length": "1.5 m",
    }
    | UNIT,
    "corner": {"patch_length": "1 m"},
    "contact": {"patch_length": "1 m"},
    "tipping": UNIT,
    "wall": {"length": "20 m", "depth": "0.3 m", "height": "32 in"},
}
"""Examples in the comments where that of the quantity is none of the key."""


@checked_arguments
def new(name: str) -> Path:
    """Write NAME.toml in the current folder, a scene with every key, its meaning and an example.

    Parameters
    ----------
    name : str
        Name of the scene.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        For an invalid name or an existing file.

    Examples
    --------
    >>> import tailslap
    >>> tailslap.rigid(tailslap.new("my-truck")).scene
    'my-truck'
    """
    stem = name.removesuffix(".toml")
    validate.validate({"name": stem, **EXAMPLE})
    path, text = Path(f"{stem}.toml"), new_scene(stem)
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        allowed = f"{path} exists; allowed is the name of a new file"
        raise InputError("NAME", name, allowed) from None
    except OSError as error:
        with suppress(OSError):
            path.unlink()
        raise place_error(path, "the file cannot be written", error, "NAME") from None
    return path


def new_scene(name: str) -> str:
    """Text of a scene with every key and its meaning; optional keys are comments."""
    lines = [f"# {name}: replace the values; lines that begin with # are optional keys", ""]
    lines.append(f"name = {toml_value(name)}")
    for key, table in schema.TABLES.items():
        given = EXAMPLE.get(key, {})
        header = f"[[{key}]]" if key in schema.LISTED else f"[{key}]"
        lines += ["", f"{'' if given else '# '}{header}"]
        shown = OPTIONAL.get(key, {})
        lines += [
            _line(name, own, given.get(name), shown.get(name)) for name, own in table.model_fields.items()
        ]
    return "\n".join(lines) + "\n"


def _line(name: str, field: FieldInfo, given: Any, shown: str | None) -> str:
    """Line of a key with its value, or with an example as a comment, and its meaning."""
    default = None if field.is_required() else field.default
    values = [toml_value(value) for value in (given, shown, default) if value is not None]
    front = "" if given is not None else "# "
    line = f"{front}{name} = {(values or [example(field)])[0]}"
    return f"{line:<34}  # {field.description}"


def example(field: FieldInfo) -> str:
    """Example of a value of a key, in TOML."""
    marks = [*field.metadata, *(mark for kind in get_args(field.annotation) for mark in get_args(kind))]
    for mark in marks:
        if isinstance(mark, units.Quantity):
            return mark.example
        if isinstance(mark, str):
            return toml_value(mark)
    if field.annotation is int:
        return "10"
    return "[20, 6]" if "tuple" in str(field.annotation) else toml_value(next(iter(materials.MATERIALS)))


@dataclass(frozen=True)
class SceneInput:
    """Input as used: dotted key, text of the scene, SI value and origin."""

    key: str
    given: str
    value: float | int | str | None
    unit: str = ""
    origin: str = "scene"


def scene_inputs(scene: schema.Scene, source: vary.Source) -> tuple[SceneInput, ...]:
    """Rows of all keys that have a value, defaults included."""
    rows = _rows(scene, source.given, source.changed, "")
    unused = ["corner.", "strike."] if scene.contact else ["verify.mesh"]
    unused += [] if scene.plate else ["verify."]
    if scene.contact and scene.contact.strike_duration is not None:
        origin = "from contact.strike_duration"
        rows = [replace(row, origin=origin) if row.key == "contact.stiffness" else row for row in rows]
    plain = plain_numbers(source)
    rows = [
        replace(row, origin=f"--set, not in {plain[row.key]}") if row.key in plain else row for row in rows
    ]
    return tuple(row for row in rows if not row.key.startswith(tuple(unused)))


def plain_numbers(source: vary.Source) -> dict[str, str]:
    """Units other than SI that keys have in the scene's file and that were changed to numbers without a unit."""
    before, found = tomllib.loads(source.text), {}
    for key in sorted(source.changed):
        earlier, now = (vary.given_at(tables, key) for tables in (before, source.given))
        match = units.NUMBER.fullmatch(earlier) if isinstance(earlier, str) else None
        if match and match[2] and isinstance(now, int | float) and units.to_si(match[2])[0] != 1.0:
            found[key] = match[2]
    return found


def resolved_inputs(
    scene: schema.Scene, source: vary.Source, plate: schema.Plate, chosen: Mapping[str, Any] | None = None
) -> tuple[SceneInput, ...]:
    """Rows of `scene_inputs` with the resolved modulus of the plate; chosen: automatically selected values by key."""
    chosen = chosen or {}
    rows = scene_inputs(scene.model_copy(update={"plate": plate}), source)
    numbers = {key: value for key, value in chosen.items() if isinstance(value, int | float)}
    origin = "from plate.first_frequency"
    known = scene.plate is not None and scene.plate.youngs_modulus is not None
    origins = dict.fromkeys(chosen, "automatic")
    if not known:
        origins["plate.youngs_modulus"] = origin
    return tuple(
        replace(row, value=numbers.get(row.key, row.value), origin=origins.get(row.key, row.origin))
        for row in rows
    )


def _rows(table: BaseModel, given: dict[str, Any], changed: frozenset[str], prefix: str) -> list[SceneInput]:
    rows = []
    for name, field in type(table).model_fields.items():
        value, key = getattr(table, name), prefix + name
        if isinstance(value, BaseModel):
            rows += _rows(value, given.get(name, {}), changed, f"{key}.")
        elif name in schema.LISTED:
            tables = dict(enumerate(given.get(name, ())))
            for number, unit in enumerate(value):
                rows += _rows(unit, tables.get(number, {}), changed, f"{key}.{number}.")
        elif value is not None:
            origin = "--set" if key in changed else "scene" if name in given else "default"
            shown = value if isinstance(value, int | float | str) else " x ".join(map(str, value))
            rows.append(SceneInput(key, str(given.get(name, "")), shown, unit_of(field), origin))
    return rows


def as_given(source: vary.Source, key: str) -> str:
    """A quantity of the scene in the unit in which it is given; a plain number in SI, or the units of the reader."""
    given = vary.given_at(source.given, key)
    if isinstance(given, str) and (found := units.NUMBER.fullmatch(given)):
        return f"{float(found[1]):.6g} {found[2]}"
    return measure(given, unit_at(key), ".6g")


def unit_at(key: str) -> str:
    """SI unit of a dotted key; "" without one."""
    table, *_, name = key.split(".")
    return unit_of(schema.TABLES[table].model_fields[name])


def unit_of(field: FieldInfo) -> str:
    """SI unit of a key, from its annotation; "" without one."""
    marks = [*field.metadata, *(mark for kind in get_args(field.annotation) for mark in get_args(kind))]
    return next((mark.unit for mark in marks if isinstance(mark, units.Quantity)), "")
