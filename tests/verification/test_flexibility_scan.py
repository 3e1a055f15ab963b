"""Verify levels of oscillating differences by exact differences."""

import math
from functools import partial
from itertools import pairwise

import numpy as np
import pytest

from tailslap.campaign import levels
from tailslap.campaign.levels import Sample
from tailslap.studies.flexibility import flexibility_scan as scan

# Plates as the study has them, instant of the strike [s], and levels.
PLATES = np.geomspace(1000.0, 2.0, 16)
INSTANT, SIZES = 0.36, (1e-2, 5e-2, 1e-1)

# Frequencies where the differences are above the smallest level somewhere, and how closely peaks are resolved.
EVERY, CLOSE = np.arange(2.0, 120.0, 2e-3), 1e-3

OSCILLATIONS = {
    "about zero": lambda f, phase: 30.0 * np.sin(2.0 * np.pi * INSTANT * f + phase) / f**2,
    "about a mean": lambda f, phase: (20.0 + 15.0 * np.sin(2.0 * np.pi * INSTANT * f + phase)) / f**2,
    "first power": lambda f, phase: np.sin(2.0 * np.pi * INSTANT * f + phase) / f,
    "beats": lambda f, phase: (
        30.0 * np.sin(2.0 * np.pi * INSTANT * f + phase) * np.cos(0.8 * np.pi * INSTANT * f) / f**2
    ),
    "steady": lambda f, phase: 30.0 / f**2,
}


def plates(difference, error=0.0):
    return [Sample(f, abs(float(difference(f))), error, True) for f in PLATES]


def runs(difference, frequencies):
    return {f: {"impulse": float(difference(f))} for f in frequencies}


def scan_of(samples, difference):
    return scan.scanned({"impulse": samples}, SIZES, 1.0 / INSTANT, partial(runs, difference))


@pytest.mark.parametrize("phase", np.linspace(0.0, 2.0 * np.pi, 7)[:-1])
@pytest.mark.parametrize("name", OSCILLATIONS)
def test_no_difference_is_above_a_level_beyond_its_frequency(name, phase):
    difference = partial(OSCILLATIONS[name], phase=phase)
    result = scan_of(plates(difference), difference)
    sizes = np.abs(difference(EVERY))
    for reach in levels.reaches(result.samples["impulse"], SIZES):
        assert reach.kind == levels.CROSSED
        last, almost = (EVERY[sizes > part * reach.level].max() for part in (1.0 + CLOSE, 1.0 - 5.0 * CLOSE))
        # On the safe side, and by no more than two steps: that of the scan and the one that is added.
        assert last <= reach.frequency <= almost + 2.0 * min(result.step, 0.05 * almost)


def test_only_crossings_below_the_steps_are_closely_scanned():
    """At low frequencies a level is within two intervals."""
    samples = [Sample(f, 0.03 / f**2, 0.0, True) for f in np.geomspace(1000.0, 0.2, 16)]
    result = scan_of(samples, lambda f: 0.03 / f**2)
    for reach in levels.reaches(result.samples["impulse"], SIZES):
        exact = math.sqrt(0.03 / reach.level)
        assert exact <= reach.frequency <= scan.RATIO**2 * exact
    ratios = [stiff / soft for stiff, soft in pairwise(result.differences)]
    assert max(ratios) == pytest.approx(scan.COARSE)
    assert sum(ratio < scan.RATIO for ratio in ratios if ratio < 1.1) < 40


def test_plates_alone_lie_between_the_peaks():
    """A power law between plates is crossed at too low a frequency."""
    parts = []
    for phase in np.linspace(0.0, 2.0 * np.pi, 7)[:-1]:
        difference = partial(OSCILLATIONS["about zero"], phase=phase)
        sizes, alone = np.abs(difference(EVERY)), levels.reaches(plates(difference), SIZES)
        parts += [reach.frequency / EVERY[sizes > reach.level].max() for reach in alone]
    assert min(parts) < 0.85


def test_the_scan_goes_up_to_where_the_level_is_kept_for_two_periods():
    """Plates at zeros of the difference underestimate it."""
    difference = partial(OSCILLATIONS["about zero"], phase=0.0)
    calls = []

    def measure(frequencies):
        calls.append(max(frequencies))
        return runs(difference, frequencies)

    small = [sample._replace(difference=0.05 * sample.difference) for sample in plates(difference)]
    result = scan.scanned({"impulse": small}, SIZES, 1.0 / INSTANT, measure)
    highest = scan.highest_above(result.samples["impulse"], SIZES[0])
    assert highest > levels.lowest_frequency(small, SIZES[0]).frequency + scan.PERIODS / INSTANT
    assert calls == sorted(calls)
    assert calls[0] < highest < calls[-1] - scan.PERIODS / INSTANT + result.step
    assert calls[-1] < highest + (scan.PERIODS + 1) / INSTANT


def test_the_error_of_the_worse_neighbour_is_added():
    difference = partial(OSCILLATIONS["steady"], phase=0.0)
    samples = [sample._replace(error=0.1 * sample.difference) for sample in plates(difference)]
    result = scan_of(samples, difference)
    above = next(s for s in samples[::-1] if s.frequency > math.sqrt(30.0 / SIZES[1]))
    below = samples[samples.index(above) + 1]
    assert scan.larger_error(samples, above.frequency) == above.error
    assert scan.larger_error(samples, 0.5 * (above.frequency + below.frequency)) == below.error
    reach = levels.lowest_frequency(result.samples["impulse"], SIZES[1])
    expected = math.sqrt(30.0 / (SIZES[1] - below.error))
    assert expected <= reach.frequency <= expected + 2.0 * result.step


def test_a_failed_run_beside_a_crossing_leaves_the_level_unknown():
    difference = partial(OSCILLATIONS["steady"], phase=0.0)
    crossing = math.sqrt(30.0 / SIZES[1])

    def measure(low, high, frequencies):
        return {f: {"impulse": math.nan if low < f < high else float(difference(f))} for f in frequencies}

    for interval, kind in (((-0.4, 0.8), levels.UNKNOWN), ((5.0, 6.0), levels.CROSSED)):
        gap = [crossing + distance for distance in interval]
        result = scan.scanned({"impulse": plates(difference)}, SIZES, 1.0 / INSTANT, partial(measure, *gap))
        assert levels.lowest_frequency(result.samples["impulse"], SIZES[1]).kind == kind


def test_a_level_that_no_plate_tells_is_not_scanned():
    def unmeasured(frequencies):
        raise AssertionError(frequencies)

    samples = [Sample(f, 1.0, 0.0, True) for f in PLATES]
    result = scan.scanned({"impulse": samples}, SIZES, 1.0 / INSTANT, unmeasured)
    assert (result.samples["impulse"], result.differences) == (samples, {})


@pytest.mark.parametrize("phase", np.linspace(0.0, 0.25 * np.pi, 5))
def test_peaks_between_samples(phase):
    """Cosines of any phase, and the middle of a parabola."""
    places = np.arange(-8.0, 9.0)
    cosine = np.cos(2.0 * np.pi * places / scan.STEPS_A_PERIOD + phase)
    peaks = [scan.peak_sizes(places, values).max() for values in (-cosine, cosine)]
    assert peaks[0] == peaks[1] == pytest.approx(1.0, abs=CLOSE)
    assert scan.peak_sizes(np.arange(3.0), np.array([-1.0, -3.0, -1.0])).tolist() == [1.0, 3.0, 1.0]
    uneven = np.array([2.0, 1.0, -1.0])
    correction = scan.peak_sizes(uneven, 5.0 - (uneven - 0.5) ** 2)[1] - 4.75
    assert correction == pytest.approx(9.0 / 8.0 * 0.25, rel=1e-12)


def test_steps_are_even_or_at_a_ratio():
    frequencies = np.array(scan.scan_frequencies(100.0, 2.0, 0.5))
    assert (frequencies[0], frequencies[-1]) == (100.0, 2.0)
    steps = -np.diff(frequencies)
    assert steps[frequencies[:-1] > 12.0] == pytest.approx(0.5)
    assert (steps / frequencies[1:]).max() <= scan.COARSE - 1.0 + 1e-12
