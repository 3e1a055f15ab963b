"""Axes and cells of the map of stability."""

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import combinations, product
from typing import NamedTuple

import numpy as np

from tailslap.campaign.random_scenes import stiffness
from tailslap.campaign.records import Record
from tailslap.scene.schema import Scene
from tailslap.scene.vary import Changes

Axis = tuple[
    str, str, Callable[[float, float, int], np.ndarray], float, float, Callable[[Scene, float], Changes]
]
"""Name, meaning, spacing, ends and changes of an axis."""


class StudyAxis(NamedTuple):
    """A varied quantity with values and changes."""

    name: str
    meaning: str
    values: tuple[float, ...]
    changes: Callable[[Scene, float], Changes]


def axes_of(scene: Scene, n: int) -> tuple[StudyAxis, ...]:
    """Return the axes of a scene, each with n values."""
    contact, corner = scene.contact, scene.corner
    if contact is None:
        absent = {"friction"} if corner.frictionless else set()
        absent |= {"penalty"} if corner.constraint == "exact" else set()
    else:
        absent = {"penalty"} if contact.crushes else {"contact stiffness", "restitution"}
        absent |= {"penalty"} if contact.enforcement == "exact" else set()
    return tuple(
        StudyAxis(name, meaning, tuple(spaced(low, high, n).tolist()), changes)
        for name, meaning, spaced, low, high, changes in (_impact_axes() if contact else _corner_axes())
        if name not in absent
    )


def _corner_axes() -> tuple[Axis, ...]:
    """Return the axes of a constrained corner."""
    return (
        ("stiffness", "E over the scene's", np.geomspace, 1e-4, 1e4, stiffness),
        ("penalty", "corner.penalty_scale", np.geomspace, 1e-3, 1e4, _of("corner.penalty_scale")),
        ("friction", "corner.friction", np.linspace, 0.0, 2.0, _of("corner.friction")),
        ("speed", "speeds over the scene's", np.geomspace, 1e-2, 1e1, _speed),
        ("angle", "angle [deg]", np.geomspace, 1.0, 80.0, _angle),
        ("slenderness", "width over length", np.geomspace, 0.01, 1.0, _slenderness),
        ("time step", "time.safety_factor", np.linspace, 0.5, 1.2, _of("time.safety_factor")),
        ("damping", "damping.ratio", _zero_and_ratios, 3e-3, 1.0, _damping),
    )


def _impact_axes() -> tuple[Axis, ...]:
    """Return the axes of a whole impact."""
    return (
        ("contact stiffness", "contact.stiffness [N/m]", np.geomspace, 1e4, 1e9, _of("contact.stiffness")),
        ("restitution", "contact.restitution", np.linspace, 0.0, 1.0, _of("contact.restitution")),
        ("penalty", "contact.penalty_scale", np.geomspace, 1e-2, 1e3, _of("contact.penalty_scale")),
        ("friction", "contact.friction", np.linspace, 0.0, 2.0, _of("contact.friction")),
        ("angle", "angle [deg]", np.geomspace, 1.0, 85.0, _angle),
        ("speed", "speed over the scene's", np.geomspace, 0.1, 3.0, _speed),
        ("modulus", "E over the scene's", np.geomspace, 1e-4, 1e2, stiffness),
        ("time step", "time.safety_factor", np.linspace, 0.5, 1.2, _of("time.safety_factor")),
        ("slenderness", "width over length", np.geomspace, 0.05, 1.0, _slenderness),
    )


def _zero_and_ratios(low: float, high: float, n: int) -> np.ndarray:
    """Return zero and n - 1 values in equal ratios."""
    return np.append(0.0, np.geomspace(low, high, n - 1))


def _of(key: str) -> Callable[[Scene, float], Changes]:
    """Return a function that sets a key to a value."""
    return lambda scene, value: {key: value}


def _speed(scene: Scene, factor: float) -> Changes:
    """Multiply the speeds that the scene has."""
    speeds = _scene_values(scene, "impact.speed", "start.omega", "start.corner_speed")
    return {key: value * factor for key, value in speeds.items()}


def _angle(scene: Scene, degrees: float) -> Changes:
    """Set the angles that the scene has."""
    return dict.fromkeys(_scene_values(scene, "impact.angle", "start.angle"), math.radians(degrees))


def _scene_values(scene: Scene, *keys: str) -> dict[str, float]:
    """Return the values of keys that the scene has."""
    paths = {key: key.split(".") for key in keys}
    values = {key: getattr(getattr(scene, table), name, None) for key, (table, name) in paths.items()}
    return {key: value for key, value in values.items() if value is not None}


def _slenderness(scene: Scene, ratio: float) -> Changes:
    """Set the width of the vehicle over its length."""
    return {"vehicle.width": ratio * scene.vehicle.length}


def _damping(scene: Scene, ratio: float) -> Changes:
    """Set the damping ratio, or remove it at zero."""
    if ratio > 0.0:
        return {"damping.ratio": ratio}
    alone = scene.damping is not None and scene.damping.model_fields_set == {"ratio"}
    return {"damping" if alone else "damping.ratio": None}


def map_cells(scene: Scene, axes: Sequence[StudyAxis]) -> tuple[dict[str, Changes], dict[str, Record]]:
    """Return changes and places of all cells.

    Cells are all pairs of values of all pairs of axes.
    """
    cells: dict[str, Changes] = {}
    places: dict[str, Record] = {}
    for first, second in combinations(axes, 2):
        for x, y in product(first.values, second.values):
            key = cell_key({first.name: x, second.name: y})
            cells[key] = {**first.changes(scene, x), **second.changes(scene, y)}
            places[key] = {"first": first.name, "first_value": x, "second": second.name, "second_value": y}
    return cells, places


def cell_key(point: Mapping[str, float]) -> str:
    """Return the key of the cell with these values."""
    return " ".join(f"{name}={value!r}" for name, value in point.items())
