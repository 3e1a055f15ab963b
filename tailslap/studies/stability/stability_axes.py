"""Axes and cells of the map of stability."""

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import combinations, product
from typing import NamedTuple

import numpy as np

from tailslap.campaign.random_scenes import stiffness
from tailslap.campaign.records import Record
from tailslap.scene.schema import Scene, value_at
from tailslap.scene.vary import Changes


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
        absent = {"penalty"} if contact.of_corners else {"contact stiffness"}
        absent |= set() if contact.of_corners or scene.crushes else {"restitution"}
        absent |= {"penalty"} if contact.enforcement == "exact" else set()
    axes = (_impact_axes if contact else _corner_axes)(n)
    return tuple(axis for axis in axes if axis.name not in absent)


def _spaced(spacing: Callable[..., np.ndarray], n: int) -> Callable[[float, float], tuple[float, ...]]:
    """Return a function of two ends that returns n values."""
    return lambda low, high: tuple(spacing(low, high, n).tolist())


def _corner_axes(n: int) -> tuple[StudyAxis, ...]:
    """Return the axes of a constrained corner."""
    ratios, steps = _spaced(np.geomspace, n), _spaced(np.linspace, n)
    return (
        StudyAxis("stiffness", "E over the scene's", ratios(1e-4, 1e4), stiffness),
        StudyAxis("penalty", "corner.penalty_scale", ratios(1e-3, 1e4), _of("corner.penalty_scale")),
        StudyAxis("friction", "corner.friction", steps(0.0, 2.0), _of("corner.friction")),
        StudyAxis("speed", "speeds over the scene's", ratios(1e-2, 1e1), _speed),
        StudyAxis("angle", "angle [deg]", ratios(1.0, 80.0), _angle),
        StudyAxis("slenderness", "width over length", ratios(0.01, 1.0), _slenderness),
        StudyAxis("time step", "time.safety_factor", steps(0.5, 1.2), _of("time.safety_factor")),
        StudyAxis("damping", "damping.ratio", (0.0, *_spaced(np.geomspace, n - 1)(3e-3, 1.0)), _damping),
    )


def _impact_axes(n: int) -> tuple[StudyAxis, ...]:
    """Return the axes of a whole impact."""
    ratios, steps = _spaced(np.geomspace, n), _spaced(np.linspace, n)
    return (
        StudyAxis("contact stiffness", "contact.stiffness [N/m]", ratios(1e4, 1e9), _of("contact.stiffness")),
        StudyAxis("restitution", "contact.restitution", steps(0.0, 1.0), _of("contact.restitution")),
        StudyAxis("penalty", "contact.penalty_scale", ratios(1e-2, 1e3), _of("contact.penalty_scale")),
        StudyAxis("friction", "contact.friction", steps(0.0, 2.0), _of("contact.friction")),
        StudyAxis("angle", "angle [deg]", ratios(1.0, 85.0), _angle),
        StudyAxis("speed", "speed over the scene's", ratios(0.1, 3.0), _speed),
        StudyAxis("modulus", "E over the scene's", ratios(1e-4, 1e2), stiffness),
        StudyAxis("time step", "time.safety_factor", steps(0.5, 1.2), _of("time.safety_factor")),
        StudyAxis("slenderness", "width over length", ratios(0.05, 1.0), _slenderness),
    )


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
    return {key: value for key in keys if (value := value_at(scene, key)) is not None}


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
