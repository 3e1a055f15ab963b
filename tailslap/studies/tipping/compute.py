"""Tipping over walls: largest roll over wall height and centre height, the line between walls that hold and those that
do not, its band over what is not known, and where the spread of the lowest wall that holds comes from.

The impacts of the samples are those of the rigid vehicle at fixed steps; error: what twice the step changes.
"""

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from solver import tipping
from tailslap.campaign import engine, sampling
from tailslap.campaign.sampling import Array, Range
from tailslap.case import case_of
from tailslap.case.impact import rigid
from tailslap.case.impact.case import ImpactCase
from tailslap.case.impact.tipping import TippingAnswer, rolling_vehicle
from tailslap.errors import InputError, Missing, Verbatim
from tailslap.scene.vary import Source
from tailslap.studies.uncertainty.compute import demand_corners, impact_ranges

INCH = 0.0254
WALLS = tuple(INCH * inches for inches in (27, 32, 36, 42, 54))
"""Heights of common walls [m]."""

POINTS, HIGHEST_WALL, BESIDE = 50, 1.5, 0.35
"""Heights of the map each way; the highest wall, and how far the centre varies to either side [m]."""

BAND_CENTRES, BAND_SAMPLES = 9, 128
"""Heights of the centre at which the band is computed, from so many samples each."""

STEP, FINE_STEP, ABRUPT, BLOCK = 1e-3, 2e-4, 0.06, 512
"""Steps of the impacts of the samples [s], the second of those with less restitution than `ABRUPT`, whose forces end
abruptly: lowest walls of 95 in 100 then lie within 2 mm of those of small steps; samples of a part at most."""

OWN = tuple(f"tipping.{name}" for name in ("centre_height", "roll_inertia", "suspension", "damping_ratio"))
FIXED_OF_BAND = (
    "impact.speed",
    "impact.angle",
    "vehicle.mass",
    "vehicle.centre_of_mass",
    "tipping.centre_height",
)
"""Keys that vary with tipping; keys that do not vary within the band of the line."""


@dataclass(frozen=True)
class RolledOver:
    """The finished study.

    Attributes
    ----------
    answer : TippingAnswer
        The scene's own.
    centres, walls, rolls : ndarray, shape (k,), (k,), (k, k)
        Heights [m], and largest roll by wall and centre [rad].
    line : ndarray, shape (k,)
        Lowest wall that holds at each of `centres` [m].
    band_centres, band : ndarray, shape (n,), (3, n)
        Heights of the centre, and the percentiles of the lowest wall that holds [m].
    ranges : tuple of Range
        Inputs that vary.
    inputs, lowest : dict of ndarray, ndarray
        Samples by key, shape ((inputs + 2) rows,), and the lowest walls that hold, shape (inputs + 2, rows) [m].
    sources : list of dict
        A row an input, as of `sampling.index_rows`.
    refusal : str
        Why there are none, or "".
    error : float
        Change of peaks, impulses and spin of the samples' impacts with twice the step, which 95 in 100 keep [-].
    """

    case: ImpactCase
    answer: TippingAnswer
    centres: Array
    walls: Array
    rolls: Array
    line: Array
    band_centres: Array
    band: Array
    ranges: tuple[Range, ...]
    inputs: Mapping[str, Array]
    lowest: Array
    sources: list[dict[str, Any]]
    refusal: str
    error: float
    seconds: float

    @property
    def samples(self) -> dict[str, Array]:
        """Combinations of the distribution and their lowest walls, shape (2 rows,)."""
        count = self.lowest[:2].size
        return {key: values[:count] for key, values in self.inputs.items()} | {
            "lowest_safe_wall": self.lowest[:2].ravel()
        }

    def holds(self, wall: float) -> float:
        """Fraction of the samples that a wall of this height holds."""
        return float(np.mean(self.lowest[:2] <= wall))


def compute(
    case: ImpactCase,
    place: Path,
    samples: int,
    ranges: tuple[str, ...],
    fixed: tuple[str, ...],
    workers: int | None,
) -> RolledOver:
    """The study of a scene with [tipping]; an interrupted one goes on from its journal. Raises InputError."""
    if case.scene.tipping is None:
        raise InputError("tipping", Missing, "`tailslap study tipping` requires this table")
    if case.scene.trailer:
        raise InputError(
            "trailer",
            Verbatim("a train"),
            "`tailslap study tipping` supports one unit, because its samples contain the total force only; remove this "
            "table, or use `tailslap rigid` for the roll of each unit",
        )
    demand_corners(case)
    began = time.perf_counter()
    answer = rigid.tipping_of(case, case.answer)
    varied = tipping_ranges(case, answer, ranges, fixed)
    own = case.scene.tipping
    centres = np.linspace(max(own.centre_height - BESIDE, 0.1), own.centre_height + BESIDE, POINTS)
    walls, force, interval = (
        np.linspace(0.4, HIGHEST_WALL, POINTS),
        case.answer.history["force_normal"][1:],
        case.answer.interval,
    )
    vehicle = replace(answer.vehicle, centre_height=centres)
    rolls = tipping.largest_rolls(vehicle, walls[:, None], force, interval)
    line = tipping.lowest_walls(vehicle, force, interval)
    found: dict[str, Any] = {}

    def solve(inputs: Mapping[str, Array]) -> dict[str, Array]:
        found.update(_solved(case, inputs, varied, place, samples, workers))
        return {"lowest": found["lowest"]}

    inputs, tables = sampling.sampled(varied, samples, solve)
    lowest = tables["lowest"]
    if not lowest[:2].std() > 0.0:
        raise InputError(
            "--range", Verbatim("these ranges"), "no vehicle within these ranges rolls over any wall"
        )
    return RolledOver(
        case, answer, centres, walls, rolls, line, found["centres"], found["band"], varied, inputs, lowest,
        *sampling.index_rows(varied, lowest), found["error"], time.perf_counter() - began,
    )  # fmt: skip


def tipping_ranges(
    case: ImpactCase, answer: TippingAnswer, ranges: tuple[str, ...], fixed: tuple[str, ...]
) -> tuple[Range, ...]:
    """The ranges: of the impact as in the study of uncertainty, of the roll assumed. Raises InputError."""
    vehicle, about = answer.vehicle, sampling.about
    limits = {
        "tipping.centre_height": about(float(vehicle.centre_height), 0.1, "± 0.1 m, assumed"),
        "tipping.roll_inertia": about(
            float(vehicle.roll_inertia), 0.25 * float(vehicle.roll_inertia), "± 25 %, assumed"
        ),
        "tipping.suspension": about(
            float(vehicle.suspension), 0.3 * float(vehicle.suspension), "± 30 %, assumed"
        ),
        "tipping.damping_ratio": (0.0, 0.3, sampling.ASSUMED),
    }
    own = [text for text in (*ranges, *fixed) if text.partition("=")[0].strip() in OWN]
    of_impact = impact_ranges(
        case, tuple(r for r in ranges if r not in own), tuple(f for f in fixed if f not in own)
    )
    rest = tuple(r for r in ranges if r in own), tuple(f for f in fixed if f in own)
    found = sampling.ranges_of(case, OWN, limits, *rest)
    return (*of_impact, *(replace(each, given=getattr(vehicle, each.key.split(".")[1])) for each in found))


def _solved(
    case: ImpactCase,
    inputs: Mapping[str, Array],
    varied: tuple[Range, ...],
    place: Path,
    samples: int,
    workers: int | None,
) -> dict[str, Any]:
    """Lowest walls of the samples, their error, and the band over centre heights."""
    first, own = next(iter(inputs.values())), case.scene.tipping
    assert own
    size, order = first.size, np.argsort(inputs.get("contact.restitution", first))  # a block has like steps
    centres = np.linspace(max(own.centre_height - BESIDE, 0.1), own.centre_height + BESIDE, BAND_CENTRES)
    few = {key: values[:BAND_SAMPLES] for key, values in inputs.items() if key not in FIXED_OF_BAND}
    blocks = order.reshape(-1, math.gcd(size, BLOCK))
    parts = {
        f"samples {n}": (case.source, {key: values[rows] for key, values in inputs.items()})
        for n, rows in enumerate(blocks)
    }
    band = {
        f"centre {n}": (case.source, few | {"tipping.centre_height": np.full(BAND_SAMPLES, centre)})
        for n, centre in enumerate(centres)
    }
    definition = {
        "study": "tipping", "scene": case.scene.model_dump(), "samples": samples,
        "ranges": [[each.key, each.lower, each.upper] for each in varied],
    }  # fmt: skip
    groups = (measure, parts, f"{size} impacts"), (measure, band, "band")
    drawn, across = engine.run_study(place, definition, groups, workers)
    lowest, errors = np.empty(size), []
    for rows, record in zip(blocks, drawn.values(), strict=True):
        lowest[rows] = record["lowest"]
        errors += record["error"]
    ends = [np.percentile(record["lowest"], sampling.PERCENTILES) for record in across.values()]
    return {
        "lowest": lowest,
        "error": float(np.percentile(errors, 95)),
        "centres": centres,
        "band": np.array(ends).T,
    }


def measure(source: Source, inputs: Mapping[str, Array]) -> dict[str, list[float]]:
    """Lowest walls that hold vehicles [m], and errors of their impacts; inputs by key, shape (n,) [SI]."""
    from tailslap.scene.vary import vary

    case = case_of(*vary(source, {}))
    assert isinstance(case, ImpactCase)
    assert case.scene.tipping
    restitution = inputs.get("contact.restitution", case.scene.needed_contact.restitution or 0.0)
    step = FINE_STEP if np.min(restitution) < ABRUPT else STEP
    found = case.impacts(inputs, after_second=rigid.AFTER_TIPPING, interval=STEP, step=step)
    names = {key.split(".")[1]: values for key, values in inputs.items() if key in OWN}
    if "vehicle.mass" in inputs:
        names["mass"] = inputs["vehicle.mass"]
    vehicle = replace(rolling_vehicle(case.scene, case.scene.tipping, case.scene.vehicle), **names)
    lowest = tipping.lowest_walls(vehicle, found.mean_force.T, STEP)
    return {
        "lowest": np.broadcast_to(lowest, found.error.shape).tolist(),
        "error": np.minimum(found.error, 1.0).tolist(),
    }
