"""Sample vehicles in space.

Inputs have ranges, and many motions are solved at a time. A key with "*" is a factor of the scene's values of all axles
or strips, which vary together.
"""

import time
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

from solver import space
from solver.conditions import RigidBodyError
from tailslap.campaign import input_ranges
from tailslap.campaign.input_ranges import Limits, Range, TypedLimits, about, nominal_value, ranges_of
from tailslap.campaign.sampling import Array
from tailslap.case.impact.case import ImpactCase
from tailslap.case.impact.space.input import space_input
from tailslap.errors import InputError, Verbatim
from tailslap.scene.schema import Scene, value_at
from tailslap.scene.vary import Source, vary

CENTRE_RANGE = 0.15
"""Half the default range of the height of a centre of mass [m]."""

TRUCK = "times the scene's, assumed: {} of a single-unit truck"
GROUPS: dict[str, Limits] = {
    "axle.*.spring": (0.5, 2.0, TRUCK.format("0.15 to 0.6 MN/m a side")),
    "axle.*.spacing": (0.9, 1.1, TRUCK.format("0.9 to 1.1 m")),
    "axle.*.friction": (0.5 / 0.65, 0.8 / 0.65, TRUCK.format("0.5 to 0.8")),
    "strip.*.stiffness": (0.5, 1.5, "times the scene's, ± 50 % assumed"),
    "strip.*.hardening": (0.2, 1.8, "times the scene's, ± 80 % assumed"),
    "strip.*.plateau": (200.0 / 350.0, 500.0 / 350.0, TRUCK.format("200 to 500 kN of 350 kN of a corner")),
}
"""Default range of each factor."""

ROLL_INERTIA = (0.9 / 1.1) ** 2, (1.4 / 1.1) ** 2
"""Default range of a roll inertia over its nominal value: radii of gyration of 0.9 to 1.4 m about 1.1 m."""

OF_AXLE, OF_STRIP = (
    ("spring", "spacing", "friction", "tyre", "cornering"),
    ("stiffness", "plateau", "hardening"),
)
"""Keys of one axle and one strip that may vary alone."""

COLUMNS = ("outcome", "largest_roll", "mean_50ms", "height", "length", "moment", "moment_height")
"""Answers that samples record."""


def nominal_values(case: ImpactCase) -> dict[str, float]:
    """Return the nominal value of each key that may vary [SI].

    Factors are 1.
    """
    scene, units = case.scene, space_input(case.scene).vehicle.units
    values: dict[str, Any] = {}
    for number, unit in enumerate(units):
        table, body = (f"trailer.{number - 1}",) * 2 if number else ("vehicle", "body")
        values |= {
            f"{table}.{name}": getattr(unit, name) for name in ("mass", "centre_of_mass", "yaw_inertia")
        }
        if not number or value_at(scene, f"{body}.centre_height") is not None:
            values[f"{body}.centre_height"] = unit.centre_height
        values |= {f"{body}.{name}": getattr(unit, name) for name in ("roll_inertia", "pitch_inertia")}
    for table, count, names in (("axle", len(scene.axle), OF_AXLE), ("strip", len(scene.strip), OF_STRIP)):
        values |= {
            key: value_at(scene, key) for n in range(count) for key in (f"{table}.{n}.{x}" for x in names)
        }
    unloading = "unloading_stiffness" if scene.needed_contact.unloading_stiffness else "restitution"
    keys = (f"contact.{unloading}", "contact.friction", "impact.speed", "impact.angle")
    values |= {key: value_at(scene, key) for key in keys} | {
        key: 1.0 for key in GROUPS if members(scene, key)
    }
    return {key: float(value) for key, value in values.items() if value is not None}


def members(scene: Scene, key: str) -> list[str]:
    """Return the keys of the scene that a factor applies to.

    Values of 0 are not among them.
    """
    table, _, name = key.split(".")
    keys = [f"{table}.{number}.{name}" for number in range(len(getattr(scene, table)))]
    return [key for key in keys if nominal_value(scene, key)]


def default_ranges(case: ImpactCase, nominal: Mapping[str, float]) -> dict[str, Limits]:
    """Return the default range of each input [SI]."""
    limits = input_ranges.impact_limits(case.scene, nominal["vehicle.mass"])
    for name in ("restitution", "unloading_stiffness"):
        limits[f"contact.{name}"] = input_ranges.CRUSH[name](nominal.get(f"contact.{name}", 0.0))
    for number, unit in enumerate(case.scene.units):
        table, body = (f"trailer.{number - 1}",) * 2 if number else ("vehicle", "body")
        middle, height = f"{table}.centre_of_mass", f"{body}.centre_height"
        limits[middle] = about(nominal[middle], 0.05 * unit.length, input_ranges.FROM_LENGTH)
        if height in nominal:
            limits[height] = about(nominal[height], CENTRE_RANGE, f"± {CENTRE_RANGE} m, assumed")
        for name in ("roll_inertia",) if number else ("roll_inertia", "yaw_inertia"):
            key = f"{body if name == 'roll_inertia' else table}.{name}"
            low, high = ROLL_INERTIA if name == "roll_inertia" else (0.8, 1.2)
            why = "radii of gyration of 0.82 to 1.27 times the scene's" if low < 0.8 else "± 20 %"
            limits[key] = (low * nominal[key], high * nominal[key], f"{why}, assumed")
    return {key: ends for key, ends in (limits | GROUPS).items() if key in nominal}


def space_ranges(case: ImpactCase, ranges: tuple[str, ...], fixed: tuple[str, ...]) -> tuple[Range, ...]:
    """Return the ranges of a vehicle in space, factors last. Raises InputError."""
    nominal = nominal_values(case)
    varied = ranges_of(case, tuple(nominal), default_ranges(case, nominal), ranges, fixed)
    return tuple(replace(item, scene_value=nominal[item.key]) for item in varied)


def stated_ranges(case: ImpactCase, limits: Mapping[str, Limits | TypedLimits]) -> tuple[Range, ...]:
    """Return ranges with stated ends and sources, factors last.

    Raises InputError.
    """
    return ranges_of(case, tuple(sorted(limits, key=lambda key: "*" in key)), limits)


def expanded(scene: Scene, inputs: Mapping[str, Any]) -> dict[str, Any]:
    """Return values by key of the scene, with factors applied.

    inputs: by key, floats or of shape (n,) [SI].
    """
    values: dict[str, Any] = {}
    for key in inputs:
        if "*" in key:
            values |= {member: nominal_value(scene, member) * inputs[key] for member in members(scene, key)}
    values |= {key: value for key, value in inputs.items() if "*" not in key}
    return values


def possible_samples(scene: Scene, inputs: Mapping[str, Array]) -> tuple[list[int], str]:
    """Return rows of the samples that stand on their axles.

    inputs: see `expanded`. The second value is the reason why the first of the others does not, or "".
    """
    try:
        space_input(scene, expanded(scene, inputs))
        return [*range(next(iter(inputs.values())).size)], ""
    except RigidBodyError:
        rows, reasons = list[int](), list[str]()
    for row, values in enumerate(zip(*inputs.values(), strict=True)):
        try:
            space_input(scene, expanded(scene, dict(zip(inputs, map(float, values), strict=True))))
            rows.append(row)
        except RigidBodyError as error:
            reasons.append(f"`{error.key}`: {error.why}")
    return rows, reasons[0]


def sample_answers(scene: Scene, inputs: Mapping[str, Any], names: Iterable[str]) -> dict[str, Array]:
    """Return answers of `solver.space` by name, shape (n,).

    inputs: see `expanded`. Raises InputError.
    """
    try:
        answers = space.solve_spaces(*space_input(scene, expanded(scene, inputs)))
    except RigidBodyError as error:
        raise InputError(error.key, Verbatim(error.value), f"{error.why}; allowed: {error.allowed}") from None
    return {name: getattr(answers, name) for name in names}


def solve_samples(source: Source, inputs: Mapping[str, Array]) -> dict[str, Any]:
    """Return the answers of samples as lists, and their processor time [s].

    inputs: by key, shape (n,) [SI]. Raises InputError.
    """
    began = time.process_time()
    scene, _ = vary(source, {})
    answers = sample_answers(scene, inputs, COLUMNS)
    columns = {name: values.tolist() for name, values in answers.items()}
    return columns | {"processor": time.process_time() - began}
