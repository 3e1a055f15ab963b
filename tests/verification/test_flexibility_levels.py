"""Verification: the flexibility study's levels, power laws and numerical error against exact laws."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tailslap.studies.flexibility.levels import (
    ABOVE_ALL,
    CROSSED,
    NOT_REACHED,
    UNKNOWN,
    Level,
    Sample,
    jointly,
    lowest_frequency,
    power_law,
)
from tailslap.studies.flexibility.points import convergence_index

pytestmark = pytest.mark.verification


def power(frequency: float, error: float = 1e-3, passed: bool = True) -> Sample:
    """A point of 0.04 (f1 / 1 Hz)^-2, with an error that is a share of that."""
    return Sample(frequency, 0.04 / frequency**2, error * 0.04 / frequency**2, passed)


SWEEP = tuple(np.geomspace(1000.0, 0.1, 9).tolist())


@pytest.mark.parametrize(("level", "hertz"), [(0.0004, 10.0), (0.01, 2.0), (0.04, 1.0), (0.16, 0.5)])
def test_levels_of_a_power_law_are_exact(level: float, hertz: float) -> None:
    found = lowest_frequency([power(f) for f in SWEEP], level)
    assert (found.kind, found.frequency) == (CROSSED, pytest.approx(hertz, rel=1e-12))


def test_levels_that_are_not_crossed() -> None:
    points = [power(f) for f in SWEEP]
    all_below = lowest_frequency(points[:4], 0.01)
    assert (all_below.kind, all_below.frequency) == (NOT_REACHED, SWEEP[3])
    above = lowest_frequency(points, 1e-12)
    assert (above.kind, above.frequency) == (ABOVE_ALL, SWEEP[0])
    none = lowest_frequency([replace(point, passed=False) for point in points], 0.01)
    assert none.kind == UNKNOWN
    assert math.isnan(none.frequency)


def level(kind: str, frequency: float) -> Level:
    return Level(0.01, kind, frequency)


@pytest.mark.parametrize(
    ("levels", "joint"),
    [
        ([level(CROSSED, 4.0), level(NOT_REACHED, 0.1), level(CROSSED, 2.0)], level(CROSSED, 4.0)),
        ([level(CROSSED, 0.2), level(NOT_REACHED, 0.3)], level(NOT_REACHED, 0.3)),
        ([level(CROSSED, 4.0), level(UNKNOWN, 1.0)], level(UNKNOWN, 1.0)),
        ([level(ABOVE_ALL, 1e3), level(UNKNOWN, 1.0), level(CROSSED, 2.0)], level(ABOVE_ALL, 1e3)),
    ],
)
def test_what_holds_for_every_start(levels: list[Level], joint: Level) -> None:
    assert jointly(levels) == jointly(levels[::-1]) == joint
    assert math.isnan(jointly([level(CROSSED, 2.0), level(UNKNOWN, math.nan)]).frequency)


@pytest.mark.parametrize(("share", "kind"), [(0.333, CROSSED), (0.334, UNKNOWN), (math.nan, UNKNOWN)])
def test_a_level_is_known_up_to_a_third_of_it_in_error(share: float, kind: str) -> None:
    assert lowest_frequency([power(f, share) for f in SWEEP], 0.01).kind == kind


def test_points_below_a_level_must_be_known_to_lie_below_it() -> None:
    points = [power(f) for f in SWEEP]
    points[2] = replace(points[2], error=0.01)
    unknown = lowest_frequency(points, 0.01)
    assert (unknown.kind, unknown.frequency) == (UNKNOWN, SWEEP[2])
    points[2] = replace(points[2], error=0.0033)
    assert lowest_frequency(points, 0.01).kind == CROSSED


def test_failed_points_say_nothing_of_a_level() -> None:
    points = [power(f) for f in SWEEP]
    points[0] = replace(points[0], passed=False, difference=9.0)
    points[-1] = replace(points[-1], passed=False, difference=0.0)
    found = lowest_frequency(points, 0.01)
    assert (found.kind, found.frequency) == (CROSSED, pytest.approx(2.0, rel=1e-12))
    below = next(i for i, f in enumerate(SWEEP) if f < 2.0)
    points[below] = replace(points[below], passed=False)
    assert lowest_frequency(points, 0.01).kind == UNKNOWN  # the crossing lies beside a point that failed


def test_a_power_law_is_followed_to_its_end() -> None:
    points = [power(f) for f in SWEEP]
    law = power_law(points)
    assert law
    assert (law.exponent, law.factor) == (pytest.approx(-2.0, abs=1e-12), pytest.approx(0.04, rel=1e-12))
    assert (law.highest, law.lowest) == (SWEEP[0], SWEEP[-1])
    bent = [*points[:6], *(replace(p, difference=3.0 * p.difference) for p in points[6:])]
    law = power_law(bent)
    assert law
    assert law.lowest == SWEEP[5]
    assert law.exponent == pytest.approx(-2.0, abs=1e-12)
    assert power_law([power(f, error=0.5) for f in SWEEP]) is None


def test_the_error_is_a_grid_convergence_index_of_a_believable_order() -> None:
    second = [3.0 + 0.01 * h**2 for h in (1.0, 2.0, 4.0)]
    assert convergence_index(*second) * second[0] == pytest.approx(1.25 * 0.01, rel=1e-9)
    lucky = [3.0 + 1e-6 * h**8 for h in (1.0, 2.0, 4.0)]
    assert convergence_index(*lucky) * lucky[0] == pytest.approx(1.25 * 255e-6 / 3.0, rel=1e-9)
    assert convergence_index(1.0, 1.01, 1.0) == pytest.approx(0.03)  # to and fro: three times the change


@pytest.mark.parametrize(("error", "kind"), [(0.9e-3, CROSSED), (1.0e-3, UNKNOWN)])
def test_what_is_below_a_level_with_its_error_on_top_is_below_it(error: float, kind: str) -> None:
    """The stiff end, where the error is most of the level and the difference next to nothing."""
    stiff = Sample(1000.0, 0.05e-3, error, True)
    rest = [Sample(frequency, 0.1 / frequency, 1e-6, True) for frequency in (200.0, 80.0)]
    found = lowest_frequency([stiff, *rest], 1e-3)
    assert found.kind == kind
    if kind == CROSSED:
        assert found.frequency == pytest.approx(100.0)
