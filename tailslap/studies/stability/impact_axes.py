"""The axes of the stability map of a whole impact."""

from __future__ import annotations

import numpy as np

from tailslap.scene.schema import Scene
from tailslap.scene.vary import Changes
from tailslap.studies.stability.axes import (
    Axis,
    change_angle,
    change_slenderness,
    change_speed,
    change_stiffness,
    change_time_step,
)


def impact_axes(scene: Scene, points: int) -> tuple[Axis, ...]:
    """The axes that mean something for this scene with [contact], each with this many values."""

    def ratios(low: float, high: float) -> tuple[float, ...]:
        return tuple(np.geomspace(low, high, points).tolist())

    def even(low: float, high: float) -> tuple[float, ...]:
        return tuple(np.linspace(low, high, points).tolist())

    assert scene.contact is not None
    crush = (
        Axis("contact stiffness", "contact.stiffness [N/m]", ratios(1e4, 1e9), _contact_stiffness),
        Axis("restitution", "contact.restitution", even(0.0, 1.0), _restitution),
    )
    penalty = Axis("penalty", "contact.penalty_scale", ratios(1e-2, 1e3), _penalty)
    exact = scene.contact.enforcement == "exact"
    return (
        *(crush if scene.contact.crushes else () if exact else (penalty,)),
        Axis("friction", "contact.friction", even(0.0, 2.0), _friction),
        Axis("angle", "angle [deg]", ratios(1.0, 85.0), change_angle),
        Axis("speed", "speed over the scene's", ratios(0.1, 3.0), change_speed),
        Axis("modulus", "E over the scene's", ratios(1e-4, 1e2), change_stiffness),
        Axis("time step", "time.safety_factor", even(0.5, 1.2), change_time_step),
        Axis("slenderness", "width over length", ratios(0.05, 1.0), change_slenderness),
    )


def _contact_stiffness(scene: Scene, value: float) -> Changes:
    return {"contact.stiffness": value}


def _restitution(scene: Scene, value: float) -> Changes:
    return {"contact.restitution": value}


def _friction(scene: Scene, value: float) -> Changes:
    return {"contact.friction": value}


def _penalty(scene: Scene, value: float) -> Changes:
    return {"contact.penalty_scale": value}
