"""The peak force of the tail-slap for many values of the inputs at once."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from solver import RectangularBody, corner_impulse, strike_force, tail_slap
from tailslap.scene.schema import Scene, Start

Array = NDArray[np.float64]

BLOCK = 2048
"""Combinations at a time: their intermediate values stay in the processor's cache."""


def peak_forces(scene: Scene, inputs: Mapping[str, Array]) -> Array:
    """Peak force [N] of each combination, by Stages 1 to 3; NaN where the theory refuses it.

    inputs: by key of the scene, SI, all of one shape (n,); the other keys have the scene's values.
    """
    size = next(iter(inputs.values())).size
    blocks = (slice(first, first + BLOCK) for first in range(0, size, BLOCK))
    return np.concatenate([_block(scene, {key: x[rows] for key, x in inputs.items()}) for rows in blocks])


def _with_columns(scene: Any, inputs: Mapping[str, Array]) -> Any:
    """The scene with columns in place of numbers: a table of scenes, not a scene, and not validated."""
    for key, value in inputs.items():
        table, _, name = key.partition(".")
        changed = (getattr(scene, table) or Start()).model_copy(update={name: value})
        scene = scene.model_copy(update={table: changed})
    return scene


def _block(scene: Scene, inputs: Mapping[str, Array]) -> Array:
    combined = _with_columns(scene, inputs)
    vehicle, corner = combined.vehicle, combined.corner
    body = RectangularBody(vehicle.length, vehicle.width, vehicle.mass)
    angle, omega, corner_speed = _start(combined, body)
    friction = 0.0 if corner.frictionless else corner.friction
    friction = combined.impact.friction if friction is None else friction
    state = tail_slap(body, angle, omega, corner_speed, friction, corner.rigid_reaction, invalid="nan")
    speed = np.asarray(state.v_gy)
    known = np.isfinite(speed)
    force = strike_force(vehicle.mass, np.where(known, speed, 0.0), combined.strike.duration).peak_force
    return np.broadcast_to(np.where(known, force, np.nan), next(iter(inputs.values())).shape)


def _start(scene: Any, body: RectangularBody[Any]) -> tuple[Any, Any, Any]:
    """What Stage 2 starts from: what [start] gives, the rest from Stage 1."""
    impact, start = scene.impact, scene.start or Start()
    given = (start.angle, start.omega, start.corner_speed)
    if impact is None:
        return given
    stage1 = corner_impulse(
        body,
        impact.speed,
        impact.angle,
        impact.friction,
        impact.restitution,
        impact.convention,
        invalid="nan",
    )
    computed = (impact.angle, stage1.omega, stage1.corner_speed)
    return tuple(own if value is None else value for value, own in zip(given, computed, strict=True))  # type: ignore[return-value]
