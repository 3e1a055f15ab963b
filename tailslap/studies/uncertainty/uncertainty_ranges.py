"""Ranges of uncertain inputs of both kinds of case."""

import math
from dataclasses import replace

from tailslap.campaign.input_ranges import ASSUMED, Range, about, default_limits, ranges_of
from tailslap.case.corner.corner_case import CornerCase
from tailslap.case.impact.case import ImpactCase
from tailslap.errors import InputError, Missing
from tailslap.scene.schema import Scene

STAGE_ONE = ("impact.speed", "impact.angle", "impact.friction", "impact.restitution")
"""Keys of Stage 1, of the start and of the vehicle."""
START = ("start.angle", "start.omega", "start.corner_speed")
BODY = ("vehicle.length", "vehicle.width", "vehicle.mass")
FROM_LENGTH = "± 5 % of the length, assumed"

HITCH = 0.3
"""Half the default range of a hitch [m]."""


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


def demand_corners(case: ImpactCase) -> None:
    """Require contact at corners with a crush law.

    Raises InputError otherwise.
    """
    contact = case.scene.needed_contact
    if contact.stiffness is None:
        allowed = "`tailslap study uncertainty` requires a crush law"
        raise InputError("contact.stiffness", Missing, allowed)
    if contact.side_stiffness:
        allowed = "`tailslap study uncertainty` models contact at the corners only; remove this key"
        raise InputError("contact.side_stiffness", contact.side_stiffness, allowed)


def impact_ranges(
    case: ImpactCase, ranges: tuple[str, ...] = (), fixed: tuple[str, ...] = ()
) -> tuple[Range, ...]:
    """Return the ranges of a whole impact.

    By default, they are the tolerances of MASH, and assumed where it has none. Raises InputError for an invalid range
    or key.
    """
    nominal, defaults = case.inputs, default_limits(case.scene)
    stiffness, mass, length = (
        nominal[key] for key in ("contact.stiffness", "vehicle.mass", "vehicle.length")
    )
    mass_limits = about(mass, 0.05 * mass, "± 5 %, assumed")
    limits = {
        "contact.stiffness": about(stiffness, 0.5 * stiffness, "± 50 %, assumed"),
        "contact.restitution": (0.0, 0.4, ASSUMED),
        "contact.friction": (0.3, 0.6, ASSUMED),
        "vehicle.mass": defaults.get("vehicle.mass", mass_limits),
        "impact.speed": defaults["impact.speed"],
        "impact.angle": defaults["impact.angle"],
        "vehicle.centre_of_mass": (0.45 * length, 0.55 * length, FROM_LENGTH),
    }
    if case.scene.vehicle.centre_of_mass is not None:
        centre = nominal["vehicle.centre_of_mass"]
        limits["vehicle.centre_of_mass"] = about(centre, 0.05 * length, FROM_LENGTH)
    for number, (ahead, unit) in enumerate(zip(case.scene.units, case.trailers, strict=False)):
        key, body = f"trailer.{number}.", unit.vehicle
        crush, centre = unit.contact.crush.stiffness, body.front_distance
        ends = max(0.0, unit.hitch - HITCH), min(ahead.length, unit.hitch + HITCH)
        limits |= {
            f"{key}stiffness": about(crush, 0.5 * crush, "± 50 %, assumed"),
            f"{key}centre_of_mass": about(centre, 0.05 * body.length, FROM_LENGTH),
            f"{key}yaw_inertia": about(body.inertia, 0.2 * body.inertia, "± 20 %, assumed"),
            f"{key}hitch": (*ends, f"± {HITCH:g} m, assumed"),
        }
    varied = ranges_of(case, case.arguments, limits, ranges, fixed)
    for item in varied:
        if item.key == "impact.angle" and not 0.0 < item.lower < item.upper < 0.5 * math.pi:
            raise InputError(
                item.key, f"{item.lower}:{item.upper}", "allowed are angles above 0 and below 90 deg"
            )
    return tuple(replace(item, given=nominal[item.key]) for item in varied)
