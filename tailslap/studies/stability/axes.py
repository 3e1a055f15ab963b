"""The axes of the stability map: what varies, over which values, and how it enters the scene."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations
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
    """A cell of the map: the pair of axes and the two values."""

    first: str
    second: str
    values: tuple[float, float]

    @property
    def key(self) -> str:
        """Name by which a journal knows the cell."""
        return f"{self.first}={self.values[0]!r} {self.second}={self.values[1]!r}"


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


def cells(axes: tuple[Axis, ...]) -> list[Cell]:
    """Every cell: each pair of axes, each pair of their values."""
    return [
        Cell(first.name, second.name, (x, y))
        for first, second in combinations(axes, 2)
        for x in first.values
        for y in second.values
    ]


def base_tables(scene: Scene) -> Tables:
    """The scene's tables, SI, as the cells change them; the wall is left out, since slides differ."""
    tables: Tables = scene.model_dump(exclude_unset=True)
    tables.pop("wall", None)
    tables["name"] = scene.name  # type: ignore[assignment]
    return tables


def cell_tables(base: Tables, axes: tuple[Axis, ...], cell: Cell) -> Tables:
    """The tables of one cell."""
    tables, by_name = copy.deepcopy(base), {axis.name: axis for axis in axes}
    for name, value in zip((cell.first, cell.second), cell.values, strict=True):
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
