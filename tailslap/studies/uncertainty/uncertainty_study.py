"""Distribution of forces for uncertain inputs."""

import importlib
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tailslap import progress
from tailslap.campaign import sampling
from tailslap.campaign.input_ranges import Range
from tailslap.campaign.planar_ranges import corner_ranges, demand_crush, impact_ranges
from tailslap.campaign.records import Record
from tailslap.campaign.sampling import Array, Band
from tailslap.case.case import Case
from tailslap.case.impact import strike_columns
from tailslap.errors import InputError, Verbatim

CORNER_SAMPLES, IMPACT_SAMPLES = 100_000, 4_000
"""Default numbers of samples."""


CORNER_BLOCK, IMPACT_BLOCK = 2048, 512
"""Samples at a time, so that intermediate values fit the processor's cache and histories are small."""


@dataclass(frozen=True)
class Spread:
    """Result of the study.

    Attributes
    ----------
    inputs : dict of ndarray, shape ((inputs + 2) rows,)
        Samples by key, see `sampling.sampled`.
    tables : dict of ndarray, shape (inputs + 2, rows)
        Results by name, NaN without a solution or strike.
    sources : dict
        Rows of `sampling.index_rows` by name, empty where refused; names without variance are missing.
    refused_sources : dict
        Reasons of refused indices by name.
    nominal : dict
        Results of the scene's own values by name [SI].
    refusal : str
        Reason of the first sample without a solution, or "".
    """

    case: Any
    ranges: tuple[Range, ...]
    inputs: Mapping[str, Array]
    tables: Mapping[str, Array]
    sources: Mapping[str, list[Record]]
    refused_sources: Mapping[str, str]
    nominal: Mapping[str, float]
    seconds: float
    refusal: str = ""

    @property
    def rows(self) -> int:
        """Return the number of rows of each table."""
        return next(iter(self.tables.values())).shape[1]

    @property
    def computed(self) -> int:
        """Return the number of all samples."""
        return next(iter(self.tables.values())).size

    @property
    def refused(self) -> tuple[int, int]:
        """Return the numbers of samples without a solution and of their rows."""
        refused = np.isnan(self.tables["peak_force"])
        return int(np.count_nonzero(refused)), int(np.count_nonzero(refused.any(axis=0)))

    @property
    def samples(self) -> dict[str, Array]:
        """Return samples and results, shape (2 rows,)."""
        results = {name: table[:2].ravel() for name, table in self.tables.items()}
        return {key: values[: 2 * self.rows] for key, values in self.inputs.items()} | results

    def band(self, name: str) -> Band:
        """Return the distribution of a quantity."""
        return sampling.band_of(self.tables[name])

    def sources_of(self, name: str) -> list[Record]:
        """Return the sources of variance, largest first.

        There are none without variance, or where refused.
        """
        return sorted(self.sources.get(name, ()), key=lambda row: -row["total"])


def compute(
    case: Any, place: Path, samples: int | None, ranges: tuple[str, ...], fixed: tuple[str, ...]
) -> Spread:
    """Compute the distribution of a scene.

    No journal is stored.
    """
    if case.scene.contact is None:
        return spread(case, corner_ranges(case, ranges, fixed), samples or CORNER_SAMPLES)
    demand_crush(case)
    return spread(case, impact_ranges(case, ranges, fixed), samples or IMPACT_SAMPLES)


def spread(case: Case, ranges: tuple[Range, ...], at_least: int) -> Spread:
    """Compute the distribution of a least number of samples.

    Raises InputError where too few samples have a solution or a second strike, or where the force is constant.
    """
    impact = case.scene.contact is not None
    importlib.import_module("scipy.stats")  # takes longer than the study
    began = time.perf_counter()
    with progress.progress_bar(f"{case.scene.name}: impacts" if impact else "combinations") as show:
        inputs, tables = sampling.sampled(ranges, at_least, lambda values: solved(case, values, show))
    main = tables["strike_2.impulse" if impact else "peak_force"]
    refusal = "" if impact else _first_refusal(case, inputs, main.ravel())
    if np.count_nonzero(np.isfinite(main).all(axis=0)) < sampling.MIN_ROWS:
        few = "too few of these impacts have a second strike"
        why = few if impact else f"too few samples have a solution; first reason: {refusal}"
        raise InputError("--range", Verbatim("these ranges"), why)
    sources, reasons = sampling.rows_and_refusals(ranges, tables)
    if not sources:
        raise InputError(
            "--range", Verbatim("these ranges"), "the peak force is constant within these ranges"
        )
    seconds = time.perf_counter() - began
    return Spread(case, ranges, inputs, tables, sources, reasons, nominal_columns(case), seconds, refusal)


def nominal_columns(case: Any) -> dict[str, float]:
    """Return the results of the scene's values [SI]."""
    if case.scene.contact is None:
        return {"peak_force": float(case.force.peak_force)}
    return strike_columns.both_strikes(case.in_plane)


def solved(
    case: Any, inputs: Mapping[str, Array], show: Callable[[float], None] = lambda fraction: None
) -> dict[str, Array]:
    """Return peak force or both strikes of each sample.

    case: corner or whole impact with all other inputs, whose yaw inertia is in proportion to the mass; inputs: by key
    of the scene, shape (n,) [SI]; show: takes the fraction of finished samples. Returns "peak_force" [N] or the columns
    of `COLUMNS` [SI], shape (n,), NaN without a solution or strike. Raises InputError where the theory has no solution
    for an impact.
    """
    block = CORNER_BLOCK if case.scene.contact is None else IMPACT_BLOCK
    return sampling.solved_in_blocks(case.many, inputs, block, show)


def _first_refusal(case: Case, inputs: Mapping[str, Array], forces: Array) -> str:
    """Return the reason of the first sample without a solution."""
    for number in np.flatnonzero(np.isnan(forces))[:1]:
        try:
            case.varied({key: float(values[number]) for key, values in inputs.items()})
        except InputError as error:
            return str(error)
    return ""
