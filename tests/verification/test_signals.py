"""Verification: filters against their transfer functions, peaks of known pulses, second strikes between valleys."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from postprocess.signals.filters import (
    CLASSES,
    cfc_filter,
    cutoff_60hz,
    force_curves,
    force_peaks,
    low_pass,
    moving_mean,
    second_strike,
)

Filter = Callable[[np.ndarray, float], np.ndarray]
FILTERS: dict[str, Filter] = {
    **{f"CFC {c}": lambda x, t, c=c: cfc_filter(x, t, c) for c in CLASSES},
    "13 Hz": lambda x, t: low_pass(x, t, 13.0),
    "60 Hz": cutoff_60hz,
    "50 ms": lambda x, t: moving_mean(x, t, 0.05),
}


def gain(apply: Filter, frequency: float, rate: float) -> float:
    """Amplitude of a long sine that comes out, in phase with what went in, over that which went in."""
    periods = 200
    t = np.arange(int(periods * rate / frequency)) / rate
    wave = np.sin(2.0 * math.pi * frequency * t)
    middle = slice(int(t.size * 0.3), int(t.size * 0.3) + int(50 * rate / frequency))
    return float(apply(wave, 1.0 / rate)[middle] @ wave[middle] / (wave[middle] @ wave[middle]))


@pytest.mark.parametrize("frequency_class", CLASSES)
@pytest.mark.parametrize("samples", [84, 167, 1000])
def test_a_class_is_3_db_down_at_its_cutoff(frequency_class, samples):
    """Sampled at 84 to 1000 times the class; for CFC 60 at 5, 10 and 60 kHz."""
    found = gain(FILTERS[f"CFC {frequency_class}"], frequency_class / 0.6, samples * frequency_class)
    assert found == pytest.approx(math.sqrt(0.5), abs=1e-3)


@pytest.mark.parametrize("frequency", [10.0, 40.0, 100.0, 150.0, 250.0])
@pytest.mark.parametrize("rate", [1000.0, 5000.0, 100000.0])
def test_gain_of_cfc_60_at_any_frequency(frequency, rate):
    corner = math.tan(math.pi * 60.0 * 2.0775 / rate)
    exact = 1.0 / (1.0 + (math.tan(math.pi * frequency / rate) / corner) ** 4)
    assert gain(FILTERS["CFC 60"], frequency, rate) == pytest.approx(exact, abs=2e-6)


@pytest.mark.parametrize(("name", "cutoff"), [("60 Hz", 60.0), ("13 Hz", 13.0)])
@pytest.mark.parametrize("rate", [480.0, 1000.0, 20000.0])
def test_a_true_cutoff_is_3_db_down_at_any_rate(name, cutoff, rate):
    assert gain(FILTERS[name], cutoff, rate) == pytest.approx(math.sqrt(0.5), abs=2e-6)


def test_coefficients_are_a_butterworth_filter_of_scipy():
    from scipy.signal import butter, filtfilt

    noise = np.concatenate([np.zeros(500), np.random.default_rng(7).normal(size=1000), np.zeros(500)])
    expected = filtfilt(*butter(2, 180 * 2.0775, fs=1e4), noise, padlen=0)
    np.testing.assert_allclose(cfc_filter(noise, 1e-4, 180), expected, atol=1e-12)


@pytest.mark.parametrize("name", FILTERS)
@pytest.mark.parametrize("size", [800, 801])
def test_a_constant_passes_unchanged_to_both_ends(name, size):
    found = FILTERS[name](np.full(size, -3.7), 1e-4)
    np.testing.assert_allclose(found, -3.7, rtol=1e-9)


@pytest.mark.parametrize("name", FILTERS)
def test_an_end_is_that_of_a_signal_that_holds_its_value(name):
    """What comes after the end of a history is as good as the end value going on."""
    rising = np.sin(np.linspace(0.0, 1.2, 1000))
    longer = np.concatenate([rising, np.full(4000, rising[-1])])
    np.testing.assert_allclose(FILTERS[name](rising, 1e-4), FILTERS[name](longer, 1e-4)[:1000], atol=3e-7)


@pytest.mark.parametrize("name", FILTERS)
def test_nothing_is_delayed_or_lost(name):
    """A pulse keeps its impulse and its middle."""
    t = 2e-5 * (np.arange(30001) + 0.5)
    pulse = np.where(np.abs(t - 0.3) < 0.04, np.cos(np.pi * (t - 0.3) / 0.08), 0.0)
    found = FILTERS[name](pulse, 2e-5)
    assert found.sum() == pytest.approx(pulse.sum(), rel=1e-7)
    assert found @ t / found.sum() == pytest.approx(pulse @ t / pulse.sum(), rel=1e-7)


@pytest.mark.parametrize("width", [0.05, 0.049, 0.0333, 0.0500001])
@pytest.mark.parametrize("length", [0.05, 0.08, 0.1143])
def test_peak_of_the_mean_of_a_half_sine(width, length):
    """(2 T / pi w) sin(pi w / 2 T), for samples that are means over their interval, whatever the width."""
    if width > length:
        width = length
    interval = 1e-5
    edges = np.arange(-8001, 8001) * interval + 0.5 * interval
    integral = (
        -length / math.pi * np.cos(math.pi * (np.clip(edges, -0.5 * length, 0.5 * length) / length + 0.5))
    )
    found = moving_mean(np.diff(integral) / interval, interval, width).max()
    exact = 2.0 * length / (math.pi * width) * math.sin(0.5 * math.pi * width / length)
    assert found == pytest.approx(exact, rel=1e-6)


def test_a_mean_over_odd_samples_is_their_mean():
    values = np.random.default_rng(3).normal(size=40)
    found = moving_mean(values, 0.01, 0.05)
    np.testing.assert_allclose(found[2:-2], np.convolve(values, np.full(5, 0.2), "valid"), atol=1e-14)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda x: cfc_filter(x, 1e-4, 100), "frequency class 100: must be one of 60, 180, 600, 1000"),
        (lambda x: cfc_filter(x, 1e-3, 180), "interval 0.001 s: must be positive, at most 0.0005556 s"),
        (lambda x: cutoff_60hz(x, 0.003), "at most 0.002778 s for a cut-off at 60 Hz"),
        (lambda x: moving_mean(x, -1e-4, 0.05), "interval -0.0001 s: must be positive"),
        (lambda x: moving_mean(x[:400], 1e-4, 0.05), "history of 0.04 s: must last at least 0.05 s"),
        (lambda x: cfc_filter(x[:50], 1e-4, 60), "history of 0.005 s: must last at least 0.01 s"),
        (lambda x: moving_mean(x[:, None], 1e-4, 0.05), r"shape \(1000, 1\): must be finite numbers in one"),
        (lambda x: cfc_filter(x / 0.0, 1e-4, 60), "must be finite"),
    ],
)
@pytest.mark.filterwarnings("ignore:invalid value")
def test_what_is_refused(call, message):
    with pytest.raises(ValueError, match=message):
        call(np.zeros(1000))


def test_the_lowest_rate_of_a_class_is_accepted():
    """Ten times the class."""
    for frequency_class in CLASSES:
        cfc_filter(np.zeros(1000), 0.1 / frequency_class, frequency_class)


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


def test_peaks_of_a_half_sine_by_name():
    """Strike 1 of a truck of k = 2 MN/m; the filters in the order of how much they smooth."""
    length, peak = 0.0812, 553.4e3
    found = force_peaks(force_curves(half_sine(0.0, length, peak), INTERVAL))
    assert list(found) == ["raw", "mean_50ms", "cfc60", "cfc180", "cutoff_60hz"]
    assert found["raw"] == pytest.approx(peak, rel=1e-5)
    exact = peak * 2.0 * length / (math.pi * 0.05) * math.sin(0.025 * math.pi / length)
    assert found["mean_50ms"] == pytest.approx(exact, rel=1e-5)
    assert found["raw"] > found["cfc180"] > found["cfc60"] > found["cutoff_60hz"] > found["mean_50ms"]


def test_before_first_touch_there_is_no_force():
    """A history that starts with a jump gives the same curves as with the rest before it."""
    force = 1e5 * np.exp(-T / 0.02)
    rest = np.concatenate([np.zeros(3000), force])
    for name, curve in force_curves(force, INTERVAL).items():
        expected = force_curves(rest, INTERVAL)[name][3000:]
        np.testing.assert_allclose(curve, expected, atol=1e-4, err_msg=name)


@pytest.mark.parametrize("length", [0.05, 0.1, 0.1434])
def test_a_triangular_pulse_gives_back_its_duration(length):
    """Alone between two others and a rest of zero, by valleys and by 2 J / F."""
    force = (
        triangle(T, 0.05, 0.08, 500e3) + triangle(T, 0.25005, length, 654e3) + triangle(T, 0.45, 0.04, 300e3)
    )
    found = second_strike(force, INTERVAL)
    assert found.duration == pytest.approx(length, abs=2.0 * INTERVAL)
    assert found.triangle == pytest.approx(length, rel=1e-5)
    assert found.peak == pytest.approx(654e3, rel=1e-9)
    assert found.impulse == pytest.approx(0.5 * 654e3 * length, rel=1e-5)


def test_valleys_of_strikes_that_run_into_each_other():
    """Lowest points lie at 0.2 and 0.34 s, the first at 60 kN; no strike ends at zero force."""
    force = np.interp(
        T, [0.0, 0.1, 0.2, 0.26, 0.34, 0.4, 0.6], 1e3 * np.array([0, 400, 60, 500, 100, 450, 0])
    )
    found = second_strike(force, INTERVAL)
    assert (found.start, found.end) == pytest.approx((0.2, 0.34), abs=INTERVAL)
    assert found.impulse == pytest.approx(1e3 * (280 * 0.06 + 300 * 0.08), rel=1e-4)


def test_ripple_is_no_strike():
    """Neither before the second peak nor upon it: less than a quarter of the largest force."""
    force = half_sine(0.02, 0.1, 400e3) + half_sine(0.3, 0.1, 450e3)
    ripple = force * (1.0 + 0.08 * np.sin(2.0 * math.pi * 130.0 * T))
    small = ripple + half_sine(0.18, 0.04, 80e3)
    found = second_strike(small, INTERVAL)
    assert (found.start, found.end) == pytest.approx((0.3, 0.4), abs=2.0 * INTERVAL)


def test_rounding_is_no_valley():
    force = half_sine(0.02, 0.1, 400e3) + half_sine(0.3, 0.1, 450e3)
    noisy = force + 1e-9 * np.random.default_rng(5).normal(size=force.size)
    assert second_strike(noisy, INTERVAL).duration == pytest.approx(0.1, abs=10.0 * INTERVAL)


def test_a_strike_that_the_history_cuts_off_ends_with_it():
    force = (half_sine(0.02, 0.1, 400e3) + half_sine(0.3, 0.1, 450e3))[:3700]
    assert second_strike(force, INTERVAL).end == pytest.approx(0.37, abs=INTERVAL)


def test_a_50_ms_mean_widens_a_strike_by_50_ms():
    """What a duration read off such a curve holds beside the strike's own."""
    curves = force_curves(half_sine(0.0, 0.0812, 550e3) + half_sine(0.2944, 0.0664, 630e3), INTERVAL)
    assert second_strike(curves["raw"], INTERVAL).duration == pytest.approx(0.0664, abs=4 * INTERVAL)
    assert second_strike(curves["mean_50ms"], INTERVAL).duration == pytest.approx(0.1164, abs=6 * INTERVAL)


@pytest.mark.parametrize(("name", "more"), [("cfc180", 0.004), ("cfc60", 0.01), ("cutoff_60hz", 0.015)])
def test_undershoot_of_a_filter_elsewhere_is_no_valley(name, more):
    """A filter adds its own rise; the dip after strike 1, though lower, is not where strike 2 begins."""
    force = half_sine(0.02, 0.03, 600e3) + half_sine(0.2, 0.08, 500e3) + half_sine(0.4, 0.03, 600e3)
    found = second_strike(force_curves(force, INTERVAL)[name], INTERVAL)
    assert 0.08 - 2.0 * INTERVAL < found.duration < 0.08 + more
    assert 0.5 * (found.start + found.end) == pytest.approx(0.24, abs=2.0 * INTERVAL)


@pytest.mark.parametrize(("force", "peaks"), [(np.zeros(6000), 0), (half_sine(0.1, 0.1, 1e5), 1)])
def test_without_a_second_peak(force, peaks):
    with pytest.raises(
        ValueError, match=f"a curve with {peaks} peaks has no second strike: must have at least 2"
    ):
        second_strike(force, INTERVAL)
