"""Roll of vehicles in space over walls.

Samples of uncertain inputs strike walls of many heights. The fraction upright, the lowest wall that keeps 5, 50 and
95 % upright, and the distribution of force and height of the resultant follow. A map shows the largest roll of the
nominal vehicle over the heights of wall and centre of mass. Sobol indices show the sources of the variance at the
scene's wall.
"""

import functools
import itertools
import math
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from postprocess.figures.tipping import INCHES
from postprocess.units import INCH
from solver import space
from tailslap import progress
from tailslap.campaign import engine, sampling, space_samples
from tailslap.campaign.input_ranges import Range
from tailslap.campaign.records import Record
from tailslap.campaign.sampling import Array
from tailslap.case.force_band import PERCENTILES, binomial_interval
from tailslap.case.impact.case import ImpactCase
from tailslap.case.impact.space.answer import SpaceAnswer
from tailslap.errors import InputError, Missing
from tailslap.scene.vary import vary
from tailslap.validation.outcomes import OutcomeRow, outcome_rows
from tailslap.validation.tables import parameters

WALLS = tuple(INCH * inches for inches in INCHES)
"""Heights of common walls [m]."""

LOWEST, HIGHEST, STEP = 20 * INCH, 60 * INCH, 2 * INCH
"""Range of the heights of walls, at least up to the highest centre of mass, and their distance [m]."""

POINTS, MAP_RANGE, ABOVE_AXLES = 50, 0.35, 0.05
"""Points of the map per axis, variation of the centre of mass to both sides, least height above the axles [m]."""

LINE_CENTRES, LINE_SAMPLES, LINE_WALLS = 5, 64, 2
"""Centres of mass with lines on the map, samples of each, and heights of walls per one of theirs."""

BLOCK = 64
"""Samples of a part."""

LEVELS = (0.05, 0.5, 0.95)
"""Fractions of the samples that the lines keep upright."""

OUTPUTS = {"roll": "the largest roll", "mean_50ms": "the largest 50 ms mean"}
"""Quantities with Sobol indices, at the scene's wall."""


@dataclass(frozen=True)
class TippingResult:
    """Result of the study.

    Attributes
    ----------
    nominal : SpaceAnswer
        Motion of the scene's own vehicle.
    centre_key : str
        Key of the centre of mass on the map, the highest one of the train.
    centres, map_walls, rolls : ndarray, shape (k,), (k,), (k, k)
        Heights [m], and largest roll of the nominal vehicle by wall and centre, at most 90 deg [rad].
    walls : ndarray, shape (n,)
        Heights of the walls of the samples [m].
    answers : dict of ndarray, shape (n, samples)
        Answers of the samples by name and wall.
    line_centres, lines : ndarray, shape (m,), (3, m)
        Heights of the centre, and the walls that keep 5, 50 and 95 % of the samples upright [m]; NaN above all walls.
    profiles : dict of dict
        Answers at the height of the scene's wall by profile.
    ranges : tuple of Range
        Uncertain inputs.
    inputs : dict of ndarray, shape (samples,)
        Samples by key.
    sources : dict of list
        Rows of `sampling.index_rows` by output, empty where refused.
    refusals : dict of str
        Reasons without indices by output.
    published : tuple of OutcomeRow
        Probabilities of the published outcomes of crash tests, see `tailslap validate`.
    motions : int
        Number of motions.
    seconds, processor : float
        Wall time, and processor time of all motions, of an earlier part as well [s].
    """

    case: ImpactCase
    nominal: SpaceAnswer
    centre_key: str
    centres: Array
    map_walls: Array
    rolls: Array
    walls: Array
    answers: Mapping[str, Array]
    line_centres: Array
    lines: Array
    profiles: Mapping[str, Mapping[str, Array]]
    ranges: tuple[Range, ...]
    inputs: Mapping[str, Array]
    sources: Mapping[str, list[Record]]
    refusals: Mapping[str, str]
    published: tuple[OutcomeRow, ...]
    motions: int
    seconds: float
    processor: float

    @property
    def height(self) -> float:
        """Height of the scene's wall [m]."""
        return wall_height(self.case)

    @property
    def count(self) -> int:
        """Number of samples of each wall."""
        return int(self.answers["outcome"].shape[1])

    @property
    def profile(self) -> str:
        """Profile of the scene's wall."""
        profile = (self.case.scene.wall and self.case.scene.wall.profile) or "vertical"
        return profile if isinstance(profile, str) else "given by points"

    @property
    def upright(self) -> Array:
        """Fraction of the samples that remains upright by wall, shape (n,)."""
        return (self.answers["outcome"] == 0.0).mean(axis=1)

    @property
    def intervals(self) -> Array:
        """Intervals of these fractions, shape (2, n)."""
        outcomes = self.answers["outcome"]
        return binomial_interval((outcomes == 0.0).sum(axis=1), self.count)

    def keeps(self, level: float) -> tuple[float, float, float]:
        """Return the lowest wall that keeps a fraction upright.

        With its interval [m], NaN above all walls.
        """
        low, high = self.intervals
        lowest, earliest, latest = (
            lowest_wall(self.walls, part, level) for part in (self.upright, high, low)
        )
        return lowest, earliest, latest

    def band(self, name: str) -> Array:
        """Return the percentiles of an answer by wall, shape (3, n)."""
        return np.percentile(self.answers[name], PERCENTILES, axis=1)


def lowest_wall(walls: Array, fractions: Array, level: float) -> float:
    """Return the height above which all fractions reach a level [m].

    It is linear between walls, the lowest wall where all reach it, and NaN where the highest does not.
    """
    below = np.flatnonzero(fractions < level)
    if not below.size:
        return float(walls[0])
    last = int(below[-1])
    if last == len(walls) - 1:
        return math.nan
    part = (level - fractions[last]) / (fractions[last + 1] - fractions[last])
    return float(walls[last] + part * (walls[last + 1] - walls[last]))


def compute(
    case: ImpactCase,
    place: Path,
    samples: int,
    ranges: tuple[str, ...],
    fixed: tuple[str, ...],
    workers: int | None,
) -> TippingResult:
    """Compute map, lines, walls, profiles and indices.

    An interrupted study resumes from its journal. Raises InputError.
    """
    if case.scene.body is None:
        raise InputError(
            "body", Missing, "`tailslap study tipping` requires this table, with [[axle]], [[strip]], [wall]"
        )
    began = time.perf_counter()
    varied, nominal = space_samples.space_ranges(case, ranges, fixed), case.space
    assert nominal
    solution: Record = {}

    def solve(inputs: Mapping[str, Array]) -> dict[str, Array]:
        solution.update(_solved(case, varied, inputs, samples, place, workers))
        return {name: solution[name] for name in OUTPUTS}

    inputs, tables = sampling.sampled(varied, samples, solve)
    sources, refusals = sampling.rows_and_refusals(varied, tables)
    refusals |= {name: "The quantity is constant." for name in tables if name not in sources}
    count = solution["answers"]["outcome"].shape[1]
    return TippingResult(
        case=case,
        nominal=nominal,
        ranges=varied,
        inputs={key: values[:count] for key, values in inputs.items()},
        sources=sources,
        refusals=refusals,
        published=published_outcomes(),
        seconds=time.perf_counter() - began,
        **{name: value for name, value in solution.items() if name not in OUTPUTS},
    )


@functools.cache
def published_outcomes() -> tuple[OutcomeRow, ...]:
    """Return the probabilities of published outcomes, of vehicles of their own."""
    with progress.progress_bar("published outcomes", 1) as show:
        return outcome_rows(parameters(), show)


def wall_height(case: ImpactCase) -> float:
    """Return the height of the scene's wall [m]."""
    assert case.scene.wall
    assert case.scene.wall.height
    return case.scene.wall.height


def wall_heights(case: ImpactCase) -> Array:
    """Return the samples' wall heights [m].

    The scene's and common ones are among them.
    """
    assert case.space
    highest = max(HIGHEST, *(float(unit.centre_height) for unit in case.space.inputs.vehicle.units))
    spaced = np.arange(LOWEST, highest + STEP - 1e-6, STEP)
    return np.unique(np.round([*spaced, *WALLS, wall_height(case)], 6))


def highest_centre(case: ImpactCase) -> tuple[str, float]:
    """Return key and height of the highest centre of mass [m]."""
    nominal = space_samples.nominal_values(case)
    heights = {key: value for key, value in nominal.items() if key.endswith("centre_height")}
    return max(heights.items(), key=lambda item: item[1])


def _solved(
    case: ImpactCase,
    varied: tuple[Range, ...],
    inputs: Mapping[str, Array],
    samples: int,
    place: Path,
    workers: int | None,
) -> Record:
    """Return fields of `TippingResult`, and the columns of `OUTPUTS`."""
    heights, count = _heights(case), 2 * next(iter(inputs.values())).size // (len(varied) + 2)
    groups = _parts(case, heights, inputs, count)
    ranges = [[item.key, item.lower, item.upper] for item in varied]
    definition = {"study": "tipping", "scene": case.scene.model_dump(), "samples": samples, "ranges": ranges}
    together = {name: arguments for parts in groups.values() for name, arguments in parts.items()}
    motions = (space_samples.solve_samples, together, "motions")
    results = engine.run_study(place, definition, motions, workers)
    records = {name: {key: results[key] for key in parts} for name, parts in groups.items()}
    tables = {name: {c: _column(of, c) for c in space_samples.COLUMNS} for name, of in records.items()}
    walls = heights["walls"]
    upright = tables["lines"]["outcome"].reshape(LINE_CENTRES, -1, LINE_SAMPLES) == 0.0
    lines = [[lowest_wall(walls[::LINE_WALLS], x, level) for x in upright.mean(axis=2)] for level in LEVELS]
    profiles = zip(space.PROFILES, records["profiles"].values(), strict=True)
    return heights | {
        "roll": _largest(tables["samples"]),
        "mean_50ms": tables["samples"]["mean_50ms"],
        "rolls": _largest(tables["map"]).reshape(POINTS, POINTS).T,
        "answers": {name: values.reshape(len(walls), count) for name, values in tables["walls"].items()},
        "lines": np.array(lines),
        "profiles": {name: {c: np.array(of[c]) for c in space_samples.COLUMNS} for name, of in profiles},
        "motions": sum(values["outcome"].size for values in tables.values()),
        "processor": math.fsum(record["processor"] for record in results.values()),
    }


def _heights(case: ImpactCase) -> Record:
    """Return heights of walls and centres of mass by fields of `TippingResult`."""
    walls, (key, centre) = wall_heights(case), highest_centre(case)
    lowest = ABOVE_AXLES + max(axle.radius or 0.0 for axle in case.scene.axle)
    centres = np.linspace(max(centre - MAP_RANGE, lowest), centre + MAP_RANGE, POINTS)
    map_walls = np.linspace(walls[0], walls[-1], POINTS)
    line_centres = np.linspace(centres[0], centres[-1], LINE_CENTRES)
    return {
        **{"centre_key": key, "centres": centres, "line_centres": line_centres},
        **{"walls": walls, "map_walls": map_walls},
    }


def _parts(
    case: ImpactCase, heights: Record, inputs: Mapping[str, Array], count: int
) -> dict[str, dict[str, tuple[object, ...]]]:
    """Return the arguments of all parts by group and key.

    heights: of `_heights`; count: number of samples of a wall.
    """
    key, walls = heights["centre_key"], heights["walls"]
    first = {name: values[:count] for name, values in inputs.items()}
    line_samples = {name: values[:LINE_SAMPLES] for name, values in first.items() if name != key}

    source, size = case.source, next(iter(inputs.values())).size
    blocks = np.array_split(np.arange(size), math.ceil(size / BLOCK))

    def at(values: Mapping[str, Array], count: int, levels: Mapping[str, float]) -> tuple[object, ...]:
        return source, {**values, **{name: np.full(count, level) for name, level in levels.items()}}

    return {
        "samples": {
            f"samples {n}": (source, {k: v[rows] for k, v in inputs.items()}) for n, rows in enumerate(blocks)
        },
        "walls": {f"wall {h:.6f}": at(first, count, {"wall.height": h}) for h in walls},
        "map": {
            f"centre {c:.6f}": (source, {key: np.full(POINTS, c), "wall.height": heights["map_walls"]})
            for c in heights["centres"]
        },
        "lines": {
            f"line {c:.6f} {h:.6f}": at(line_samples, LINE_SAMPLES, {key: c, "wall.height": h})
            for c, h in itertools.product(heights["line_centres"], walls[::LINE_WALLS])
        },
        "profiles": {
            f"profile {name}": (vary(source, {"wall.profile": name})[1], dict(first))
            for name in space.PROFILES
        },
    }


def _column(records: Mapping[str, Mapping[str, list[float]]], name: str) -> Array:
    """Return an answer of all parts of a group in their order."""
    return np.concatenate([record[name] for record in records.values()])


def _largest(table: Mapping[str, Array]) -> Array:
    """Return the largest rolls, 90 deg unless upright [rad]."""
    return np.where(
        table["outcome"] == 0.0, np.minimum(np.abs(table["largest_roll"]), 0.5 * np.pi), 0.5 * np.pi
    )
