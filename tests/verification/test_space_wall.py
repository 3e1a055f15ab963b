"""Verify strips on the face of a profile and on its top."""

import math

import numpy as np
import pytest
from space_vehicles import ANGLE, MASS, SPEED, axle, truck, truck_unit

from solver.body import GRAVITY
from solver.space import SpaceStrip, SpaceVehicle, SpaceWall, solve_space
from solver.space.solve import COMPARED, LEAST_ERROR


def on_wall(strips, wall, speed=SPEED, angle=ANGLE, **options):
    """Return the history of the truck with these strips."""
    vehicle = SpaceVehicle((truck_unit(),), truck(friction=0.0).axles, strips)
    return solve_space(vehicle, wall, speed, angle, **options).history


@pytest.mark.parametrize(
    ("profile", "heights", "slope"),
    [
        ("vertical", (0.5, 0.9), 0.0),
        ("single-slope", (0.5, 0.9), math.tan(math.radians(11.0))),
        ("new-jersey", (0.18, 0.22), 0.7),
        ("new-jersey", (0.5, 0.9), math.tan(math.radians(6.0))),
    ],
)
def test_force_without_friction_is_normal_to_the_face(profile, heights, slope):
    """The upward force is the slope times the lateral one."""
    h = on_wall((SpaceStrip((0.0, 0.0), heights, 4e6),), SpaceWall(2.0, profile), end=0.03, step=1e-4)
    assert h["force_normal"].max() > 1e4
    assert np.abs(h["force_vertical"] - slope * h["force_normal"]).max() < 1e-9 * h["force_normal"].max()
    assert np.abs(h["force_tangential"]).max() == 0.0
    assert np.abs(h["friction_work"]).max() == 0.0


def test_depth_is_normal_to_the_face():
    """At one height depth and lateral force are smaller by the cosine."""
    point = (SpaceStrip((0.0, 0.0), (0.5, 0.55), 4e6),)
    force = {
        profile: on_wall(point, SpaceWall(2.0, profile), end=5e-3, step=1e-5)["force_normal"][2]
        for profile in ("vertical", "single-slope")
    }
    assert force["single-slope"] / force["vertical"] == pytest.approx(
        math.cos(math.radians(11.0)) ** 2, rel=1e-3
    )


def test_friction_along_a_vertical_wall():
    """It opposes sliding with friction times the normal force."""
    h = on_wall((SpaceStrip((0.0, 0.0), (0.5, 0.9), 4e6),), SpaceWall(2.0, friction=0.3), end=0.03, step=1e-4)
    ratio = -h["force_tangential"][2:] / h["force_normal"][2:]
    assert ratio == pytest.approx(0.3, rel=1e-3)


@pytest.mark.parametrize(("top", "part"), [(0.5, 0.0), (0.75, 0.5), (0.6, 0.2), (1.0, 1.0)])
def test_part_of_a_strip_below_the_top_crushes(top, part):
    """The force is in proportion to the length below the top."""
    low = SpaceStrip((0.0, 0.0), (0.05, 0.1), 1.0)
    strips = low, SpaceStrip((0.0, 0.0), (0.5, 1.0), 4e6)
    force = on_wall(strips, SpaceWall(top), end=5e-3, step=1e-5)["force_normal"][2]
    complete = on_wall(strips, SpaceWall(2.0), end=5e-3, step=1e-5)["force_normal"][2]
    assert force == pytest.approx(part * complete, rel=2e-3, abs=1.0)


def test_box_lands_on_the_top():
    """Wheels and wall carry weight and push."""
    strips = (
        SpaceStrip((0.0, 0.0), (0.05, 0.4), 4e6, inset=0.3),
        SpaceStrip((10.0, 10.0), (0.05, 0.4), 4e6, inset=0.3),
        SpaceStrip((0.0, 10.0), (0.95, 0.95), 1e6),
    )
    end, load = 6.0, 1.5e5
    grown = np.clip((np.arange(300) + 0.5) / 150.0, 0.0, 1.0)
    push = np.zeros((300, 5))
    push[:, 2], push[:, 4] = -load * grown**2 * (3.0 - 2.0 * grown), np.nan
    axles = tuple(axle(at, damping_ratio=0.5, friction=3.0) for at in (2.0, 8.0))
    vehicle = SpaceVehicle((truck_unit(),), axles, strips)
    h = solve_space(vehicle, SpaceWall(0.9), 0.0, 1e-9, interval=2e-2, step=1e-3, end=end, push=push).history
    wheels = np.sum([h[f"load_{side}_{number}"] for side in ("left", "right") for number in (1, 2)], axis=0)
    first = int(np.argmax(h["force_vertical"] > 1e-3))
    assert first > 10
    assert h["force_normal"][first] < 1e-3 * h["force_vertical"][first]
    assert h["force_vertical"][-1] > 1e3
    assert wheels[-1] + h["force_vertical"][-1] == pytest.approx(MASS * GRAVITY + load, rel=1e-3)


def test_landing_crushes_in_proportion_to_the_depth():
    """The force is stiffness times length times the greatest depth."""
    strips = SpaceStrip((0.0, 0.0), (0.05, 0.4), 4e6, inset=0.3), SpaceStrip((0.0, 10.0), (0.95, 0.95), 1e5)
    grown = np.clip((np.arange(400) + 0.5) / 400.0, 0.0, 1.0)
    push = np.zeros((400, 5))
    push[:, 2], push[:, 4] = -2e5 * grown**2, np.nan
    held = truck_unit(roll_inertia=1e14, pitch_inertia=1e14)
    axles = tuple(axle(at, damping_ratio=0.5) for at in (2.0, 8.0))
    vehicle = SpaceVehicle((held,), axles, strips)
    h = solve_space(vehicle, SpaceWall(0.9), 0.0, 1e-9, interval=5e-3, step=1e-4, end=2.0, push=push).history
    sunk = h["z_g"] - h["z_g"][0] - 400.0 * (h["heave_1"] + h["heave_2"]) / MASS
    force = 1e5 * 10.0 * np.maximum(-0.05 - sunk, 0.0)
    rows = np.flatnonzero((force[1:] > 1e4) & (np.diff(sunk) < 0.0)) + 1
    assert rows.size > 20
    mean = 0.5 * (force[rows] + force[rows - 1])  # rows hold the mean since the previous one
    assert h["force_vertical"][rows] == pytest.approx(mean, rel=1e-3)


def test_strip_in_front_of_the_face_does_not_land():
    """The box beside the wall sinks along the face without a force."""
    strips = SpaceStrip((0.0, 0.0), (0.05, 0.4), 4e6), SpaceStrip((0.0, 10.0), (0.95, 0.95), 1e6, inset=0.1)
    push = np.zeros((100, 5))
    push[:, 2], push[:, 4] = -1.5e5, np.nan
    vehicle = SpaceVehicle((truck_unit(),), truck(friction=0.0).axles, strips)
    h = solve_space(vehicle, SpaceWall(0.9), 0.0, 1e-9, interval=1e-2, step=1e-3, end=1.0, push=push).history
    assert h["z_g"].min() < 1.25
    assert np.abs(h["force_vertical"]).max() == 0.0


@pytest.mark.parametrize(("profile", "height"), [("vertical", 0.7), ("new-jersey", 0.55)])
def test_stated_error_bounds_the_distance_from_an_eighth_of_the_step(profile, height):
    """The stated error includes that of the step.

    The second truck is 3e-3 off with the step that suffices for the first.
    """
    wall = SpaceWall(height, profile, 0.3)
    motion = solve_space(truck(), wall, SPEED, ANGLE)
    fine = solve_space(truck(), wall, SPEED, ANGLE, step=motion.step / 8.0)
    assert LEAST_ERROR <= motion.error <= 1e-3
    for name, least in COMPARED.items():
        value, true = float(getattr(motion.answers, name)), float(getattr(fine.answers, name))
        assert abs(value - true) <= motion.error * max(abs(true), least)
