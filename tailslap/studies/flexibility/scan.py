"""Scan of first frequencies where levels are crossed, at steps finer than the differences oscillate."""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from tailslap.campaign.levels import CROSSED, NOT_REACHED, Sample, lowest_frequency

# Steps in a period of the difference over the first frequency, and the largest ratio of frequencies a step apart.
STEPS_A_PERIOD, RATIO = 8, 1.05

# Periods above the highest crossing of the smallest level that are scanned too.
PERIODS = 2

Series = Mapping[str, Sequence[Sample]]
Measure = Callable[[Sequence[float]], Mapping[float, Mapping[str, float]]]
"""Differences with their signs by series, NaN where a run failed, at each of these first frequencies [Hz]."""


class Scan(NamedTuple):
    """Samples of each series with those of the scan, its differences by frequency, and its step [Hz]."""

    samples: Series
    differences: Mapping[float, Mapping[str, float]]
    step: float


def scanned(series: Series, levels: Sequence[float], period: float, measure: Measure) -> Scan:
    """Scan where these samples cross the levels.

    Parameters
    ----------
    series : dict of list of Sample
        Plates from stiff to soft by the name of what is measured.
    levels : sequence of float
        Sizes of differences.
    period : float
        Shortest period at which the differences oscillate over the first frequency [Hz].
    measure : callable
        Runs plates of further first frequencies, see `Measure`.
    """
    step = period / STEPS_A_PERIOD
    known = {name: known_levels(samples, levels) for name, samples in series.items()}
    ends = [crossings(series[name], sizes) for name, sizes in known.items() if sizes]
    if not ends:
        return Scan(series, {}, step)
    top, bottom = max(high for high, _ in ends) + PERIODS * period, min(low for _, low in ends)
    grid = scan_frequencies(max(samples[0].frequency for samples in series.values()), bottom, step)
    while True:
        frequencies = [frequency for frequency in grid if frequency - step < top]
        differences = measure(frequencies)
        samples = {
            name: merged(own, {f: differences[f][name] for f in frequencies}) for name, own in series.items()
        }
        above = [highest_above(samples[name], min(sizes)) for name, sizes in known.items() if sizes]
        top = max(*above, bottom) + PERIODS * period
        if frequencies[0] >= min(top, grid[0]):
            return Scan(samples, differences, step)


def known_levels(samples: Sequence[Sample], levels: Sequence[float]) -> list[float]:
    """Levels that the samples cross, or lie below."""
    return [level for level in levels if lowest_frequency(samples, level).kind in (CROSSED, NOT_REACHED)]


def crossings(samples: Sequence[Sample], levels: Sequence[float]) -> tuple[float, float]:
    """Frequency [Hz] where the smallest level seems to be crossed, and that of a sample beyond the largest."""
    passed = [sample for sample in samples if sample.passed]
    beyond = [sample.frequency for sample in passed if not sample.bound <= max(levels)]
    low = beyond[0] if beyond else passed[-1].frequency
    return lowest_frequency(samples, min(levels)).frequency, low


def highest_above(samples: Sequence[Sample], level: float) -> float:
    """Highest frequency [Hz] at which the difference with its error exceeds the level; 0 without."""
    return max((s.frequency for s in samples if s.passed and not s.bound <= level), default=0.0)


def scan_frequencies(highest: float, lowest: float, step: float) -> list[float]:
    """First frequencies [Hz] from the highest to the lowest, at the step or at `RATIO` if that is less."""
    found = [highest]
    while found[-1] > lowest:
        found.append(max(lowest, found[-1] - step, found[-1] / RATIO))
    return found


def merged(samples: Sequence[Sample], differences: Mapping[float, float]) -> list[Sample]:
    """The samples, and in their stead those of the scan where there are any, from stiff to soft.

    A sample of the scan bounds the difference down to the next one, so that levels are a step higher than the scan
    shows. Its numerical error is the larger of both neighbours with one.
    """
    grid, sizes = [*differences], peak_sizes(np.array([*differences.values()]))
    errors = [larger_error(samples, frequency) for frequency in grid]
    scan = [
        Sample(f, np.nanmax(sizes[i : i + 2]), max(errors[i : i + 2]), True)
        if np.isfinite(sizes[i])
        else Sample(f, np.nan, errors[i], False)
        for i, f in enumerate(grid)
    ]
    stiffer = [sample for sample in samples if sample.frequency > grid[0]]
    return [*stiffer, *scan, *(sample for sample in samples if sample.frequency < grid[-1])]


def peak_sizes(values: np.ndarray) -> np.ndarray:
    """Sizes of evenly spaced values; of the largest of three the peak between them.

    The vertex of a parabola, but of fourth order where the peak is midway between two values.
    """
    sizes = np.abs(values)
    before, here, after = (np.sign(values[1:-1]) * part for part in (values[:-2], values[1:-1], values[2:]))
    curvature = 2.0 * here - before - after
    with np.errstate(all="ignore"):
        peak = here + 9.0 / 64.0 * (after - before) ** 2 / curvature
    is_peak = (here >= before) & (here >= after) & (curvature > 0.0)
    sizes[1:-1] = np.where(is_peak, peak, sizes[1:-1])
    return sizes


def larger_error(samples: Sequence[Sample], frequency: float) -> float:
    """The larger error of the samples that passed next to a frequency [Hz]."""
    passed = [sample for sample in samples if sample.passed]
    stiffer = [sample.error for sample in passed if sample.frequency >= frequency][-1:]
    softer = [sample.error for sample in passed if sample.frequency <= frequency][:1]
    return float(np.max([*stiffer, *softer]))
