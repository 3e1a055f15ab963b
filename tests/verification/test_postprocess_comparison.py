"""Verification: the differences by hand, and the published values as printed in the paper."""

import math

import pytest

from postprocess.comparison.quantities import PAPER_TABLE_3, comparison_rows, relative_difference

pytestmark = pytest.mark.verification

FE = {"t": 0.5, "v_gx": 22.0, "v_gy": -3.0, "omega": 0.75, "slide": 9.0}
RIGID = {"t": 0.4, "v_gx": 20.0, "v_gy": -4.0, "omega": 0.75, "slide": 10.0}


def test_relative_difference_by_hand() -> None:
    difference = relative_difference(FE, RIGID)
    assert list(difference) == ["t", "v_gx", "v_gy", "omega", "slide"]
    expected = {"t": 0.25, "v_gx": 0.1, "v_gy": -0.25, "omega": 0.0, "slide": -0.1}
    assert difference == pytest.approx(expected, abs=1e-15)


def test_keys_choose_the_quantities() -> None:
    assert relative_difference({"a": 3.0, "b": 1.0}, {"a": 2.0, "b": 1.0}, keys=("a",)) == {"a": 0.5}


@pytest.mark.parametrize(("fe", "expected"), [(0.0, 0.0), (1e-300, math.inf), (-2.0, -math.inf)])
def test_against_zero_only_zero_agrees(fe: float, expected: float) -> None:
    assert relative_difference({"t": fe}, {"t": 0.0}, keys=("t",)) == {"t": expected}


def test_not_a_number_stays_one() -> None:
    difference = relative_difference({"t": math.nan}, {"t": 1.0}, keys=("t",))["t"]
    assert not difference <= 1.0


def test_paper_table_3_as_printed() -> None:
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


def test_paper_analytical_column_is_the_rounded_exact_solution() -> None:
    exact = {
        "t": 0.3839597401,
        "v_gx": 23.2733311090,
        "v_gy": -3.2755267205,
        "omega": 0.6551053441,
        "slide": 9.4236754419,
    }
    for key, difference in relative_difference(PAPER_TABLE_3["analytical"], exact).items():
        assert abs(difference) < 0.01, key


def test_rows_hold_everything_a_table_shows() -> None:
    rows = comparison_rows(FE, RIGID)
    assert [row.quantity.key for row in rows] == list(FE)
    v_gy = rows[2]
    assert (v_gy.quantity.symbol, v_gy.quantity.unit) == ("v_GY", "m/s")
    assert (v_gy.fe, v_gy.rigid, v_gy.difference) == (-3.0, -4.0, -0.25)
    assert (v_gy.paper_analytical, v_gy.paper_abaqus) == (-3.274, -3.289)


def test_rows_of_a_scene_that_is_not_the_papers() -> None:
    assert all(
        row.paper_analytical is None and row.paper_abaqus is None for row in comparison_rows(FE, RIGID, None)
    )
