"""Verification: the whole impact of the rigid vehicle: limits, conservation, friction, what is refused."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from solver import RectangularBody, RigidBodyError, corner_impulse
from solver.impact import (
    CrushLaw,
    ImpactMotion,
    ImpactState,
    ImpactVehicle,
    WallContact,
    first_touch,
    solve_impact,
)

pytestmark = pytest.mark.verification

TRUCK = ImpactVehicle(10.0, 2.438, 9979.0)
SPEED, ANGLE, MU = 56 * 0.44704, math.radians(15.0), 0.47


def impact(
    k: float = 2e6, e: float = 0.22, mu: float = MU, angle: float = 15.0, force: float = 0.0, **more: Any
) -> ImpactMotion:
    vehicle, side = more.pop("vehicle", TRUCK), more.pop("side", None)
    contact = WallContact(CrushLaw(k, force, e), mu, side, more.pop("side_points", 4))
    return solve_impact(vehicle, contact, first_touch(vehicle, math.radians(angle), SPEED), **more)


@pytest.mark.parametrize("e", [0.05, 0.22, 0.9])
def test_a_stiff_corner_gives_newtons_impulse(e: float) -> None:
    """omega after the first strike converges on Stage 1 with k, whose error falls with 1/k."""
    newton = corner_impulse(RectangularBody(10.0, 2.438, 9979.0), SPEED, ANGLE, MU, e, "newton")
    runs = [impact(k, e, end=0.02) for k in (1e9, 4e9)]  # a gap like 1/sqrt(k)
    coarse, fine = (float(run.at(0.02).omega) for run in runs)
    assert abs(fine / newton.omega - 1.0) == pytest.approx(0.5 * abs(coarse / newton.omega - 1.0), rel=0.02)
    assert 2.0 * fine - coarse == pytest.approx(newton.omega, rel=1e-5)
    impulse = 2.0 * runs[1].strikes[0].impulse - runs[0].strikes[0].impulse
    assert impulse * math.hypot(1.0, MU) == pytest.approx(newton.impulse, rel=1e-5)


def test_the_first_strike_of_the_truck() -> None:
    """m_eff 3677 kg, J 29.06 kN s, omega 1.1059, from 1/m_eff = 1/m + r^2 cos(phi) (cos(phi) - mu sin(phi))/I."""
    phi, r = ANGLE + math.atan(0.2438), math.hypot(10.0, 2.438) / 2.0
    lever = math.cos(phi) - MU * math.sin(phi)
    effective = 1.0 / (1.0 / TRUCK.mass + r * r * math.cos(phi) * lever / TRUCK.inertia)
    impulse = 1.22 * SPEED * math.sin(ANGLE) * effective
    assert (effective, impulse) == (pytest.approx(3677.0, abs=0.5), pytest.approx(29.06e3, abs=5.0))
    runs = [impact(k, end=0.01) for k in (1e10, 4e10, 16e10)]
    first, second, third = (run.strikes[0].impulse for run in runs)
    extrapolated = (4.0 * (2.0 * third - second) - (2.0 * second - first)) / 3.0
    assert extrapolated == pytest.approx(impulse, rel=1e-8)
    assert float(runs[2].at(0.01).omega) == pytest.approx(impulse * r * lever / TRUCK.inertia, rel=1e-5)


@pytest.mark.parametrize("speed", [1e-6, 1e-5, 1e-4])
def test_a_slow_vehicle_brings_the_impulse_of_its_effective_mass(speed: float) -> None:
    """(1 + e) m_eff v in the limit; the steps' tolerance of 1e-11 m is a share of its crush, 1e-7 m at 1e-6 m/s."""
    phi, r = ANGLE + math.atan(0.2438), math.hypot(10.0, 2.438) / 2.0
    lever = math.cos(phi) - MU * math.sin(phi)
    effective = 1.0 / (1.0 / TRUCK.mass + r * r * math.cos(phi) * lever / TRUCK.inertia)
    contact = WallContact(CrushLaw(2e6, 0.0, 0.22), MU)
    strike = solve_impact(TRUCK, contact, first_touch(TRUCK, ANGLE, speed), 0.2).strikes[0]
    near = speed + 3e-11 / speed
    assert strike.impulse == pytest.approx(1.22 * speed * math.sin(ANGLE) * effective, rel=near)
    assert strike.duration == pytest.approx(math.pi / 2.0 * 1.22 * math.sqrt(effective / 2e6), rel=near)


TABLE = {  # corner, start, duration, peak, impulse, as of an explicit trial run
    1e6: (
        ("front", 0.0, 0.1143, 390.7e3, 28.40e3),
        ("rear", 0.2998, 0.0938, 447.0e3, 26.74e3),
        ("front", 0.4613, 0.0481, 435.6e3, 16.47e3),
        396.8e3,
    ),
    2e6: (
        ("front", 0.0, 0.0812, 553.4e3, 28.58e3),
        ("rear", 0.2944, 0.0664, 630.6e3, 26.68e3),
        ("front", 0.4460, 0.0339, 615.8e3, 16.41e3),
        493.7e3,
    ),
}


@pytest.mark.parametrize("k", TABLE)
def test_the_strikes_of_the_truck(k: float) -> None:
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


CASES: dict[str, dict[str, Any]] = {
    **{f"k {k:.0e}": {"k": k} for k in (1e4, 1e5, 2e6, 1e7, 1e9)},
    **{f"e {e}": {"e": e} for e in (0.0, 0.05, 0.9, 1.0)},
    **{f"angle {angle}": {"angle": angle} for angle in (1.0, 30.0, 60.0, 85.0)},
    **{f"mu {mu} angle {a}": {"mu": mu, "angle": a} for mu in (0.0, 2.0) for a in (15.0, 45.0, 85.0)},
    "e 0, mu 2, angle 85": {"e": 0.0, "mu": 2.0, "angle": 85.0},
    "e 0, soft": {"e": 0.0, "k": 1e5, "mu": 0.0},
    **{f"F0, e {e}": {"force": 1e5, "e": e} for e in (0.0, 0.22, 0.7)},
    "off centre": {"vehicle": ImpactVehicle(10.0, 2.438, 9979.0, 4.0, 6e4)},
    "layer": {"side": CrushLaw(1e6, 0.0, 0.22), "end": 0.4},
    "layer, e 0, mu 2": {"side": CrushLaw(1e6, 0.0, 0.0), "e": 0.0, "mu": 2.0, "angle": 70.0, "end": 0.2},
    "whole vehicle behind the wall, stuck": {
        "vehicle": ImpactVehicle(5.285, 2.121, 29888.0, 2.1878, 53924.0), "k": 1.2e5, "e": 0.69, "mu": 1.67,
        "angle": 73.0, "end": 1.0,
    },
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_momentum_energy_and_friction(case: str) -> None:
    """No pull, Coulomb's cone, momenta against the forces' integrals, and the ledger of energy."""
    motion = impact(**CASES[case])
    vehicle, mu = motion.vehicle, motion.contact.friction
    instants = np.union1d(np.linspace(0.0, motion.t_end, 2001), motion.event_times)
    r, points = motion.at(instants), motion.points_at(instants)
    m, top = vehicle.mass, points.normal.max()
    assert points.normal.min() >= 0.0
    assert np.max(np.abs(points.tangential) - mu * points.normal) <= 1e-9 * top
    assert r.force_normal == pytest.approx(points.normal.sum(axis=0), abs=1e-12 * top)
    assert m * (r.v_gy - r.v_gy[0]) == pytest.approx(r.impulse_normal, abs=1e-9 * m * SPEED)
    assert m * (r.v_gx - r.v_gx[0]) == pytest.approx(r.impulse_tangential, abs=1e-9 * m * SPEED)
    spin = vehicle.inertia * r.omega + m * (r.x_g * r.v_gy - r.y_g * r.v_gx)
    assert spin - spin[0] == pytest.approx(r.impulse_angular, abs=1e-9 * np.abs(spin).max())
    ledger = r.kinetic_energy + r.crush_energy_stored + r.crush_energy_lost - r.friction_work
    assert ledger / ledger[0] == pytest.approx(1.0, abs=1e-9)
    assert r.crush_work == pytest.approx(r.crush_energy_stored + r.crush_energy_lost, abs=1e-9 * ledger[0])
    assert np.all(np.diff(r.friction_work) <= 1e-12 * ledger[0])
    assert np.all(np.diff(r.crush_energy_lost) >= -1e-12 * ledger[0])


@pytest.mark.parametrize("case", CASES)
def test_the_forces_are_what_the_impulses_integrate(case: str) -> None:
    """Gauss quadrature of the recorded forces between the instants where they are not smooth."""
    motion = impact(**CASES[case])
    nodes, weights = np.polynomial.legendre.leggauss(8)
    edges = motion.event_times
    half = np.diff(edges) / 2.0
    r = motion.at((edges[:-1] + half)[:, None] + half[:, None] * nodes)
    last, scale = motion.at(motion.t_end), motion.vehicle.mass * SPEED
    assert half @ (r.force_normal @ weights) == pytest.approx(float(last.impulse_normal), abs=1e-8 * scale)
    assert half @ (r.force_tangential @ weights) == pytest.approx(
        float(last.impulse_tangential), abs=1e-8 * scale
    )
    total = math.fsum(strike.impulse for strike in motion.strikes)
    assert total == pytest.approx(float(last.impulse_normal), rel=1e-10)
    absorbed = math.fsum(strike.energy_absorbed for strike in motion.strikes)
    assert absorbed == pytest.approx(float(last.crush_work), rel=1e-9, abs=1e-9 * scale * SPEED)


def test_a_plastic_corner_is_held_while_the_other_presses_on_it() -> None:
    """e = 0: the rear rests at its greatest crush under less than its strength until the front has stopped."""
    motion = impact(e=0.0)
    rear, front = motion.strikes[1:3]
    assert motion.t_end == pytest.approx(rear.end + 0.1)
    assert rear.end == pytest.approx(front.end, abs=1e-6)
    points = motion.points_at(np.linspace(rear.end - 0.015, rear.end - 1e-6, 50))
    assert np.ptp(points.crush[1]) < 1e-11
    assert np.all((points.normal[1] > 0.0) & (points.normal[1] < rear.peak_force))


def test_the_record_is_smooth_enough() -> None:
    """Positions between the steps follow the velocities: dense output against Gauss quadrature of itself."""
    motion = impact()
    edges = np.linspace(0.0, motion.t_end, 2001)
    nodes, weights = np.polynomial.legendre.leggauss(4)
    inside = motion.at((edges[:-1, None] + edges[1:, None]) / 2.0 + np.diff(edges)[:, None] / 2.0 * nodes)
    moved = (inside.v_gy @ weights) * np.diff(edges) / 2.0
    assert np.diff(motion.at(edges).y_g) == pytest.approx(moved, abs=1e-10)


def test_where_it_strikes() -> None:
    """Corners are points: the force attacks at the front, then at the rear."""
    front, rear = impact().strikes[:2]
    assert (front.point_of_attack, rear.point_of_attack) == pytest.approx((0.0, 10.0))
    assert 0.0 < front.position < SPEED * front.end
    assert front.impulse_tangential == pytest.approx(-MU * front.impulse)
    assert front.friction_work < 0.0


@pytest.mark.parametrize("points", [16, pytest.param(32, marks=pytest.mark.long)])
def test_a_layer_converges_with_its_points(points: int) -> None:
    """Doubling changes peaks and impulses of the first two strikes by 2e-3 from 16, 1e-3 from 32 points."""
    law = CrushLaw(1e6, 0.0, 0.22)
    runs = [impact(side=law, side_points=count, end=0.41) for count in (points, 2 * points)]
    for coarse, fine in zip(runs[0].strikes[:2], runs[1].strikes[:2], strict=True):
        assert coarse.corner == fine.corner
        assert coarse.impulse == pytest.approx(fine.impulse, rel=32e-4 / points)
        assert coarse.peak_force == pytest.approx(fine.peak_force, rel=32e-3 / points)


def test_a_layer_pressed_flat_is_a_spring_of_its_stiffness_times_length() -> None:
    """The side strikes flat: F = v sqrt(k m) with k = 2 corners + layer times length."""
    k, law = 1e5, CrushLaw(2e5, 0.0, 1.0)
    start = ImpactState(0.0, TRUCK.width / 2.0, 0.0, 0.0, -0.1, 0.0)  # so that the ends do not reach the wall
    motion = solve_impact(TRUCK, WallContact(CrushLaw(k, 0.0, 1.0), 0.3, law, 6), start, end=0.05)
    total = 2.0 * k + 2e5 * TRUCK.length
    r = motion.at(np.linspace(0.0, 0.05, 41))
    w = math.sqrt(total / TRUCK.mass)
    assert r.force_normal == pytest.approx(0.1 * total / w * np.sin(w * r.t), rel=1e-9, abs=1e-6)
    assert {strike.corner for strike in motion.strikes} == {"front", "rear"}


def test_the_end() -> None:
    """After the second strike; where there is none, when nothing can touch any more."""
    motion = impact()
    assert motion.t_end == pytest.approx(motion.strikes[1].end + 0.1)
    single = impact(mu=2.0, longest=9.0)
    assert len(single.strikes) == 1
    assert single.end.y_g >= TRUCK.reach * (1.0 - 1e-9)
    assert impact(end=0.05).t_end == 0.05
    assert impact(end=0.05).strikes[0].end == 0.05


REFUSED: list[tuple[str, Callable[[], Any], str]] = [
    ("length", lambda: ImpactVehicle(0.0, 2.0, 1e3), "positive"),
    ("mass", lambda: ImpactVehicle(4.0, 2.0, -1e3), "positive"),
    ("centre_of_mass", lambda: ImpactVehicle(4.0, 2.0, 1e3, 4.1), "between 0 and the length, 4 m"),
    ("centre_of_mass", lambda: ImpactVehicle(4.0, 2.0, 1e3, 0.0), "between 0 and the length, 4 m"),
    ("centre_of_mass", lambda: ImpactVehicle(4.0, 2.0, 1e3, 0.1), "nearer to the middle"),
    ("yaw_inertia", lambda: ImpactVehicle(4.0, 2.0, 1e3, 2.0, 0.0), "from a thousandth"),
    ("yaw_inertia", lambda: ImpactVehicle(4.0, 2.0, 1e3, 2.0, 4.99), "from a thousandth"),
    (
        "yaw_inertia",
        lambda: ImpactVehicle(4.0, 2.0, 1e3, 2.0, 5001.0),
        "at most m (a (L - a) + B^2/4) = 5000",
    ),
    ("yaw_inertia", lambda: ImpactVehicle(4.0, 2.0, 1e3, 1.0, math.nan), "from a thousandth"),
    ("friction", lambda: WallContact(CrushLaw(1e6), -0.1), "0 or more"),
    ("side_points", lambda: WallContact(CrushLaw(1e6), 0.1, CrushLaw(1e6), 0), "1 or more"),
    ("angle", lambda: first_touch(TRUCK, 0.0, 25.0), "between 0 and pi/2"),
    ("angle", lambda: first_touch(TRUCK, 1.6, 25.0), "between 0 and pi/2"),
    ("speed", lambda: first_touch(TRUCK, 0.3, 0.0), "positive"),
    ("state", lambda: ImpactState(0.0, 1.0, math.nan, 0.0, 0.0, 0.0), "six finite numbers"),
    ("state", lambda: start(y_g=1.0), "outside the wall"),
    ("state", lambda: start(v_gy=1.0), "a motion towards the wall"),
    ("end", lambda: impact(end=0.0), "positive"),
    ("time", lambda: impact(end=0.1).at(0.2), "from 0 to 0.1 s"),
]


def start(y_g: float = 2.0, v_gy: float = -1.0) -> ImpactMotion:
    state = ImpactState(0.0, y_g, 0.0, 20.0, v_gy, 0.0)
    return solve_impact(TRUCK, WallContact(CrushLaw(1e6), 0.4), state)


@pytest.mark.parametrize(("key", "attempt", "allowed"), REFUSED)
def test_what_cannot_be_is_refused(key: str, attempt: Callable[[], Any], allowed: str) -> None:
    with pytest.raises(RigidBodyError) as caught:
        attempt()
    assert caught.value.key == key
    assert allowed in str(caught.value)


def test_the_greatest_inertia_is_that_of_masses_at_the_corners() -> None:
    """A quarter of the mass at each corner, and the same moved forwards."""
    for a, front in ((2.0, 0.5), (1.0, 0.75)):
        places = [(x, y, share / 2.0) for x, share in ((0.0, front), (4.0, 1.0 - front)) for y in (-1.0, 1.0)]
        inertia = 1e3 * sum(share * ((x - a) ** 2 + y * y) for x, y, share in places)
        assert sum(x * share for x, _, share in places) == pytest.approx(a)
        assert ImpactVehicle(4.0, 2.0, 1e3, a, inertia).greatest_inertia == pytest.approx(inertia)


def test_a_single_strike_is_followed_for_a_tenth_of_a_second() -> None:
    """Filters need a history of 50 ms, also of what has left the wall for good after 3 ms."""
    car = ImpactVehicle(4.0, 2.0, 1500.0)
    touch = first_touch(car, math.radians(45.0), 500.0)
    motion = solve_impact(car, WallContact(CrushLaw(1e10, 0.0, 0.9), 0.0), touch)
    assert len(motion.strikes) == 1
    assert motion.strikes[0].end < 3e-3
    assert motion.t_end == pytest.approx(0.1, rel=1e-12)
