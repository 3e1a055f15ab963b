"""The study itself: combinations, distribution, indices."""

from __future__ import annotations

import importlib
import math
import time
from dataclasses import dataclass

import numpy as np

from tailslap.case.corner.case import CornerCase
from tailslap.errors import InputError, Verbatim
from tailslap.progress import announced
from tailslap.scene.write import scene_inputs
from tailslap.studies.study import Call
from tailslap.studies.uncertainty.indices import Indices, sobol_indices
from tailslap.studies.uncertainty.model import Array
from tailslap.studies.uncertainty.ranges import Range, study_ranges, used_keys
from tailslap.studies.uncertainty.sampling import SEED, Samples, draw, tables

PERCENTILES = (5, 50, 95)
BINS = 60
MIN_ROWS, MIN_SPREAD = 16, 1e-12
"""Rows and relative standard deviation below which there are no indices."""


@dataclass(frozen=True)
class Distribution:
    """Of the peak force [N]: counts has one entry fewer than edges; percentiles are those of PERCENTILES."""

    mean: float
    standard_deviation: float
    percentiles: tuple[float, ...]
    edges: Array
    counts: Array


@dataclass(frozen=True)
class VariedInput:
    """A varied input: its range and the scene's own value in words, its Sobol indices and their 95 % intervals."""

    key: str
    lower: float
    upper: float
    unit: str
    origin: str
    of_the_scene: float | None
    first_order: float
    first_order_interval: tuple[float, float]
    total: float
    total_interval: tuple[float, float]

    @property
    def range(self) -> str:
        """Its range, angles in degrees."""
        factor, unit = (180.0 / math.pi, "deg") if self.unit == "rad" else (1.0, self.unit)
        return f"{self.lower * factor:.5g} to {self.upper * factor:.5g} {unit}".strip()

    @property
    def value(self) -> str:
        """The scene's own value, angles in degrees."""
        factor, unit = (180.0 / math.pi, "deg") if self.unit == "rad" else (1.0, self.unit)
        return "–" if self.of_the_scene is None else f"{self.of_the_scene * factor:.5g} {unit}".strip()


@dataclass(frozen=True)
class Spread:
    """The finished study of a plan. first_refusal: why the theory refused the first combination, or ""."""

    plan: CornerCase
    samples: Samples
    distribution: Distribution
    indices: Indices
    first_refusal: str
    seconds: float

    @property
    def inputs(self) -> tuple[VariedInput, ...]:
        """Ranges and indices, in the order of the scene."""
        return varied_inputs(self.samples.ranges, self.indices)

    @property
    def columns(self) -> dict[str, Array]:
        """The combinations of the distribution, inputs and force; NaN where the theory refuses one."""
        samples = self.samples
        values = np.hstack([samples.a, samples.b])
        columns = {item.key: column for item, column in zip(samples.ranges, values, strict=True)}
        return columns | {"peak_force": np.concatenate([samples.force_a, samples.force_b])}

    @property
    def histogram(self) -> tuple[Array, Array, tuple[tuple[int, float], ...], float]:
        """Edges and counts of the distribution, its percentiles, and the scene's own force [N]."""
        its = self.distribution
        percentiles = tuple(zip(PERCENTILES, its.percentiles, strict=True))
        return its.edges, its.counts, percentiles, float(self.plan.force.peak_force)

    @property
    def fixed(self) -> tuple[str, ...]:
        """Keys of the scene that the force depends on and that did not vary."""
        varied = {item.key for item in self.samples.ranges}
        keys = (row.key for row in scene_inputs(self.plan.scene, self.plan.source))
        return tuple(key for key in keys if key in used_keys(self.plan.scene) and key not in varied)

    @property
    def share_below(self) -> float:
        """Share of the combinations whose force is below that of the scene's own values."""
        return float(np.mean(self.samples.known < self.plan.force.peak_force))


def varied_inputs(ranges: tuple[Range, ...], found: Indices) -> tuple[VariedInput, ...]:
    """Ranges and indices of the same inputs as one record each."""
    first, total = (np.transpose(ends).tolist() for ends in (found.first_interval, found.total_interval))
    return tuple(
        VariedInput(
            *(item.key, item.lower, item.upper, item.unit, item.origin, item.given),
            *(float(found.first[i]), tuple(first[i]), float(found.total[i]), tuple(total[i])),
        )
        for i, item in enumerate(ranges)
    )


def study_spread(call: Call, samples: int, ranges: tuple[str, ...], fixed: tuple[str, ...]) -> Spread:
    """The study as the command line asks for it."""
    return find_spread(call.plan, study_ranges(call.plan, ranges, fixed), samples)


def find_spread(plan: CornerCase, ranges: tuple[Range, ...], at_least: int) -> Spread:
    """Run the study. Raises InputError where the theory refuses (nearly) all combinations."""
    importlib.import_module("scipy.stats")  # takes longer than the study
    began = time.perf_counter()
    samples = draw(plan.scene, ranges, at_least)
    refusal = _first_refusal(plan, samples)
    complete = samples.complete
    if np.count_nonzero(complete) < MIN_ROWS:
        raise InputError(
            "--range", Verbatim("these ranges"), f"the theory refuses nearly all of them, like {refusal}"
        )
    distribution = describe(samples.known)
    if not distribution.standard_deviation > MIN_SPREAD * distribution.mean:
        raise InputError("--range", Verbatim("these ranges"), "the peak force is the same all over them")
    with announced("Resampling for the confidence intervals ..."):
        forces = (samples.force_a[complete], samples.force_b[complete], samples.force_ab[:, complete])
        indices = sobol_indices(*forces, seed=SEED)
    return Spread(plan, samples, distribution, indices, refusal, time.perf_counter() - began)


def describe(forces: Array) -> Distribution:
    """Mean, standard deviation, percentiles and histogram of peak forces [N], shape (n,)."""
    counts, edges = np.histogram(forces, BINS)
    percentiles = tuple(np.percentile(forces, PERCENTILES).tolist())
    return Distribution(float(forces.mean()), float(forces.std(ddof=1)), percentiles, edges, counts)


def _first_refusal(plan: CornerCase, samples: Samples) -> str:
    """Why the first combination that is refused is."""
    forces = (samples.force_a, samples.force_b, *samples.force_ab)
    for table, force in zip(tables(samples.a, samples.b), forces, strict=True):
        for row in np.flatnonzero(np.isnan(force))[:1]:
            values = zip(samples.ranges, table[:, row].tolist(), strict=True)
            try:
                plan.varied({item.key: value for item, value in values})
            except InputError as error:
                return str(error)
    return ""
