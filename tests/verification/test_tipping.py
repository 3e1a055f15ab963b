"""Verification: roll of a vehicle over a wall: closed forms, energy, order, and the trial of `impact.md` 7."""

import math
from dataclasses import replace

import numpy as np
import pytest

from solver import RigidBodyError, tipping
from solver.body import GRAVITY
from solver.impact import CrushLaw, ImpactVehicle, WallContact, first_touch, solve_impact
from solver.tipping import TIPPED, RollingVehicle

MASS, CENTRE, INERTIA, TRACK, SPRING = 9979.0, 1.35, 9979.0 * 1.1**2, 1.85, 1.2e6
B, WALL, WEIGHT = 0.5 * TRACK, 0.81, 9979.0 * 9.80665
TRUCK = RollingVehicle(MASS, CENTRE, INERTIA, TRACK, SPRING)
UNDAMPED = replace(TRUCK, damping_ratio=0.0)
HARD = replace(TRUCK, suspension=1e11)
"""Springs that deflect by 5e-7 m: hard ground within 1e-6."""

INTERVAL = 2e-4


@pytest.fixture(scope="module")
def push():
    """Mean forces of Table 1's truck at k = 2 MN/m, its third strike included."""
    vehicle = ImpactVehicle(10.0, 2.438, MASS)
    start = first_touch(vehicle, math.radians(15.0), 56 * 0.44704)
    motion = solve_impact(vehicle, WallContact(CrushLaw(2e6, 0.0, 0.22), 0.47), start, end=0.8)
    return np.diff(motion.at(np.linspace(0.0, 0.8, 4001)).impulse_normal) / INTERVAL


def column(motion, name):
    return motion.rows[:, tipping.ROW.index(name)]


def potential(vehicle, height, roll):
    """Return the energy of gravity and springs, written independently [J]."""
    total = vehicle.mass * GRAVITY * height
    for side in (-0.5, 0.5):
        above = height + side * vehicle.track * np.sin(roll) - vehicle.centre_height * np.cos(roll)
        closed = np.maximum(0.5 * vehicle.mass * GRAVITY / vehicle.suspension - above, 0.0)
        total = total + 0.5 * vehicle.suspension * closed**2
    return total


def test_static_tipping_on_hard_ground():
    """F (z - h) = m g b: a force that grows slowly to a millionth more tips, to a millionth less it does not."""
    give = 0.5 * WEIGHT / HARD.suspension / B  # roll at which the far wheels lift
    static = WEIGHT * (B - CENTRE * give) / (CENTRE - WALL)
    assert static == pytest.approx(WEIGHT * B / (CENTRE - WALL), rel=1e-6)
    part = np.minimum(5e-3 * (np.arange(700) + 0.5), 1.0)
    forces = static * np.array([1.0 - 1e-6, 1.0 + 1e-6])[:, None] * part**2 * (3.0 - 2.0 * part)
    damped = replace(HARD, damping_ratio=np.ones(2))
    held, tipped = tipping.largest_rolls(damped, WALL, forces, 1e-2)
    assert held < 1e-5
    assert tipped == TIPPED


def test_energy_to_tip_on_hard_ground():
    """(I + m b^2) w^2/2 > m g (sqrt(z^2 + b^2) - z): the body turns about the wheels, which slide across the wall."""
    rise = WEIGHT * (math.hypot(CENTRE, B) - CENTRE)
    hard = replace(HARD, suspension=1e12, damping_ratio=0.0)
    for more, tips in ((-1e-6, False), (1e-6, True)):
        rate = math.sqrt(2.0 * rise * (1.0 + more) / (INERTIA + MASS * B**2))
        found = tipping.solve_roll(hard, WALL, np.zeros(1), 1e-2, 1e-6, (0.0, 0.0, B * rate, rate))
        assert found.tips == tips


def test_frequency_of_small_rolls_on_both_wheels():
    """sqrt((2 k b^2 - m g z)/I), about the roll of a small force that comes on at once."""
    force = np.full(20_000, 0.1)
    roll = column(tipping.solve_roll(UNDAMPED, WALL, force, INTERVAL), "roll")[: force.size]
    stiffness = 2.0 * SPRING * B**2 - WEIGHT * CENTRE
    exact = 0.1 * (CENTRE - WALL) / stiffness
    omega = math.sqrt(stiffness / INERTIA)
    t = INTERVAL * np.arange(force.size)
    assert roll.max() == pytest.approx(2.0 * exact, rel=1e-6)
    crossings = np.flatnonzero((roll[:-1] < exact) & (roll[1:] >= exact))
    at = t[crossings] + INTERVAL * (exact - roll[crossings]) / (roll[crossings + 1] - roll[crossings])
    period = (at[-1] - at[0]) / (at.size - 1)
    assert 2.0 * math.pi / period == pytest.approx(omega, rel=1e-6)


def test_damping_of_the_heave():
    """Without roll successive amplitudes, small beside the static deflection, have the ratio exp(-2 pi ratio)."""
    start = (1e-6, 0.0, 0.0, 0.0)
    force = np.full(20_000, 1e-9)
    vehicle = replace(TRUCK, damping_ratio=0.05)
    z = column(tipping.solve_roll(vehicle, CENTRE, force, INTERVAL, start=start), "height") - CENTRE
    tops = z[1:-1][(z[1:-1] > z[:-2]) & (z[1:-1] >= z[2:])][:3]
    ratio = 0.05 / math.sqrt(1.0 - 0.05**2)
    assert np.log(tops[:-1] / tops[1:]) == pytest.approx(2.0 * math.pi * ratio, rel=1e-3)


@pytest.mark.parametrize("friction", [0.0, 0.47])
@pytest.mark.parametrize("damping", [0.0, 0.15])
@pytest.mark.parametrize("wall", [0.69, 0.81, 1.07])
def test_energy_balance(push, friction, damping, wall):
    """Work of the wall's force against kinetic energy, gravity and springs, and what friction and damper take."""
    vehicle = replace(TRUCK, damping_ratio=damping, width=2.438, friction=friction, speed=24.0)
    found = tipping.solve_roll(vehicle, wall, push, INTERVAL)
    energy = 0.5 * (MASS * column(found, "v_z") ** 2 + INERTIA * column(found, "rate") ** 2)
    energy += potential(vehicle, column(found, "height"), column(found, "roll"))
    friction_work, damping_work = column(found, "friction_work"), column(found, "damping_work")
    gap = energy - energy[0] - column(found, "wall_work") - friction_work - damping_work
    assert np.abs(gap).max() <= 1e-6 * column(found, "wall_work").max()
    assert (friction_work[-1] < 0.0) == (friction > 0.0)
    assert (damping_work[-1] < 0.0) == (damping > 0.0)
    assert np.diff(friction_work).max() <= 1e-9
    assert np.diff(damping_work).max() <= 1e-9


@pytest.mark.parametrize("friction", [0.0, 0.47])
def test_second_order(push, friction):
    vehicle = replace(TRUCK, width=2.438, friction=friction, speed=24.0)
    parts = (1, 2, 4, 8)
    solve = lambda n: tipping.solve_roll(vehicle, WALL, push, INTERVAL, INTERVAL / n)  # noqa: E731
    rolls = [solve(n).largest_roll for n in (*parts, 256)]
    errors = np.abs(np.array(rolls[:-1]) / rolls[-1] - 1.0)
    assert errors[0] < 1e-5
    assert np.polyfit(np.log(parts), -np.log(errors), 1)[0] == pytest.approx(2.0, abs=0.15)


def test_the_stated_error_covers_the_true_one(push):
    for wall in (0.75, 0.81, 0.91, 1.07):
        found = tipping.solve_roll(TRUCK, wall, push, INTERVAL)
        fine = tipping.solve_roll(TRUCK, wall, push, INTERVAL, INTERVAL / 64)
        assert abs(found.largest_roll / fine.largest_roll - 1.0) <= found.error <= tipping.TOLERANCE


def test_a_vehicle_that_rises_quickly_flies():
    """A damper does not pull: above the speed at which it takes all of the spring's load, gravity alone acts."""
    vehicle, force = replace(TRUCK, damping_ratio=1.0), np.full(300, 1e-9)
    found = tipping.solve_roll(vehicle, CENTRE, force, INTERVAL, start=(0.0, 0.0, 1.0, 0.0))
    t = INTERVAL * np.arange(300)
    assert 1.0 - GRAVITY * t[-1] > GRAVITY / (2.0 * math.sqrt(2.0 * SPRING / MASS))
    assert column(found, "height")[:300] == pytest.approx(CENTRE + t - 0.5 * GRAVITY * t**2, rel=1e-12)
    assert not column(found, "load_near")[1:300].any()


@pytest.mark.parametrize("leaning", [0.0, 0.4])
def test_a_side_that_sticks_on_the_wall_turns_about_it(leaning):
    """Friction without limit, and no sliding along: the point of the side on the wall's top stays where it is."""
    vehicle = replace(UNDAMPED, width=2.438, friction=1e3)
    start = (0.0, leaning, 0.0, 0.0)
    found = tipping.solve_roll(vehicle, WALL, np.full(100, 2e5), INTERVAL, start=start)
    height, roll, v, w = found.rows[1:101, :4].T
    assert w[-1] > 1e-3
    arm = -(0.5 * 2.438 - (height - WALL) * np.sin(roll)) / np.cos(roll)
    assert np.abs(v + arm * w).max() < 1e-3 * np.abs(v).max()
    assert np.abs(column(found, "friction_work")).max() < 1e-3 * column(found, "wall_work").max()


TABLE = {
    1.25: (9.0, 4.0, 3.0, 2.0), 1.35: (90.0, 8.0, 4.0, 2.0), 1.45: (90.0, 90.0, 8.0, 4.0),
}  # fmt: skip
"""Largest roll [deg] over walls of 0.69, 0.81, 0.91 and 1.07 m by the height of the centre, 90 where it tips."""


def test_the_trial_of_the_paper_s_truck(push):
    centre, wall = np.array(list(TABLE))[:, None], np.array([0.69, 0.81, 0.91, 1.07])
    rolls = np.degrees(tipping.largest_rolls(replace(TRUCK, centre_height=centre), wall, push, INTERVAL))
    printed = np.array(list(TABLE.values()))
    assert ((rolls == 90.0) == (printed == 90.0)).all()
    assert np.abs(rolls - printed).max() <= 1.0
    assert ((tipping.largest_rolls(replace(UNDAMPED, centre_height=centre), wall, push, INTERVAL) == TIPPED)
            == (printed == 90.0)).all()  # fmt: skip


def test_lowest_wall_and_highest_centre(push):
    low = float(tipping.lowest_walls(TRUCK, push, INTERVAL))
    high = float(tipping.highest_centres(TRUCK, WALL, push, INTERVAL))
    for vehicle, wall, tips in (
        (TRUCK, low, False),
        (TRUCK, low - 1.01e-3, True),
        (replace(TRUCK, centre_height=high), WALL, False),
        (replace(TRUCK, centre_height=high + 1.01e-3), WALL, True),
    ):
        assert (tipping.largest_rolls(vehicle, wall, push, INTERVAL) == TIPPED) == tips
    higher = np.linspace(low, CENTRE, 100)
    assert (tipping.largest_rolls(TRUCK, higher, push, INTERVAL) < TIPPED).all()


def test_many_are_as_one(push):
    rng = np.random.default_rng(7)
    many = RollingVehicle(
        rng.uniform(8e3, 1e4, 20), rng.uniform(1.2, 1.5, 20), rng.uniform(1e4, 1.5e4, 20), TRACK,
        rng.uniform(8e5, 2e6, 20), rng.uniform(0.0, 0.3, 20), 2.438, rng.uniform(0.0, 0.5, 20), 24.0,
    )  # fmt: skip
    force = push * rng.uniform(0.8, 1.1, 20)[:, None]
    rolls = tipping.largest_rolls(many, WALL, force, INTERVAL)
    lowest = tipping.lowest_walls(many, force, INTERVAL)
    names = ("mass", "centre_height", "roll_inertia", "suspension", "damping_ratio", "friction")
    for i in range(20):
        one = replace(many, **{name: getattr(many, name)[i] for name in names})
        found = tipping.solve_roll(one, WALL, force[i], INTERVAL)
        assert rolls[i] == pytest.approx(found.largest_roll, rel=2e-3)
        assert lowest[i] == pytest.approx(float(tipping.lowest_walls(one, force[i], INTERVAL)), abs=2e-3)


def test_a_centre_below_the_wall_s_top_never_tips(push):
    found = tipping.solve_roll(TRUCK, 1.36, push, INTERVAL)
    assert not found.tips
    assert found.largest_roll < math.radians(1.0)
    assert float(tipping.lowest_walls(TRUCK, 0.0 * push, INTERVAL)) == 0.0


def test_wheels_lifted(push):
    """Those of the far side alone, once each strike; loads of both carry the weight when it is over."""
    found = tipping.solve_roll(TRUCK, WALL, push, INTERVAL)
    for side, start, end in found.lifted():
        assert side == "far"
        assert 0.0 < start < end < found.interval * len(found.rows)
        during = column(found, "load_far")[round(start / INTERVAL) : round(end / INTERVAL)]
        assert (during == 0.0).all()
    assert found.lifted()
    assert column(found, "roll").max() == pytest.approx(found.largest_roll, rel=1e-6)


REFUSED = [
    ({"suspension": -1.0}, "suspension"), ({"roll_inertia": 0.0}, "roll_inertia"),
    ({"track": math.nan}, "track"), ({"friction": -0.1}, "friction"),
]  # fmt: skip


@pytest.mark.parametrize(("change", "key"), REFUSED)
def test_refusals(change, key):
    with pytest.raises(RigidBodyError, match=key):
        replace(TRUCK, **change)


def test_refusals_of_the_wall_and_of_springs_that_are_too_stiff(push):
    with pytest.raises(RigidBodyError, match="wall_height"):
        tipping.solve_roll(TRUCK, 0.0, push, INTERVAL)
    with pytest.raises(RigidBodyError, match="suspension"):
        tipping.solve_roll(replace(TRUCK, suspension=1e16), WALL, push, INTERVAL)
