"""Remarks on values without a unit that are far from those of vehicles on roads: they do not stop a run."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

from tailslap.scene.vary import Source


class Usual(NamedTuple):
    """The usual range of a key in SI, its unit, and another unit with its value in SI."""

    low: float
    high: float
    unit: str
    other: str
    factor: float


SPEED = Usual(1.0, 40.0, "m/s", "km/h", 1.0 / 3.6)
ANGLE = Usual(math.radians(1.0), math.radians(60.0), "rad", "deg", math.radians(1.0))
USUAL = {
    "vehicle.length": Usual(1.5, 40.0, "m", "ft", 0.3048),
    "vehicle.width": Usual(0.5, 6.0, "m", "ft", 0.3048),
    "vehicle.mass": Usual(200.0, 2e5, "kg", "lb", 0.45359237),
    "impact.speed": SPEED,
    "impact.angle": ANGLE,
    "start.angle": ANGLE,
    "start.corner_speed": SPEED,
    "strike.duration": Usual(1e-3, 2.0, "s", "ms", 1e-3),
    "plate.thickness": Usual(1e-4, 1.0, "m", "mm", 1e-3),
}


def remarks(source: Source) -> Iterator[str]:
    """A sentence for each number that was given without a unit and is not usual."""
    for key, usual in USUAL.items():
        table, name = key.split(".")
        value = _given(source.given.get(table), name)
        if value is not None and not usual.low <= value <= usual.high:
            means = f"{value:g} {usual.unit}, {value / usual.factor:.4g} {usual.other}"
            yield f"{key} = {value:g} without a unit is {means}"


def _given(table: Any, name: str) -> float | None:
    value = table.get(name) if isinstance(table, dict) else None
    return float(value) if isinstance(value, int | float) else None
