"""Compute the force band of a scene.

It is that of few rigid vehicles with varied inputs.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from tailslap.campaign import planar_ranges, sampling
from tailslap.campaign.input_ranges import Range
from tailslap.campaign.sampling import Array
from tailslap.case.case import Case
from tailslap.case.force_band import ForceBand
from tailslap.case.resources import available_cores
from tailslap.errors import InputError

SAMPLES, SAMPLES_OF_SLOW = 256, 72
"""Number of vehicles, and of trains and vehicles in space."""

TOO_FEW = "too few of the varied inputs have a solution"

Columns = Mapping[str, Array]


def force_band(case: Case) -> ForceBand:
    """Return the force band over the default ranges.

    The force is that of the headline: the peak of a constrained corner, otherwise the largest 50 ms mean. An input with
    a value outside its range is not varied, as the vehicle would not belong to the band. A band that cannot be computed
    contains the reason.
    """
    try:
        count = SAMPLES_OF_SLOW if case.scene.trailer or case.scene.body else SAMPLES
        every, solve = _problem(case, math.ceil(count / available_cores()))
        ranges = tuple(item for item in every if _contains_own(item))
        if not ranges:
            return ForceBand(refusal="all inputs of the scene are outside their ranges")
        drawn = sampling.latin_hypercube(len(ranges), count, np.random.default_rng(sampling.SEED))
        inputs = {
            item.key: item.lower + (item.upper - item.lower) * column
            for item, column in zip(ranges, drawn, strict=True)
        }
        rows, reason = _possible(case, inputs, count)
        if len(rows) < sampling.MIN_ROWS:
            return ForceBand(refusal=f"{TOO_FEW}; {reason}")
        inputs = {key: values[rows] for key, values in inputs.items()}
        columns = solve(inputs)
    except InputError as error:
        return ForceBand(refusal=str(error))
    fixed = tuple(item.key for item in every if item not in ranges)
    band = _band(ranges, inputs, columns)
    return replace(band, fixed=fixed, unsolved=count - band.samples, reason=reason)


def _contains_own(item: Range) -> bool:
    """Return whether a range contains the scene's value."""
    margin = 1e-9 * (item.upper - item.lower)
    return item.scene_value is None or item.lower - margin <= item.scene_value <= item.upper + margin


def _possible(case: Case, inputs: Columns, count: int) -> tuple[list[int], str]:
    """Return rows of vehicles that stand, and why another does not."""
    if case.scene.body is None:
        return [*range(count)], ""
    from tailslap.campaign import space_samples

    return space_samples.possible_samples(case.scene, inputs)


def _problem(case: Any, block: int) -> tuple[tuple[Range, ...], Any]:
    """Return ranges, and the function from inputs to forces.

    block: number of vehicles at a time. Raises InputError.
    """
    if case.scene.contact is None:
        return planar_ranges.corner_ranges(case), case.many  # closed forms, faster than a thread starts
    if case.scene.body is not None:
        from tailslap.campaign import space_samples

        ranges = space_samples.space_ranges(case, (), ())
        solve = partial(space_samples.sample_answers, case.scene, names=("mean_50ms", "outcome"))
    else:
        planar_ranges.demand_crush(case)
        ranges, solve = planar_ranges.impact_ranges(case), case.largest_means
    return ranges, partial(sampling.solved_in_blocks, solve, block=block)


def _band(ranges: tuple[Range, ...], inputs: Columns, columns: Columns) -> ForceBand:
    """Return the band of samples, without those that have no solution."""
    force = next(iter(columns.values()))
    solved = np.isfinite(force)
    if np.count_nonzero(solved) < sampling.MIN_ROWS:
        return ForceBand(refusal=TOO_FEW)
    fractions: dict[str, float] = {}
    if "outcome" in columns:
        from solver.space import OUTCOMES

        outcome = columns["outcome"][solved]
        fractions = {name: float(np.mean(outcome == k)) for k, name in enumerate(OUTCOMES)}
    return ForceBand(
        sampling.band_of(force).percentiles,
        int(np.count_nonzero(solved)),
        variance_fractions({key: values[solved] for key, values in inputs.items()}, force[solved]),
        {item.key: (item.lower, item.upper, item.origin) for item in ranges},
        fractions,
        forces=tuple(force[solved].tolist()),
    )


def variance_fractions(inputs: Columns, output: Array) -> dict[str, float]:
    """Return each input's fraction of the variance.

    The largest is first. The output is approximated by a linear function of independent inputs (Saltelli et al., Global
    Sensitivity Analysis, 2008, section 1.2.5, squared standardised regression coefficients).
    """
    values = np.array(list(inputs.values()))
    scaled = (values - values.mean(axis=1, keepdims=True)) / values.std(axis=1, keepdims=True)
    slopes = np.linalg.lstsq(scaled.T, output - output.mean(), rcond=None)[0]
    fractions = slopes**2 / max(float(np.var(output)), np.finfo(float).tiny)
    order = np.argsort(-fractions)
    keys = list(inputs)
    return {keys[number]: float(fractions[number]) for number in order}
