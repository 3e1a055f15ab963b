"""Scan of first frequencies where levels are crossed."""

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise, product
from typing import NamedTuple

import numpy as np

from tailslap.campaign.levels import CROSSED, NOT_REACHED, Sample, lowest_frequency

STEPS_A_PERIOD, RATIO, COARSE = 8, 1.05, 1.25
"""Steps per period of the difference over the first frequency, and largest ratios of adjacent frequencies.

The first ratio holds beside a crossing, the coarse one elsewhere.
"""

ROUNDING = 1e-9
"""Excess of a ratio of frequencies that is rounding."""

PERIODS = 2
"""Scanned periods above the highest crossing of the smallest level."""

Series = Mapping[str, Sequence[Sample]]
Measure = Callable[[Sequence[float]], Mapping[float, Mapping[str, float]]]
"""Function from first frequencies [Hz] to signed differences by series, NaN where a run failed."""


class Scan(NamedTuple):
    """Samples, scanned differences by frequency, and step [Hz]."""

    samples: Series
    differences: Mapping[float, Mapping[str, float]]
    step: float


def scanned(series: Series, levels: Sequence[float], period: float, measure: Measure) -> Scan:
    """Scan where the samples cross the levels.

    series: plates from stiff to soft by quantity; levels: of the difference; period: shortest period of the oscillation
    over the first frequency [Hz]; measure: runs plates of further first frequencies, see `Measure`.
    """
    step = period / STEPS_A_PERIOD
    sought = {
        name: [level for level in levels if lowest_frequency(samples, level).kind in (CROSSED, NOT_REACHED)]
        for name, samples in series.items()
    }
    ends = [crossings(series[name], sizes) for name, sizes in sought.items() if sizes]
    if not ends:
        return Scan(series, {}, step)
    top, bottom = max(high for high, _ in ends) + PERIODS * period, min(low for _, low in ends)
    grid = scan_frequencies(max(samples[0].frequency for samples in series.values()), bottom, step)
    scan = Scan(series, {}, step)
    while True:
        frequencies = {frequency for frequency in grid if frequency - step < top}
        if frequencies <= scan.differences.keys():
            frequencies = beside_crossings(scan, levels)
        if not frequencies:
            return scan
        new = sorted(frequencies - scan.differences.keys(), reverse=True)
        differences = dict(sorted({**scan.differences, **measure(new)}.items(), reverse=True))
        samples = {
            name: merged(plates, {f: values[name] for f, values in differences.items()})
            for name, plates in series.items()
        }
        scan = Scan(samples, differences, step)
        above = [highest_above(samples[name], min(sizes)) for name, sizes in sought.items() if sizes]
        top = max(*above, bottom) + PERIODS * period


def beside_crossings(scan: Scan, levels: Sequence[float]) -> set[float]:
    """Return further frequencies beside the crossings of the levels [Hz].

    They divide the intervals from the last sample that passed before the first one above a level, to the one behind it.
    """
    further = set[float]()
    for samples, level in product(scan.samples.values(), levels):
        first = next((k for k, sample in enumerate(samples) if sample.passed and sample.bound > level), None)
        if first is None:
            continue
        last = max((k for k in range(first) if samples[k].passed), default=first)
        for stiff, soft in pairwise(sample.frequency for sample in samples[last : first + 2]):
            if {stiff, soft} <= scan.differences.keys():
                parts = math.ceil(math.log(stiff / soft) / math.log(RATIO) - ROUNDING)
                further |= {stiff * (soft / stiff) ** (part / parts) for part in range(1, parts)}
    return further


def crossings(samples: Sequence[Sample], levels: Sequence[float]) -> tuple[float, float]:
    """Return the approximate ends of the crossings [Hz].

    The first is the crossing of the smallest level, the second a sample above the largest.
    """
    passed = [sample for sample in samples if sample.passed]
    beyond = [sample.frequency for sample in passed if not sample.bound <= max(levels)]
    low = beyond[0] if beyond else passed[-1].frequency
    return lowest_frequency(samples, min(levels)).frequency, low


def highest_above(samples: Sequence[Sample], level: float) -> float:
    """Return the highest frequency above the level [Hz].

    The error is added to the difference. It is 0 if the level is not exceeded.
    """
    return max((s.frequency for s in samples if s.passed and not s.bound <= level), default=0.0)


def scan_frequencies(highest: float, lowest: float, step: float) -> list[float]:
    """Return falling first frequencies [Hz].

    They decrease by the step or by `COARSE`, the smaller change.
    """
    frequencies = [highest]
    while frequencies[-1] > lowest:
        frequencies.append(max(lowest, frequencies[-1] - step, frequencies[-1] / COARSE))
    return frequencies


def merged(samples: Sequence[Sample], differences: Mapping[float, float]) -> list[Sample]:
    """Replace samples by those of the scan.

    Samples are ordered from stiff to soft. A sample of the scan bounds the difference down to the next one, so that
    levels are one step above those of the scan. Its numerical error is the larger one of both neighbours.
    """
    grid, sizes = [*differences], peak_sizes(np.array([*differences]), np.array([*differences.values()]))
    errors = [larger_error(samples, frequency) for frequency in grid]
    scan = [
        Sample(f, np.nanmax(sizes[i : i + 2]), max(errors[i : i + 2]), True)
        if np.isfinite(sizes[i])
        else Sample(f, np.nan, errors[i], False)
        for i, f in enumerate(grid)
    ]
    stiffer = [sample for sample in samples if sample.frequency > grid[0]]
    return [*stiffer, *scan, *(sample for sample in samples if sample.frequency < grid[-1])]


def peak_sizes(frequencies: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the sizes of values, with interpolated peaks.

    The largest of three values becomes the vertex of a parabola. With the factor 9/8 it is of fourth order where the
    values are evenly spaced and the peak is midway between two.
    """
    sizes, spaces = np.abs(values), np.diff(frequencies)
    before, here, after = (np.sign(values[1:-1]) * part for part in (values[:-2], values[1:-1], values[2:]))
    to_here, from_here = (here - before) / spaces[:-1], (after - here) / spaces[1:]
    curvature = (to_here - from_here) / (spaces[:-1] + spaces[1:])
    slope = (to_here * spaces[1:] + from_here * spaces[:-1]) / (spaces[:-1] + spaces[1:])
    with np.errstate(all="ignore"):
        peak = here + 9.0 / 32.0 * slope**2 / curvature
    is_peak = (here >= before) & (here >= after) & (curvature > 0.0)
    sizes[1:-1] = np.where(is_peak, peak, sizes[1:-1])
    return sizes


def larger_error(samples: Sequence[Sample], frequency: float) -> float:
    """Return the larger error of the adjacent samples that passed."""
    passed = [sample for sample in samples if sample.passed]
    stiffer = [sample.error for sample in passed if sample.frequency >= frequency][-1:]
    softer = [sample.error for sample in passed if sample.frequency <= frequency][:1]
    return float(np.max([*stiffer, *softer]))
