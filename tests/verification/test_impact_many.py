"""Verify many whole impacts at once by single ones."""

import math
from typing import Any

import numpy as np
import pytest
from sampled_impacts import sampled_impacts

from solver import RigidBodyError
from solver.impact import (
    CrushLaw,
    ImpactVehicle,
    WallContact,
    first_touch,
    solve_impact,
)
from tailslap.case.of_arguments import case_of_scene

SPEED, ANGLE, MU = 56 * 0.44704, math.radians(15.0), 0.47

CORNERS = ("front", "rear", "front far side", "rear far side")

GIVEN: dict[str, Any] = {
    "length": 10.0, "width": 2.438, "mass": 9979.0, "speed": SPEED, "angle": ANGLE, "stiffness": 2e6,
    "restitution": 0.22, "friction": MU,
}  # fmt: skip

TIGHT = 5e-4
"""Tolerance of many impacts below which their steps are not coarse."""


def random_impacts(seed, n, steepest, roughest):
    """Random vehicles, laws and impacts."""
    rng = np.random.default_rng(seed)
    length, mass = rng.uniform(4.0, 12.0, n), rng.uniform(1e3, 3e4, n)
    return {
        "length": length, "width": length * rng.uniform(0.2, 0.45, n), "mass": mass,
        "speed": rng.uniform(10.0, 30.0, n), "angle": np.radians(rng.uniform(5.0, steepest, n)),
        "stiffness": 10.0 ** rng.uniform(5.0, 7.0, n), "restitution": rng.uniform(0.05, 0.9, n),
        "friction": rng.uniform(0.0, roughest, n), "centre_of_mass": length * rng.uniform(0.35, 0.65, n),
        "yaw_inertia": mass * length**2 / 12.0 * rng.uniform(0.7, 1.0, n),
    }  # fmt: skip


def alone(row):
    size = row["length"], row["width"], row["mass"]
    vehicle = ImpactVehicle(*size, row.get("centre_of_mass"), row.get("yaw_inertia"))
    law = CrushLaw(row["stiffness"], row.get("initial_force", 0.0), row["restitution"])
    touch = first_touch(vehicle, row["angle"], row["speed"])
    return solve_impact(vehicle, WallContact(law, row["friction"]), touch)


@pytest.mark.parametrize(
    ("seed", "steepest", "roughest"), [(2, 30.0, 0.8), pytest.param(3, 85.0, 2.0, marks=pytest.mark.long)]
)
def test_many_are_what_each_is_alone(seed, steepest, roughest):
    """Slender, steep, slipping and sticking vehicles agree within 1e-4."""
    inputs = random_impacts(seed, 15, steepest, roughest)
    many = sampled_impacts(**inputs, interval=5e-4, tolerance=TIGHT)
    assert np.all(many.error < 2e-3)
    for i in range(15):
        motion = alone({key: float(value[i]) for key, value in inputs.items()})
        for k, strike in enumerate(motion.strikes[:2]):
            assert CORNERS[many.group[k, i]] == strike.corner
            assert many.impulse[k, i] == pytest.approx(strike.impulse, rel=1e-4)
            assert many.peak_force[k, i] == pytest.approx(strike.peak_force, rel=1e-4)
            assert many.duration[k, i] == pytest.approx(strike.duration, rel=1e-3)
            assert many.start[k, i] == pytest.approx(strike.start, rel=1e-4, abs=1e-9)
        if len(motion.strikes) == 1:
            assert many.group[1, i] == -1
            assert math.isnan(many.impulse[1, i])
        rows = int(motion.t_end / 5e-4)
        impulse = motion.at(5e-4 * np.arange(1, rows + 1)).impulse_normal
        summed = 5e-4 * np.cumsum(many.mean_force[:rows, i])
        assert summed == pytest.approx(impulse, abs=1e-3 * impulse.max())
        assert np.all(many.mean_force[rows + 2 :, i] == 0.0)
    exact = alone({key: float(np.asarray(value)) for key, value in GIVEN.items()})
    end = sampled_impacts(**GIVEN, interval=exact.strikes[0].end / 100.0, tolerance=TIGHT).mean_force
    assert len(end) == pytest.approx(100.0 * exact.t_end / exact.strikes[0].end, abs=1.0)


@pytest.mark.parametrize(("steepest", "restitution", "initial_force"), [
    (30.0, (0.05, 0.9), 0.0), (60.0, (0.0, 0.02), 20.0), (40.0, (0.0, 0.0), 0.0),
])  # fmt: skip
def test_coarse_steps_stay_within_the_stated_error(steepest, restitution, initial_force):
    """Impulses of 40 vehicles, also with nearly vertical unloading.

    Up to three in a hundred, with repeated contacts that are one strike or two by a millisecond, exceed it.
    """
    inputs = random_impacts(4, 40, steepest, 0.6)
    inputs["restitution"] = np.random.default_rng(5).uniform(restitution[0], restitution[1], 40)
    inputs["initial_force"] = initial_force * inputs["mass"]
    many, exact = sampled_impacts(**inputs), sampled_impacts(**inputs, step=2e-5)
    assert np.all(many.error < 4e-2)
    assert np.all(np.abs(many.peak_force[0] / exact.peak_force[0] - 1.0) <= many.error)
    strike = ~np.isnan(exact.impulse)
    outside = np.abs(many.impulse / exact.impulse - 1.0) > many.error
    assert np.count_nonzero(outside[strike]) <= 0.03 * np.count_nonzero(strike)


GRAZING = {
    "length": 10.0, "width": 2.438, "mass": 10_000.0, "speed": 25.0, "angle": math.radians(15.0), "stiffness": 1.2e6,
    "restitution": 0.02, "friction": 0.45,
}  # fmt: skip


@pytest.mark.parametrize("count", [20, pytest.param(200, marks=pytest.mark.long)])
def test_many_have_the_strikes_of_each_where_contact_is_lost_for_a_moment(count):
    """Impulses and 97 % of durations are within the stated error.

    At low restitution the rear corner separates by micrometres: the tolerance of a single solution is 4e-3. All
    durations are within 10 %.
    """
    rng = np.random.default_rng(8)
    samples = {
        "mass": rng.uniform(9480.0, 10478.0, count), "angle": rng.uniform(0.2356, 0.288, count),
        "speed": rng.uniform(23.9, 26.2, count), "stiffness": rng.uniform(1e6, 3e6, count),
        "restitution": rng.uniform(0.0, 0.05, count), "friction": rng.uniform(0.3, 0.6, count),
    }  # fmt: skip
    inputs: dict[str, Any] = {key: np.broadcast_to(v, count) for key, v in (GRAZING | samples).items()}
    many = sampled_impacts(**inputs)
    apart = []
    for i in range(count):
        motion = alone({key: float(value[i]) for key, value in inputs.items()})
        for k, strike in enumerate(motion.strikes[:2]):
            assert CORNERS[many.group[k, i]] == strike.corner
            allowed = many.error[i] + 4e-3
            assert many.impulse[k, i] == pytest.approx(strike.impulse, rel=allowed)
            apart.append((abs(many.duration[k, i] / strike.duration - 1.0), allowed))
    off, allowed = np.array(apart).T
    assert np.count_nonzero(off > allowed) <= 0.03 * off.size
    assert off.max() < 0.1


def test_numbers_and_arrays_broadcast():
    """One impact has the shape (), stiffness times restitution the product's."""
    one = sampled_impacts(**GIVEN, tolerance=TIGHT)
    assert one.error.shape == ()
    assert one.mean_force.shape == (0,)
    assert one.impulse == pytest.approx([28.583e3, 26.675e3], rel=1e-4)
    e = np.array([0.22, 0.5])
    stiffness = np.array([[1e6], [2e6], [3e6]])
    grid = sampled_impacts(**{**GIVEN, "stiffness": stiffness, "restitution": e}, tolerance=TIGHT)
    assert grid.impulse.shape == (2, 3, 2)
    assert grid.impulse[:, 1, 0] == pytest.approx(one.impulse, rel=1e-9)
    assert np.all(np.diff(grid.peak_force[0], axis=0) > 0.0)


@pytest.mark.parametrize(("key", "value", "allowed"), [
    ("length", -1.0, "positive"), ("mass", 0.0, "positive"), ("speed", math.inf, "positive"),
    ("angle", 0.0, "between 0 and pi/2"), ("stiffness", [1e6, -1.0], "at index 1"),
    ("restitution", 1.5, "from 0 to 1"), ("friction", -0.1, "0 or more"),
    ("initial_force", -1.0, "0 or more"), ("centre_of_mass", 11.0, "between 0 and the length"),
    ("centre_of_mass", 0.2, "closer to the middle"), ("yaw_inertia", 1e7, "to I = m (a (L - a)"),
    ("yaw_inertia", 1.0, "from 0.001 I to I = m (a (L - a)"),
])  # fmt: skip
def test_what_cannot_be_among_many_is_refused(key, value, allowed):
    with pytest.raises(RigidBodyError) as caught:
        sampled_impacts(**{**GIVEN, key: value})
    assert caught.value.key == key
    assert allowed in str(caught.value)


def test_forces_of_a_huge_vehicle_have_rows_of_the_interval():
    """Its motion alone would allow steps of minutes."""
    huge = {**GIVEN, "width": 1e6}
    many, motion = sampled_impacts(**huge, interval=5e-4, longest=5.0), alone(huge)
    rows = int(motion.strikes[0].end / 5e-4)
    impulse = motion.at(5e-4 * np.arange(1, rows + 1)).impulse_normal
    assert 5e-4 * np.cumsum(many.mean_force[:rows]) == pytest.approx(impulse, abs=1e-3 * impulse.max())


@pytest.mark.parametrize(
    "scene", ["impact-mash-tl4-sut", "impact-mash-tl3-car", "impact-mash-tl5-tractor-van"]
)
def test_no_step_depends_on_rounding(scene):
    """Inputs that differ in their last digits have the same steps."""
    case: Any = case_of_scene(scene, None)
    speed, random = np.linspace(0.9, 1.1, 60) * case.inputs["impact.speed"], np.random.default_rng(4)
    rounded = {
        key: value * (1.0 + 8e-16 * random.uniform(-1.0, 1.0, 60)) for key, value in case.inputs.items()
    }
    until = {"after_second": 0.1, "interval": 5e-4, "strikes": 32}
    other = case.impacts(
        rounded | {"impact.speed": speed * (1.0 + 8e-16 * random.uniform(-1.0, 1.0, 60))}, **until
    )
    impacts = case.impacts({"impact.speed": speed}, **until)
    np.testing.assert_allclose(other.impulse, impacts.impulse, rtol=1e-8)
