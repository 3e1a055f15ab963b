"""Verify filters, peaks, durations and occupant risk by known pulses."""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any, get_args

import numpy as np
import pytest
from scipy.signal import butter, filtfilt

from postprocess.signals import filters
from postprocess.signals import occupant as risk
from postprocess.signals.design_forces import EN_LEVELS, LRFD, design_forces
from postprocess.signals.filters import CLASSES, cfc_filter, force_curves, force_peaks, low_pass, moving_mean
from postprocess.signals.strike_duration import second_strike
from tailslap.scene.types import TestLevel

FILTERS: dict[str, Callable[..., Any]] = {
    **{f"CFC {c}": partial(cfc_filter, frequency_class=c) for c in CLASSES},
    "13 Hz": lambda x, t: low_pass(x, t, 13.0),
    "60 Hz": filters.FILTERS["cutoff_60hz"],
    "50 ms": lambda x, t: moving_mean(x, t, 0.05),
}


def gain(apply, frequency, rate):
    """Amplitude of a filtered sine over that of the original."""
    periods = 200
    t = np.arange(int(periods * rate / frequency)) / rate
    wave = np.sin(2.0 * math.pi * frequency * t)
    middle = slice(int(t.size * 0.3), int(t.size * 0.3) + int(50 * rate / frequency))
    return float(apply(wave, 1.0 / rate)[middle] @ wave[middle] / (wave[middle] @ wave[middle]))


@pytest.mark.parametrize("frequency_class", CLASSES)
@pytest.mark.parametrize("samples", [84, 167, 1000])
def test_a_class_is_3_db_down_at_its_cutoff(frequency_class, samples):
    """The gain is that of the class at any rate."""
    amplitude = gain(FILTERS[f"CFC {frequency_class}"], frequency_class / 0.6, samples * frequency_class)
    assert amplitude == pytest.approx(math.sqrt(0.5), abs=1e-3)


@pytest.mark.parametrize(("name", "cutoff"), [("60 Hz", 60.0), ("13 Hz", 13.0)])
@pytest.mark.parametrize("rate", [480.0, 1000.0, 20000.0])
def test_a_true_cutoff_is_3_db_down_at_any_rate(name, cutoff, rate):
    assert gain(FILTERS[name], cutoff, rate) == pytest.approx(math.sqrt(0.5), abs=2e-6)


@pytest.mark.parametrize("frequency_class", CLASSES)
@pytest.mark.parametrize("rate", [1e4, 1e5])
def test_coefficients_are_a_butterworth_filter_of_scipy(frequency_class, rate):
    rest = np.zeros(10_000)
    noise = np.concatenate([rest, np.random.default_rng(7).normal(size=1000), rest])
    expected = filtfilt(*butter(2, frequency_class * 2.0775, fs=rate), noise, padlen=0)
    np.testing.assert_allclose(cfc_filter(noise, 1.0 / rate, frequency_class), expected, atol=1e-12)


@pytest.mark.parametrize("name", FILTERS)
@pytest.mark.parametrize("size", [800, 801])
def test_a_constant_passes_unchanged_to_both_ends(name, size):
    filtered = FILTERS[name](np.full(size, -3.7), 1e-4)
    np.testing.assert_allclose(filtered, -3.7, rtol=1e-9)


@pytest.mark.parametrize("name", [name for name in FILTERS if name != "50 ms"])
def test_an_end_is_that_of_a_signal_that_holds_its_value(name):
    """Beyond the end a history continues with its last value."""
    rising = np.sin(np.linspace(0.0, 1.2, 1000))
    longer = np.concatenate([rising, np.full(4000, rising[-1])])
    np.testing.assert_allclose(FILTERS[name](rising, 1e-4), FILTERS[name](longer, 1e-4)[:1000], atol=3e-7)


def test_no_mean_reaches_beyond_the_end():
    """Near the end the mean is the last one within the history."""
    force = np.linspace(0.0, 1.0, 1000)
    means = moving_mean(force, 1e-4, 0.05)
    assert means[-250:] == pytest.approx(force[-500:].mean())
    assert means[500] == pytest.approx(force[250:751].mean(), rel=1e-3)


@pytest.mark.parametrize("name", ["cfc60", "cfc180", "cutoff_60hz"])
def test_a_force_that_is_cut_is_filtered_as_far_as_later_values_do_not_count(name):
    """The curve equals that of the complete pulse, then a constant."""
    t = 1e-4 * np.arange(3000.0)
    pulse = np.maximum(0.0, np.sin(20.0 * np.pi * (t - 0.1)))
    complete = force_curves(pulse, 1e-4)[name]
    for rows in (1200, 1300, 1450):
        filtered = force_curves(pulse[:rows], 1e-4)[name]
        settled = rows - filters.settling_samples(filters.LOW_PASSES[name].cutoff, 1e-4)
        assert filtered[:settled] == pytest.approx(complete[:settled], abs=2e-3)
        assert np.ptp(filtered[settled:]) == 0.0


def test_several_histories_are_filtered_as_each_alone():
    forces = np.random.default_rng(3).uniform(0.0, 1e5, (3, 777))
    forces[0, -40:] = 0.0  # the other two are cut
    together = force_curves(forces, 1e-4)
    for number, force in enumerate(forces):
        for name, curve in force_curves(force, 1e-4).items():
            np.testing.assert_allclose(together[name][number], curve, rtol=1e-11, err_msg=name)


@pytest.mark.parametrize("name", FILTERS)
def test_nothing_is_delayed_or_lost(name):
    """A pulse keeps its impulse and its middle."""
    t = 2e-5 * (np.arange(30001) + 0.5)
    pulse = np.where(np.abs(t - 0.3) < 0.04, np.cos(np.pi * (t - 0.3) / 0.08), 0.0)
    filtered = FILTERS[name](pulse, 2e-5)
    assert filtered.sum() == pytest.approx(pulse.sum(), rel=1e-7)
    assert filtered @ t / filtered.sum() == pytest.approx(pulse @ t / pulse.sum(), rel=1e-7)


@pytest.mark.parametrize("width", [0.05, 0.049, 0.0333, 0.0500001])
@pytest.mark.parametrize("length", [0.05, 0.08, 0.1143])
def test_peak_of_the_mean_of_a_half_sine(width, length):
    """(2 T/(pi w)) sin(pi w/(2 T)) of samples that are interval means."""
    width, interval = min(width, length), 1e-5
    edges = np.arange(-8001, 8001) * interval + 0.5 * interval
    phase = math.pi * (np.clip(edges, -0.5 * length, 0.5 * length) / length + 0.5)
    integral = -length / math.pi * np.cos(phase)
    peak_mean = moving_mean(np.diff(integral) / interval, interval, width).max()
    exact = 2.0 * length / (math.pi * width) * math.sin(0.5 * math.pi * width / length)
    assert peak_mean == pytest.approx(exact, rel=1e-6)


def test_a_mean_over_odd_samples_is_their_mean():
    values = np.random.default_rng(3).normal(size=40)
    means = moving_mean(values, 0.01, 0.05)
    np.testing.assert_allclose(means[2:-2], np.convolve(values, np.full(5, 0.2), "valid"), atol=1e-14)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda x: cfc_filter(x, 1e-4, 100), "frequency class 100: must be one of 60, 180, 600, 1000"),
        (lambda x: cfc_filter(x, 1e-3, 180), "interval 0.001 s: must be positive, at most 0.0005556 s"),
        (lambda x: FILTERS["60 Hz"](x, 0.003), "at most 0.002778 s for a cut-off at 60 Hz"),
        (lambda x: moving_mean(x, -1e-4, 0.05), "interval -0.0001 s: must be positive"),
        (lambda x: moving_mean(x[:400], 1e-4, 0.05), "history of 0.04 s: must last at least 0.05 s"),
        (lambda x: cfc_filter(x[:50], 1e-4, 60), "history of 0.005 s: must last at least 0.01 s"),
        (lambda x: moving_mean(x[0], 1e-4, 0.05), r"shape \(\): must be finite numbers in one or two"),
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
        filtered = cfc_filter(np.ones(1000), 0.1 / frequency_class, frequency_class)
        assert filtered == pytest.approx(np.ones(1000), rel=1e-9)


INTERVAL = 1e-4


def means(edges, integral):
    return np.diff(integral) / np.diff(edges)


def triangle(t, middle, length, peak):
    return peak * np.clip(1.0 - np.abs(t - middle) / (0.5 * length), 0.0, None)


T = (np.arange(6000) + 0.5) * INTERVAL


def half_sine(start, length, peak):
    """Means over the intervals of T."""
    edges = np.arange(6001) * INTERVAL
    phase = math.pi * np.clip((edges - start) / length, 0.0, 1.0)
    return means(edges, -peak * length / math.pi * np.cos(phase))


def test_peaks_of_a_half_sine_by_name():
    """Strike 1 of a truck of 2 MN/m, in order of smoothing."""
    length, peak = 0.0812, 553.4e3
    peaks = force_peaks(force_curves(half_sine(0.0, length, peak), INTERVAL))
    assert list(peaks) == ["raw", "mean_10ms", "mean_50ms", "cfc60", "cfc180", "cutoff_60hz"]
    assert peaks["raw"] == pytest.approx(peak, rel=1e-5)
    for name, width in (("mean_10ms", 0.01), ("mean_50ms", 0.05)):
        exact = peak * 2.0 * length / (math.pi * width) * math.sin(0.5 * width * math.pi / length)
        assert peaks[name] == pytest.approx(exact, rel=1e-5)
    assert peaks["raw"] > peaks["cfc180"] > peaks["cfc60"] > peaks["cutoff_60hz"] > peaks["mean_50ms"]


def test_before_first_touch_there_is_no_force():
    """A jump at the start has curves as after a rest."""
    force = 1e5 * np.exp(-T / 0.02)
    rest = np.concatenate([np.zeros(3000), force])
    for name, curve in force_curves(force, INTERVAL).items():
        expected = force_curves(rest, INTERVAL)[name][3000:]
        np.testing.assert_allclose(curve, expected, atol=1e-4, err_msg=name)


@pytest.mark.parametrize("length", [0.05, 0.1, 0.1434])
def test_a_triangular_pulse_gives_back_its_duration(length):
    """Valleys and 2 J/F agree, between two other pulses."""
    force = triangle(T, 0.05, 0.08, 500e3) + triangle(T, 0.25005, length, 654e3)
    force += triangle(T, 0.45, 0.04, 300e3)
    strike = second_strike(force, INTERVAL)
    assert strike.duration == pytest.approx(length, abs=2.0 * INTERVAL)
    assert strike.triangle == pytest.approx(length, rel=1e-5)
    assert strike.peak == pytest.approx(654e3, rel=1e-9)
    assert strike.impulse == pytest.approx(0.5 * 654e3 * length, rel=1e-5)


def test_valleys_of_strikes_that_run_into_each_other():
    """The lowest points are at 0.2 and 0.34 s, above zero force."""
    kilonewtons = np.array([0, 400, 60, 500, 100, 450, 0])
    force = np.interp(T, [0.0, 0.1, 0.2, 0.26, 0.34, 0.4, 0.6], 1e3 * kilonewtons)
    strike = second_strike(force, INTERVAL)
    assert (strike.start, strike.end) == pytest.approx((0.2, 0.34), abs=INTERVAL)
    assert strike.impulse == pytest.approx(1e3 * (280 * 0.06 + 300 * 0.08), rel=1e-4)


def test_ripple_is_no_strike():
    """Ripple below a quarter of the largest force is ignored."""
    force = half_sine(0.02, 0.1, 400e3) + half_sine(0.3, 0.1, 450e3)
    ripple = force * (1.0 + 0.08 * np.sin(2.0 * math.pi * 130.0 * T))
    small = ripple + half_sine(0.18, 0.04, 80e3)
    strike = second_strike(small, INTERVAL)
    assert (strike.start, strike.end) == pytest.approx((0.3, 0.4), abs=2.0 * INTERVAL)


def test_rounding_is_no_valley():
    force = half_sine(0.02, 0.1, 400e3) + half_sine(0.3, 0.1, 450e3)
    noisy = force + 1e-9 * np.random.default_rng(5).normal(size=force.size)
    assert second_strike(noisy, INTERVAL).duration == pytest.approx(0.1, abs=10.0 * INTERVAL)


def test_a_strike_that_the_history_cuts_off_ends_with_it():
    force = (half_sine(0.02, 0.1, 400e3) + half_sine(0.3, 0.1, 450e3))[:3700]
    assert second_strike(force, INTERVAL).end == pytest.approx(0.37, abs=INTERVAL)


def test_a_50_ms_mean_widens_a_strike_by_50_ms():
    """The duration of such a curve includes the width of the mean."""
    curves = force_curves(half_sine(0.0, 0.0812, 550e3) + half_sine(0.2944, 0.0664, 630e3), INTERVAL)
    for name, duration, rows in (("raw", 0.0664, 4), ("mean_50ms", 0.1164, 6)):
        widened = second_strike(curves[name], INTERVAL).duration
        assert widened == pytest.approx(duration, abs=rows * INTERVAL)


@pytest.mark.parametrize(("name", "more"), [("cfc180", 0.004), ("cfc60", 0.01), ("cutoff_60hz", 0.015)])
def test_undershoot_of_a_filter_elsewhere_is_no_valley(name, more):
    """The undershoot after strike 1 is not the begin of strike 2."""
    force = half_sine(0.02, 0.03, 600e3) + half_sine(0.2, 0.08, 500e3) + half_sine(0.4, 0.03, 600e3)
    strike = second_strike(force_curves(force, INTERVAL)[name], INTERVAL)
    assert 0.08 - 2.0 * INTERVAL < strike.duration < 0.08 + more
    assert 0.5 * (strike.start + strike.end) == pytest.approx(0.24, abs=2.0 * INTERVAL)


@pytest.mark.parametrize(("force", "peaks"), [(np.zeros(6000), 0), (half_sine(0.1, 0.1, 1e5), 1)])
def test_without_a_second_peak(force, peaks):
    message = f"a curve with {peaks} peaks has no second strike: must have at least 2"
    with pytest.raises(ValueError, match=message):
        second_strike(force, INTERVAL)


TIMES = np.linspace(0.0, 0.6, 6001)
ZERO = np.zeros_like(TIMES)


def measures(motion):
    return {measure.name: measure for measure in risk.occupant_risk(motion)}


@pytest.mark.parametrize("edition", ["ASI 1998, 50 ms mean", "ASI 2010, 13 Hz"])
def test_vertical_acceleration_counts_in_the_severity_index(edition):
    """Three components at their limits, over two."""
    a = 9.80665 * (ZERO + 1.0)
    motion = risk.VehicleMotion(TIMES, 12.0 * a, 9.0 * a, ZERO, ZERO, 10.0 * a)
    measure = measures(motion)[edition]
    assert measure.value / measures(replace(motion, az=None))[edition].value == pytest.approx(math.sqrt(1.5))
    assert measure.lacks == risk.IN_SPACE
    assert measures(replace(motion, ay=ZERO))["THIV"] == measures(replace(motion, ay=ZERO, az=None))["THIV"]


def straight(ax, ay):
    return risk.VehicleMotion(TIMES, ax + ZERO, ay + ZERO, ZERO, ZERO)


@pytest.mark.parametrize(
    ("ax", "ay", "distance"), [(-50.0, 0.0, 0.6), (0.0, 40.0, 0.3), (0.0, -40.0, 0.3), (-20.0, 30.0, 0.3)]
)
def test_constant_deceleration(ax, ay, distance):
    """The first axis in contact determines the instant.

    v = sqrt(2 a d) and t = sqrt(2 d/a).
    """
    risk_values, first = measures(straight(ax, ay)), abs(ay or ax)
    time = math.sqrt(2.0 * distance / first)
    assert risk_values["OIV longitudinal"].time == pytest.approx(time, rel=1e-12)
    assert risk_values["OIV longitudinal"].value == pytest.approx(abs(ax) * time, rel=1e-12)
    assert risk_values["OIV lateral"].value == pytest.approx(abs(ay) * time, rel=1e-12)
    assert max(abs(ax), abs(ay)) * time == pytest.approx(math.sqrt(2.0 * first * distance))
    assert risk_values["THIV"].value == pytest.approx(math.hypot(ax, ay) * time, rel=1e-12)
    assert risk_values["ORA longitudinal"].value == pytest.approx(abs(ax) / risk.GRAVITY, rel=1e-9)
    assert risk_values["ORA lateral"].value == pytest.approx(abs(ay) / risk.GRAVITY, rel=1e-9)
    assert risk_values["PHD"].value == pytest.approx(math.hypot(ax, ay) / risk.GRAVITY, rel=1e-9)


@pytest.mark.parametrize("name", ["ASI 1998, 50 ms mean", "ASI 2010, 13 Hz"])
def test_severity_of_constant_accelerations(name):
    severity = measures(straight(-6.0 * risk.GRAVITY, 4.5 * risk.GRAVITY))[name]
    assert severity.value == pytest.approx(math.sqrt(0.5), rel=0.1 if "2010" in name else 1e-9)
    assert "lower bound" in severity.lacks


def test_severity_of_a_half_sine():
    """50 ms means have a closed form, waves a known gain."""
    length = 0.12
    pulse = 5.0 * risk.GRAVITY * np.sin(math.pi * np.clip(TIMES / length, 0.0, 1.0))
    severity = measures(straight(0.0, pulse))["ASI 1998, 50 ms mean"]
    exact = 5.0 / 9.0 * 2.0 * length / (math.pi * 0.05) * math.sin(0.025 * math.pi / length)
    assert (severity.value, severity.time) == (pytest.approx(exact, rel=1e-5), pytest.approx(0.06, abs=2e-4))
    wave = 5.0 * risk.GRAVITY * np.sin(math.pi * TIMES / 0.6) ** 2 * np.sin(2.0 * math.pi * 13.0 * TIMES)
    severity = measures(straight(0.0, wave))["ASI 2010, 13 Hz"]
    assert severity.value == pytest.approx(5.0 / 9.0 * math.sqrt(0.5), rel=0.02)


def test_growing_deceleration_of_few_instants():
    """A linear deceleration is exact between 13 instants.

    a = j t, so x = j t^3/6 and v = j t^2/2.
    """
    t = np.linspace(0.0, 0.6, 13)
    motion = risk.VehicleMotion(t, -200.0 * t, 0.0 * t, 0.0 * t, 0.0 * t)
    time = (6.0 * 0.6 / 200.0) ** (1.0 / 3.0)
    ahead = risk.head_contact(motion, ahead=2.0)
    for contact in (risk.occupant_contact(motion), risk.head_contact(motion), ahead):
        assert contact is not None
        assert contact.time == pytest.approx(time, rel=1e-12)
        assert contact.forward == pytest.approx(100.0 * time**2, rel=1e-12)


def test_half_sine_of_deceleration():
    """The motion has a closed form during the pulse.

    x = (a L/pi) (t - (L/pi) sin(pi t/L)) and v = (a L/pi) (1 - cos(pi t/L)).
    """
    length, size = 0.2, 120.0
    pulse = -size * np.sin(math.pi * np.clip(TIMES / length, 0.0, 1.0))
    contact = risk.occupant_contact(straight(pulse, 0.0))
    assert contact is not None
    phase, scale = math.pi * contact.time / length, size * length / math.pi
    assert scale * (contact.time - length / math.pi * math.sin(phase)) == pytest.approx(0.6, rel=1e-6)
    assert contact.forward == pytest.approx(scale * (1.0 - math.cos(phase)), rel=1e-6)


def test_ridedown_begins_after_contact():
    """A pulse after the contact counts, by its mean over 10 ms."""
    early = 60.0 * ((TIMES > 0.01) & (TIMES < 0.05))
    late = 100.0 * ((TIMES > 0.4) & (TIMES < 0.405))
    risk_values = measures(straight(-early - late, 0.0))
    assert risk_values["OIV longitudinal"].value == pytest.approx(2.4, rel=1e-2)
    assert risk_values["ORA longitudinal"].time == pytest.approx(0.4025, abs=0.006)
    assert risk_values["ORA longitudinal"].value == pytest.approx(50.0 / risk.GRAVITY, rel=0.03)


def test_head_goes_straight_on_while_the_vehicle_turns():
    """On a circle the head leaves on an involute."""
    speed, rate = 20.0, 1.5
    motion = risk.VehicleMotion(TIMES, ZERO, ZERO + speed * rate, ZERO + rate, rate * TIMES)
    contact = risk.head_contact(motion)

    def inside(t):
        turned = rate * t
        away = speed / rate * np.array([turned - math.sin(turned), math.cos(turned) - 1.0])
        cos, sin = math.cos(turned), math.sin(turned)
        return np.array([cos * away[0] + sin * away[1], cos * away[1] - sin * away[0]])

    assert contact is not None
    assert inside(contact.time)[1] == pytest.approx(-0.3, abs=1e-8)
    speeds = (inside(contact.time + 1e-5) - inside(contact.time - 1e-5)) / 2e-5
    assert (contact.forward, contact.sideways) == pytest.approx(tuple(speeds), abs=1e-5)


def test_a_head_ahead_of_the_centre_is_met_by_the_turning_side():
    """The side approaches a head 2 m ahead by rotation."""
    spin = 8.0
    motion = risk.VehicleMotion(TIMES, ZERO, ZERO, spin * TIMES, 0.5 * spin * TIMES**2)
    contact = risk.head_contact(motion, ahead=2.0)
    turned = math.asin(0.15)
    assert contact is not None
    assert 0.5 * spin * contact.time**2 == pytest.approx(turned, rel=1e-7)
    assert contact.sideways == pytest.approx(-2.0 * spin * contact.time * math.cos(turned), rel=1e-6)
    assert risk.head_contact(motion) is None


def test_a_flight_that_does_not_end_has_no_value():
    risk_values = measures(straight(-1.0, 0.5))
    empty = {name for name, measure in risk_values.items() if measure.value is None and measure.time is None}
    assert empty == {"THIV", "PHD", "OIV longitudinal", "OIV lateral", "ORA longitudinal", "ORA lateral"}


def test_every_measure_says_what_it_lacks():
    assert all(m.lacks and m.limits == "limits not given" for m in measures(straight(-50.0, 0.0)).values())


def test_motions_that_are_refused():
    with pytest.raises(ValueError, match=r"arrays of shapes \[\(2,\), \(6001,\)\]: must be one shape"):
        risk.VehicleMotion(TIMES, ZERO, ZERO, ZERO, ZERO[:2])
    with pytest.raises(ValueError, match="must rise evenly"):
        risk.VehicleMotion(TIMES**2, ZERO, ZERO, ZERO, ZERO)
    with pytest.raises(ValueError, match=r"at most 0\.0005556 s"):
        risk.occupant_risk(risk.VehicleMotion(10.0 * TIMES, ZERO, ZERO, ZERO, ZERO))
    short = slice(0, 600)
    with pytest.raises(ValueError, match=r"history of 0\.0601 s: must last at least 0\.07692 s"):
        risk.occupant_risk(risk.VehicleMotion(*(values[short] for values in (TIMES, ZERO, ZERO, ZERO, ZERO))))


def test_design_forces_of_the_test_levels():
    """The table in kip and in kN, MASH first."""
    rows = [design_forces(level)[-1] for level in LRFD]
    assert [round(row.force / 1e3) for row in rows] == [60, 120, 240, 240, 552, 778]


def test_design_forces_of_mash():
    tti, acceleration, aashto = design_forces("TL-4")
    assert (aashto.longitudinal, aashto.vertical) == pytest.approx(
        (80.07e3, 80.07e3), rel=1e-3
    )  # 18 kip each
    assert (aashto.height, aashto.length) == pytest.approx((0.8128, 1.0668))  # 32 in, 3.5 ft
    assert round(tti.force / 1e3) == 356
    assert (round(acceleration.kip), acceleration.force) == (99, pytest.approx(440e3, rel=5e-3))
    assert all(row.source for level in LRFD for row in design_forces(level))


def test_design_forces_of_the_walls_that_tractors_strike():
    """Forces of both levels [kN], unverified ones marked."""
    forces = {level: [round(row.force / 1e3) for row in design_forces(level)] for level in ("TL-5", "TL-6")}
    assert forces == {"TL-5": [712, 845, 1165, 552], "TL-6": [1334, 778]}
    assert [row.kip for row in design_forces("TL-5") if "not verified" in row.source] == [160.0, 262.0]


@pytest.mark.parametrize(("top", "height"), [(None, 1.0), (0.9, 0.8), (1.5, 1.0)])
def test_classes_of_en_1991_2(top, height):
    """The load acts below the top of a low wall."""
    loads = design_forces("H2", top)
    assert [(load.force, load.height, load.length, load.moment) for load in loads] == [
        pytest.approx((force, height, 0.5, force * height)) for force in (100e3, 200e3, 400e3, 600e3)
    ]
    assert all("not verified" in load.name and "not confirmed" in load.source for load in loads)
    assert {*get_args(TestLevel)} == {*LRFD, *EN_LEVELS}


def test_another_test_level_is_refused():
    with pytest.raises(ValueError, match="test level 'TL-7': must be one of TL-1, TL-2"):
        design_forces("TL-7")
