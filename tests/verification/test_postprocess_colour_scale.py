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
        (0.65507, 0.65613),
        (-6.551, 0.0),
        (0.6551053, 0.6553),
        (1e7, 1.1e7),
        (1e7, 1.002e7),
        (-3e-9, 2e-9),
        (0.0, 7.0),
    ],
)
def test_labels_differ_and_are_round(low: float, high: float) -> None:
    """Multiples of 1, 2 or 5 times a power of ten, five to eight of them, that hold all values and little else."""
    scale = colour_scale(np.array([low, high]))
    assert not scale.uniform
    assert len(set(scale.ticks)) == scale.labels
    assert 4 <= scale.labels <= 9
    printed = np.array([float(tick.replace("−", "-")) for tick in scale.ticks])
    steps = np.diff(printed)
    size = float(f"{steps[0]:.0e}")
    assert f"{size:e}"[0] in "125"
    np.testing.assert_allclose(steps, size, rtol=1e-6)
    np.testing.assert_allclose(printed / size, np.rint(printed / size), atol=1e-6)
    assert low - size < scale.low <= low + 1e-9 * size
    assert high - 1e-9 * size <= scale.high < high + size
    assert scale.bands == 2 * (scale.labels - 1)


def test_next_to_nothing_is_uniform_not_a_drama() -> None:
    """Rounding, and eight parts in a million: one colour in a range of a hundredth."""
    for spread in (1e-13, 4e-6):
        scale = colour_scale(0.655 * (1.0 + spread * np.linspace(-1, 1, 9)))
        assert scale.uniform
        assert scale.high - scale.low == pytest.approx(0.655e-2, rel=1e-4)
        assert 0.5 * (scale.high + scale.low) == pytest.approx(0.655, rel=1e-6)
        assert scale.bands % 2 == 1
        assert scale.ticks == ["0.652", "0.655", "0.658"]


def test_uniform_threshold_is_1e_4() -> None:
    assert colour_scale(np.array([1.0, 1.0 + 0.9e-4])).uniform
    assert not colour_scale(np.array([1.0, 1.0 + 1.1e-4])).uniform


def test_zero_everywhere() -> None:
    scale = colour_scale(np.zeros(4))
    assert (scale.low, scale.high, scale.uniform) == (-5e-3, 5e-3, True)


def test_a_zero_has_no_sign_and_others_a_true_minus() -> None:
    scale = colour_scale(np.array([-6.5, -1e-12]))
    assert (scale.high, scale.ticks[-1], scale.text(-1e-9)) == (0.0, "0.0", "0.0")
    assert scale.ticks[0] == "−7.0"


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
