"""Ranges of uncertain inputs of both kinds of case."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from tailslap.campaign.input_ranges import (
    ASSUMED,
    CRUSH,
    FROM_LENGTH,
    Limits,
    Range,
    about,
    default_limits,
    impact_limits,
    nominal_value,
    ranges_of,
)
from tailslap.case.impact.rigid_input import touching
from tailslap.errors import InputError, Missing
from tailslap.scene.schema import Scene

if TYPE_CHECKING:
    from tailslap.case.corner.corner_case import CornerCase
    from tailslap.case.impact.case import ImpactCase

STAGE_ONE = ("impact.speed", "impact.angle", "impact.friction", "impact.restitution")
"""Keys of Stage 1, of the start and of the vehicle."""
START = ("start.angle", "start.omega", "start.corner_speed")
BODY = ("vehicle.length", "vehicle.width", "vehicle.mass")

HITCH = 0.3
"""Half the default range of a hitch [m]."""

TYRES: Limits = (0.5, 0.8, ASSUMED)
"""Default range of the friction of tyres."""


def corner_ranges(
    case: CornerCase, ranges: tuple[str, ...] = (), fixed: tuple[str, ...] = ()
) -> tuple[Range, ...]:
    """Return the ranges of a constrained corner.

    They are in the order of the scene. Raises InputError for an invalid range or key.
    """
    limits = default_limits(case.scene)
    return ranges_of(case, used_keys(case.scene), limits, ranges, fixed)


def used_keys(scene: Scene) -> tuple[str, ...]:
    """Return the keys that determine the peak force."""
    start = {key for key in START if scene.start and getattr(scene.start, key[6:]) is not None}
    overridden = {"start.omega", "start.corner_speed"} <= start
    unused = set(STAGE_ONE) if overridden or not scene.impact else set()
    if scene.impact and "start.angle" not in start:
        unused.discard("impact.angle")
    if scene.impact and scene.corner.friction is None and not scene.corner.frictionless:
        unused.discard("impact.friction")
    if scene.corner.frictionless:
        unused.add("corner.friction")
    keys = (*BODY, *STAGE_ONE, *START, "corner.friction", "strike.duration")
    return tuple(key for key in keys if key not in unused)


def demand_crush(case: ImpactCase) -> None:
    """Require a crush law.

    Raises InputError otherwise.
    """
    if not case.scene.crushes:
        allowed = "`tailslap study uncertainty` requires a crush law"
        raise InputError("contact.stiffness", Missing, allowed)


def impact_ranges(
    case: ImpactCase, ranges: tuple[str, ...] = (), fixed: tuple[str, ...] = ()
) -> tuple[Range, ...]:
    """Return the ranges of a whole impact.

    By default, they are the tolerances of MASH, and assumed where it has none. Raises InputError for an invalid range
    or key.
    """
    nominal = nominal_values(case)
    varied = ranges_of(case, tuple(nominal), _impact_limits(case, nominal), ranges, fixed)
    for item in varied:
        if item.key == "impact.angle" and not 0.0 < item.lower < item.upper < 0.5 * math.pi:
            raise InputError(
                item.key, f"{item.lower}:{item.upper}", "allowed are angles above 0 and below 90 deg"
            )
    assumed = {item.key for item in varied if item.scene_value == 0.0 < nominal[item.key]}
    return tuple(
        replace(item, scene_value=None if item.key in assumed else nominal[item.key]) for item in varied
    )


def nominal_values(case: ImpactCase) -> dict[str, float]:
    """Return the scene's value of every input [SI].

    Values of each corner and the yaw inertia are included.
    """
    values = case.inputs | {"vehicle.yaw_inertia": case.vehicle.inertia}
    values |= {key: nominal_value(case.scene, key) or 0.0 for key in values if key.endswith(".hardening")}
    parts = [part for part in touching(case.scene) if part.number is None]
    keys = (part.keys[name] for part in parts for name in CRUSH)
    of_corners = {
        key: values[base] for key in keys if (base := key.partition("@")[0]) in values and "@" in key
    }
    return of_corners | values


def _impact_limits(case: ImpactCase, nominal: Mapping[str, float]) -> dict[str, Limits]:
    """Return the default range of each input."""
    scene, length = case.scene, nominal["vehicle.length"]
    laws = ((key, _law_limits(key, value)) for key, value in nominal.items())
    limits = {key: law for key, law in laws if law}
    limits |= {key: TYRES for key in nominal if key.startswith("axle.") and key.endswith(".friction")}
    limits |= impact_limits(scene, nominal["vehicle.mass"])
    limits["vehicle.yaw_inertia"] = _about_inertia(case.vehicle.inertia)
    limits["vehicle.centre_of_mass"] = 0.45 * length, 0.55 * length, FROM_LENGTH
    if scene.vehicle.centre_of_mass is not None:
        limits["vehicle.centre_of_mass"] = about(
            nominal["vehicle.centre_of_mass"], 0.05 * length, FROM_LENGTH
        )
    for number, (ahead, unit) in enumerate(zip(scene.units, case.trailers, strict=False)):
        key, body = f"trailer.{number}.", unit.vehicle
        ends = max(0.0, unit.hitch - HITCH), min(ahead.length, unit.hitch + HITCH)
        limits |= {
            f"{key}centre_of_mass": about(body.front_distance, 0.05 * body.length, FROM_LENGTH),
            f"{key}yaw_inertia": _about_inertia(body.inertia),
            f"{key}hitch": (*ends, f"± {HITCH:g} m, assumed"),
        }
    return limits


def _law_limits(key: str, value: float) -> Limits | None:
    """Return the default range of a parameter of a law."""
    table, *_, name = key.partition("@")[0].split(".")
    if name == "plateau":
        return about(value, 3.0 / 7.0 * value, "± 43 %, assumed: 200 to 500 kN of 350 kN of a corner")
    of_all = name == "restitution" and "@" in key  # one restitution, that of the first corner
    varies = name in CRUSH and (value or name != "hardening") and not of_all
    return CRUSH[name](value) if table in ("contact", "strip") and varies else None


def _about_inertia(inertia: float) -> Limits:
    """Return the default range of a yaw inertia."""
    return about(inertia, 0.2 * inertia, "± 20 %, assumed")
