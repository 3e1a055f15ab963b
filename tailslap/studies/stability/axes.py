"""The axes of the stability map: what varies, over which values, and how it enters the scene."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import combinations, product
from typing import Any

import numpy as np

from tailslap.scene.schema import Scene

Tables = dict[str, dict[str, Any]]


@dataclass(frozen=True)
class Axis:
    """A quantity that varies: name, what its numbers mean, values, its setter."""

    name: str
    meaning: str
    values: tuple[float, ...]
    apply: Callable[[Tables, float], None]


@dataclass(frozen=True)
class Cell:
    """A scene of the campaign: its key in the journal, its entries in the table of cells, and its tables."""

    key: str
    entries: dict[str, Any]
    tables: Tables


def stability_axes(scene: Scene, points: int) -> tuple[Axis, ...]:
    """The axes that mean something for this scene, each with this many values."""

    def ratios(low: float, high: float, count: int = points) -> tuple[float, ...]:
        return tuple(np.geomspace(low, high, count).tolist())

    def even(low: float, high: float) -> tuple[float, ...]:
        return tuple(np.linspace(low, high, points).tolist())

    axes = [
        Axis("stiffness", "E over the scene's", ratios(1e-4, 1e4), _stiffness),
        Axis("penalty", "corner.penalty_scale", ratios(1e-3, 1e4), _penalty),
        Axis("friction", "corner.friction", even(0.0, 2.0), _friction),
        Axis("speed", "speeds over the scene's", ratios(1e-2, 1e1), _speed),
        Axis("angle", "angle [deg]", ratios(1.0, 80.0), _angle),
        Axis("slenderness", "width over length", ratios(0.01, 1.0), _slenderness),
        Axis("time step", "time.safety_factor", even(0.5, 1.2), _time_step),
        Axis("damping", "damping.ratio", (0.0, *ratios(3e-3, 1.0, points - 1)), _damping),
    ]
    absent = {"friction"} if scene.corner.frictionless else set()
    absent |= {"penalty"} if scene.corner.constraint == "exact" else set()
    return tuple(axis for axis in axes if axis.name not in absent)


def map_cells(base: Tables, axes: tuple[Axis, ...]) -> list[Cell]:
    """Every cell of the map: each pair of axes, each pair of their values."""
    return [
        _map_cell(base, pair, values)
        for pair in combinations(axes, 2)
        for values in product(*(axis.values for axis in pair))
    ]


def _map_cell(base: Tables, pair: tuple[Axis, ...], values: tuple[float, ...]) -> Cell:
    (first, second), (x, y) = pair, values
    entries = {"first": first.name, "first_value": x, "second": second.name, "second_value": y}
    point = {first.name: x, second.name: y}
    return Cell(cell_key(point), entries, cell_tables(base, pair, point))


def cell_key(point: Mapping[str, float]) -> str:
    """Key of the cell where the axes have these values."""
    return " ".join(f"{name}={value!r}" for name, value in point.items())


def base_tables(scene: Scene) -> Tables:
    """The scene's tables, SI, as the cells change them; the wall is left out, since slides differ."""
    tables: Tables = scene.model_dump(exclude_unset=True)
    tables.pop("wall", None)
    tables["name"] = scene.name  # type: ignore[assignment]
    return tables


def cell_tables(base: Tables, axes: tuple[Axis, ...], point: Mapping[str, float]) -> Tables:
    """The scene's tables where the axes have these values, in their order."""
    tables, by_name = copy.deepcopy(base), {axis.name: axis for axis in axes}
    for name, value in point.items():
        by_name[name].apply(tables, value)
    return tables


def _stiffness(tables: Tables, factor: float) -> None:
    plate = tables["plate"]
    if "first_frequency" in plate:
        plate["first_frequency"] *= math.sqrt(factor)
    else:
        plate["youngs_modulus"] *= factor


def _penalty(tables: Tables, value: float) -> None:
    tables.setdefault("corner", {})["penalty_scale"] = value


def _friction(tables: Tables, value: float) -> None:
    tables.setdefault("corner", {})["friction"] = value


def _speed(tables: Tables, factor: float) -> None:
    for table, keys in (("impact", ("speed",)), ("start", ("omega", "corner_speed"))):
        for key in keys:
            if key in tables.get(table, {}):
                tables[table][key] *= factor


def _angle(tables: Tables, degrees: float) -> None:
    for table in ("impact", "start"):
        if "angle" in tables.get(table, {}):
            tables[table]["angle"] = math.radians(degrees)


def _slenderness(tables: Tables, ratio: float) -> None:
    tables["vehicle"]["width"] = ratio * tables["vehicle"]["length"]


def _time_step(tables: Tables, factor: float) -> None:
    tables.setdefault("time", {})["safety_factor"] = factor


def _damping(tables: Tables, ratio: float) -> None:
    if ratio > 0.0:
        tables.setdefault("damping", {})["ratio"] = ratio
    else:
        tables.get("damping", {}).pop("ratio", None)
        if not tables.get("damping"):
            tables.pop("damping", None)
