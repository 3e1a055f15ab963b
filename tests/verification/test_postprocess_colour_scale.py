"""Verification: colour ranges, tick labels and the view, by hand."""

import numpy as np
import pytest

from postprocess.contours.colour_scale import colour_scale
from postprocess.contours.view import round_positions, view_of_plate

pytestmark = pytest.mark.verification


@pytest.mark.parametrize(
    ("low", "high"),
    [
        (22.4747, 24.0719),
        (0.65507, 0.65513),
        (-6.551, 0.0),
        (0.6551053, 0.655105302),
        (1e7, 1.1e7),
        (1e7, 1.00002e7),
        (-3e-9, 2e-9),
    ],
)
def test_tick_labels_differ_and_have_four_digits(low: float, high: float) -> None:
    scale = colour_scale(np.array([low, high]))
    assert not scale.uniform
    assert len(set(scale.ticks)) == 7
    digits = [len(tick.split("e")[0].replace("-", "").replace(".", "").lstrip("0")) for tick in scale.ticks]
    assert max(digits) >= 4
    steps = np.diff([float(tick) for tick in scale.ticks])
    np.testing.assert_allclose(steps, (high - low) / 6, rtol=0.06)


def test_range_is_that_of_the_values() -> None:
    scale = colour_scale(np.array([22.5, 24.0, 23.0]))
    assert (scale.low, scale.high, scale.ticks[0], scale.ticks[-1]) == (22.5, 24.0, "22.50", "24.00")


def test_uniform_to_rounding_is_widened_not_amplified() -> None:
    scale = colour_scale(0.655 * (1.0 + 1e-13 * np.linspace(-1, 1, 9)))
    assert scale.uniform
    assert scale.high - scale.low == pytest.approx(0.655e-3, rel=1e-6)
    assert 0.5 * (scale.high + scale.low) == pytest.approx(0.655, rel=1e-9)
    assert scale.bands % 2 == 1


def test_uniform_threshold_is_1e_9() -> None:
    assert colour_scale(np.array([1.0, 1.0 + 0.9e-9])).uniform
    assert not colour_scale(np.array([1.0, 1.0 + 1.1e-9])).uniform


def test_zero_everywhere() -> None:
    scale = colour_scale(np.zeros(4))
    assert (scale.low, scale.high, scale.uniform) == (-5e-4, 5e-4, True)


def test_a_zero_has_no_sign() -> None:
    scale = colour_scale(np.array([-6.5, -1e-12]))
    assert (scale.high, scale.ticks[-1], scale.text(-1e-9)) == (0.0, "0.000", "0.000")


def test_values_that_are_not_finite_are_refused() -> None:
    with pytest.raises(ValueError, match="not finite"):
        colour_scale(np.array([1.0, np.nan]))


def test_the_view_holds_plate_and_wall_line() -> None:
    points = np.array([[-1.0, 0.0], [9.0, 0.0], [9.0, 2.4], [-1.0, 2.4]])
    view = view_of_plate(points, (1600, 700))
    left, bottom = view.pixel(-1.0, 0.0)
    right, top = view.pixel(9.0, 2.4)
    assert (left, right) == pytest.approx((70.0, 1530.0))
    assert (top - bottom) / (right - left) == pytest.approx(0.24)
    assert bottom >= 120.0
    assert top <= 700.0 - 190.0
    low, high = view.span()
    assert view.pixel(low, 0.0)[0] == pytest.approx(0.0, abs=1e-9)
    assert view.pixel(high, 0.0)[0] == pytest.approx(1600.0)


def test_the_view_reaches_down_to_the_wall_from_a_plate_above_it() -> None:
    view = view_of_plate(np.array([[0.0, 3.0], [2.0, 5.0]]), (1600, 700))
    assert view.pixel(0.0, 0.0)[1] >= 120.0 - 1e-9
    assert view.pixel(0.0, 5.0)[1] <= 510.0 + 1e-9


def test_round_positions() -> None:
    assert round_positions(-0.9, 3.2) == pytest.approx([-0.5, 0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0])
    assert round_positions(0.0, 100.0) == pytest.approx(np.arange(0.0, 101.0, 10.0))
    assert round_positions(3.0, 3.0) == round_positions(3.0, 2.0) == []
