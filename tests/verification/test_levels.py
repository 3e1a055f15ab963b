"""Verify levels, power laws and errors of the study of flexibility."""

import math

import numpy as np
import pytest

from postprocess.comparison.grid_convergence import convergence_index
from tailslap.campaign import levels


def power(frequency, error=1e-3, passed=True):
    """A point of 0.04 (f1/1 Hz)^-2 with a relative error."""
    return levels.Sample(frequency, 0.04 / frequency**2, error * 0.04 / frequency**2, passed)


SWEEP = tuple(np.geomspace(1000.0, 0.1, 9).tolist())


@pytest.mark.parametrize(("level", "hertz"), [(0.0004, 10.0), (0.01, 2.0), (0.04, 1.0), (0.16, 0.5)])
def test_levels_of_a_power_law_are_exact(level, hertz):
    """The frequency is that of the difference with its error on top."""
    for error in (0.0, 1e-3, 0.1):
        reach = levels.lowest_frequency([power(f, error) for f in SWEEP], level)
        expected = hertz * math.sqrt(1.0 + error)
        assert (reach.kind, reach.frequency) == (levels.CROSSED, pytest.approx(expected, rel=1e-12))


@pytest.mark.parametrize(("frequency", "text"), [
    (21.6, "22 Hz"), (1.34, "1.4 Hz"), (0.572, "0.58 Hz"), (2.0, "2 Hz"), (2.0000001, "2.1 Hz"),
    (991.0, "1 kHz"), (1001.0, "1.1 kHz"), (0.0999, "0.1 Hz"),
])  # fmt: skip
def test_a_level_is_rounded_to_the_safe_side(frequency, text):
    assert level(levels.CROSSED, frequency).text.replace("\N{NO-BREAK SPACE}", " ") == f"≈ {text}"


def test_levels_that_are_not_crossed():
    points = [power(f) for f in SWEEP]
    all_below = levels.lowest_frequency(points[:4], 0.01)
    assert (all_below.kind, all_below.frequency) == (levels.NOT_REACHED, SWEEP[3])
    above = levels.lowest_frequency(points, 1e-12)
    assert (above.kind, above.frequency) == (levels.ABOVE_ALL, SWEEP[0])
    none = levels.lowest_frequency([point._replace(passed=False) for point in points], 0.01)
    assert none.kind == levels.UNKNOWN
    assert math.isnan(none.frequency)


def level(kind, frequency):
    return levels.Reach(0.01, kind, frequency)


AT_4, AT_2, LOST = level(levels.CROSSED, 4.0), level(levels.CROSSED, 2.0), level(levels.UNKNOWN, 1.0)
ABOVE, NOT_DOWN_TO = level(levels.ABOVE_ALL, 1e3), level(levels.NOT_REACHED, 0.3)


@pytest.mark.parametrize(("reaches", "joint"), [
    ([AT_4, level(levels.NOT_REACHED, 0.1), AT_2], AT_4),
    ([level(levels.CROSSED, 0.2), NOT_DOWN_TO], NOT_DOWN_TO), ([AT_4, LOST], AT_4), ([ABOVE, LOST, AT_2], ABOVE),
    ([level(levels.CROSSED, 0.2), LOST], LOST), ([NOT_DOWN_TO, LOST], LOST),
])  # fmt: skip
def test_what_holds_for_every_start(reaches, joint):
    assert levels.jointly(reaches) == levels.jointly(reaches[::-1]) == joint
    assert math.isnan(levels.jointly([level(levels.CROSSED, 2.0), level(levels.UNKNOWN, math.nan)]).frequency)


@pytest.mark.parametrize(
    ("share", "kind"), [(0.499, levels.CROSSED), (0.501, levels.UNKNOWN), (math.nan, levels.UNKNOWN)]
)
def test_a_level_is_known_up_to_a_third_of_it_in_error(share, kind):
    """The error is half of the difference at a third of both."""
    assert levels.lowest_frequency([power(f, share) for f in SWEEP], 0.01).kind == kind


def test_points_below_a_level_must_be_known_to_lie_below_it():
    points = [power(f) for f in SWEEP]
    points[2] = points[2]._replace(error=0.01)
    unknown = levels.lowest_frequency(points, 0.01)
    assert (unknown.kind, unknown.frequency) == (levels.UNKNOWN, SWEEP[1])
    points[2] = points[2]._replace(error=0.0033)
    assert levels.lowest_frequency(points, 0.01).kind == levels.CROSSED


def test_failed_points_say_nothing_of_a_level():
    points = [power(f) for f in SWEEP]
    points[0] = points[0]._replace(passed=False, difference=9.0)
    points[-1] = points[-1]._replace(passed=False, difference=0.0)
    reach = levels.lowest_frequency(points, 0.01)
    assert (reach.kind, reach.frequency) == (levels.CROSSED, pytest.approx(2.0 * math.sqrt(1.001), rel=1e-12))
    below = next(i for i, f in enumerate(SWEEP) if f < 2.0)
    points[below] = points[below]._replace(passed=False)
    # The crossing lies beside a point that failed.
    assert levels.lowest_frequency(points, 0.01).kind == levels.UNKNOWN


def test_the_error_is_a_grid_convergence_index_of_a_believable_order():
    second = [3.0 + 0.01 * h**2 for h in (1.0, 2.0, 4.0)]
    assert convergence_index(*second) * second[0] == pytest.approx(1.25 * 0.01, rel=1e-9)
    lucky = [3.0 + 1e-6 * h**8 for h in (1.0, 2.0, 4.0)]
    assert convergence_index(*lucky) * lucky[0] == pytest.approx(1.25 * 255e-6 / 3.0, rel=1e-9)
    # To and fro: three times the change.
    assert convergence_index(1.0, 1.01, 1.0) == pytest.approx(0.03)


@pytest.mark.parametrize(("error", "kind"), [(0.9e-3, levels.CROSSED), (1.0e-3, levels.UNKNOWN)])
def test_what_is_below_a_level_with_its_error_on_top_is_below_it(error, kind):
    """At the stiff end the error is most of the level."""
    stiff = levels.Sample(1000.0, 0.05e-3, error, True)
    rest = [levels.Sample(frequency, 0.1 / frequency, 1e-6, True) for frequency in (200.0, 80.0)]
    reach = levels.lowest_frequency([stiff, *rest], 1e-3)
    assert reach.kind == kind
    if kind == levels.CROSSED:
        assert reach.frequency == pytest.approx(100.0, rel=2e-3)


def test_wrong_frequencies(refused):
    for lowest in ("0", "2 kg", "2 kHz"):
        assert refused(levels.frequencies, lowest, "1 kHz", 5) == "--lowest"
    assert refused(levels.frequencies, "1 Hz", "1 MHz", 5) == "--highest"


def test_frequencies_are_at_even_ratios_from_stiff_to_soft():
    assert levels.frequencies("1", "1 kHz", 4) == pytest.approx((1000.0, 100.0, 10.0, 1.0), rel=1e-12)
