"""Kernels of a page in space with their arguments, from a scene."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from solver.space import accuracy, columns, motion, solve, state
from solver.space.vehicle import fleet_of
from tailslap.browser import model, space
from tailslap.browser.model import Model
from tailslap.campaign import band_samples, space_samples
from tailslap.case.force_band import PERCENTILES
from tailslap.case.impact.space.input import space_input
from tailslap.scene.schema import value_at

if TYPE_CHECKING:
    from tailslap.case.impact.case import ImpactCase

UNIT = ("length", "width", "mass", "centre_of_mass", "centre_height", "roll_inertia", "pitch_inertia", "yaw_inertia",
        "hitch", "kingpin", "hitch_height", "roll_stiffness")  # fmt: skip
AXLE = ("position", "track", "radius", "mass", "spring", "spacing", "tyre", "damping_ratio", "roll_centre", "friction",
        "cornering")  # fmt: skip
STRIP = ("at.0", "at.1", "height.0", "height.1", "stiffness", "inset", "plateau", "restitution", "unloading_stiffness",
         "initial_force", "hardening")  # fmt: skip
"""Keys of the values of `columns.Values`."""

OF_BODY = UNIT[4:7]
"""Keys of a unit that stand in [body] of the first."""

WALLS = 31
"""Walls of other heights."""


def model_of(case: ImpactCase) -> Model:
    """Return the kernels of a case with [body].

    Raises InputError for a scene that a page cannot compute.
    """
    scene, ranges = case.scene, space_samples.space_ranges(case, (), ())
    model.demand_space(case)
    inputs = space_input(scene)
    fleet, count = fleet_of(*inputs), band_samples.SAMPLES_OF_SLOW
    keys, values = _values(case, [item.key for item in ranges])
    places = {key: k for k, key in enumerate(keys)}
    parts = _parts(case, places, [item.key for item in ranges])
    table = np.array(values)[:, None]
    room, curves = _room(fleet, 1.0, solve.INTERVAL, solve.PHASE)
    accurate, further = _room(fleet, 2.0 * accuracy.MOST_POINTS, motion.INTERVAL, motion.PHASE)
    accurate = accurate._replace(values=room.values, limit=room.limit)
    motions = accuracy.room_for(fleet, further.rows.shape[1], motion.INTERVAL)
    choice = accuracy.Choice(accuracy.POINTS, True, accuracy.TOLERANCE)
    varied = model.ranges_of(case, ranges, places, count)
    percentiles = [PERCENTILES, np.zeros(len(PERCENTILES))]
    band = (
        table, np.zeros((len(values), count)), parts, varied, model.class_rows(case), room, np.zeros(count),
        np.zeros(len(solve.OUTCOMES)), np.zeros(1, dtype=np.int64), np.array(percentiles, dtype=np.float64),
    )  # fmt: skip
    place = np.zeros(1, dtype=np.int64)
    return Model(
        {
            "space": (space.solve_motion, (table, parts, room, curves)),
            "space_one": (space.solve_accurately, (table, parts, accurate, motions, choice, further)),
            "space_band": (space.solve_block, band),
            "space_wall": (space.solve_wall, (table, parts, room, place, np.zeros((WALLS, 6)), np.zeros(2))),
        },
        keys,
        ranges,
    )  # fmt: skip


def _room(fleet: state.Fleet, finer: float, interval: float, phase: float) -> tuple[space.Room, space.Curves]:
    """Return memory of one motion and its curves.

    finer: most points of a strip over those of many motions.
    """
    clock = solve.clock_of(interval, np.ones(1, dtype=np.int64), None, solve.NO_PUSH)
    work, rows = solve.workspace_of(solve.with_points(fleet, finer), clock), solve.rows_of(clock)
    counts = fleet.units.shape[1], fleet.axles.shape[1], fleet.strips.shape[1]
    answers, rolls = np.zeros((1, state.ANSWERS)), np.zeros((1, counts[0]))
    fleet = fleet._replace(strip_points=fleet.strip_points.copy())
    curves, widths = 1 + len(model.MEANS), np.array(model.MEANS)
    table, forces = np.zeros((1, rows, state.row_columns(*counts))), np.zeros((curves, rows))
    return (
        space.Room(columns.room_for(1, *counts), fleet, clock, work, answers, rolls, np.zeros(1), phase),
        space.Curves(table, forces, widths, np.zeros(curves), np.zeros(rows + 1)),
    )


def column_names(case: ImpactCase) -> tuple[str, ...]:
    """Return the names of the columns of a row."""
    return state.column_names(len(case.scene.units), len(case.scene.axle))


def _unit_key(number: int, name: str) -> str:
    """Return the key of a quantity of a unit, from 0."""
    table = f"trailer.{number - 1}" if number else "body" if name in OF_BODY else "vehicle"
    return f"{table}.{name}"


def _values(case: ImpactCase, varied: list[str]) -> tuple[tuple[str, ...], list[float]]:
    """Return keys of the scene with constants behind, and their values.

    Without a value in the scene they are those of its vehicle.
    """
    scene, inputs = case.scene, space_input(case.scene)
    values: dict[str, Any] = {}
    for number, unit in enumerate(inputs.vehicle.units):
        for name, value in zip(UNIT, vars(unit).values(), strict=True):
            values.setdefault(_unit_key(number, name), value)
    keys = [f"axle.{number}.{name}" for number in range(len(scene.axle)) for name in AXLE]
    numbers = (value for axle in inputs.vehicle.axles for value in [*vars(axle).values()][: len(AXLE)])
    values |= dict(zip(keys, numbers, strict=True))
    for number, strip in enumerate(inputs.vehicle.strips):
        law = {
            name: value for name, value in vars(strip).items() if name not in ("unit", "axle", "at", "height")
        }
        law_values = (*strip.at, *strip.height, *law.values())
        values |= {f"strip.{number}.{name}": value for name, value in zip(STRIP, law_values, strict=True)}
    values |= {key: value_at(scene, key) for key in ("contact.restitution", "contact.friction", "impact.speed",
                                                     "impact.angle", "wall.height")}  # fmt: skip
    values |= dict.fromkeys((key for key in varied if "*" in key), 1.0)
    values["one"] = 1.0
    return tuple(values), [math.nan if value is None else float(value) for value in values.values()]


def _parts(case: ImpactCase, places: dict[str, int], varied: list[str]) -> space.Parts:
    """Return the structure of a scene."""
    scene, factors = case.scene, [key for key in varied if "*" in key]
    units, one = range(len(scene.units)), places["one"]

    def unit_place(number: int, name: str) -> int:
        of_body = name == "centre_height" and value_at(scene, _unit_key(number, name)) is None
        return places[_unit_key(0 if of_body else number, name)]

    def strip_place(number: int, name: str) -> int:
        key, slope = f"strip.{number}.{name}", value_at(scene, f"strip.{number}.unloading_stiffness")
        is_common = name == "restitution" and value_at(scene, key) is None and not slope
        return places["contact.restitution" if is_common else key]

    def factor_places(table: str, names: tuple[str, ...], count: int) -> list[list[int]]:
        """Return places of factors, that of 1 for a value without one."""
        keys = {member: key for key in factors for member in space_samples.members(scene, key)}
        of = [[keys.get(f"{table}.{number}.{name}") for name in names] for number in range(count)]
        return [[one if key is None else places[key] for key in row] for row in of]

    counts = len(scene.axle), len(scene.strip)
    computed = "centre_of_mass", "roll_inertia", "pitch_inertia", "yaw_inertia"
    follows = [[value_at(scene, _unit_key(u, name)) is None for name in computed] for u in units]
    hardened = [not value_at(scene, f"strip.{k}.hardening") and "strip.*.hardening" in factors
                and f"strip.{k}.hardening" in space_samples.members(scene, "strip.*.hardening")
                for k in range(counts[1])]  # fmt: skip
    tables: list[Any] = [
        [[unit_place(u, name) for name in UNIT] for u in units],
        [[places[f"axle.{a}.{name}"] for name in AXLE] for a in range(counts[0])],
        factor_places("axle", AXLE, counts[0]),
        [[strip_place(k, name) for name in STRIP] for k in range(counts[1])],
        factor_places("strip", STRIP, counts[1]),
        follows, [[_unit_key(u, name) in varied for name in UNIT[5:8]] for u in units], hardened,
        [places[key] for key in ("impact.speed", "impact.angle", "contact.friction", "wall.height")],
    ]  # fmt: skip
    return space.Parts._make(np.array(table, dtype=np.int64) for table in tables)
