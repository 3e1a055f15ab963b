"""Verification: relative differences and metrics by hand, the paper's printed table, orders of known sequences."""

from __future__ import annotations

import math

import numpy as np
import pytest

from postprocess.comparison.metrics import Metrics, compare_histories, grid_convergence, observed_order
from postprocess.comparison.quantities import PAPER_TABLE_3, comparison_rows, relative_difference

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
    assert PAPER_TABLE_3["analytical"] == {
        "t": 0.383,
        "v_gx": 23.270,
        "v_gy": -3.274,
        "omega": 0.65,
        "slide": 9.420,
    }
    assert PAPER_TABLE_3["abaqus"] == {
        "t": 0.37,
        "v_gx": 23.305,
        "v_gy": -3.289,
        "omega": 0.66,
        "slide": 8.915,
    }


def test_paper_analytical_column_is_the_rounded_exact_solution():
    exact = {
        "t": 0.3839597401,
        "v_gx": 23.2733311090,
        "v_gy": -3.2755267205,
        "omega": 0.6551053441,
        "slide": 9.4236754419,
    }
    for key, difference in relative_difference(PAPER_TABLE_3["analytical"], exact).items():
        assert abs(difference) < 0.01, key


def test_rows_hold_everything_a_table_shows():
    rows = comparison_rows(FE, RIGID)
    assert [row.quantity.key for row in rows] == list(FE)
    v_gy = rows[2]
    assert (v_gy.quantity.symbol, v_gy.quantity.unit) == ("v_GY", "m/s")
    assert (v_gy.fe, v_gy.rigid, v_gy.difference) == (-3.0, -4.0, -0.25)
    assert (v_gy.paper_analytical, v_gy.paper_abaqus) == (-3.274, -3.289)


def test_rows_of_a_scene_that_is_not_the_papers():
    assert all(
        row.paper_analytical is None and row.paper_abaqus is None for row in comparison_rows(FE, RIGID, None)
    )


PERIODS = np.linspace(0.0, 6.0 * np.pi, 3001)
"""Three whole periods of a sine, over which the trapezoidal rule is exact."""


@pytest.mark.parametrize("factor", [0.3, 1.0, 1.0 + 1e-9, 2.5])
def test_a_scaled_signal_differs_in_magnitude_alone(factor):
    signal = np.exp(-0.1 * PERIODS) * np.cos(PERIODS)
    found = compare_histories(PERIODS, factor * signal, signal)
    assert found.magnitude == pytest.approx(factor - 1.0, abs=1e-14)
    assert found.phase == pytest.approx(0.0, abs=1e-14)
    assert found.combined == pytest.approx(abs(factor - 1.0), abs=1e-14)


@pytest.mark.parametrize("shift", [1e-9, 1e-3, 0.5, 2.0, math.pi])
def test_a_sine_with_a_phase_shift(shift):
    found = compare_histories(PERIODS, np.sin(PERIODS - shift), np.sin(PERIODS))
    assert found.phase == pytest.approx(shift / math.pi, rel=1e-6, abs=1e-15)
    assert found.magnitude == pytest.approx(0.0, abs=1e-13)


def test_magnitude_and_phase_combine_as_the_sides_of_a_right_angle():
    found = compare_histories(PERIODS, 1.3 * np.sin(PERIODS - 0.4 * math.pi), np.sin(PERIODS))
    assert found.combined == pytest.approx(0.5, abs=1e-12)


def test_a_constant_offset_is_all_mean_and_no_deviation():
    """Over the peak of the reference, whatever its sign; and signed."""
    reference = -4.0 - np.sin(PERIODS)
    found = compare_histories(PERIODS, reference - 0.25, reference)
    assert found.mean_residual == pytest.approx(-0.05, abs=1e-14)
    assert found.deviation == pytest.approx(0.0, abs=1e-14)


def test_a_wave_on_top_is_all_deviation():
    reference = 2.0 + 0.0 * PERIODS
    found = compare_histories(PERIODS, reference + 0.6 * np.sin(PERIODS), reference)
    assert found.mean_residual == pytest.approx(0.0, abs=1e-14)
    assert found.deviation == pytest.approx(0.3 / math.sqrt(2.0), abs=1e-12)


def test_it_is_time_that_counts_and_not_rows():
    """Rows crowd where the two differ: the mean over time is that of the trapezoids, -0.07, not that of the rows."""
    instants = np.array([0.0, 0.01, 0.02, 0.03, 0.04, 0.1, 0.9, 1.0])
    residual = np.where(instants < 0.05, -1.0, 0.0)
    found = compare_histories(instants, 10.0 + 10.0 * residual, np.full(8, 10.0))
    assert found.mean_residual == pytest.approx(-(0.04 + 0.5 * 0.06), abs=1e-15)
    later = compare_histories(7.0 + 3.0 * instants, 10.0 + 10.0 * residual, np.full(8, 10.0))
    for name in ("magnitude", "phase", "mean_residual", "deviation"):
        assert getattr(later, name) == pytest.approx(getattr(found, name), abs=1e-13)


def test_the_trapezoidal_rule_converges_in_second_order():
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
def test_numbers_that_are_not_finite_give_none_that_could_pass(value):
    history = np.sin(PERIODS)
    history[7] = value
    found = compare_histories(PERIODS, history, np.sin(PERIODS))
    assert all(math.isnan(x) for x in vars(found).values())


def test_nothing_to_compare_gives_none():
    for rows in (0, 1):
        few = np.ones(rows)
        assert all(math.isnan(x) for x in vars(compare_histories(few, few, few)).values())
    zero = compare_histories(PERIODS, np.sin(PERIODS), 0.0 * PERIODS)
    assert isinstance(zero, Metrics)
    assert all(math.isnan(x) for x in vars(zero).values())


def test_published_example():
    """NPARC Alliance, "Examining Spatial (Grid) Convergence": p = 1.786170, 0.97130, GCI 0.103083 and 0.356249 %."""
    found = grid_convergence((0.97050, 0.96854, 0.96178), (2.0, 2.0))
    assert found.order == pytest.approx(1.786170, abs=5e-7)
    assert found.extrapolated == pytest.approx(0.97130, abs=5e-6)
    assert 100.0 * found.gci_fine == pytest.approx(0.103083, abs=5e-7)
    assert 100.0 * found.gci_coarse == pytest.approx(0.356249, abs=5e-7)
    assert found.behaviour == "converging"
    assert found.asymptotic == pytest.approx(1.0, abs=3e-3)


@pytest.mark.parametrize("order", [0.8, 1.7, 4.0])
@pytest.mark.parametrize("ratios", [(2.0, 2.0), (1.5, 2.2), (3.0, 1.2)])
def test_power_law_is_found_exactly(order, ratios):
    sizes = (1.0, ratios[0], ratios[0] * ratios[1])
    values = tuple(5.0 - 0.01 * size**order for size in sizes)
    found = grid_convergence(values, ratios)
    assert found.order == pytest.approx(order, rel=1e-9)
    assert found.extrapolated == pytest.approx(5.0, rel=1e-12)
    assert found.error == pytest.approx(0.01 / 4.99, rel=1e-9)
    assert found.gci_fine == pytest.approx(1.25 * found.error, rel=1e-9)
    assert found.gci_coarse == pytest.approx(1.25 * 0.01 * sizes[1] ** order / values[1], rel=1e-9)


@pytest.mark.parametrize(
    ("values", "behaviour"),
    [
        ((1.0, 1.1, 0.9), "oscillating"),
        ((1.0, 2.0, 2.5), "diverging"),
        ((3.9, 3.6, 3.29), "slow"),  # a logarithm: it grows by the same with every halving
        ((2.0, 2.0, 2.0), "settled"),
    ],
)
def test_values_that_do_not_converge_are_not_extrapolated(values, behaviour):
    found = grid_convergence(values, (2.0, 2.0))  # type: ignore[arg-type]
    assert found.behaviour == behaviour
    assert found.extrapolated == values[0]
    if behaviour != "settled":
        assert found.gci_fine == pytest.approx(3.0 * abs(values[0] - values[1]) / values[0])


def test_no_order_for_a_quotient_that_no_power_law_has():
    assert observed_order(0.1, (1.5, 2.2)) == -math.inf


def test_ratios_must_be_above_one():
    with pytest.raises(ValueError, match="above 1"):
        grid_convergence((1.0, 2.0, 3.0), (1.0, 2.0))
