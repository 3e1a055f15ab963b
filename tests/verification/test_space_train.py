"""Verify trains in space by rest, energy, hinges and planar trains."""

import math

import numpy as np
import pytest
from space_motions import energy_error
from space_vehicles import ANGLE, SPEED, train

from solver.impact import (
    CrushLaw,
    HitchedVehicle,
    ImpactVehicle,
    Strip,
    WallContact,
    first_touch,
    solve_impact,
)
from solver.space import SpaceStrip, SpaceWall, solve_space

STRIPS = (
    SpaceStrip((0.0, 0.0), (0.45, 1.0), 4e6, plateau=7e5, restitution=0.225),
    SpaceStrip((5.4, 5.4), (0.05, 1.0), 2e6, plateau=4e5, restitution=0.225, axle=1),
    SpaceStrip((1.0, 14.6), (1.2, 1.2), 1e6, plateau=6e4, restitution=0.225, unit=1),
    SpaceStrip((13.0, 13.0), (0.05, 1.0), 4e6, plateau=8e5, restitution=0.225, axle=4, unit=1),
    SpaceStrip((14.6, 14.6), (1.2, 3.5), 2e6, plateau=3e5, restitution=0.225, unit=1),
)
WALL = SpaceWall(1.0668, friction=0.35)


@pytest.fixture(scope="module")
def motion():
    """Return the train on a wall of 42 in."""
    return solve_space(train(STRIPS), WALL, 50 * 0.44704, ANGLE, step=1e-4)


def test_train_at_rest_stays():
    """The kingpin carries its part, and nothing changes for 1 s."""
    h = solve_space(train(STRIPS), WALL, 0.0, 0.3, end=1.0, step=1e-3).history
    for name in ("z_g", "z_g_2", "pitch", "pitch_2", "roll", "roll_2"):
        assert np.ptp(h[name]) < 1e-12, name
    total = sum(h[f"load_{side}_{number}"][-1] for side in ("left", "right") for number in range(1, 6))
    assert total == pytest.approx((8200.0 + 27770.0) * 9.80665, rel=1e-12)
    rear = 27770.0 * 9.80665 * (7.0 - 0.9) / (12.8 - 0.9)
    assert sum(
        h[f"load_{side}_{number}"][-1] for side in ("left", "right") for number in (4, 5)
    ) == pytest.approx(rear, rel=1e-12)


def test_hinge_carries_its_part_of_the_weight():
    """At rest it carries the trailer's load on the kingpin alone."""
    h = solve_space(train(STRIPS), WALL, 0.0, 0.3, end=0.1, step=1e-3).history
    weight = 27770.0 * 9.80665 * (12.8 - 7.0) / (12.8 - 0.9)
    for name, force in (("x", 0.0), ("y", 0.0), ("z", -weight)):
        assert h[f"hinge_force_{name}_1"][1:] == pytest.approx(force, rel=1e-8, abs=1e-4)


def test_hinge_and_wall_change_the_momentum_of_a_trailer():
    """Without friction nothing else pushes it, error of second order."""
    errors = list[float]()
    for step in (4e-4, 2e-4, 1e-4):
        train_of = train(STRIPS, friction=0.0), SpaceWall(1.0668), 22.0, ANGLE
        motion = solve_space(*train_of, interval=2e-3, step=step, end=1.0)
        h = motion.history
        wall = sum(push for name, push in motion.pushes.items() if name.startswith("trailer"))
        for axis, push in (("x", 0.0), ("y", wall)):
            gained = 27770.0 * (h[f"v_g{axis}_2"] - h[f"v_g{axis}_2"][0])
            impulse = 2e-3 * np.cumsum(push - h[f"hinge_force_{axis}_1"][1:])
            errors.append(np.abs(gained[1:] - impulse).max() / np.abs(gained).max())
    by_step = np.reshape(errors, (3, 2))
    assert (by_step[2] < (1e-5, 1e-6)).all()
    assert (np.log2(by_step[:2] / by_step[1:]) > 1.8).all()


def test_energy_balance_of_a_train(motion):
    """Hinges take no energy besides that of their stiffness in roll."""
    h = motion.history
    assert np.abs(energy_error(h)).max() < 1e-6 * h["kinetic_energy"][0]
    assert np.abs(h["roll_2"]).max() > 0.1


def test_hinge_stays_closed(motion):
    """The hinge is one point, twisted by its moment over the stiffness."""
    h = motion.history
    yaw = [h["yaw"], h["yaw_2"]]
    level = np.abs(h["roll"]) + np.abs(h["roll_2"]) < 0.02
    ends = [
        np.array([h[f"x_g{end}"] + arm * np.cos(angle), h[f"y_g{end}"] + arm * np.sin(angle)])
        for end, arm, angle in (("", 2.3 - 5.4, yaw[0]), ("_2", 7.0 - 0.9, yaw[1]))
    ]
    assert level.sum() > 50
    assert np.abs(ends[0] - ends[1])[:, level].max() < 2e-2  # the roll shifts the centres to the side


def test_held_train_is_the_planar_one():
    """With roll and pitch fixed, impulses are those of the planar train."""
    corners = ((0.0, 0, 3.5e6), (6.4, 0, 3.5e6), (0.0, 1, 8.75e6), (14.6, 1, 8.75e6))
    strips = tuple(
        SpaceStrip((at, at), (0.5, 0.6), 2e7, plateau=most, restitution=0.225, unit=unit)
        for at, unit, most in corners
    )
    held = train(strips, friction=0.0, roll_centre=0.5, roll_inertia=1e14, pitch_inertia=1e14)
    h = solve_space(
        held, SpaceWall(1.0, friction=0.35), SPEED, ANGLE, interval=4e-5, step=4e-5, end=0.72
    ).history
    laws = [CrushLaw(2e6, 0.0, 0.225, most) for most in (3.5e5, 8.75e5)]
    behind = tuple(Strip((at, at), laws[1], unit=1) for at in (0.0, 14.6))
    contact = WallContact(laws[0], 0.35, behind)
    tractor, trailer = (
        ImpactVehicle(6.4, 2.5, 8200.0, 2.3, 3e4),
        ImpactVehicle(14.6, 2.6, 27770.0, 7.0, 4.5e5),
    )
    hitched = (HitchedVehicle(trailer, 5.4, 0.9),)
    start = first_touch(tractor, ANGLE, SPEED, hitched)
    plane = solve_impact(tractor, contact, start, end=0.72, trailers=hitched, tolerance=1e-6)
    force, t = h["force_normal"], h["t"]
    for strikes in ([0], [1, 2], [3], [4]):  # of the second and third the contacts overlap
        few = [plane.strikes[number] for number in strikes]
        during = (t > min(s.start for s in few) - 1e-3) & (t < max(s.end for s in few) + 1e-3)
        assert 4e-5 * force[during].sum() == pytest.approx(math.fsum(s.impulse for s in few), rel=1e-6)
    for name, planar in zip("xy", plane.hinge_forces(t)[0], strict=True):
        impulse, exact = np.cumsum(h[f"hinge_force_{name}_1"][1:]), np.cumsum(planar)
        assert impulse[-1] == pytest.approx(exact[-1], rel=1e-6)
        assert np.abs(impulse - exact).max() < 1e-5 * np.abs(exact).max()  # of the instant of a strike
    at = plane.at(0.7)
    k = round(0.7 / 4e-5)
    for end in ("", "_2"):
        for name, column in (("v_gx", "v_gx"), ("v_gy", "v_gy"), ("omega", "omega_z")):
            assert h[f"{column}{end}"][k] == pytest.approx(
                float(getattr(at, f"{name}{end}")), rel=1e-5, abs=1e-5
            )
