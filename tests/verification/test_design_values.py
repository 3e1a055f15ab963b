"""Verify moment, intrusion, exit box and severity by closed forms."""

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from space_motions import pushes
from space_vehicles import WIDTH, axle, truck, truck_unit

from solver.space import SpaceStrip, SpaceVehicle, SpaceWall, solve_space, state
from solver.space.rows import means
from tailslap.case.impact.case import ImpactCase
from tailslap.case.impact.space.design import exit_box, intrusions, numbers
from tailslap.scene.read import read_scene


def test_moment_has_an_instant_height_and_length_of_its_own():
    """A later strike with less force acts higher."""
    windows, answer = np.zeros((600, 7)), np.zeros(state.ANSWERS)
    for rows, force, height, station, length in (
        (slice(100, 200), 300e3, 0.5, 1.0, 0.6),
        (slice(400, 480), 250e3, 0.8, 9.0, 3.0),
        (slice(520, 545), 900e3, 0.2, 5.0, 0.1),  # half a window
    ):
        windows[rows, state.LATERAL], windows[rows, state.MOMENT] = force, force * height
        windows[rows, state.STATION] = force * station
        windows[rows, state.SPREAD] = force * (station**2 + length**2 / 12.0)
    means(windows, np.zeros(10), 50, 1e-3, answer)
    names = state.MEAN, state.CENTRE_HEIGHT, state.MOMENT_MEAN, state.MOMENT_HEIGHT, state.MOMENT_LENGTH
    assert answer[[*names]] == pytest.approx([450e3, 0.2, 200e3, 0.8, 3.0], rel=1e-9)


def test_moment_of_a_given_force_at_given_heights():
    """Two springs share a slow push by their stiffness."""
    low, high = 0.4, 0.8
    strips = tuple(SpaceStrip((0.0, 10.0), (z, z), k) for z, k in ((low, 3e5), (high, 1e5)))
    held = truck_unit(roll_inertia=1e14, pitch_inertia=1e14, yaw_inertia=1e14)
    grown = np.clip((np.arange(3800) + 0.5) / 3500.0, 0.0, 1.0)
    push = pushes(3800, across=-2e5 * grown**3 * (10.0 - 15.0 * grown + 6.0 * grown**2))
    vehicle = SpaceVehicle((held,), tuple(axle(at, damping_ratio=0.5) for at in (2.0, 8.0)), strips)
    answers = solve_space(
        vehicle, SpaceWall(0.9), 0.0, 1e-9, interval=1e-3, step=5e-4, end=3.8, push=push, points=4
    ).answers
    height = (3.0 * low + high) / 4.0
    assert answers.moment == pytest.approx(2e5 * height, rel=1e-3)
    assert answers.moment_height == pytest.approx(height, rel=1e-4)
    assert answers.moment_length == pytest.approx(10.0, rel=2e-2)  # of pieces of the strip


def moving(**columns: Any) -> Any:
    """Return a motion with these columns, last in contact at 0.1 s."""
    rows = max(np.size(values) for values in columns.values())
    names = ["t", *state.POSE, *(f"{name}_{k}" for k in (1, 2) for name in state.WHEELS)]
    history = {name: np.zeros(rows) + columns.get(name, 0.0) for name in names}
    answers = dict.fromkeys(("moment", "moment_height", "moment_length", "end"), 0.0) | {"last_contact": 0.1}
    return SimpleNamespace(history=history, answers=SimpleNamespace(**answers))


@pytest.mark.parametrize(("roll", "yaw"), [(0.0, 0.0), (0.5, 0.0), (0.3, -0.1)])
def test_intrusion_of_a_given_pose(roll, yaw):
    """Corners of the box follow from the rolled and turned body."""
    pose = moving(t=[0.0, 0.1], y_g=[9.0, 1.2], z_g=1.35, roll=roll, yaw=yaw)
    wall = SpaceWall(0.9144, "single-slope")
    rows = {row["strip"]: row for row in intrusions(truck(), wall, pose)}
    up, edge = 2.6 - 1.35, -0.9144 * math.tan(math.radians(11.0))
    across = -0.5 * WIDTH * math.cos(roll) - up * math.sin(roll)
    ends = {3: 5.0 - 2.6, 4: 5.0 - 10.0}  # ahead of the centre
    places = {strip: 1.2 + ahead * math.sin(yaw) + across * math.cos(yaw) for strip, ahead in ends.items()}
    behind = {strip: edge - place for strip, place in places.items() if place < edge}
    assert {strip: row["intrusion"] for strip, row in rows.items() if strip in ends} == pytest.approx(behind)
    for strip in behind:
        height = 1.35 + up * math.cos(roll) - 0.5 * WIDTH * math.sin(roll)
        assert (rows[strip]["height"], rows[strip]["t"]) == pytest.approx((height, 0.1))
    assert bool(behind) == (roll > 0.0)
    width = numbers(truck(), wall, pose, "upright")["working_width"]
    assert width == pytest.approx(-min([edge, *(places[strip] for strip in behind)]))


@pytest.mark.parametrize(("mass", "margin", "length"), [(9979.0, 4.4, 20.0), (1500.0, 2.2, 10.0)])
def test_exit_box_of_a_straight_path(mass, margin, length):
    """Wheels reach y + half the track + B tan(direction)."""
    t, slope = np.linspace(0.0, 0.4, 41), 0.1
    path = moving(t=t, x_g=20.0 * t, y_g=1.5 + slope * 20.0 * t, z_g=1.35, v_gx=20.0, v_gy=20.0 * slope)
    vehicle = SpaceVehicle((truck_unit(mass=mass),), truck().axles, truck().strips)
    box = exit_box(vehicle, SpaceWall(0.9), path)
    assert box.width == pytest.approx(margin + WIDTH + 0.16 * 10.0)
    assert box.length == length
    assert box.reached == pytest.approx(1.5 + 0.1 * 20.0 * slope + 0.5 * 1.85 + length * slope)


def test_severity_counts_the_whole_train():
    """m (v sin(theta))^2/2 of tractor and trailer."""
    mass, across = 17390 * 0.45359237 + 28265.0, 84.9 / 3.6 * math.sin(math.radians(15.4))
    assert ImpactCase(*read_scene("impact-tl5cmb-2")).impact_severity == pytest.approx(
        0.5 * mass * across**2, rel=1e-12
    )
