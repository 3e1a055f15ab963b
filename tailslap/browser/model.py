"""Kernels of a page with their arguments, from a scene."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from postprocess.signals.filters import LOW_PASSES
from postprocess.units import POUND
from solver import impact
from solver.impact.crush_law import LAW
from solver.impact.many import MANY_TOLERANCE
from solver.impact.solve import MOST_STRIKES, column_names, rate_columns
from solver.impact.state import workspace
from solver.impact.strips import LINE_POINTS, SIDES
from solver.impact.train import Train
from solver.impact.trajectories import room_for, timing
from solver.impact.tyres import SUMS, Tyres
from solver.space.strips import joined
from tailslap.browser import bands, kernels
from tailslap.campaign import band_samples, planar_ranges, sampling
from tailslap.campaign.input_ranges import HARDENING, LIGHT_VEHICLES, MASS, Range
from tailslap.case.force_band import PERCENTILES
from tailslap.case.impact import answers, rigid_motion
from tailslap.case.impact.rigid_input import Touching, touching
from tailslap.case.impact.space.input import space_input
from tailslap.errors import InputError, Verbatim
from tailslap.scene.schema import Scene, value_at
from tailslap.scene.write import quantity_at
from tailslap.validation.calibration import VehicleClass, classes

if TYPE_CHECKING:
    from machine_code.web_assembly import Calls
    from tailslap.case.impact.case import ImpactCase

UNIT = ("length", "width", "mass", "centre_of_mass", "yaw_inertia", "hitch", "kingpin")
"""Quantities of a unit in the order of `kernels.Parts`."""

AXLE = ("position", "friction", "cornering")
"""Quantities of an axle in that order."""

PAPER = "impact.friction", "impact.restitution", "strike.duration"
"""Quantities of the paper's method alone, behind those of the impact."""

MEANS = (0.01, 0.05)
"""Widths of the means of a page, the last that of the answer [s]."""

BEYOND = {
    "impact": "whole impacts, with [contact]",
    "contact.stiffness": "vehicles that crush",
    "contact.strike_duration": "impacts with a stiffness",
    "wall": "rigid walls",
    "time.end": "impacts that end after their strikes",
    "strip.height": "strips without heights",
    "strip.at": "strips apart from each other",
    "axle.friction": "axles with friction",
}
"""What a page computes instead of scenes with these keys."""

MOST_INSTANTS = 200_001
"""Instants for which a page has room."""


class Model(NamedTuple):
    """Kernels of a scene.

    calls: their arguments by name; quantities: keys of the scene in the order of the values, with "" for constants;
    ranges: of the band.
    """

    calls: Calls
    quantities: tuple[str, ...]
    ranges: tuple[Range, ...]


def model_of(case: ImpactCase) -> Model:
    """Return the kernels of a case.

    Raises InputError for a scene that a page cannot compute.
    """
    demand_planar(case)
    nominal = planar_ranges.nominal_values(case)
    ranges = planar_ranges.impact_ranges(case)
    varied_keys = {item.key for item in ranges}
    nominal = {key: value for key, value in nominal.items() if "@" not in key or key in varied_keys}
    nominal |= {key: case.inputs.get(key, 0.0) for key in nominal if "hardening" in key}  # of the scene
    columns, values = _columns(case, nominal)
    count = band_samples.SAMPLES_OF_SLOW if case.trailers else band_samples.SAMPLES
    parts, (unit, group) = _parts(case, columns), _owners(case)
    solved = [_case(case, parts, unit, group, n) for n in (1, count)]
    table = np.array(values)[:, None]
    motion, paper = _motion(case, solved[0][1]), _paper(case, columns)
    interval, means = rigid_motion.INTERVAL, 3
    instants = math.ceil(rigid_motion.LONGEST / interval) + 2
    workspaces = tuple(np.zeros(instants + 1) for _ in range(means))
    percentiles = np.array([PERCENTILES, np.zeros(len(PERCENTILES))], dtype=np.float64)
    varied = ranges_of(case, ranges, columns, count)
    samples = np.zeros((len(values), count))
    motions = class_rows(case), _growth(case, count), *solved[1]
    band = table, samples, parts, varied, *motions, workspaces, np.zeros(count), percentiles
    calls = {
        "motion": (kernels.solve_motion, (table, parts, *solved[0], motion, paper)),
        "band": (bands.solve_band, band),
    }
    keys = *nominal, *PAPER
    return Model(calls, (*keys, *[""] * (len(values) - len(keys))), ranges)


def demand_planar(case: Any) -> None:
    """Require a whole impact in the plane that a page computes.

    It is on a rigid wall, with crush. Raises InputError with the key that is beyond a page.
    """
    scene = case.scene
    _demand(scene, {"impact": scene.contact is None})
    beyond = {
        "contact.stiffness": not scene.crushes,
        "contact.strike_duration": scene.contact.strike_duration is not None,
        "wall": scene.meshed_wall is not None,
        "time.end": scene.time.end is not None,
        "strip.height": any(strip.height for strip in scene.strip),
        "axle.friction": not all(axle.friction for axle in scene.axle),
    }
    _demand(scene, beyond)


def demand_space(case: Any) -> None:
    """Require an impact in space that a page computes.

    Raises InputError with the key that is beyond a page.
    """
    strips = space_input(case.scene).vehicle.strips
    _demand(
        case.scene,
        {"wall": case.scene.meshed_wall is not None, "strip.at": len(joined(strips)) < len(strips)},
    )


def _demand(scene: Scene, beyond: Mapping[str, bool]) -> None:
    """Raise InputError for a scene that a page cannot compute."""
    for key in (key for key, is_beyond in beyond.items() if is_beyond):
        command = "run" if key == "wall" else "rigid"
        why = f"the page computes {BEYOND[key]}; `tailslap {command} {scene.name}` computes this scene"
        raise InputError(key, Verbatim(scene.name), why)


def _columns(case: ImpactCase, nominal: Mapping[str, float]) -> tuple[dict[str, int], list[float]]:
    """Return places of quantities by key, and their values.

    Constants follow.
    """
    values, columns = [float(value) for value in nominal.values()], {key: k for k, key in enumerate(nominal)}

    def constant(key: str, value: float) -> None:
        columns[key] = len(values)
        values.append(value)

    for key in PAPER:
        value = value_at(case.scene, key)
        constant(key, math.nan if value is None else float(value))
    constant("zero", 0.0)
    constant("infinite", math.inf)
    for number, strip in enumerate(case.scene.strip):
        for name, value in (("begin", strip.at[0]), ("end", strip.at[1]), ("inset", strip.inset)):
            constant(f"strip.{number}.{name}", value)
    return columns, values


def _unit_key(number: int, name: str) -> str:
    """Return the key of a quantity of a unit, from 0."""
    return f"trailer.{number - 1}.{name}" if number else f"vehicle.{name}"


def _parts(case: ImpactCase, columns: Mapping[str, int]) -> kernels.Parts:
    """Return the structure of a scene."""
    scene, count = case.scene, len(case.vehicles)
    units = [[columns.get(_unit_key(u, name), 0) for name in UNIT] for u in range(count)]
    computed = [[unit.centre_of_mass is None, unit.yaw_inertia is None] for unit in scene.units]
    axles = [[columns[f"axle.{a}.{name}"] for name in AXLE] for a in range(len(scene.axle))]
    points, places = [], []
    for part, side, node, weight in _points(case):
        length = columns[_unit_key(part.unit - 1, "length")]
        at = [columns["zero"] if part.is_front else length] * 2 + [columns["zero"]]
        if part.number is not None:
            at = [columns[f"strip.{part.number}.{name}"] for name in ("begin", "end", "inset")]
        points.append([*at, *(_law_column(case, part, name, columns) for name in LAW)])
        places.append([side, node, weight])
    common = [columns[key] for key in ("impact.speed", "impact.angle", "contact.friction")]
    copies = [[k, columns[key.partition("@")[0]]] for key, k in columns.items() if "@" in key]
    whole: list[Any] = [
        np.array(table, dtype=np.int64).reshape(-1, width)
        for table, width in ((units, 7), (computed, 2), (axles, 3), (points, 3 + len(LAW)))
    ]
    further = np.array(places), np.array(common), np.array(copies, dtype=np.int64).reshape(-1, 2)
    return kernels.Parts._make([*whole, *further])


def _points(case: ImpactCase) -> list[tuple[Touching, float, float, float]]:
    """Return part, side, place and weight of each contact point.

    They are in the order of `points_of`.
    """
    nodes, weights = np.polynomial.legendre.leggauss(LINE_POINTS)
    points = []
    for unit in range(1, 1 + len(case.vehicles)):
        parts = [part for part in touching(case.scene) if part.unit == unit]
        for side in SIDES:
            for part in parts:
                strip = None if part.number is None else case.scene.strip[part.number]
                if strip is None or strip.at[0] == strip.at[1]:
                    points.append((part, side, 0.0, 0.0))
                else:
                    line = zip(0.5 * (1.0 + nodes), 0.5 * weights, strict=True)
                    points += [(part, side, float(node), float(weight)) for node, weight in line]
    return points


def _owners(case: ImpactCase) -> tuple[np.ndarray, np.ndarray]:
    """Return unit and group of each point."""
    sizes = np.array([[v.length, v.width, v.front_distance] for v in case.vehicles]).T[..., None]
    points = impact.strips.points_of(case.contact, *sizes)
    return points.unit, points.group


def _law_column(case: ImpactCase, part: Touching, name: str, columns: Mapping[str, int]) -> int:
    """Return the place of a parameter of a law."""
    key = part.keys[name]
    base = key.partition("@")[0]
    if value_at(case.scene, base) is not None:
        return columns[key] if key in columns else columns[base]
    of_strip = part.number is not None
    if name == "restitution" and of_strip and not value_at(case.scene, part.keys["unloading_stiffness"]):
        return columns["contact.restitution"]
    return columns["infinite" if name == "plateau_force" else "zero"]


def _case(
    case: ImpactCase, parts: kernels.Parts, unit: np.ndarray, group: np.ndarray, n: int
) -> tuple[Any, Any]:
    """Return the arguments of `accuracy.solve_sample` and its outcome.

    n: 1 for a motion, otherwise the samples of a band.
    """
    units, points, axles = len(case.vehicles), len(unit), len(case.scene.axle)
    of_units: list[Any] = [np.zeros((units, n)), np.zeros((units, n)), *np.zeros((2, units - 1, n))]
    train = Train._make(
        [*of_units, unit, group, *np.zeros((len(LAW) + 3, points, n)), np.zeros((units, 3, n))]
    )
    owners: list[Any] = [np.array([axle.unit - 1 for axle in case.scene.axle], dtype=np.int64)]
    sums = [np.zeros(axles), np.zeros(3 * units if axles else 0), np.zeros(len(SUMS) * units if axles else 0)]
    tyres = Tyres(*owners, *np.zeros((4, axles, n)), *sums)
    start, is_band = np.zeros((n, units, 6)), n > 1
    awaited = impact.awaited(case.contact, case.lengths)
    one = rigid_motion.TRAIN_TOLERANCE if case.trailers else impact.TOLERANCE
    tolerance, interval = (MANY_TOLERANCE, rigid_motion.INTERVAL) if is_band else (one, 0.0)
    end = rigid_motion.AFTER_SECOND, awaited, rigid_motion.LONGEST
    choice, clock = timing(train, start, tyres, None, None, interval, is_band, *end, tolerance)
    work = workspace(units, len(train.hitch), points, 1 + int(group.max()))
    rows = math.ceil(rigid_motion.LONGEST / interval) + 2 if is_band else 2 * len(case.motion.rows)
    width = 1 if is_band else case.motion.rows.shape[1]
    outcome = room_for(start, 0, rigid_motion.STRIKES if is_band else MOST_STRIKES, width)
    return (train, tyres, start, choice, clock, work), outcome._replace(rows=np.zeros((1, rows, width)))


def _motion(case: ImpactCase, outcome: Any) -> kernels.Motion:
    """Return memory for the motion of a page."""
    units, instants = len(case.vehicles), MOST_INSTANTS
    names, curves = column_names(units, bool(case.axles)), 1 + len(MEANS) + len(LOW_PASSES)
    return kernels.Motion(
        *rate_columns(units, names), np.zeros(instants), np.zeros((instants, len(names))), np.zeros(instants + 1),
        np.zeros((curves, instants)), np.array(MEANS), np.array([*LOW_PASSES.values()]), np.zeros(2 * instants),
        np.zeros(curves),
        np.zeros(outcome.strikes.shape[1]), names.index("impulse_normal"), answers.counted(units),
    )  # fmt: skip


def _paper(case: ImpactCase, columns: Mapping[str, int]) -> kernels.Paper:
    """Return the inputs of the paper's method, which trains lack."""
    keys = ("impact.speed", "impact.angle", *PAPER[:2], *(f"vehicle.{name}" for name in UNIT[:3]), PAPER[2])
    table = case.scene.impact
    is_possible = table and None not in (table.friction, table.restitution) and not case.scene.trailer
    places = [columns[key] if is_possible else -1 for key in keys]
    sign = 1.0 if table and table.convention == "newton" else -1.0
    return kernels.Paper(np.array(places), sign, np.zeros(1))


def _growth(case: ImpactCase, count: int) -> bands.Growth:
    """Return memory for the growth of the force."""
    pairs = min(band_samples.PAIRS, count // 4)
    speeds = [*band_samples.two_speeds(case).values()]
    return bands.Growth(np.array(speeds), np.zeros((2, pairs)), np.zeros(1))


def ranges_of(
    case: ImpactCase, ranges: tuple[Range, ...], columns: Mapping[str, int], count: int
) -> bands.Ranges:
    """Return the rules of the ranges about other values, the mass first."""
    rows, widths, bounds = [], [], []
    for item in ranges:
        half, value = 0.5 * (item.upper - item.lower), item.scene_value or 0.0
        unit = item.key.rpartition(".")[0]
        width, most = [0.0, 0.0, 0.0, math.nan, math.nan, 0.0], -1
        further = columns.get(f"{unit}.length", -1)
        if item.scene_value is None:
            further = columns[f"{unit.partition('@')[0]}.stiffness"]
            width[1], width[5] = half / (0.5 * (item.lower + item.upper)), HARDENING
        elif item.key.endswith("roll_inertia"):  # not evenly about its value
            further, middle = columns[item.key], 0.5 * (item.lower + item.upper)
            width[1], width[5] = half / middle, middle / value
        elif "of the length" in item.origin:
            width[2] = half / case.lengths[int(unit.split(".")[-1]) + 1 if "." in unit else 0]
        elif item.key == "vehicle.mass":
            width[1] = MASS
        elif item.key.endswith(".hitch"):
            width[0], most = planar_ranges.HITCH, columns[_unit_key(int(unit.split(".")[1]), "length")]
        elif "%" in item.origin:
            width[1] = half / value
        elif item.origin.startswith("±"):
            width[0] = half
        else:
            width[3:5] = item.lower, item.upper
        rows.append([columns[item.key], further if width[2] or width[5] else -1, most])
        widths.append(width)
        bounds.append(key_bounds(item.key, case))
    light = [[POUND * mass, POUND * tolerance] for mass, tolerance in LIGHT_VEHICLES.values()]
    drawn = sampling.latin_hypercube(len(ranges), count, np.random.default_rng(sampling.SEED))
    size, rules = len(ranges), (np.array(rows), np.array(widths), np.array(bounds))
    room = np.zeros((size, 2)), np.zeros(size), np.zeros((size, count)), np.zeros((size, size + 1))
    return bands.Ranges(*rules, columns["vehicle.mass"], np.array(light), drawn, *room)


def classes_of(case: ImpactCase) -> list[VehicleClass]:
    """Return the classes of vehicles of a scene's test level."""
    level = case.scene.impact and str(case.scene.impact.test_level)
    return [one for one in classes() if level in one.levels]


def class_rows(case: ImpactCase) -> np.ndarray:
    """Return the classes of `bands.calibrate`."""
    rows = [[*one.speeds, *one.masses, one.calibration["factor"] or math.nan] for one in classes_of(case)]
    return np.array(rows, dtype=np.float64).reshape(-1, 5)


def key_bounds(key: str, case: ImpactCase) -> tuple[float, float]:
    """Return the least and greatest value of a key [SI]."""
    if "*" in key:  # a factor
        return 0.0, math.inf
    quantity = quantity_at(key, case.source.tables)
    assert quantity
    return quantity.least, min(quantity.most, math.nextafter(quantity.below, 0.0))
