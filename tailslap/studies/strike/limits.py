"""Between which values the inputs vary: along the curves, and in the bands, unless the user says otherwise.

Curves are wide, to show the course; bands hold what is not known of one impact.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tailslap.case.impact.case import ImpactCase
from tailslap.errors import InputError
from tailslap.studies.strike.impacts import ARGUMENTS, scene_values
from tailslap.studies.strike.quantities import Array
from tailslap.studies.uncertainty.ranges import Range, ranges_of
from tailslap.studies.uncertainty.tolerances import Limits, default_limits

LABELS = {
    "contact.stiffness": ("crush stiffness", "MN/m", 1e6),
    "contact.restitution": ("restitution", "", 1.0),
    "contact.friction": ("friction", "", 1.0),
    "vehicle.mass": ("mass", "t", 1e3),
    "impact.speed": ("speed", "m/s", 1.0),
    "impact.angle": ("angle", "deg", np.pi / 180.0),
    "vehicle.centre_of_mass": ("centre of mass behind the front", "m", 1.0),
}
"""The inputs of the curves: words, the unit that they are shown in, and what of SI makes one of that."""

STIFFNESS, RESTITUTION, FRICTION, CENTRE = (0.3e6, 5e6), (0.0, 0.6), (0.1, 0.8), (0.4, 0.6)
"""Of the curves; centre of mass as a share of the length."""

POINTS = 25
ASSUMED = "assumed"


@dataclass(frozen=True)
class InputCurve:
    """An input of the curves: key, its values [SI], shape (n,), the scene's own."""

    key: str
    values: Array
    own: float


def curve_inputs(plan: ImpactCase) -> tuple[InputCurve, ...]:
    """The inputs along whose curves one varies alone, others as the scene has them."""
    own = scene_values(plan)
    found = []
    for key, (lower, upper) in _wide(plan, own).items():
        spaced = np.geomspace if key == "contact.stiffness" else np.linspace
        found.append(InputCurve(key, spaced(lower, upper, POINTS), own[key]))
    return tuple(found)


def _wide(plan: ImpactCase, own: dict[str, float]) -> dict[str, tuple[float, float]]:
    stiffness, angle = own["contact.stiffness"], own["impact.angle"]
    length, mass, speed = (own[key] for key in ("vehicle.length", "vehicle.mass", "impact.speed"))
    return {
        "contact.stiffness": (min(STIFFNESS[0], 0.5 * stiffness), max(STIFFNESS[1], 2.0 * stiffness)),
        "contact.restitution": RESTITUTION,
        "contact.friction": FRICTION,
        "vehicle.mass": (0.75 * mass, 1.25 * mass),
        "impact.speed": (0.75 * speed, 1.25 * speed),
        "impact.angle": (0.5 * angle, min(1.6 * angle, 0.5 * (angle + 0.5 * np.pi))),
        "vehicle.centre_of_mass": (CENTRE[0] * length, CENTRE[1] * length),
    }


def band_ranges(plan: ImpactCase, ranges: tuple[str, ...], fixed: tuple[str, ...]) -> tuple[Range, ...]:
    """The ranges of the bands; ranges, fixed: as the user typed them. Raises InputError."""
    found = ranges_of(plan, tuple(ARGUMENTS), default_band(plan), ranges, fixed)
    own = scene_values(plan)
    for item in found:
        if item.key == "impact.angle" and not 0.0 < item.lower < item.upper < 0.5 * np.pi:
            raise InputError(item.key, f"{item.lower}:{item.upper}", "allowed is above 0 and below 90 deg")
    return tuple(replace(item, given=own[item.key]) for item in found)


def default_band(plan: ImpactCase) -> dict[str, Limits]:
    """Ranges of the bands by default: MASH's tolerances where they are known, the others assumed."""
    own, known = scene_values(plan), default_limits(plan.scene)
    stiffness, mass, length = (own[key] for key in ("contact.stiffness", "vehicle.mass", "vehicle.length"))
    return {
        "contact.stiffness": Limits(0.5 * stiffness, 1.5 * stiffness, "± 50 %, assumed"),
        "contact.restitution": Limits(0.0, 0.4, ASSUMED),
        "contact.friction": Limits(0.3, 0.6, ASSUMED),
        "vehicle.mass": known.get("vehicle.mass", Limits(0.95 * mass, 1.05 * mass, "± 5 %, assumed")),
        "impact.speed": known["impact.speed"],
        "impact.angle": known["impact.angle"],
        "vehicle.centre_of_mass": Limits(0.45 * length, 0.55 * length, "± 5 % of the length, assumed"),
    }
