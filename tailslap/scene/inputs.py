"""The inputs of a scene as a table: what was given, its value in SI, and where it came from."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, get_args

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from tailslap.scene.schema import Plate, Scene
from tailslap.scene.units import Quantity
from tailslap.scene.vary import Source


@dataclass(frozen=True)
class SceneInput:
    """An input as used: dotted key, the words of the scene, the SI value, and where it came from."""

    key: str
    given: str
    value: float | int | str | None
    unit: str = ""
    origin: str = "scene"


def scene_inputs(scene: Scene, source: Source) -> tuple[SceneInput, ...]:
    """A row for every key that has a value; keys that the scene left to their defaults say so."""
    rows = _rows(scene, source.given, source.changed, "")
    unused = ("corner.", "strike.") if scene.contact else ()
    return tuple(row for row in rows if not row.key.startswith(unused))


def resolved_inputs(
    scene: Scene, source: Source, plate: Plate, chosen: frozenset[str] = frozenset()
) -> tuple[SceneInput, ...]:
    """The same, with the modulus that the first frequency has given the plate; chosen: keys that it filled in."""
    rows = scene_inputs(scene.model_copy(update={"plate": plate}), source)
    origin = "from plate.first_frequency"
    known = scene.plate is not None and scene.plate.youngs_modulus is not None
    origins = dict.fromkeys(chosen, "chosen by the program")
    if not known:
        origins["plate.youngs_modulus"] = origin
    return tuple(replace(row, origin=origins.get(row.key, row.origin)) for row in rows)


def _rows(table: BaseModel, given: dict[str, Any], changed: frozenset[str], prefix: str) -> list[SceneInput]:
    rows = []
    for name, field in type(table).model_fields.items():
        value, key = getattr(table, name), prefix + name
        if isinstance(value, BaseModel):
            rows += _rows(value, given.get(name, {}), changed, f"{key}.")
        elif value is not None:
            origin = "--set" if key in changed else "scene" if name in given else "default"
            shown = value if isinstance(value, int | float | str) else " x ".join(map(str, value))
            rows.append(SceneInput(key, str(given.get(name, "")), shown, unit_of(field), origin))
    return rows


def unit_of(field: FieldInfo) -> str:
    """SI unit of a key, from its annotation; "" for what has none."""
    marks = [*field.metadata, *(mark for kind in get_args(field.annotation) for mark in get_args(kind))]
    return next((mark.unit for mark in marks if isinstance(mark, Quantity)), "")
