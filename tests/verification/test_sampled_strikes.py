"""Verify strikes of sampled forces by the rule of the rigid impact."""

import math

import numpy as np
import pytest
from test_impact_rigid import impact

from solver.impact import strikes_of


def half_sine(t, start, duration, peak):
    """Means of a half sine over the intervals between the instants."""
    phase = np.clip((t - start) / duration, 0.0, 1.0)
    impulse = peak * duration / math.pi * (1.0 - np.cos(math.pi * phase))
    return np.diff(impulse) / np.diff(t)


@pytest.mark.parametrize("shift", [0.0, 0.3, 0.77])
def test_a_half_sine(shift):
    """The impulse is exact, the instants are far below a sample."""
    dt = 1e-3
    t = np.arange(0.0, 0.3, dt)
    start, duration = 0.05 + shift * dt, 0.08
    (strike,) = strikes_of(t, {"rear": half_sine(t, start, duration, 5e5)})
    assert strike.corner == "rear"
    assert strike.impulse == pytest.approx(2.0 / math.pi * 5e5 * duration, rel=1e-12)
    assert strike.start == pytest.approx(start, abs=1e-6)
    assert strike.duration == pytest.approx(duration, abs=2e-6)
    assert strike.peak_force == pytest.approx(5e5, rel=1e-6)
    assert math.isnan(strike.point_of_attack)
    assert math.isnan(strike.impulse_tangential)


@pytest.mark.parametrize("dropped", [0.1, 0.5, 0.9])
def test_a_force_that_drops_has_its_peak_before(dropped):
    """Without restitution it drops at any part of a sample."""
    t = np.linspace(0.0, 0.1, 101)
    for last in (50, 58, 59):
        force = np.where(np.arange(100) <= last, half_sine(t, 0.02, 0.08, 1e5), 0.0)
        force[last + 1] = dropped * force[last]
        (strike,) = strikes_of(t, {"front": force})
        assert force.max() <= strike.peak_force < 1e5 * math.sin(math.pi * (last - 19) / 80) * (1.0 + 1e-6)


def test_a_jump_is_found_within_a_sample():
    t = np.linspace(0.0, 0.1, 101)
    force = np.where((t[:-1] > 0.0205) & (t[:-1] < 0.0595), 3e5, 0.0)
    (strike,) = strikes_of(t, {"front": force})
    assert (strike.start, strike.end) == pytest.approx((0.021, 0.060), abs=1e-9)
    assert strike.peak_force == pytest.approx(3e5)


@pytest.mark.parametrize(("interval", "first", "second", "strikes"), [
    (2e-4, (100, 200), (295, 320), 1), (2e-4, (100, 200), (305, 320), 2),  # 19 and 21 ms after one of 20 ms
    (1e-4, (10, 12), (20, 22), 1), (1e-4, (10, 12), (21, 24), 1),  # 0.8 and 0.9 ms after one of 0.2 ms
    (1e-4, (10, 12), (23, 25), 2),  # 1.1 ms
])  # fmt: skip
def test_a_strike_is_over_when_the_corner_has_been_off_as_long_or_a_millisecond(
    interval, first, second, strikes
):
    force = np.zeros(400)
    force[slice(*first)] = force[slice(*second)] = 1e5
    sampled = strikes_of(interval * np.arange(401.0), {"front": force})
    assert len(sampled) == strikes
    impulse = math.fsum(strike.impulse for strike in sampled)
    assert impulse == pytest.approx(1e5 * interval * np.count_nonzero(force))


def test_touches_that_bring_half_a_per_cent_prolong_a_strike():
    """Lighter touches count in the impulse alone, or together."""
    force = np.zeros(400)
    force[100:200], force[220] = 1e5, 4.5e4
    (light,) = strikes_of(1e-4 * np.arange(401.0), {"rear": force})
    assert (light.end, light.cut) == (pytest.approx(0.02), False)
    assert light.impulse == pytest.approx(1e-4 * force.sum())
    force[240] = 4.5e4
    (two,) = strikes_of(1e-4 * np.arange(401.0), {"rear": force})
    assert two.end == pytest.approx(0.0241)
    force[220], force[240] = 6e4, 0.0
    (heavy,) = strikes_of(1e-4 * np.arange(401.0), {"rear": force})
    assert heavy.end == pytest.approx(0.0221)


def test_other_limits_of_a_strike_and_touches_by_rounding():
    """A pause is 19 ms after 20 ms."""
    force = np.zeros(400)
    force[100:200] = force[295:320] = 1e5
    force[350] = 1e-35
    t = 2e-4 * np.arange(401.0)
    assert [len(strikes_of(t, {"front": force}, apart=factor)) for factor in (0.9, 1.0)] == [2, 1]
    force[295:320] = 0.0
    assert len(strikes_of(t, {"front": force})) == 1


def test_a_strike_that_is_not_over_at_the_end_is_cut():
    force = np.zeros(400)
    force[100:200] = 1e5
    for rows, cut in ((150, True), (200, True), (298, True), (302, False)):
        (strike,) = strikes_of(1e-4 * np.arange(rows + 1.0), {"rear": force[:rows]})
        assert strike.cut == cut


def test_uneven_samples_and_means_beside_the_force():
    t = np.sort(np.random.default_rng(1).uniform(0.0, 0.2, 400))
    force = half_sine(t, 0.02, 0.1, 2e5)
    station = np.linspace(0.0, 10.0, force.size)
    beside = {"front": -0.4 * force}, {"front": station}, {"front": t[1:]}
    (strike,) = strikes_of(t, {"front": force, "rear": 0.0 * force}, *beside)
    push = force * np.diff(t)
    assert strike.impulse_tangential == pytest.approx(-0.4 * strike.impulse)
    assert strike.point_of_attack == pytest.approx(station @ push / push.sum())
    assert strike.position == pytest.approx(t[1:] @ push / push.sum())


def test_one_sample_alone():
    (strike,) = strikes_of(np.array([0.0, 1.0, 2.0, 3.0]), {"rear": np.array([0.0, 7.0, 0.0])})
    assert (strike.start, strike.end, strike.impulse, strike.peak_force) == (1.0, 2.0, 7.0, 7.0)


def test_the_rigid_impact_sampled():
    """Means over 0.5 ms have the strikes of the motion in steps."""
    motion = impact()
    t = np.linspace(0.0, motion.t_end, round(motion.t_end / 5e-4) + 1)
    mean = np.diff(motion.at(t).impulse_normal) / np.diff(t)
    rear = (t[1:] > motion.strikes[1].start) & (t[:-1] < motion.strikes[1].end)  # the corners strike in turn
    sampled = strikes_of(t, {"front": np.where(rear, 0.0, mean), "rear": np.where(rear, mean, 0.0)})
    assert [strike.corner for strike in sampled] == [strike.corner for strike in motion.strikes]
    for one, exact in zip(sampled[:2], motion.strikes[:2], strict=True):
        assert one.impulse == pytest.approx(exact.impulse, rel=1e-5)
        assert one.start == pytest.approx(exact.start, abs=1e-5)
        assert one.duration == pytest.approx(exact.duration, abs=2e-5)
        assert one.peak_force == pytest.approx(exact.peak_force, rel=2e-3)  # the peak is a kink
