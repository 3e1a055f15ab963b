"""Verification: metrics of histories against closed forms of scaled, shifted, offset and noisy signals."""

import math

import numpy as np
import pytest

from postprocess.comparison.metrics import Metrics, compare_histories

pytestmark = pytest.mark.verification

PERIODS = np.linspace(0.0, 6.0 * np.pi, 3001)
"""Three whole periods of a sine, over which the trapezoidal rule is exact."""


@pytest.mark.parametrize("factor", [0.3, 1.0, 1.0 + 1e-9, 2.5])
def test_a_scaled_signal_differs_in_magnitude_alone(factor: float) -> None:
    signal = np.exp(-0.1 * PERIODS) * np.cos(PERIODS)
    found = compare_histories(PERIODS, factor * signal, signal)
    assert found.magnitude == pytest.approx(factor - 1.0, abs=1e-14)
    assert found.phase == pytest.approx(0.0, abs=1e-14)
    assert found.combined == pytest.approx(abs(factor - 1.0), abs=1e-14)


@pytest.mark.parametrize("shift", [1e-9, 1e-3, 0.5, 2.0, math.pi])
def test_a_sine_with_a_phase_shift(shift: float) -> None:
    found = compare_histories(PERIODS, np.sin(PERIODS - shift), np.sin(PERIODS))
    assert found.phase == pytest.approx(shift / math.pi, rel=1e-6, abs=1e-15)
    assert found.magnitude == pytest.approx(0.0, abs=1e-13)


def test_magnitude_and_phase_combine_as_the_sides_of_a_right_angle() -> None:
    found = compare_histories(PERIODS, 1.3 * np.sin(PERIODS - 0.4 * math.pi), np.sin(PERIODS))
    assert found.combined == pytest.approx(0.5, abs=1e-12)


def test_a_constant_offset_is_all_mean_and_no_deviation() -> None:
    """Over the peak of the reference, whatever its sign; and signed."""
    reference = -4.0 - np.sin(PERIODS)
    found = compare_histories(PERIODS, reference - 0.25, reference)
    assert found.mean_residual == pytest.approx(-0.05, abs=1e-14)
    assert found.deviation == pytest.approx(0.0, abs=1e-14)


def test_a_wave_on_top_is_all_deviation() -> None:
    reference = 2.0 + 0.0 * PERIODS
    found = compare_histories(PERIODS, reference + 0.6 * np.sin(PERIODS), reference)
    assert found.mean_residual == pytest.approx(0.0, abs=1e-14)
    assert found.deviation == pytest.approx(0.3 / math.sqrt(2.0), abs=1e-12)


def test_it_is_time_that_counts_and_not_rows() -> None:
    """Rows crowd where the two differ: the mean over time is that of the trapezoids, -0.07, not that of the rows."""
    instants = np.array([0.0, 0.01, 0.02, 0.03, 0.04, 0.1, 0.9, 1.0])
    residual = np.where(instants < 0.05, -1.0, 0.0)
    found = compare_histories(instants, 10.0 + 10.0 * residual, np.full(8, 10.0))
    assert found.mean_residual == pytest.approx(-(0.04 + 0.5 * 0.06), abs=1e-15)
    later = compare_histories(7.0 + 3.0 * instants, 10.0 + 10.0 * residual, np.full(8, 10.0))
    for name in ("magnitude", "phase", "mean_residual", "deviation"):
        assert getattr(later, name) == pytest.approx(getattr(found, name), abs=1e-13)


def test_the_trapezoidal_rule_converges_in_second_order() -> None:
    """Norms of exp and 1 on [0, 1]: M = sqrt((e^2 - 1) / 2) - 1, cos(pi P) = (e - 1) sqrt(2 / (e^2 - 1))."""
    square = (math.e**2 - 1.0) / 2.0
    exact = (math.sqrt(square) - 1.0, math.acos((math.e - 1.0) / math.sqrt(square)) / math.pi)
    errors = []
    for rows in (20, 40, 80):
        t = np.linspace(0.0, 1.0, rows + 1)
        found = compare_histories(t, np.exp(t), np.ones_like(t))
        errors.append([abs(found.magnitude - exact[0]), abs(found.phase - exact[1])])
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    np.testing.assert_allclose(orders, 2.0, atol=0.01)
    assert max(errors[-1]) < 1e-4


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_numbers_that_are_not_finite_give_none_that_could_pass(value: float) -> None:
    history = np.sin(PERIODS)
    history[7] = value
    found = compare_histories(PERIODS, history, np.sin(PERIODS))
    assert all(math.isnan(x) for x in vars(found).values())


def test_nothing_to_compare_gives_none() -> None:
    for rows in (0, 1):
        few = np.ones(rows)
        assert all(math.isnan(x) for x in vars(compare_histories(few, few, few)).values())
    zero = compare_histories(PERIODS, np.sin(PERIODS), 0.0 * PERIODS)
    assert isinstance(zero, Metrics)
    assert all(math.isnan(x) for x in vars(zero).values())
