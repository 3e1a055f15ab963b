"""Verification: the methods of Olson, Hirsch and Ritter against hand calculation and each other."""

import math
from typing import Any

import numpy as np
import pytest

from solver import RigidBodyError, hirsch_force, olson_force, ritter_force

TRUCK: dict[str, Any] = {
    "mass": 9979.0,
    "speed": 25.0,
    "angle": math.pi / 6,
    "front_distance": 4.0,
    "half_width": 1.2,
}


def test_olson_by_hand():
    """At 30 degrees: way 4/2 - 1.2 (1 - sqrt(3)/2), lateral speed 12.5, average 6.25."""
    way = 2.0 - 1.2 * (1.0 - math.sqrt(3.0) / 2.0)
    force = olson_force(**TRUCK)
    assert force.travel == pytest.approx(way, rel=1e-15)
    assert force.time == pytest.approx(way / 6.25, rel=1e-14)
    assert force.deceleration == pytest.approx(12.5**2 / (2.0 * 9.80665 * way), rel=1e-14)
    assert force.average_force == pytest.approx(9979.0 * 12.5**2 / (2.0 * way), rel=1e-14)


def test_the_average_force_stops_the_lateral_motion_in_the_way_there_is():
    """Work and impulse of a constant force; gravity is a unit only, and a yielding barrier softens the blow."""
    force = olson_force(**TRUCK, deflection=0.5)
    energy, momentum = 0.5 * 9979.0 * 12.5**2, 9979.0 * 12.5
    assert force.average_force * force.travel == pytest.approx(energy, rel=1e-14)
    assert force.average_force * force.time == pytest.approx(momentum, rel=1e-14)
    assert olson_force(**TRUCK, gravity=1.62).average_force == pytest.approx(
        olson_force(**TRUCK).average_force, rel=1e-14
    )
    assert force.travel == pytest.approx(olson_force(**TRUCK).travel + 0.5, rel=1e-14)


def test_hirsch_and_ritter_are_olson_times_a_number():
    average = olson_force(**TRUCK, deflection=0.1).average_force
    ritter = ritter_force(**TRUCK, deflection=0.1)
    assert hirsch_force(average) == pytest.approx(math.pi / 2.0 * average, rel=1e-15)
    assert ritter.peak_force == pytest.approx(2.0 * average, rel=1e-14)
    assert ritter.impulse == pytest.approx(2.0 * 9979.0 * 12.5, rel=1e-14)
    assert ritter.peak_force * (2.0 * ritter.time) / 2.0 == pytest.approx(ritter.impulse, rel=1e-14)


def test_broadcasting_equals_single_calls():
    angles, masses = np.array([[0.1], [0.4]]), np.array([1000.0, 2000.0, 4000.0])
    together = olson_force(masses, 20.0, angles, 4.0, 1.2)
    pulses, peaks = ritter_force(masses, 20.0, angles, 4.0, 1.2), hirsch_force(together.average_force)
    for i, j in np.ndindex(2, 3):
        alone = olson_force(float(masses[j]), 20.0, float(angles[i, 0]), 4.0, 1.2)
        pulse = ritter_force(float(masses[j]), 20.0, float(angles[i, 0]), 4.0, 1.2)
        assert isinstance(alone.average_force, float)
        assert together.average_force[i, j] == pytest.approx(alone.average_force, rel=1e-14)
        assert pulses.peak_force[i, j] == pytest.approx(pulse.peak_force, rel=1e-14)
        assert peaks[i, j] == pytest.approx(hirsch_force(alone.average_force), rel=1e-14)


@pytest.mark.parametrize(
    ("call", "key", "allowed"),
    [
        (lambda: olson_force(**{**TRUCK, "mass": 0.0}), "mass", "positive and finite, kg"),
        (lambda: olson_force(**{**TRUCK, "speed": math.nan}), "speed", "positive and finite, m/s"),
        (lambda: olson_force(**{**TRUCK, "angle": 0.0}), "angle", "between 0 and pi/2 rad"),
        (lambda: olson_force(**{**TRUCK, "angle": math.pi / 2}), "angle", "between 0 and pi/2 rad"),
        (lambda: olson_force(**{**TRUCK, "front_distance": -1.0}), "front_distance", "positive"),
        (lambda: olson_force(**{**TRUCK, "half_width": math.inf}), "half_width", "positive"),
        (lambda: olson_force(**TRUCK, gravity=0.0), "gravity", "positive"),
        (lambda: ritter_force(**TRUCK, deflection=-0.1), "deflection", "0 or more"),
        (lambda: ritter_force(**{**TRUCK, "half_width": 20.0}), "travel", "positive: front_distance"),
        (lambda: hirsch_force(0.0), "average_force", "positive and finite, N"),
    ],
)
def test_what_is_refused(call, key, allowed):
    with pytest.raises(RigidBodyError) as refused:
        call()
    assert refused.value.key == key
    assert refused.value.allowed.startswith(allowed)
