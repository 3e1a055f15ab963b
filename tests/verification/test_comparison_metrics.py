"""Verify metrics of two histories, relative differences and orders by hand.

Further subjects are the printed table of the paper and the published example of grid convergence.
"""

import math

import numpy as np
import pytest

from postprocess.comparison import grid_convergence, metrics
from postprocess.comparison.quantities import PAPER_TABLE_3, comparison_rows, relative_difference

T = np.linspace(0.0, 1.0, 1001)


def beside(ours, reference):
    """Compare two histories of one column, which have times in common."""
    comparison = metrics.beside("v", ours, reference)
    assert comparison is not None
    return comparison


def test_metrics_of_a_scaled_and_of_a_late_history():
    """Twice as large is M = 1, late is P = 0.02."""
    reference = {"t": T, "v": np.sin(2.0 * np.pi * T)}
    twice = beside({"t": T, "v": 2.0 * reference["v"]}, reference)
    late = beside({"t": T, "v": np.sin(2.0 * np.pi * (T - 0.01))}, reference)
    assert twice.metrics.magnitude == pytest.approx(1.0, abs=1e-12)
    assert (twice.metrics.phase, twice.largest[0]) == (pytest.approx(0.0, abs=1e-7), pytest.approx(1.0))
    assert not twice.within
    assert late.metrics.magnitude == pytest.approx(0.0, abs=1e-12)
    assert late.metrics.phase == pytest.approx(0.02, rel=1e-6)
    assert late.within


def test_residuals_of_a_shifted_history():
    reference = {"t": T, "v": 4.0 - T}
    measures = beside({"t": T, "v": reference["v"] + 0.4}, reference)
    assert measures.metrics.mean_residual == pytest.approx(0.1)
    assert measures.metrics.deviation == pytest.approx(0.0, abs=1e-12)
    assert measures.at_end == pytest.approx(0.4 / 3.0)
    assert not measures.within  # the mean residual is beyond 5 %


def test_only_the_common_time_counts():
    reference = {"t": T, "v": T}
    measures = beside({"t": T[200:500:3] + 1e-5, "v": T[200:500:3] + 1e-5}, reference)
    assert (measures.t[0], measures.t[-1]) == (T[200] + 1e-5, T[497] + 1e-5)
    assert measures.covered == pytest.approx(0.297, rel=1e-10)
    assert not measures.within  # less than half of the reference's time
    np.testing.assert_allclose(measures.value, measures.reference, atol=1e-12)
    assert metrics.beside("v", {"t": T + 2.0, "v": T}, reference) is None


def test_rows_that_are_not_finite_are_left_out():
    values = np.where(T > 0.5, np.nan, T)
    measures = beside({"t": T, "v": values}, {"t": T, "v": T})
    assert measures.t[-1] == 0.5
    assert measures.covered == pytest.approx(0.5, rel=1e-12)


def test_a_gap_is_not_interpolated():
    """The rest agrees over 0.625 of the time, in either order."""
    wild = {"t": T, "v": np.where((T > 0.25) & (T < 0.625), 50.0, T)}
    rows = T[(T <= 0.25) | (T >= 0.625)]
    part = {"t": rows, "v": rows}
    for measures in (beside(part, wild), beside(wild, part)):
        assert measures.gaps == ((0.25, 0.625),)
        assert measures.covered == pytest.approx(0.625, rel=1e-12)
        assert {*vars(measures.metrics).values()} == {0.0}
        assert measures.largest[0] == 0.0


def test_a_gap_of_missing_values_is_one_too():
    values = np.where((T > 0.25) & (T < 0.625), np.nan, T)
    measures = beside({"t": T, "v": values}, {"t": T, "v": T})
    assert measures.gaps == ((0.25, 0.625),)


def test_even_and_dense_rows_have_no_gaps():
    """Five even rows, dense rows in a strike, and a short flight."""
    coarse = np.linspace(0.0, 1.0, 5)
    crowded = np.unique(np.r_[np.linspace(0.0, 1.0, 26), np.linspace(0.5, 0.6, 1001)])
    for t in (coarse, crowded):
        measures = beside({"t": t, "v": t}, {"t": T, "v": T})
        assert (measures.gaps, measures.covered) == ((), 1.0)


def test_rows_of_the_finer_history_count_too():
    """A peak between rows counts by its area of 0.001."""
    reference = {"t": np.linspace(0.0, 1.0, 11), "v": np.full(11, 2.0)}
    value = 2.0 + (np.arange(T.size) == 250)
    measures = beside({"t": T, "v": value}, reference)
    assert measures.metrics.mean_residual == pytest.approx(0.0005, rel=1e-10)
    assert measures.largest == (pytest.approx(0.5, rel=1e-12), T[250])


FE = {"t": 0.5, "v_gx": 22.0, "v_gy": -3.0, "omega": 0.75, "slide": 9.0}
RIGID = {"t": 0.4, "v_gx": 20.0, "v_gy": -4.0, "omega": 0.75, "slide": 10.0}


def test_relative_difference_by_hand():
    difference = relative_difference(FE, RIGID)
    assert list(difference) == ["t", "v_gx", "v_gy", "omega", "slide"]
    expected = {"t": 0.25, "v_gx": 0.1, "v_gy": -0.25, "omega": 0.0, "slide": -0.1}
    assert difference == pytest.approx(expected, abs=1e-15)


def test_keys_choose_the_quantities():
    assert relative_difference({"a": 3.0, "b": 1.0}, {"a": 2.0, "b": 1.0}, keys=("a",)) == {"a": 0.5}


@pytest.mark.parametrize(("fe", "expected"), [(0.0, 0.0), (1e-300, math.inf), (-2.0, -math.inf)])
def test_against_zero_only_zero_agrees(fe, expected):
    assert relative_difference({"t": fe}, {"t": 0.0}, keys=("t",)) == {"t": expected}


def test_not_a_number_stays_one():
    difference = relative_difference({"t": math.nan}, {"t": 1.0}, keys=("t",))["t"]
    assert not difference <= 1.0


def test_paper_table_3_as_printed():
    columns = {name: list(values.items()) for name, values in PAPER_TABLE_3.items()}
    names = ("t", "v_gx", "v_gy", "omega", "slide")
    assert columns["analytical"] == [*zip(names, (0.383, 23.270, -3.274, 0.65, 9.420), strict=True)]
    assert columns["abaqus"] == [*zip(names, (0.37, 23.305, -3.289, 0.66, 8.915), strict=True)]


def test_rows_hold_everything_a_table_shows():
    rows = comparison_rows(FE, RIGID, has_paper=True)
    assert [row["quantity"].key for row in rows] == list(FE)
    assert (rows[2]["quantity"].symbol, rows[2]["quantity"].unit) == ("v_GY", "m/s")
    computed, paper = {"fe": -3.0, "rigid": -4.0, "difference": -0.25}, ("paper_analytical", "paper_abaqus")
    assert computed.items() <= rows[2].items()
    assert [rows[2][name] for name in paper] == [-3.274, -3.289]


def test_rows_of_a_scene_that_is_not_the_papers():
    assert {*comparison_rows(FE, RIGID)[0]} == {"quantity", "fe", "rigid", "difference"}


PERIODS = np.linspace(0.0, 6.0 * np.pi, 3001)
"""Three whole periods of a sine, over which the trapezoidal rule is exact."""


@pytest.mark.parametrize("factor", [0.3, 1.0, 1.0 + 1e-9, 2.5])
def test_a_scaled_signal_differs_in_magnitude_alone(factor):
    signal = np.exp(-0.1 * PERIODS) * np.cos(PERIODS)
    measures = metrics.compare_histories(PERIODS, factor * signal, signal)
    assert measures.magnitude == pytest.approx(factor - 1.0, abs=1e-14)
    assert measures.phase == pytest.approx(0.0, abs=1e-14)
    assert measures.combined == pytest.approx(abs(factor - 1.0), abs=1e-14)


@pytest.mark.parametrize("shift", [1e-9, 1e-3, 0.5, 2.0, math.pi])
def test_a_sine_with_a_phase_shift(shift):
    measures = metrics.compare_histories(PERIODS, np.sin(PERIODS - shift), np.sin(PERIODS))
    assert measures.phase == pytest.approx(shift / math.pi, rel=1e-6, abs=1e-15)
    assert measures.magnitude == pytest.approx(0.0, abs=1e-13)


def test_magnitude_and_phase_combine_as_the_sides_of_a_right_angle():
    measures = metrics.compare_histories(PERIODS, 1.3 * np.sin(PERIODS - 0.4 * math.pi), np.sin(PERIODS))
    assert measures.combined == pytest.approx(0.5, abs=1e-12)


def test_a_constant_offset_is_all_mean_and_no_deviation():
    """It is relative to the peak of the reference, with its sign."""
    reference = -4.0 - np.sin(PERIODS)
    measures = metrics.compare_histories(PERIODS, reference - 0.25, reference)
    assert measures.mean_residual == pytest.approx(-0.05, abs=1e-14)
    assert measures.deviation == pytest.approx(0.0, abs=1e-14)


def test_a_wave_on_top_is_all_deviation():
    reference = 2.0 + 0.0 * PERIODS
    measures = metrics.compare_histories(PERIODS, reference + 0.6 * np.sin(PERIODS), reference)
    assert measures.mean_residual == pytest.approx(0.0, abs=1e-14)
    assert measures.deviation == pytest.approx(0.3 / math.sqrt(2.0), abs=1e-12)


def test_it_is_time_that_counts_and_not_rows():
    """The mean over time is that of the trapezoids, -0.07."""
    instants = np.array([0.0, 0.01, 0.02, 0.03, 0.04, 0.1, 0.9, 1.0])
    residual = np.where(instants < 0.05, -1.0, 0.0)
    measures = metrics.compare_histories(instants, 10.0 + 10.0 * residual, np.full(8, 10.0))
    assert measures.mean_residual == pytest.approx(-(0.04 + 0.5 * 0.06), abs=1e-15)
    later = metrics.compare_histories(7.0 + 3.0 * instants, 10.0 + 10.0 * residual, np.full(8, 10.0))
    for name in ("magnitude", "phase", "mean_residual", "deviation"):
        assert getattr(later, name) == pytest.approx(getattr(measures, name), abs=1e-13)


def test_the_trapezoidal_rule_converges_in_second_order():
    """exp against 1 on [0, 1] has closed forms of its norms.

    M = sqrt((e^2 - 1)/2) - 1 and cos(pi P) = (e - 1) sqrt(2/(e^2 - 1)).
    """
    square = (math.e**2 - 1.0) / 2.0
    exact = (math.sqrt(square) - 1.0, math.acos((math.e - 1.0) / math.sqrt(square)) / math.pi)
    errors = []
    for rows in (20, 40, 80):
        t = np.linspace(0.0, 1.0, rows + 1)
        measures = metrics.compare_histories(t, np.exp(t), np.ones_like(t))
        errors.append([abs(measures.magnitude - exact[0]), abs(measures.phase - exact[1])])
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    np.testing.assert_allclose(orders, 2.0, atol=0.01)
    assert max(errors[-1]) < 1e-4


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_numbers_that_are_not_finite_give_none_that_could_pass(value):
    history = np.sin(PERIODS)
    history[7] = value
    measures = metrics.compare_histories(PERIODS, history, np.sin(PERIODS))
    assert all(math.isnan(x) for x in vars(measures).values())


def test_nothing_to_compare_gives_none():
    for rows in (0, 1):
        few = np.ones(rows)
        assert all(math.isnan(x) for x in vars(metrics.compare_histories(few, few, few)).values())
    zero = metrics.compare_histories(PERIODS, np.sin(PERIODS), 0.0 * PERIODS)
    assert all(math.isnan(x) for x in vars(zero).values())


def test_published_example():
    """The example of the NPARC Alliance, "Examining Spatial (Grid) Convergence".

    p = 1.786170, limit 0.97130, GCI 0.103083 and 0.356249 %.
    """
    estimate = grid_convergence.grid_convergence(0.97050, 0.96854, 0.96178)
    assert estimate.order == pytest.approx(1.786170, abs=5e-7)
    assert estimate.extrapolated == pytest.approx(0.97130, abs=5e-6)
    assert 100.0 * estimate.gci_fine == pytest.approx(0.103083, abs=5e-7)
    assert (100.0 * estimate.gci_coarse, estimate.behaviour) == (
        pytest.approx(0.356249, abs=5e-7),
        "converging",
    )
    assert estimate.asymptotic == pytest.approx(1.0, abs=3e-3)


@pytest.mark.parametrize("order", [0.8, 1.7, 4.0])
def test_power_law_is_found_exactly(order):
    sizes = (1.0, 2.0, 4.0)
    values = tuple(5.0 - 0.01 * size**order for size in sizes)
    estimate = grid_convergence.grid_convergence(*values)
    assert estimate.order == pytest.approx(order, rel=1e-9)
    assert estimate.extrapolated == pytest.approx(5.0, rel=1e-12)
    assert estimate.gci_fine == pytest.approx(1.25 * 0.01 / 4.99, rel=1e-9)
    assert estimate.gci_coarse == pytest.approx(1.25 * 0.01 * sizes[1] ** order / values[1], rel=1e-9)


@pytest.mark.parametrize(("values", "behaviour"), [
    ((1.0, 1.1, 0.9), "oscillating"), ((1.0, 2.0, 2.5), "diverging"), ((2.0, 2.0, 2.0), "settled"),
    ((3.9, 3.6, 3.29), "slow"),  # a logarithm: it grows by the same with every halving
])  # fmt: skip
def test_values_that_do_not_converge_are_not_extrapolated(values, behaviour):
    estimate = grid_convergence.grid_convergence(*values)
    assert (estimate.behaviour, estimate.extrapolated) == (behaviour, values[0])
    if behaviour != "settled":
        assert estimate.gci_fine == pytest.approx(3.0 * abs(values[0] - values[1]) / values[0])
