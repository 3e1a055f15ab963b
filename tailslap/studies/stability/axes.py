"""Axes of the map of stability: quantities of a scene, the range of each, and what a value changes; pairs of axes."""

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import combinations, product
from typing import Any, NamedTuple

import numpy as np

from tailslap.campaign.draws import stiffness
from tailslap.scene.schema import Scene
from tailslap.scene.vary import Changes


class StudyAxis(NamedTuple):
    """A quantity that varies: name, what its numbers mean, values, what a value changes in a scene."""

    name: str
    meaning: str
    values: tuple[float, ...]
    changes: Callable[[Scene, float], Changes]


def axes_of(scene: Scene, n: int) -> tuple[StudyAxis, ...]:
    """The axes that mean something for this scene, each with n values."""
    contact, corner = scene.contact, scene.corner
    if contact is None:
        absent = {"friction"} if corner.frictionless else set()
        absent |= {"penalty"} if corner.constraint == "exact" else set()
    else:
        absent = {"penalty"} if contact.crushes else {"contact stiffness", "restitution"}
        absent |= {"penalty"} if contact.enforcement == "exact" else set()
    return tuple(
        StudyAxis(name, meaning, tuple(spaced(low, high, n).tolist()), changes)
        for name, meaning, spaced, low, high, changes in (IMPACT_AXES if contact else CORNER_AXES)
        if name not in absent
    )


def _zero_and_ratios(low: float, high: float, n: int) -> np.ndarray:
    return np.append(0.0, np.geomspace(low, high, n - 1))


def _of(key: str) -> Callable[[Scene, float], Changes]:
    return lambda scene, value: {key: value}


def _speed(scene: Scene, factor: float) -> Changes:
    given = _given(scene, "impact.speed", "start.omega", "start.corner_speed")
    return {key: value * factor for key, value in given.items()}


def _angle(scene: Scene, degrees: float) -> Changes:
    return dict.fromkeys(_given(scene, "impact.angle", "start.angle"), math.radians(degrees))


def _given(scene: Scene, *keys: str) -> dict[str, float]:
    """Values of these keys that the scene gives."""
    paths = {key: key.split(".") for key in keys}
    found = {key: getattr(getattr(scene, table), name, None) for key, (table, name) in paths.items()}
    return {key: value for key, value in found.items() if value is not None}


def _slenderness(scene: Scene, ratio: float) -> Changes:
    return {"vehicle.width": ratio * scene.vehicle.length}


def _damping(scene: Scene, ratio: float) -> Changes:
    if ratio > 0.0:
        return {"damping.ratio": ratio}
    alone = scene.damping is not None and scene.damping.model_fields_set == {"ratio"}
    return {"damping" if alone else "damping.ratio": None}


# Name, what its numbers mean, how its values lie between which ends, and what a value changes.
CORNER_AXES: tuple[tuple[str, str, Any, float, float, Any], ...] = (
    ("stiffness", "E over the scene's", np.geomspace, 1e-4, 1e4, stiffness),
    ("penalty", "corner.penalty_scale", np.geomspace, 1e-3, 1e4, _of("corner.penalty_scale")),
    ("friction", "corner.friction", np.linspace, 0.0, 2.0, _of("corner.friction")),
    ("speed", "speeds over the scene's", np.geomspace, 1e-2, 1e1, _speed),
    ("angle", "angle [deg]", np.geomspace, 1.0, 80.0, _angle),
    ("slenderness", "width over length", np.geomspace, 0.01, 1.0, _slenderness),
    ("time step", "time.safety_factor", np.linspace, 0.5, 1.2, _of("time.safety_factor")),
    ("damping", "damping.ratio", _zero_and_ratios, 3e-3, 1.0, _damping),
)
IMPACT_AXES: tuple[tuple[str, str, Any, float, float, Any], ...] = (
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


def map_cells(
    scene: Scene, axes: Sequence[StudyAxis]
) -> tuple[dict[str, Changes], dict[str, dict[str, Any]]]:
    """Changes of every cell of the map, and its place: each pair of axes, each pair of their values."""
    cells: dict[str, Changes] = {}
    places: dict[str, dict[str, Any]] = {}
    for first, second in combinations(axes, 2):
        for x, y in product(first.values, second.values):
            key = cell_key({first.name: x, second.name: y})
            cells[key] = {**first.changes(scene, x), **second.changes(scene, y)}
            places[key] = {"first": first.name, "first_value": x, "second": second.name, "second_value": y}
    return cells, places


def cell_key(point: Mapping[str, float]) -> str:
    """Key of the cell where the axes have these values."""
    return " ".join(f"{name}={value!r}" for name, value in point.items())
