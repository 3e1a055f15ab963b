"""Verification: peaks of known pulses, and the second strike's duration from valley to valley."""

from __future__ import annotations

import math

import numpy as np
import pytest

from postprocess.signals.filters import force_curves, force_peaks, second_strike

pytestmark = pytest.mark.verification

INTERVAL = 1e-4


def means(edges: np.ndarray, integral: np.ndarray) -> np.ndarray:
    return np.diff(integral) / np.diff(edges)


def triangle(t: np.ndarray, middle: float, length: float, peak: float) -> np.ndarray:
    return peak * np.clip(1.0 - np.abs(t - middle) / (0.5 * length), 0.0, None)


T = (np.arange(6000) + 0.5) * INTERVAL


def half_sine(start: float, length: float, peak: float) -> np.ndarray:
    """Means over the intervals of T."""
    edges = np.arange(6001) * INTERVAL
    phase = math.pi * np.clip((edges - start) / length, 0.0, 1.0)
    return means(edges, -peak * length / math.pi * np.cos(phase))


def test_peaks_of_a_half_sine_by_name() -> None:
    """Strike 1 of a truck of k = 2 MN/m; the filters in the order of how much they smooth."""
    length, peak = 0.0812, 553.4e3
    found = force_peaks(force_curves(half_sine(0.0, length, peak), INTERVAL))
    assert list(found) == ["raw", "mean_50ms", "cfc60", "cfc180", "cutoff_60hz"]
    assert found["raw"] == pytest.approx(peak, rel=1e-5)
    exact = peak * 2.0 * length / (math.pi * 0.05) * math.sin(0.025 * math.pi / length)
    assert found["mean_50ms"] == pytest.approx(exact, rel=1e-5)
    assert found["raw"] > found["cfc180"] > found["cfc60"] > found["cutoff_60hz"] > found["mean_50ms"]


def test_before_first_touch_there_is_no_force() -> None:
    """A history that starts with a jump gives the same curves as with the rest before it."""
    force = 1e5 * np.exp(-T / 0.02)
    rest = np.concatenate([np.zeros(3000), force])
    for name, curve in force_curves(force, INTERVAL).items():
        expected = force_curves(rest, INTERVAL)[name][3000:]
        np.testing.assert_allclose(curve, expected, atol=1e-4, err_msg=name)


@pytest.mark.parametrize("length", [0.05, 0.1, 0.1434])
def test_a_triangular_pulse_gives_back_its_duration(length: float) -> None:
    """Alone between two others and a rest of zero, by valleys and by 2 J / F."""
    force = (
        triangle(T, 0.05, 0.08, 500e3) + triangle(T, 0.25005, length, 654e3) + triangle(T, 0.45, 0.04, 300e3)
    )
    found = second_strike(force, INTERVAL)
    assert found.duration == pytest.approx(length, abs=2.0 * INTERVAL)
    assert found.triangle == pytest.approx(length, rel=1e-5)
    assert found.peak == pytest.approx(654e3, rel=1e-9)
    assert found.impulse == pytest.approx(0.5 * 654e3 * length, rel=1e-5)


def test_valleys_of_strikes_that_run_into_each_other() -> None:
    """Lowest points lie at 0.2 and 0.34 s, the first at 60 kN; no strike ends at zero force."""
    force = np.interp(
        T, [0.0, 0.1, 0.2, 0.26, 0.34, 0.4, 0.6], 1e3 * np.array([0, 400, 60, 500, 100, 450, 0])
    )
    found = second_strike(force, INTERVAL)
    assert (found.start, found.end) == pytest.approx((0.2, 0.34), abs=INTERVAL)
    assert found.impulse == pytest.approx(1e3 * (280 * 0.06 + 300 * 0.08), rel=1e-4)


def test_ripple_is_no_strike() -> None:
    """Neither before the second peak nor upon it: less than a quarter of the largest force."""
    force = half_sine(0.02, 0.1, 400e3) + half_sine(0.3, 0.1, 450e3)
    ripple = force * (1.0 + 0.08 * np.sin(2.0 * math.pi * 130.0 * T))
    small = ripple + half_sine(0.18, 0.04, 80e3)
    found = second_strike(small, INTERVAL)
    assert (found.start, found.end) == pytest.approx((0.3, 0.4), abs=2.0 * INTERVAL)


def test_rounding_is_no_valley() -> None:
    force = half_sine(0.02, 0.1, 400e3) + half_sine(0.3, 0.1, 450e3)
    noisy = force + 1e-9 * np.random.default_rng(5).normal(size=force.size)
    assert second_strike(noisy, INTERVAL).duration == pytest.approx(0.1, abs=10.0 * INTERVAL)


def test_a_strike_that_the_history_cuts_off_ends_with_it() -> None:
    force = (half_sine(0.02, 0.1, 400e3) + half_sine(0.3, 0.1, 450e3))[:3700]
    assert second_strike(force, INTERVAL).end == pytest.approx(0.37, abs=INTERVAL)


def test_a_50_ms_mean_widens_a_strike_by_50_ms() -> None:
    """What a duration read off such a curve holds beside the strike's own."""
    curves = force_curves(half_sine(0.0, 0.0812, 550e3) + half_sine(0.2944, 0.0664, 630e3), INTERVAL)
    assert second_strike(curves["raw"], INTERVAL).duration == pytest.approx(0.0664, abs=4 * INTERVAL)
    assert second_strike(curves["mean_50ms"], INTERVAL).duration == pytest.approx(0.1164, abs=6 * INTERVAL)


@pytest.mark.parametrize(("name", "more"), [("cfc180", 0.004), ("cfc60", 0.01), ("cutoff_60hz", 0.015)])
def test_undershoot_of_a_filter_elsewhere_is_no_valley(name: str, more: float) -> None:
    """A filter adds its own rise; the dip after strike 1, though lower, is not where strike 2 begins."""
    force = half_sine(0.02, 0.03, 600e3) + half_sine(0.2, 0.08, 500e3) + half_sine(0.4, 0.03, 600e3)
    found = second_strike(force_curves(force, INTERVAL)[name], INTERVAL)
    assert 0.08 - 2.0 * INTERVAL < found.duration < 0.08 + more
    assert 0.5 * (found.start + found.end) == pytest.approx(0.24, abs=2.0 * INTERVAL)


@pytest.mark.parametrize(("force", "peaks"), [(np.zeros(6000), 0), (half_sine(0.1, 0.1, 1e5), 1)])
def test_without_a_second_peak(force: np.ndarray, peaks: int) -> None:
    with pytest.raises(
        ValueError, match=f"a curve with {peaks} peaks has no second strike: must have at least 2"
    ):
        second_strike(force, INTERVAL)
