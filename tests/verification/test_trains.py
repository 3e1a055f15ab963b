"""Verify trains of rigid vehicles by exact answers and another scheme."""

import math
from dataclasses import astuple
from typing import Any

import numpy as np
import pytest
from sampled_impacts import sampled_impacts

from solver import RigidBodyError
from solver.impact import (
    CrushLaw,
    HitchedVehicle,
    ImpactMotion,
    ImpactVehicle,
    Strip,
    WallContact,
    first_touch,
    group_names,
    solve_impact,
    solve_impacts,
    solve_trains,
    train_of,
)
from solver.impact.solve import column_names
from solver.impact.train import Train, lined_up

ANGLE, SPEED, MU = math.radians(15.0), 22.35, 0.47
TRACTOR = ImpactVehicle(6.9, 2.44, 8200.0, 2.9, 34621.0)
TRAILER = ImpactVehicle(14.6, 2.59, 27770.0, 8.0, 497057.0)
HITCH, KINGPIN = 5.6, 0.9


def train_run(vehicles, hinges, k, **more):
    """A straight train at first touch, the first unit the widest."""
    train = train_of(vehicles, WallContact(CrushLaw(k, 0.0, 0.22), MU), hinges)
    return solve_trains(train, straight(vehicles, hinges), **more)


def straight(vehicles=(TRACTOR, TRAILER), hinges=((HITCH, KINGPIN),)):
    """States of a straight train at first touch."""
    ahead = [hitch - unit.front_distance for (hitch, _), unit in zip(hinges, vehicles, strict=False)]
    behind = [unit.front_distance - kingpin for (_, kingpin), unit in zip(hinges, vehicles[1:], strict=True)]
    return lined_up(astuple(first_touch(vehicles[0], ANGLE, SPEED)), np.cumsum(np.add(ahead, behind)))[None]


def both_units(law):
    """The tractor and its trailer."""
    return train_of((TRACTOR, TRAILER), law, [(HITCH, KINGPIN)])


def train_impact(k=2e6, vehicle=TRACTOR, trailers=((TRAILER, HITCH, KINGPIN),), **more):
    law = WallContact(CrushLaw(k, 0.0, 0.22), MU)
    behind = [HitchedVehicle(unit, *hinge) for unit, *hinge in trailers]
    return solve_impact(vehicle, law, first_touch(vehicle, ANGLE, SPEED, behind), trailers=behind, **more)


TRAIN = {  # unit and corner, start, duration, peak, impulse, as of a trial by another scheme
    1e6: [
        (0, "front", 0.0, 0.1268, 390.5e3, 31.43e3), (1, "front", 0.1958, 0.1590, 531.2e3, 52.34e3),
        (0, "rear", 0.2490, 0.0944, 304.0e3, 18.59e3), (0, "front", 0.4190, 0.0447, 405.2e3, 13.29e3),
        (1, "rear", 0.7058, 0.1721, 704.0e3, 77.16e3),
    ],
    2e6: [
        (0, "front", 0.0, 0.0904, 554.0e3, 31.82e3), (1, "front", 0.1958, 0.1204, 797.5e3, 59.50e3),
        (0, "rear", 0.2452, 0.0616, 348.8e3, 13.99e3), (0, "front", 0.4414, 0.0297, 561.3e3, 11.46e3),
        (1, "rear", 0.6983, 0.1217, 996.6e3, 77.23e3),
    ],
}  # fmt: skip


@pytest.mark.parametrize("k", TRAIN)
def test_the_strikes_of_a_tractor_and_trailer(k):
    """Five strikes to the digits of the trial."""
    trains = train_run([TRACTOR, TRAILER], [(HITCH, KINGPIN)], k, end=0.95, strikes=8, step=2e-5)
    rows = sorted(trains.strikes[0][trains.strikes[0, :, 4] > 0.0].tolist(), key=lambda row: row[1])
    for row, (unit, corner, first, duration, peak, impulse) in zip(rows, TRAIN[k], strict=False):
        assert row[0] == 4 * unit + ["front", "rear"].index(corner)
        assert (row[1], row[2] - row[1]) == pytest.approx((first, duration), abs=3e-4)
        assert (row[3], row[4]) == (pytest.approx(peak, rel=1e-3), pytest.approx(impulse, rel=1e-3))


def test_a_trailer_without_mass_changes_nothing():
    light = ImpactVehicle(14.6, 2.44, 1e-4, 8.0, 1e-4 * 17.9)
    train = train_run([TRACTOR, light, light], [(HITCH, KINGPIN), (13.0, KINGPIN)], 2e6, end=0.15, step=2e-5)
    single = train_run([TRACTOR], [], 2e6, end=0.15, step=2e-5)
    assert train.strikes[0, 0] == pytest.approx(single.strikes[0, 0], rel=1e-6, abs=1e-6)
    assert train.state[0, 0] == pytest.approx(single.state[0, 0], rel=1e-6)


def test_the_first_strike_of_a_train_brings_the_impulse_of_its_constrained_mass():
    """The impulse follows from the inverse mass at the corner.

    J = (1 + e) v0 sin(theta)/(n' W d), n = (0, 1), d = (-mu, 1), and W is the inverse mass of the hinged train there.
    """
    masses = np.diag([mass for unit in (TRACTOR, TRAILER) for mass in (unit.mass, unit.mass, unit.inertia)])
    c, s = math.cos(ANGLE), math.sin(ANGLE)

    def rows(along, across, unit):
        x, y = along * c + across * s, across * c - along * s
        out = np.zeros((2, 6))
        out[0, 3 * unit], out[1, 3 * unit + 1] = 1.0, 1.0
        out[:, 3 * unit + 2] = -y, x
        return out

    hinge = rows(TRACTOR.front_distance - HITCH, 0.0, 0) - rows(TRAILER.front_distance - KINGPIN, 0.0, 1)
    system = np.block([[masses, hinge.T], [hinge, np.zeros((2, 2))]])
    corner = rows(TRACTOR.front_distance, -TRACTOR.width / 2.0, 0)
    blow = np.concatenate([corner.T @ np.array([-MU, 1.0]), np.zeros(2)])
    gain = corner[1] @ np.linalg.solve(system, blow)[:6]
    both = (train_impact(k, end=200.0 / math.sqrt(k), tolerance=1e-7) for k in (1e11, 1e13))
    soft, stiff = (motion.strikes[0].impulse for motion in both)
    rigid = stiff + (stiff - soft) / 9.0  # what is missing goes with the duration, k to the -1/2
    assert rigid == pytest.approx(1.22 * 22.35 * s / gain, rel=1e-6)


def flown(w_a, w_b, end=2.0, step=2e-4):
    """A train along X far from the wall, with these spins.

    The hinge is at rest at the start.
    """
    a, b = HITCH - TRACTOR.front_distance, TRAILER.front_distance - KINGPIN
    train = both_units(WallContact(CrushLaw(1e6), MU))
    state = np.array([[[a, 50.0, 0.0, 3.0, w_a * a, w_a], [-b, 50.0, 0.0, 3.0, -w_b * b, w_b]]])
    return train, a, b, solve_trains(train, state, end=end, interval=0.0, step=step)


def test_a_train_in_free_flight():
    """Momentum, angular momentum and energy are constant, the hinges closed."""
    train, a, b, trains = flown(0.4, -0.3)
    rows = trains.rows[0, : int(2.0 / 2e-4), :12].reshape(-1, 2, 6)
    m, inertia = train.mass[:, 0], train.inertia[:, 0]
    x, y, theta, u, v, w = np.moveaxis(rows, -1, 0)
    assert (u @ m, v @ m) == (pytest.approx(u[0] @ m, rel=1e-12), pytest.approx(v[0] @ m, rel=1e-12))
    spin = w @ inertia + (x * v - y * u) @ m
    assert spin == pytest.approx(spin[0], rel=1e-6)
    energy = (u**2 + v**2) @ m / 2.0 + w**2 @ inertia / 2.0
    assert energy == pytest.approx(energy[0], rel=1e-6)
    gap = x[:, 0] - a * np.cos(theta[:, 0]) - (x[:, 1] + b * np.cos(theta[:, 1]))
    assert np.abs(gap).max() < 1e-9


def test_the_hinge_of_two_spinning_units_bears_their_relative_acceleration():
    """m1 m2/(m1 + m2) times the relative acceleration of the centres.

    It is w^2 times their distance in a straight train, and holds at any instant of a folding one.
    """
    behind = [HitchedVehicle(TRAILER, HITCH, KINGPIN)]
    reduced = TRACTOR.mass * TRAILER.mass / (TRACTOR.mass + TRAILER.mass)
    for spins in ((0.4, 0.4), (0.4, -0.3)):
        _, a, b, trains = flown(*spins)
        law = WallContact(CrushLaw(1e6), MU)
        start: Any = None  # plays no part
        rows = trains.rows[0, :10001]
        motion = ImpactMotion(TRACTOR, law, (), 2.0, start, 2e-4, 0.0, 2e-4, rows, tuple(behind))
        t = np.linspace(0.0, 2.0, 1001)
        force, at = motion.hinge_forces(t)[0], motion.at(t)
        velocities = ((at.v_gx, at.v_gx_2), (at.v_gy, at.v_gy_2))
        relative = np.array([np.diff(first - second) / np.diff(t) for first, second in velocities])
        assert force == pytest.approx(reduced * relative, abs=1e-6 * np.abs(force).max())
        if spins[0] == spins[1]:
            assert np.hypot(*force) == pytest.approx(reduced * 0.4**2 * (a + b), rel=1e-6)


def test_a_tow_ball_is_the_hinge_of_a_longer_vehicle_until_the_rear_strikes():
    tractors = (ImpactVehicle(length, 2.44, 8200.0, 2.9, 34621.0) for length in (6.9, 7.1))
    trailers = [(TRAILER, 7.0, 0.9)]
    short, long = (train_impact(vehicle=tractor, trailers=trailers, end=0.12) for tractor in tractors)
    assert long.strikes[0].corner == short.strikes[0].corner
    for name in ("duration", "peak_force", "impulse", "friction_work"):
        value = getattr(short.strikes[0], name)
        assert getattr(long.strikes[0], name) == pytest.approx(value, rel=1e-7)


def test_a_hinge_at_the_trailers_centre_makes_it_a_point_mass():
    """The tractor and a point mass are one rigid vehicle until contact."""
    m, point, a = TRACTOR.mass, 27770.0, TRACTOR.front_distance
    centre = (m * a + point * HITCH) / (m + point)
    inertia = TRACTOR.inertia + m * (a - centre) ** 2 + point * (HITCH - centre) ** 2
    heavier = ImpactVehicle(6.9, 2.44, m + point, centre, inertia)
    one = train_impact(vehicle=heavier, trailers=(), end=0.12, step=2e-5)
    for trailer_inertia in (3e4, 1e5):
        trailer = ImpactVehicle(4.0, 0.5, point, 2.0, trailer_inertia)
        pair = train_impact(trailers=[(trailer, HITCH, 2.0)], end=0.12, step=2e-5)
        for name in ("duration", "peak_force", "impulse", "friction_work", "position"):
            assert getattr(pair.strikes[0], name) == pytest.approx(getattr(one.strikes[0], name), rel=1e-6)
        assert (pair.end.theta, pair.end.omega) == pytest.approx((one.end.theta, one.end.omega), rel=1e-6)


def test_a_wide_trailer_that_touches_first_starts_on_the_wall():
    """Its front corner is 1.5 m behind and 2 m farther outward."""
    wide = ImpactVehicle(10.0, 6.44, 20000.0)
    motion = train_impact(trailers=[(wide, 5.0, 3.5)], end=0.2)
    assert motion.strikes[0].corner == "trailer front"
    assert motion.strikes[0].start == pytest.approx(0.0, abs=1e-6)
    depth = motion.contact_depths(0.0)
    assert depth[0] == pytest.approx(1.5 * math.sin(ANGLE) - 2.0 * math.cos(ANGLE), rel=1e-9)


def test_a_train_ends_after_the_strike_of_its_last_rear():
    motion = train_impact()
    assert [strike.corner for strike in motion.strikes[:5]] == [
        "front", "trailer front", "rear", "front", "trailer rear",
    ]  # fmt: skip
    tractor = motion.strikes[5]  # in progress 0.1 s after that
    assert tractor.start < motion.strikes[4].end + 0.1 < tractor.end
    assert motion.t_end == pytest.approx(tractor.end + tractor.duration, rel=1e-6)
    assert not any(strike.cut for strike in motion.strikes)
    assert motion.error < 1e-5


def test_many_trains_are_what_each_is_alone():
    """Eight trains of different trailers and walls equal single solutions."""
    rng = np.random.default_rng(3)
    n, between = 8, lambda low, high: rng.uniform(low, high, 8)
    shared: dict[str, Any] = {
        "speed": between(18.0, 25.0), "angle": ANGLE,
    }  # fmt: skip
    first: dict[str, Any] = {"length": 6.9, "width": 2.44, "mass": between(7e3, 9e3), "centre_of_mass": 2.9}
    behind: dict[str, Any] = {
        "length": 14.6, "width": 2.59, "mass": between(1e4, 3e4), "hitch": between(5.0, 6.0), "kingpin": 0.9,
    }  # fmt: skip
    behind |= {"centre_of_mass": 8.0}
    friction, k = between(0.2, 0.6), between(1e6, 3e6)

    def contact(friction, k):
        soft = tuple(Strip((at, at), CrushLaw(k, 0.0, 0.22), unit=1) for at in (0.0, 14.6))
        return WallContact(CrushLaw(2e6, 0.0, 0.22), friction, soft)

    options: dict[str, Any] = {"tolerance": 1e-5, "interval": 5e-4}
    many = solve_impacts(**first, **shared, contact=contact(friction, k), trailers=[behind], **options)
    for i in range(n):
        tables = ({key: np.broadcast_to(v, n)[i] for key, v in t.items()} for t in (first, behind, shared))
        one, two, impact = tables
        law = contact(friction[i], k[i])
        hinge = two.pop("hitch"), two.pop("kingpin")
        vehicle, trailer = ImpactVehicle(**one), HitchedVehicle(ImpactVehicle(**two), *hinge)
        state = first_touch(vehicle, ANGLE, impact["speed"], [trailer])
        alone = solve_impact(vehicle, law, state, trailers=[trailer])
        assert many.error[i] < 1e-4
        names = group_names(law, (6.9, 14.6))
        for number, strike in enumerate(alone.strikes):
            assert names[many.group[number, i]] == strike.corner
            values = many.start[number, i], many.impulse[number, i]
            assert values == pytest.approx((strike.start, strike.impulse), rel=1e-5)
        total = many.impulse[:, i][many.group[:, i] >= 0].sum()
        assert many.mean_force[:, i].sum() * 5e-4 == pytest.approx(total)


def test_coarse_steps_of_trains_stay_within_the_stated_error():
    rng, count = np.random.default_rng(6), 12
    behind = {
        "length": 14.6,
        "width": 2.59,
        "mass": rng.uniform(1e4, 3e4, count),
        "hitch": 5.6,
        "kingpin": 0.9,
    }
    inputs: dict[str, Any] = {
        "length": 6.9, "width": 2.44, "mass": rng.uniform(7e3, 9e3, count), "speed": rng.uniform(18.0, 25.0, count),
        "angle": ANGLE, "stiffness": rng.uniform(1e6, 3e6, count), "restitution": rng.uniform(0.02, 0.4, count),
        "friction": MU, "trailers": [behind],
    }  # fmt: skip
    many, exact = sampled_impacts(**inputs), sampled_impacts(**inputs, tolerance=4e-5)
    assert np.all((many.error > 1e-4) & (many.error < 1e-2))
    largest, last = (np.nanmax(impacts.impulse, axis=0) for impacts in (many, exact))
    assert np.all(np.abs(largest / last - 1.0) <= many.error)


def test_what_no_trailer_can_have_is_refused_by_its_number():
    trailer: dict[str, Any] = {
        "length": 14.6, "width": 2.59, "mass": np.array([1e4, -1.0]), "hitch": 5.6, "kingpin": 0.9,
    }  # fmt: skip
    with pytest.raises(RigidBodyError, match=r"trailer\.0\.mass is -1 at index 1"):
        sampled_impacts(length=6.9, width=2.44, mass=8200.0, speed=20.0, angle=0.2, stiffness=1e6, restitution=0.2,
                      friction=0.4, trailers=[trailer])  # fmt: skip


@pytest.mark.parametrize(("restitution", "allowed"), [(0.0, 1e-3), (0.02, 3e-4), (0.3, 3e-4)])
def test_steps_in_parts_agree_with_short_steps_of_one_length(restitution, allowed):
    """Steep lines of unloading are resolved by parts of a step.

    At a restitution of 0.02 unloading is 2 500 times stiffer; a vertical line is of first order.
    """
    law = WallContact(CrushLaw(2e6, 0.0, restitution), MU)
    train, start = both_units(law), straight()
    run = solve_trains(train, start, strikes=8, end=0.4, tolerance=4e-3)
    fine = solve_trains(train, start, strikes=8, end=0.4, step=4e-6)
    firsts = (run.strikes[0], fine.strikes[0])
    rows, exact = (strikes[strikes[:, 4] > 0.05 * np.nanmax(strikes[:, 4])] for strikes in firsts)
    assert rows[:, 0].tolist() == exact[:, 0].tolist() == [0.0, 4.0, 1.0, 0.0][: len(exact)]
    true = np.abs(rows[:, 3:5] / exact[:, 3:5] - 1.0).max()
    assert true < allowed
    assert true <= 1.5 * run.error[0]
    assert run.error[0] < 6e-3  # of durations, too
    assert run.step[0] > 2e-4


def test_rows_of_the_impulse_alone_are_that_column():
    train, start = both_units(WallContact(CrushLaw(2e6, 1e5, 0.1), MU)), straight()
    settings: dict[str, Any] = {"tolerance": 5e-4, "end": 0.4, "interval": 5e-4}
    runs = (solve_trains(train, start, impulse_alone=alone, **settings) for alone in (False, True))
    full, short = (impacts.rows[0, :801] for impacts in runs)
    column = column_names(2).index("impulse_normal")
    assert short[:, 0] == pytest.approx(full[:, column], rel=1e-14)
    assert full[-1, column] > 1e4


def test_a_restitution_near_zero_is_solved_or_its_error_is_stated():
    """Unloading of a period of 20 us has 1024 parts."""
    train, start = both_units(WallContact(CrushLaw(2e6, 0.0, 1e-4), MU)), straight()
    nearly_plastic = solve_trains(train, start, tolerance=4e-3, strikes=8, end=0.2)
    plastic_train = train._replace(restitution=0.0 * train.restitution)
    plastic = solve_trains(plastic_train, start, tolerance=4e-3, strikes=8, end=0.2)
    assert nearly_plastic.strikes[0, 0, 3:5] == pytest.approx(plastic.strikes[0, 0, 3:5], rel=2e-3)
    assert nearly_plastic.error[0] < 4e-2


@pytest.mark.parametrize(
    "crushes", [((0.5e6, 0.03), (5e6, 0.1)), ((0.5e6, 0.3), (2e6, 0.03))], ids=["fewer", "more"]
)
def test_a_refined_train_has_another_number_of_strikes(crushes):
    """The result has room for all strikes of both trains."""
    trains, room = [both_units(WallContact(CrushLaw(k, 0.0, e), MU)) for k, e in crushes], 3
    both = Train(
        *(a if a.ndim == 1 else np.concatenate([a, b], axis=-1) for a, b in zip(*trains, strict=True))
    )
    start = straight()
    many = solve_trains(both, np.concatenate([start, start]), tolerance=1e-3, strikes=room, end=1.5)
    for i, train in enumerate(trains):
        alone = solve_trains(train, start, tolerance=1e-3, strikes=room, end=1.5).strikes[0]
        assert len(alone) > room
        assert np.array_equal(many.strikes[i, : len(alone)], alone, equal_nan=True)
        assert np.isnan(many.strikes[i, len(alone) :]).all()
