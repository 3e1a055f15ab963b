"""Write scenes as text, a new scene, and the table of inputs."""

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
from tailslap.scene.model_tables import Plate
from tailslap.scene.vehicle_tables import StripTable

EXAMPLE: Mapping[str, Mapping[str, str | float]] = {
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

IN_SPACE = {"centre_height": "1.3 m", "roll_inertia": "12000 kg m^2", "pitch_inertia": "88000 kg m^2"}
OPTIONAL: Mapping[str, Mapping[str, str | list[str]]] = {
    "vehicle": {"centre_of_mass": "5 m"},
    "trailer": {
        "length": "48 ft",
        "width": "102 in",
        "mass": "61910 lb",
        "centre_of_mass": "6.8 m",
        "yaw_inertia": "500000 kg m^2",
        "hitch_length": "1.5 m",
    }
    | IN_SPACE
    | {"hitch_height": "1.2 m"},
    "corner": {"patch_length": "1 m"},
    "contact": {"patch_length": "1 m"},
    "axle": {
        "track": "1.85 m",
        "radius": "0.5 m",
        "mass": "400 kg",
        "spring": "0.2 MN/m",
        "spacing": "1 m",
        "tyre": "0.9 MN/m",
    },
    "body": IN_SPACE,
    "strip": {"height": ["0.45 m", "0.9 m"], "inset": "0.1 m", "stiffness": "4 MN/m^2"},
    "parapet": {
        "height": "36 in",
        "length": "12 m",
        "end_distance": "3 m",
        "load_length": "1.067 m",
        "load_height": "36 in",
    },
    "wall": {"length": "20 m", "depth": "0.3 m", "height": "32 in", "profile": "new-jersey"},
}
"""Examples in the comments where that of the quantity does not fit the key."""


def scene_text(source: vary.Source) -> str:
    """Return a scene file that reproduces this run.

    It is the original file, or has all tables where keys were changed and where there was no file.
    """
    if source.text and not source.changed:
        return source.text
    title = source.text.partition("\n")[0]
    changed = [f"# changed: {', '.join(sorted(source.changed))}"] if source.changed else []
    return "\n".join([*([title] if title.startswith("#") else []), *changed, *_lines(source.tables)]) + "\n"


def scene_file(tables: Mapping[str, object], title: str) -> str:
    """Return the text of a scene file.

    Values are numbers in SI.
    """
    return "\n".join([f"# {title}", *_lines(tables)]) + "\n"


def _lines(tables: Mapping[str, Any], prefix: str = "") -> list[str]:
    """Return the lines of a scene file.

    prefix: of the tables' dotted names.
    """
    lines, below = [], list[str]()
    for key, value in tables.items():
        name = f"{prefix}{key}"
        if isinstance(value, Mapping):
            below += ["", f"[{name}]", *_lines(value, f"{name}.")]
        elif name in schema.LISTED:
            below += [line for table in value for line in ("", f"[[{name}]]", *_lines(table, f"{name}."))]
        elif value is not None:
            lines.append(f"{key} = {toml_value(value)}")
    return lines + below


def toml_value(value: object) -> str:
    """Return a value in TOML."""
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(toml_value, value))}]"
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str | bool) else repr(value)


@checked_arguments
def new(name: str) -> Path:
    """Write NAME.toml in the current folder.

    It is a scene with every key, its meaning and an example.

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
    """Return the text of a scene with every key and its meaning.

    Optional keys are comments.
    """
    lines = [f"# {name}: replace the values; lines that begin with # are optional keys", ""]
    lines.append(f"name = {toml_value(name)}")
    for table, kind in schema.TABLES.items():
        values, examples = EXAMPLE.get(table, {}), OPTIONAL.get(table, {})
        header = f"[[{table}]]" if table in schema.LISTED else f"[{table}]"
        lines += ["", f"{'' if values else '# '}{header}"]
        lines += [
            _line(key, field, values.get(key), examples.get(key))
            for key, field in schema.values_of(kind).items()
        ]
    return "\n".join(lines) + "\n"


def _line(name: str, field: FieldInfo, value: str | float | None, comment: str | list[str] | None) -> str:
    """Return the line of a key with its value and meaning.

    A key without a value is a comment with an example.
    """
    default = None if field.is_required() else field.default
    values = [toml_value(text) for text in (value, comment, default) if text is not None]
    front = "" if value is not None else "# "
    line = f"{front}{name} = {(values or [example(field)])[0]}"
    return f"{line:<34}  # {field.description}"


def example(field: FieldInfo) -> str:
    """Return an example of a value of a key, in TOML."""
    marks = [*field.metadata, *(mark for kind in get_args(field.annotation) for mark in get_args(kind))]
    for mark in marks:
        if isinstance(mark, units.Quantity):
            return mark.example
        if isinstance(mark, str):
            return toml_value(mark)
    if field.annotation is int:
        return "10"
    if any(int in (kind, *get_args(kind)) for kind in get_args(field.annotation)):
        return "0"
    return "[20, 6]" if "tuple" in str(field.annotation) else toml_value(next(iter(materials.MATERIALS)))


@dataclass(frozen=True)
class SceneInput:
    """Key of a run with value and origin."""

    key: str
    scene_text: str
    value: float | int | str | None
    unit: str = ""
    origin: str = "scene"


def scene_inputs(scene: schema.Scene, source: vary.Source) -> tuple[SceneInput, ...]:
    """Return rows of all keys with values.

    Defaults are included.
    """
    unused = ["corner.", "strike."] if scene.contact else ["verify.mesh"]
    unused += [] if scene.plate else ["verify."]
    origins = {key: f"--set, not in {unit}" for key, unit in plain_numbers(source).items()}
    if scene.contact and scene.contact.strike_duration is not None:
        origins["contact.stiffness"] = "from contact.strike_duration"
    rows = _rows(scene, source.tables, source.changed, "")
    used = (row for row in rows if not row.key.startswith(tuple(unused)))
    return tuple(replace(row, origin=origins.get(row.key, row.origin)) for row in used)


def plain_numbers(source: vary.Source) -> dict[str, str]:
    """Return units of the file by keys changed to plain numbers.

    Keys in SI in the scene's file are not among them.
    """
    before, lost_units = tomllib.loads(source.text), {}
    for key in sorted(source.changed):
        earlier, changed = (validate.value_in(tables, key) for tables in (before, source.tables))
        match = units.NUMBER.fullmatch(earlier) if isinstance(earlier, str) else None
        if match and match[2] and isinstance(changed, int | float) and units.to_si(match[2])[0] != 1.0:
            lost_units[key] = match[2]
    return lost_units


def resolved_inputs(
    scene: schema.Scene, source: vary.Source, plate: Plate, chosen: Mapping[str, object] | None = None
) -> tuple[SceneInput, ...]:
    """Return the rows of `scene_inputs` with the resolved modulus.

    chosen: automatically selected values by key.
    """
    chosen = chosen or {}
    rows = scene_inputs(scene.model_copy(update={"plate": plate}), source)
    numbers = {key: value for key, value in chosen.items() if isinstance(value, int | float)}
    origins = dict.fromkeys(chosen, "automatic")
    if scene.plate is None or scene.plate.youngs_modulus is None:
        origins["plate.youngs_modulus"] = "from plate.first_frequency"
    return tuple(
        replace(row, value=numbers.get(row.key, row.value), origin=origins.get(row.key, row.origin))
        for row in rows
    )


def _rows(table: BaseModel, entries: vary.Tables, changed: frozenset[str], prefix: str) -> list[SceneInput]:
    """Return rows of the values of nested tables."""
    rows = []
    for name, field in type(table).model_fields.items():
        value, key = getattr(table, name), prefix + name
        if isinstance(value, BaseModel):
            rows += _rows(value, entries.get(name) or {}, changed, f"{key}.")
        elif name in schema.LISTED and isinstance(value, tuple):  # [[strip]] has a number of this name
            tables = dict(enumerate(entries.get(name, ())))
            for number, unit in enumerate(value):
                rows += _rows(unit, tables.get(number, {}), changed, f"{key}.{number}.")
        elif value is not None:
            origin = "--set" if key in changed else "scene" if name in entries else "default"
            text = value if isinstance(value, int | float | str) else " x ".join(map(str, value))
            unit = unit_of(field, is_point=isinstance(table, StripTable) and table.is_point)
            rows.append(SceneInput(key, str(entries.get(name, "")), text, unit, origin))
    return rows


def in_scene_unit(source: vary.Source, key: str) -> str:
    """Return the text of a quantity in the unit of the scene.

    A plain number is in SI, or in the units of the reader.
    """
    value = validate.value_in(source.tables, key)
    if isinstance(value, str) and (match := units.NUMBER.fullmatch(value)):
        return f"{float(match[1]):.6g} {match[2]}"
    return measure(value, unit_at(key, source.tables), ".6g")


def unit_at(key: str, tables: vary.Tables | None = None) -> str:
    """Return the SI unit of a dotted key, "" without one.

    tables: of the scene, which say whether a strip is a point.
    """
    quantity = quantity_at(key, tables)
    return quantity.unit if quantity else ""


def quantity_at(key: str, tables: vary.Tables | None = None) -> units.Quantity | None:
    """Return the quantity of a dotted key, None for other values.

    tables: as of `unit_at`.
    """
    table, *_, name = key.partition("@")[0].split(".")
    strip = validate.value_in(tables or {}, key.rpartition(".")[0]) if table == "strip" else None
    is_point = isinstance(strip, Mapping) and "height" not in strip and not isinstance(strip.get("at"), list)
    return _quantity(schema.TABLES[table].model_fields[name], is_point)


def unit_of(field: FieldInfo, is_point: bool = False) -> str:
    """Return a key's SI unit, "" without one.

    is_point: of a strip that is a point.
    """
    quantity = _quantity(field, is_point)
    return quantity.unit if quantity else ""


def _quantity(field: FieldInfo, is_point: bool = False) -> units.Quantity | None:
    """Return the quantity of a key, None for other values.

    is_point: of a strip that is a point.
    """
    marks = [*field.metadata, *(mark for kind in get_args(field.annotation) for mark in get_args(kind))]
    quantity = next((mark for mark in marks if isinstance(mark, units.Quantity)), None)
    if is_point and isinstance(quantity, units.OfStrip):
        quantity = quantity.of_point
    return quantity
