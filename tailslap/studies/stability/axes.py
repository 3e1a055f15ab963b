"""The axes of the stability map: what varies, over which values, and how it enters the scene."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import combinations, product
from typing import Any

import numpy as np

from tailslap.scene.schema import Scene
from tailslap.scene.vary import Changes, Source, changed_tables, vary


@dataclass(frozen=True)
class Axis:
    """A quantity that varies: name, what its numbers mean, values, what a value changes in a scene."""

    name: str
    meaning: str
    values: tuple[float, ...]
    changes: Callable[[Scene, float], Changes]


@dataclass(frozen=True)
class Cell:
    """A scene of the campaign: its key in the journal, its entries in the table of cells, and what it changes in which
    scene; that need not make a scene."""

    key: str
    entries: dict[str, Any]
    base: Source
    changes: Changes

    @property
    def tables(self) -> dict[str, Any]:
        """Its tables, as in a scene file."""
        return changed_tables(self.base.given, self.changes)[0]


def of_key(name: str, key: str, values: tuple[float, ...], meaning: str = "") -> Axis:
    """The axis of a key of the scene."""
    return Axis(name, meaning or key, values, lambda scene, value: {key: value})


def ratios(low: float, high: float, count: int) -> tuple[float, ...]:
    """Values in equal ratios."""
    return tuple(np.geomspace(low, high, count).tolist())


def even(low: float, high: float, count: int) -> tuple[float, ...]:
    """Values at equal distances."""
    return tuple(np.linspace(low, high, count).tolist())


def stability_axes(scene: Scene, n: int) -> tuple[Axis, ...]:
    """The axes that mean something for this scene, each with n values."""
    axes = [
        Axis("stiffness", "E over the scene's", ratios(1e-4, 1e4, n), _stiffness),
        of_key("penalty", "corner.penalty_scale", ratios(1e-3, 1e4, n)),
        of_key("friction", "corner.friction", even(0.0, 2.0, n)),
        Axis("speed", "speeds over the scene's", ratios(1e-2, 1e1, n), _speed),
        Axis("angle", "angle [deg]", ratios(1.0, 80.0, n), _angle),
        Axis("slenderness", "width over length", ratios(0.01, 1.0, n), _slenderness),
        of_key("time step", "time.safety_factor", even(0.5, 1.2, n)),
        Axis("damping", "damping.ratio", (0.0, *ratios(3e-3, 1.0, n - 1)), _damping),
    ]
    absent = {"friction"} if scene.corner.frictionless else set()
    absent |= {"penalty"} if scene.corner.constraint == "exact" else set()
    return tuple(axis for axis in axes if axis.name not in absent)


def impact_axes(scene: Scene, n: int) -> tuple[Axis, ...]:
    """The same for a scene with [contact]."""
    contact = scene.needed_contact
    crush = (
        of_key("contact stiffness", "contact.stiffness", ratios(1e4, 1e9, n), "contact.stiffness [N/m]"),
        of_key("restitution", "contact.restitution", even(0.0, 1.0, n)),
    )
    penalty = of_key("penalty", "contact.penalty_scale", ratios(1e-2, 1e3, n))
    return (
        *(crush if contact.crushes else () if contact.enforcement == "exact" else (penalty,)),
        of_key("friction", "contact.friction", even(0.0, 2.0, n)),
        Axis("angle", "angle [deg]", ratios(1.0, 85.0, n), _angle),
        Axis("speed", "speed over the scene's", ratios(0.1, 3.0, n), _speed),
        Axis("modulus", "E over the scene's", ratios(1e-4, 1e2, n), _stiffness),
        of_key("time step", "time.safety_factor", even(0.5, 1.2, n)),
        Axis("slenderness", "width over length", ratios(0.05, 1.0, n), _slenderness),
    )


def map_cells(scene: Scene, axes: tuple[Axis, ...]) -> list[Cell]:
    """Every cell of the map: each pair of axes, each pair of their values."""
    base = base_source(scene)
    return [
        _map_cell(scene, base, pair, values)
        for pair in combinations(axes, 2)
        for values in product(*(axis.values for axis in pair))
    ]


def _map_cell(scene: Scene, base: Source, pair: tuple[Axis, ...], values: tuple[float, ...]) -> Cell:
    (first, second), (x, y) = pair, values
    entries = {"first": first.name, "first_value": x, "second": second.name, "second_value": y}
    changes = {**first.changes(scene, x), **second.changes(scene, y)}
    return Cell(cell_key({first.name: x, second.name: y}), entries, base, changes)


def cell_key(point: Mapping[str, float]) -> str:
    """Key of the cell where the axes have these values."""
    return " ".join(f"{name}={value!r}" for name, value in point.items())


def base_source(scene: Scene) -> Source:
    """What the cells change: the scene in SI, without its wall, since slides differ."""
    return vary(Source.of(scene), {"wall": None})[1]


def _stiffness(scene: Scene, factor: float) -> Changes:
    """Young's modulus, or what the first frequency makes it, over the scene's."""
    plate = scene.needed_plate
    if plate.first_frequency is not None:
        return {"plate.first_frequency": plate.first_frequency * math.sqrt(factor)}
    return {"plate.youngs_modulus": plate.modulus * factor}


def _speed(scene: Scene, factor: float) -> Changes:
    """All speeds of the start over the scene's."""
    start, changes = scene.start, {}
    if scene.impact:
        changes["impact.speed"] = scene.impact.speed * factor
    if start and start.omega is not None:
        changes["start.omega"] = start.omega * factor
    if start and start.corner_speed is not None:
        changes["start.corner_speed"] = start.corner_speed * factor
    return changes


def _angle(scene: Scene, degrees: float) -> Changes:
    """The angle at the start [deg]."""
    angles = {"impact.angle": scene.impact, "start.angle": scene.start}
    given = [key for key, table in angles.items() if table and table.angle is not None]
    return dict.fromkeys(given, math.radians(degrees))


def _slenderness(scene: Scene, ratio: float) -> Changes:
    """Width over length."""
    return {"vehicle.width": ratio * scene.vehicle.length}


def _damping(scene: Scene, ratio: float) -> Changes:
    if ratio > 0.0:
        return {"damping.ratio": ratio}
    alone = scene.damping is not None and scene.damping.model_fields_set == {"ratio"}
    return {"damping" if alone else "damping.ratio": None}
