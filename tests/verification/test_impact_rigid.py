"""Verify whole impacts of rigid vehicles by closed forms and conservation."""

import math
from functools import partial
from typing import Any

import numpy as np
import pytest

from solver import RectangularBody, RigidBodyError, corner_impulse
from solver.impact import (
    CrushLaw,
    HitchedVehicle,
    ImpactState,
    ImpactVehicle,
    Strip,
    Train,
    TyreAxle,
    WallContact,
    first_touch,
    solve_impact,
    solve_trains,
    train_of,
)
from solver.impact.train import greatest_inertia

TRUCK = ImpactVehicle(10.0, 2.438, 9979.0)
SPEED, ANGLE, MU = 56 * 0.44704, math.radians(15.0), 0.47


def point(at, **more):
    """A strip of one place."""
    return Strip((at, at), CrushLaw(1e6), **more)


def with_line(e):
    """Both corners and a line along the side."""
    corners = (Strip((at, at), CrushLaw(2e6, 0.0, e)) for at in (0.0, TRUCK.length))
    return (*corners, Strip((0.0, TRUCK.length), CrushLaw(1e6, 0.0, e)))


def impact(k=2e6, e=0.22, mu=MU, angle=15.0, force=0.0, **more):
    vehicle, strips = more.pop("vehicle", TRUCK), more.pop("strips", ())
    contact = WallContact(CrushLaw(k, force, e), mu, strips)
    touch = first_touch(vehicle, math.radians(angle), SPEED, more.get("trailers", ()), contact=contact)
    return solve_impact(vehicle, contact, touch, **more)


# --- a point mass on the crush law ---

BOX = ImpactVehicle(4.0, 2.0, 1500.0)
UPRIGHT = math.pi / 2.0 - math.atan(0.5)  # the front corner is below the centre of mass
REACH = math.hypot(2.0, 1.0)
CLOSING = 7.0


def head_on(law, **more):
    """A corner below the centre of mass is a point mass."""
    start = ImpactState(0.0, REACH, UPRIGHT, 0.0, -CLOSING, 0.0)
    return solve_impact(BOX, WallContact(law, 0.0), start, end=0.3, **more)


@pytest.mark.parametrize(("force", "e"), [(0.0, 0.22), (3e5, 0.22), (3e5, 0.7)])
def test_the_order_is_two(force, e):
    """Errors of a point mass, and of the truck's second strike."""
    m, k = BOX.mass, 2e6
    top = math.sqrt(force**2 + k * m * CLOSING**2)
    steps = np.array([4e-4, 2e-4, 1e-4, 5e-5])
    runs = [head_on(CrushLaw(k, force, e), step=h) for h in steps]
    assert [run.step for run in runs] == pytest.approx(steps, rel=1e-3)
    off = [abs(run.strikes[0].impulse / ((1.0 + e) * m * CLOSING) - 1.0) for run in runs]
    assert np.polyfit(np.log(steps), np.log(off), 1)[0] > 1.8
    assert abs(runs[-1].strikes[0].peak_force / top - 1.0) < 1e-5
    trucks = [impact(force=force, e=e, step=h).strikes[1].impulse for h in (*steps, 2e-6)]
    off = np.abs(np.array(trucks[:-1]) / trucks[-1] - 1.0)
    assert np.polyfit(np.log(steps), np.log(off), 1)[0] > 1.6
    assert off[-1] < 1e-5


def test_the_stated_error_is_that_of_twice_the_step():
    """It is not below the true error, and small by default."""
    fine = impact(step=1e-6)
    for step in (1e-4, 2e-5):
        run = impact(step=step)
        pairs = zip(run.strikes[:2], fine.strikes[:2], strict=True)
        assert max(abs(a.impulse / b.impulse - 1.0) for a, b in pairs) < run.error < 1e-3
    assert impact(tolerance=1e-7).error < 2e-6
    assert impact().error < 1e-5


# --- the first strike, and the truck ---


@pytest.mark.parametrize("e", [0.05, 0.22, 0.9])
def test_a_stiff_corner_gives_newtons_impulse(e):
    """The error of omega is in proportion to the root of 1/k."""
    newton = corner_impulse(RectangularBody(10.0, 2.438, 9979.0), SPEED, ANGLE, MU, e, "newton")
    runs = [impact(k, e, end=0.02) for k in (1e9, 4e9)]  # a gap like 1/sqrt(k)
    coarse, fine = (run.end.omega for run in runs)
    assert abs(fine / newton.omega - 1.0) == pytest.approx(0.5 * abs(coarse / newton.omega - 1.0), rel=0.02)
    assert 2.0 * fine - coarse == pytest.approx(newton.omega, rel=1e-5)
    impulse = 2.0 * runs[1].strikes[0].impulse - runs[0].strikes[0].impulse
    assert impulse * math.hypot(1.0, MU) == pytest.approx(newton.impulse, rel=1e-5)


def effective_mass():
    """Effective mass of the front corner, and its lever over I.

    1/m_eff = 1/m + r^2 cos(phi) (cos(phi) - mu sin(phi))/I.
    """
    phi, r = ANGLE + math.atan(0.2438), math.hypot(10.0, 2.438) / 2.0
    lever = math.cos(phi) - MU * math.sin(phi)
    effective = 1.0 / (1.0 / TRUCK.mass + r * r * math.cos(phi) * lever / TRUCK.inertia)
    return effective, r * lever / TRUCK.inertia


def test_the_first_strike_of_the_truck():
    """m_eff 3677 kg, J 29.06 kN s, omega 1.1059."""
    effective, lever = effective_mass()
    impulse = 1.22 * SPEED * math.sin(ANGLE) * effective
    assert (effective, impulse) == (pytest.approx(3677.0, abs=0.5), pytest.approx(29.06e3, abs=5.0))
    runs = [impact(k, end=0.01, tolerance=1e-6) for k in (1e10, 4e10, 16e10)]
    first, second, third = (run.strikes[0].impulse for run in runs)
    extrapolated = (4.0 * (2.0 * third - second) - (2.0 * second - first)) / 3.0
    assert extrapolated == pytest.approx(impulse, rel=1e-6)
    assert runs[2].end.omega == pytest.approx(impulse * lever, rel=1e-5)


@pytest.mark.parametrize("speed", [1e-6, 1e-5, 1e-4])
def test_a_slow_vehicle_brings_the_impulse_of_its_effective_mass(speed):
    """(1 + e) m_eff v, except rounding of positions of 1e-15 m.

    The crush is 1e-7 m at 1e-6 m/s.
    """
    effective, _ = effective_mass()
    contact = WallContact(CrushLaw(2e6, 0.0, 0.22), MU)
    strike = solve_impact(TRUCK, contact, first_touch(TRUCK, ANGLE, speed), 0.2).strikes[0]
    near = speed + 3e-11 / speed
    assert strike.impulse == pytest.approx(1.22 * speed * math.sin(ANGLE) * effective, rel=near)
    assert strike.duration == pytest.approx(math.pi / 2.0 * 1.22 * math.sqrt(effective / 2e6), rel=near)


TABLE = {  # corner, start, duration, peak, impulse, as of an explicit trial run
    1e6: (
        ("front", 0.0, 0.1143, 390.7e3, 28.40e3), ("rear", 0.2998, 0.0938, 447.0e3, 26.74e3),
        ("front", 0.4613, 0.0481, 435.6e3, 16.47e3), 396.8e3,
    ),
    2e6: (
        ("front", 0.0, 0.0812, 553.4e3, 28.58e3), ("rear", 0.2944, 0.0664, 630.6e3, 26.68e3),
        ("front", 0.4460, 0.0339, 615.8e3, 16.41e3), 493.7e3,
    ),
}  # fmt: skip


@pytest.mark.parametrize("k", TABLE)
def test_the_strikes_of_the_truck(k):
    """Within a step of the trial, 1e-4 s, and its printed digits."""
    motion = impact(k, end=0.6)
    *rows, mean = TABLE[k]
    for strike, (corner, start, duration, peak, impulse) in zip(motion.strikes, rows, strict=False):
        assert strike.corner == corner
        assert (strike.start, strike.duration) == pytest.approx((start, duration), abs=1.01e-4)
        assert strike.peak_force == pytest.approx(peak, abs=0.051e3)
        assert strike.impulse == pytest.approx(impulse, abs=0.006e3)
    t = np.linspace(0.0, 0.6, 60_001)
    impulse = motion.at(t).impulse_normal
    assert (impulse[5000:] - impulse[:-5000]).max() / 0.05 == pytest.approx(mean, abs=0.051e3)


def test_where_it_strikes():
    """The force attacks at the front, then at the rear."""
    front, rear = impact().strikes[:2]
    assert (front.point_of_attack, rear.point_of_attack) == pytest.approx((0.0, 10.0))
    assert 0.0 < front.position < SPEED * front.end
    assert front.impulse_tangential == pytest.approx(-MU * front.impulse)
    assert front.friction_work < 0.0


# --- conservation ---

TYRES = (TyreAxle(1.3, 0.7, 6.0), TyreAxle(7.5, 0.6, 5.0))
CASES: dict[str, dict[str, Any]] = {
    **{f"k {k:.0e}": {"k": k} for k in (1e4, 1e5, 2e6, 1e7, 1e9)},
    **{f"e {e}": {"e": e} for e in (0.0, 0.05, 0.9, 1.0)},
    **{f"angle {angle}": {"angle": angle} for angle in (1.0, 30.0, 60.0, 85.0)},
    **{f"mu {mu} angle {a}": {"mu": mu, "angle": a} for mu in (0.0, 2.0) for a in (15.0, 45.0, 85.0)},
    "e 0, mu 2, angle 85": {"e": 0.0, "mu": 2.0, "angle": 85.0},
    "e 0, soft": {"e": 0.0, "k": 1e5, "mu": 0.0},
    **{f"F0, e {e}": {"force": 1e5, "e": e} for e in (0.0, 0.22, 0.7)},
    "off centre": {"vehicle": ImpactVehicle(10.0, 2.438, 9979.0, 4.0, 6e4)},
    "tyres": {"axles": TYRES},
    "train on tyres": {
        "trailers": [HitchedVehicle(ImpactVehicle(12.0, 2.5, 20000.0, 6.0), 7.0, 1.0)],
        "axles": (*TYRES, TyreAxle(9.5, 0.7, unit=1), TyreAxle(10.5, 0.7, unit=1)),
    },
    "line": {"strips": with_line(0.22), "end": 0.4},
    "line, e 0, mu 2, 0.05 s": {"strips": with_line(0.0), "mu": 2.0, "angle": 70.0, "end": 0.05},
    "line, e 0, mu 2": {"strips": with_line(0.0), "mu": 2.0, "angle": 70.0, "end": 0.2},
    "whole vehicle behind the wall, stuck": {
        "vehicle": ImpactVehicle(5.285, 2.121, 29888.0, 2.1878, 53924.0), "k": 1.2e5, "e": 0.69, "mu": 1.67,
        "angle": 73.0, "end": 1.0,
    },
}  # fmt: skip


LONG = {"line, e 0, mu 2"}


def momenta(motion, r):
    """Momenta along, across and about the origin, of all units.

    Then impulses, their moment and the work of the tyres.
    """
    sums, tyres = np.zeros((3, r.t.size)), np.zeros((4, r.t.size))
    for k, body in enumerate(motion.vehicles, 1):
        end = "" if k == 1 else f"_{k}"
        x, y, u, v, w = (getattr(r, f"{name}{end}") for name in ("x_g", "y_g", "v_gx", "v_gy", "omega"))
        sums += body.mass * u, body.mass * v, body.inertia * w + body.mass * (x * v - y * u)
        if motion.axles:
            names = ("impulse_tangential", "impulse_normal", "impulse_angular", "work")
            tyres += [getattr(r, f"tyre_{name}{end}") for name in names]
    return *sums, *tyres


@pytest.mark.parametrize(
    "case", [pytest.param(c, marks=pytest.mark.long if c in LONG else ()) for c in CASES]
)
def test_momentum_energy_and_friction(case):
    """No tension, Coulomb's cone, momentum by impulses, and energy balance."""
    motion = impact(**CASES[case])
    m, mu = sum(body.mass for body in motion.vehicles), motion.contact.friction
    r = motion.at(motion.interval * np.arange(0, len(motion.rows) - 1, 1 + len(motion.rows) // 2000))
    along, across, spin, tyres_along, tyres_across, tyres_spin, tyre_work = momenta(motion, r)
    top = r.force_normal.max()
    assert r.force_normal.min() >= 0.0
    assert np.max(np.abs(r.force_tangential) - mu * r.force_normal) <= 1e-9 * top
    assert across - across[0] == pytest.approx(r.impulse_normal + tyres_across, abs=1e-9 * m * SPEED)
    assert along - along[0] == pytest.approx(r.impulse_tangential + tyres_along, abs=1e-9 * m * SPEED)
    assert spin - spin[0] == pytest.approx(r.impulse_angular + tyres_spin, abs=1e-6 * np.abs(spin).max())
    balance = r.kinetic_energy + r.crush_energy_stored + r.crush_energy_lost - r.friction_work - tyre_work
    assert balance / balance[0] == pytest.approx(1.0, abs=1e-6)
    absorbed = r.crush_energy_stored + r.crush_energy_lost
    assert r.crush_work == pytest.approx(absorbed, abs=1e-6 * balance[0])
    assert np.all(np.diff(r.friction_work) <= 1e-9 * balance[0])
    assert np.all(np.diff(r.crush_energy_lost) >= -1e-12 * balance[0])
    total, last = math.fsum(strike.impulse for strike in motion.strikes), motion.at(motion.t_end)
    assert total == pytest.approx(float(last.impulse_normal), rel=1e-6)
    absorbed = math.fsum(strike.energy_absorbed for strike in motion.strikes)
    assert absorbed == pytest.approx(float(last.crush_work), rel=1e-5, abs=1e-6 * balance[0])


def test_the_forces_are_what_the_impulses_integrate():
    """Trapezia of the forces, and velocities between the rows."""
    motion = impact()
    t = motion.interval * np.arange(len(motion.rows) - 1)
    r, scale = motion.at(t), TRUCK.mass * SPEED
    for force, impulse in ((r.force_normal, r.impulse_normal), (r.force_tangential, r.impulse_tangential)):
        area = np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(t))
        assert area == pytest.approx(impulse[1:], abs=2e-5 * scale)
    nodes, weights = np.polynomial.legendre.leggauss(4)
    edges = np.linspace(0.0, motion.t_end, 2001)
    inside = motion.at((edges[:-1, None] + edges[1:, None]) / 2.0 + np.diff(edges)[:, None] / 2.0 * nodes)
    travel = (inside.v_gy @ weights) * np.diff(edges) / 2.0
    assert np.diff(motion.at(edges).y_g) == pytest.approx(travel, abs=1e-8)


def test_a_plastic_corner_is_held_while_the_other_presses_on_it():
    """The rear corner rests at its greatest crush until the front stops.

    For e = 0 the force on it is then below its strength.
    """
    motion = impact(e=0.0)
    rear, front = motion.strikes[1:3]
    assert (motion.t_end, rear.end) == (pytest.approx(rear.end + 0.1), pytest.approx(front.end, abs=2e-5))
    t = np.linspace(front.end - 0.015, front.end - 1e-4, 50)
    front_depth, depth, *_ = motion.contact_depths(t)
    assert np.ptp(depth) < 1e-6
    rear_force = motion.at(t).force_normal - 2e6 * front_depth
    assert np.all((rear_force > 0.0) & (rear_force < rear.peak_force))


# --- friction ---


def pressed_block(mu, speed, end, push=0.0):
    """State of a block of 1 t, pressed on with 10 kN.

    It does not rotate, and a force `push` [N] acts along the wall.
    """
    one = np.ones((1, 1))
    law = 1e-3 * one, 1e4 * one, math.inf * one, 0.0 * one, 0.0 * one, 0.0 * one, mu * one
    unit = np.zeros(1, dtype=np.int64)
    load = np.array([push, 0.0, 0.0]).reshape(1, 3, 1)
    block = Train(1e3 * one, 1e30 * one, one[:0], one[:0], unit, unit, 0.0 * one, -one, *law, load)
    return solve_trains(block, np.array([[[0.0, 1.0, 0.0, speed, -10.0, 0.0]]]), end=end).state[0, 0]


def test_a_sliding_block_stops_after_its_way():
    """v^2 m/(2 mu N0), and stays there."""
    mu, v = 0.4, 3.0
    for end in (0.8, 0.95):
        x, _, _, v_x, *_ = pressed_block(mu, v, end)
        assert x == pytest.approx(v * v * 1e3 / (2.0 * mu * 1e4), rel=1e-6)
        assert v_x == pytest.approx(0.0, abs=1e-12)
    half = v * 1e3 / (2.0 * mu * 1e4)
    assert pressed_block(mu, v, half)[3] == pytest.approx(v / 2.0, rel=1e-6)
    assert pressed_block(mu, -v, half)[3] == pytest.approx(-v / 2.0, rel=1e-6)


@pytest.mark.parametrize("push", [-0.9, 0.9, -1.5])
def test_a_pushed_block_sticks_below_its_friction_and_turns_above(push):
    """It stops, and returns for a push above the friction.

    It stops after v^2 m/(2 (mu N0 - T)), and returns at (T - mu N0)/m.
    """
    v, limit, end = 0.3, 4.0, 0.95  # mu N0/m [m/s^2]
    slowing, back = limit * (1.0 - push), limit * min(push + 1.0, 0.0)
    rest = end - v / slowing
    x, _, _, v_x, *_ = pressed_block(0.4, v, end, 1e3 * limit * push)
    assert x == pytest.approx(v * v / (2.0 * slowing) + 0.5 * back * rest**2, rel=1e-5)
    assert v_x == pytest.approx(back * rest, rel=1e-5, abs=1e-12)


@pytest.mark.parametrize("e", [0.22, 0.7, 1.0])
def test_a_point_mass_bounces_under_gravity(e):
    """It touches after sqrt(2h/g), and again after 2 e v/g.

    From then on it returns along the line that the first strike ended on, at e v again.
    """
    g, height = 40.0, 0.8
    v = math.sqrt(2.0 * g * height)
    train = train_of([BOX], WallContact(CrushLaw(2e6, 0.0, e), 0.0))
    train.load[0, 1] = -BOX.mass * g
    start = np.array([[[0.0, REACH + height, UPRIGHT, 0.0, 0.0, 0.0]]])
    strikes = solve_trains(train, start, end=1.2, strikes=8, step=2e-5).strikes[0]
    first, last, impulse = strikes[:, 1], strikes[:, 2], strikes[:, 4]
    assert first[0] == pytest.approx(math.sqrt(2.0 * height / g), rel=1e-5)
    assert first[1:3] - last[:2] == pytest.approx(2.0 * e * v / g, rel=1e-5)
    change = impulse[:2] / BOX.mass - g * (last - first)[:2]
    assert change == pytest.approx([(1.0 + e) * v, 2.0 * e * v], rel=1e-5)


def test_a_steep_vehicle_sticks_and_another_slides():
    """The corner sticks for a friction above the ratio at rest."""
    for mu, sticks in ((2.0, True), (0.2, False)):
        motion = impact(k=1e5, mu=mu, angle=60.0)
        front = motion.strikes[0]
        r = motion.at(np.linspace(0.3 * front.end, 0.6 * front.end, 200))
        ratio = np.abs(r.force_tangential) / r.force_normal
        assert np.all(ratio <= mu * (1.0 + 1e-9))
        assert bool(np.any(ratio < 0.999 * mu)) == sticks


# --- a line along the side ---


@pytest.mark.parametrize("points", [64, pytest.param(128, marks=pytest.mark.long)])
def test_a_line_converges_with_its_points(points, monkeypatch):
    """Doubling changes impulses by 1e-3, their sum by 1e-4."""
    runs = []
    for count in (points, 2 * points):
        monkeypatch.setattr("solver.impact.strips.LINE_POINTS", count)
        runs.append(impact(strips=with_line(0.22), end=0.41, step=4e-5))
    for coarse, fine in zip(runs[0].strikes[:3], runs[1].strikes[:3], strict=True):
        assert coarse.corner == fine.corner
        assert coarse.impulse == pytest.approx(fine.impulse, rel=64e-3 / points)
        few = 1.0 if coarse.corner in ("front", "rear") else 5.0  # those in contact of a line
        assert coarse.peak_force == pytest.approx(fine.peak_force, rel=few * 64e-3 / points)
    coarse, fine = (math.fsum(strike.impulse for strike in motion.strikes[:3]) for motion in runs)
    assert coarse == pytest.approx(fine, rel=64e-4 / points)


def test_a_line_pressed_flat_is_a_spring_of_its_stiffness_times_length():
    """F = v sqrt(k m) of both corners and the line."""
    k, law = 1e5, CrushLaw(1e5, 0.0, 1.0)
    strips = (*(Strip((at, at), law) for at in (0.0, 10.0)), Strip((0.0, 10.0), CrushLaw(2e5, 0.0, 1.0)))
    start = ImpactState(0.0, TRUCK.width / 2.0, 0.0, 0.0, -0.1, 0.0)  # so that the ends do not reach the wall
    motion = solve_impact(TRUCK, WallContact(None, 0.3, strips), start, end=0.05)
    total = 2.0 * k + 2e5 * TRUCK.length
    r = motion.at(np.linspace(0.0, 0.05, 41))
    w = math.sqrt(total / TRUCK.mass)
    assert r.force_normal == pytest.approx(0.1 * total / w * np.sin(w * r.t), rel=1e-6, abs=1.0)
    assert {strike.corner for strike in motion.strikes} == {"front", "rear", "0 to 10 m"}


# --- refusals ---


def start(y_g=2.0, v_gy=-1.0):
    state = ImpactState(0.0, y_g, 0.0, 20.0, v_gy, 0.0)
    return solve_impact(TRUCK, WallContact(CrushLaw(1e6), 0.4), state)


BOX_OF_A_TON = partial(ImpactVehicle, 4.0, 2.0, 1e3)
PAIR: Any = [1.0, 2.0]
TOUCH = first_touch(TRUCK, ANGLE, SPEED)

REFUSED = [
    ("length", lambda: ImpactVehicle(0.0, 2.0, 1e3), "positive"),
    ("mass", lambda: ImpactVehicle(4.0, 2.0, -1e3), "positive"),
    ("centre_of_mass", lambda: BOX_OF_A_TON(4.1), "between 0 and the length, 4 m"),
    ("centre_of_mass", lambda: BOX_OF_A_TON(0.0), "between 0 and the length, 4 m"),
    ("centre_of_mass", lambda: BOX_OF_A_TON(0.1), "closer to the middle"),
    ("yaw_inertia", lambda: BOX_OF_A_TON(2.0, 0.0), "from 0.001 I to I"),
    ("yaw_inertia", lambda: BOX_OF_A_TON(2.0, 4.99), "from 0.001 I to I"),
    ("yaw_inertia", lambda: BOX_OF_A_TON(2.0, 5001.0), "to I = m (a (L - a) + B^2/4) = 5000"),
    ("yaw_inertia", lambda: BOX_OF_A_TON(1.0, math.nan), "from 0.001 I to I"),
    ("stiffness", lambda: CrushLaw(-1.0), "positive and finite"),
    ("stiffness", lambda: CrushLaw(math.inf), "positive and finite"),
    ("stiffness", lambda: solve_impact(TRUCK, WallContact(CrushLaw(PAIR), MU), TOUCH), "a number"),
    ("initial_force", lambda: CrushLaw(1e6, -1.0), "0 or more"),
    ("restitution", lambda: CrushLaw(1e6, 0.0, 1.1), "from 0 to 1"),
    ("restitution", lambda: CrushLaw(1e6, 0.0, math.nan), "from 0 to 1"),
    ("restitution", lambda: CrushLaw(1e6, 1.0, 0.8), "at most sqrt(1/2)"),
    ("friction", lambda: WallContact(CrushLaw(1e6), -0.1), "0 or more"),
    ("strip.0.at", lambda: impact(strips=(point(10.5),)), "from 0 to the length, 10 m"),
    ("strip.0.at", lambda: impact(strips=(Strip((2.0, 1.0), CrushLaw(1e6)),)), "two places rearwards"),
    (
        "strip.0.inset",
        lambda: impact(strips=(point(0.0, inset=1.3),)),
        "less than half of the width, 1.219 m",
    ),
    ("strip.1.unit", lambda: impact(strips=(point(0.0), point(0.0, unit=1))), "below the number of units, 1"),
    ("contact", lambda: first_touch(TRUCK, 0.3, 25.0, contact=WallContact(None, MU)), "a strip of this unit"),
    ("angle", lambda: first_touch(TRUCK, 0.0, 25.0), "between 0 and pi/2"),
    ("angle", lambda: first_touch(TRUCK, 1.6, 25.0), "between 0 and pi/2"),
    ("speed", lambda: first_touch(TRUCK, 0.3, 0.0), "positive"),
    ("state", lambda: ImpactState(0.0, 1.0, math.nan, 0.0, 0.0, 0.0), "six finite numbers"),
    ("state", lambda: start(y_g=1.0), "outside the wall"),
    ("state", lambda: start(v_gy=1.0), "a motion towards the wall"),
    ("end", lambda: impact(end=0.0), "positive"),
    ("end", lambda: impact(step=-1.0), "positive"),
    ("time", lambda: impact(end=0.1).at(0.2), "from 0 to 0.1 s"),
]


@pytest.mark.parametrize(("key", "attempt", "allowed"), REFUSED)
def test_what_cannot_be_is_refused(key, attempt, allowed):
    with pytest.raises(RigidBodyError) as caught:
        attempt()
    assert caught.value.key == key
    assert allowed in str(caught.value)


def test_the_greatest_inertia_is_that_of_masses_at_the_corners():
    """A quarter of the mass is at each corner."""
    for a, front in ((2.0, 0.5), (1.0, 0.75)):
        places = [(x, y, mass / 2.0) for x, mass in ((0.0, front), (4.0, 1.0 - front)) for y in (-1.0, 1.0)]
        inertia = 1e3 * sum(mass * ((x - a) ** 2 + y * y) for x, y, mass in places)
        assert sum(x * mass for x, _, mass in places) == pytest.approx(a)
        assert ImpactVehicle(4.0, 2.0, 1e3, a, inertia)
        assert greatest_inertia(4.0, 2.0, 1e3, a) == pytest.approx(inertia)
