"""Roll of vehicles over walls.

The lowest wall without rollover is sought. A map shows the largest roll over the heights of wall and centre of mass,
with the line of the lowest walls and its band for uncertain inputs. Sobol indices show the sources of the variance. The
impacts of the samples are those of the rigid vehicle with fixed time steps; their error is the change with twice the
step.
"""

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from solver import tipping
from tailslap.campaign import engine, input_ranges, sampling
from tailslap.campaign.input_ranges import Range
from tailslap.campaign.records import Record
from tailslap.campaign.sampling import Array
from tailslap.case import case_of
from tailslap.case.impact import rigid
from tailslap.case.impact.case import ImpactCase
from tailslap.case.impact.tipping import TippingAnswer, rolling_vehicle
from tailslap.errors import InputError, Missing, Verbatim
from tailslap.scene.vary import Source
from tailslap.studies.uncertainty.uncertainty_ranges import demand_corners, impact_ranges

INCH = 0.0254
WALLS = tuple(INCH * inches for inches in (27, 32, 36, 42, 54))
"""Heights of common walls [m]."""

POINTS, HIGHEST_WALL, CENTRE_RANGE = 50, 1.5, 0.35
"""Points of the map per axis, highest wall, and variation of the centre of mass to both sides [m]."""

BAND_CENTRES, BAND_SAMPLES = 9, 128
"""Heights of the centre of mass with a band, and samples of each."""

STEP, FINE_STEP, ABRUPT, BLOCK = 1e-3, 2e-4, 0.06, 512
"""Time steps of the samples [s], restitution below which the finer one applies, and samples of a part.

Forces end abruptly at low restitution. 95 % of the lowest walls then differ by less than 2 mm from those of small
steps.
"""

TIPPING_KEYS = tuple(
    f"tipping.{name}" for name in ("centre_height", "roll_inertia", "suspension", "damping_ratio")
)
"""Keys of tipping that vary."""
FIXED_OF_BAND = (
    "impact.speed",
    "impact.angle",
    "vehicle.mass",
    "vehicle.centre_of_mass",
    "tipping.centre_height",
)
"""Keys that do not vary within the band of the line."""


@dataclass(frozen=True)
class TippingResult:
    """Result of the study.

    Attributes
    ----------
    answer : TippingAnswer
        Roll of the scene's own vehicle.
    centres, walls, rolls : ndarray, shape (k,), (k,), (k, k)
        Heights [m], and largest roll by wall and centre [rad].
    line : ndarray, shape (k,)
        Lowest wall without rollover by centre [m].
    band_centres, band : ndarray, shape (n,), (3, n)
        Heights of the centre, and percentiles of the lowest wall [m].
    ranges : tuple of Range
        Uncertain inputs.
    inputs, lowest : dict of ndarray, ndarray
        Samples by key, shape ((inputs + 2) rows,), and their lowest walls, shape (inputs + 2, rows) [m].
    sources : list of dict
        One row per input, see `sampling.index_rows`.
    refusal : str
        Reason without indices, or "".
    error : float
        Change of peaks, impulses and spin of the impacts with twice the step, not exceeded by 95 % of the samples [-].
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
    sources: list[Record]
    refusal: str
    error: float
    seconds: float

    @property
    def samples(self) -> dict[str, Array]:
        """Return the samples of the distribution and their lowest walls.

        The shape is (2 rows,).
        """
        count = self.lowest[:2].size
        return {key: values[:count] for key, values in self.inputs.items()} | {
            "lowest_safe_wall": self.lowest[:2].ravel()
        }

    def holds(self, wall: float) -> float:
        """Return the fraction of samples without rollover."""
        return float(np.mean(self.lowest[:2] <= wall))


def compute(
    case: ImpactCase,
    place: Path,
    samples: int,
    ranges: tuple[str, ...],
    fixed: tuple[str, ...],
    workers: int | None,
) -> TippingResult:
    """Compute map, line, band and samples.

    An interrupted study resumes from its journal. Raises InputError.
    """
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
    centres = _centres(case, POINTS)
    walls, interval = np.linspace(0.4, HIGHEST_WALL, POINTS), case.answer.interval
    force = case.answer.history["force_normal"][1:]
    vehicle = replace(answer.vehicle, centre_height=centres)
    rolls = tipping.largest_rolls(vehicle, walls[:, None], force, interval)
    line = tipping.lowest_walls(vehicle, force, interval)
    sampled: Record = {}

    def solve(inputs: Mapping[str, Array]) -> dict[str, Array]:
        sampled.update(_solved(case, inputs, varied, place, samples, workers))
        return {"lowest": sampled["lowest"]}

    inputs, tables = sampling.sampled(varied, samples, solve)
    lowest = tables["lowest"]
    if not lowest[:2].std() > 0.0:
        raise InputError(
            "--range", Verbatim("these ranges"), "no vehicle within these ranges rolls over any wall"
        )
    return TippingResult(
        case, answer, centres, walls, rolls, line, sampled["centres"], sampled["band"], varied, inputs, lowest,
        *sampling.index_rows(varied, lowest), sampled["error"], time.perf_counter() - began,
    )  # fmt: skip


def _centres(case: ImpactCase, count: int) -> Array:
    """Return heights of the centre of mass [m]."""
    assert case.scene.tipping
    height = case.scene.tipping.centre_height
    return np.linspace(max(height - CENTRE_RANGE, 0.1), height + CENTRE_RANGE, count)


def tipping_ranges(
    case: ImpactCase, answer: TippingAnswer, ranges: tuple[str, ...], fixed: tuple[str, ...]
) -> tuple[Range, ...]:
    """Return the ranges of impact and roll.

    Ranges of the impact are those of the study of uncertainty, those of the roll are assumed. Raises InputError.
    """
    vehicle, about = answer.vehicle, input_ranges.about
    limits = {
        "tipping.centre_height": about(float(vehicle.centre_height), 0.1, "± 0.1 m, assumed"),
        "tipping.roll_inertia": about(
            float(vehicle.roll_inertia), 0.25 * float(vehicle.roll_inertia), "± 25 %, assumed"
        ),
        "tipping.suspension": about(
            float(vehicle.suspension), 0.3 * float(vehicle.suspension), "± 30 %, assumed"
        ),
        "tipping.damping_ratio": (0.0, 0.3, input_ranges.ASSUMED),
    }
    of_roll = [text for text in (*ranges, *fixed) if text.partition("=")[0].strip() in TIPPING_KEYS]
    of_impact = impact_ranges(
        case, tuple(r for r in ranges if r not in of_roll), tuple(f for f in fixed if f not in of_roll)
    )
    typed = tuple(r for r in ranges if r in of_roll), tuple(f for f in fixed if f in of_roll)
    roll_ranges = input_ranges.ranges_of(case, TIPPING_KEYS, limits, *typed)
    return (
        *of_impact,
        *(replace(item, given=getattr(vehicle, item.key.split(".")[1])) for item in roll_ranges),
    )


def _solved(
    case: ImpactCase,
    inputs: Mapping[str, Array],
    varied: tuple[Range, ...],
    place: Path,
    samples: int,
    workers: int | None,
) -> Record:
    """Return lowest walls of samples and band."""
    first = next(iter(inputs.values()))
    size = first.size
    order = np.argsort(inputs.get("contact.restitution", first))  # steps of a block are similar
    centres = _centres(case, BAND_CENTRES)
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
        "ranges": [[item.key, item.lower, item.upper] for item in varied],
    }  # fmt: skip
    groups = (measure, parts, f"{size} impacts"), (measure, band, "band")
    sample_records, band_records = engine.run_study(place, definition, groups, workers)
    lowest, errors = np.empty(size), []
    for rows, record in zip(blocks, sample_records.values(), strict=True):
        lowest[rows] = record["lowest"]
        errors += record["error"]
    ends = [np.percentile(record["lowest"], sampling.PERCENTILES) for record in band_records.values()]
    return {
        "lowest": lowest,
        "error": float(np.percentile(errors, 95)),
        "centres": centres,
        "band": np.array(ends).T,
    }


def measure(source: Source, inputs: Mapping[str, Array]) -> dict[str, list[float]]:
    """Return the lowest walls [m] and the errors of impacts.

    Inputs are by key, shape (n,) [SI].
    """
    from tailslap.scene.vary import vary

    case = case_of(*vary(source, {}))
    assert isinstance(case, ImpactCase)
    assert case.scene.tipping
    restitution = inputs.get("contact.restitution", case.scene.needed_contact.restitution or 0.0)
    step = FINE_STEP if np.min(restitution) < ABRUPT else STEP
    impacts = case.impacts(inputs, after_second=rigid.AFTER_TIPPING, interval=STEP, step=step)
    varied = {key.split(".")[1]: values for key, values in inputs.items() if key in TIPPING_KEYS}
    if "vehicle.mass" in inputs:
        varied["mass"] = inputs["vehicle.mass"]
    vehicle = replace(rolling_vehicle(case.scene, case.scene.tipping, case.scene.vehicle), **varied)
    lowest = tipping.lowest_walls(vehicle, impacts.mean_force.T, STEP)
    return {
        "lowest": np.broadcast_to(lowest, impacts.error.shape).tolist(),
        "error": np.minimum(impacts.error, 1.0).tolist(),
    }
