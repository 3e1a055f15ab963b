"""Verification: the whole impact that `tailslap paper` holds against Stages 1 to 3, by closed forms."""

from __future__ import annotations

import math

import pytest

from solver.impact import CrushLaw, ImpactState, ImpactVehicle, WallContact, solve_impact
from tailslap.paper.printed import MASS
from tailslap.paper.whole_impact import WholeImpact, corner_share, motion, rear_speed, whole_impact

pytestmark = pytest.mark.verification


@pytest.fixture(scope="module")
def found() -> WholeImpact:
    return whole_impact()


def test_the_share_of_the_mass_that_a_corner_brings() -> None:
    """A blow J at the rear corner, side along the wall: v_G = J/m and omega = J (L/2)/I add up to J/m_eff."""
    inertia = MASS * (10.0**2 + 2.438**2) / 12.0
    assert corner_share(0.0) * MASS == pytest.approx(1.0 / (1.0 / MASS + 25.0 / inertia), rel=1e-13)
    assert corner_share(0.0) == pytest.approx(0.261, abs=5e-5)
    assert corner_share(0.47) < corner_share(0.0)


@pytest.mark.parametrize(("friction", "share"), [(0.0, corner_share(0.0)), (0.47, corner_share(0.47))])
def test_the_share_against_a_strike_of_the_rear_corner_alone(friction: float, share: float) -> None:
    """Stiff, at angle zero, turning about the front corner: J = (1 + e) m_eff v_E, v_E = 2 v_GY."""
    vehicle = ImpactVehicle(10.0, 2.438, MASS)
    start = ImpactState(0.0, 1.219 + 0.01, -0.002, 20.0, -3.0, 0.6)  # the front corner 20 mm off
    contact = WallContact(CrushLaw(1e11, 0.0, 0.5), friction)
    strike = solve_impact(vehicle, contact, start, 1e-3).strikes[0]
    assert strike.corner == "rear"
    assert strike.impulse == pytest.approx(1.5 * share * MASS * 2.0 * 3.0, rel=3e-3)


def test_the_rear_strike_brings_that_share(found: WholeImpact) -> None:
    for case in found.cases:
        assert case.share == pytest.approx(found.share_friction, rel=5e-3)
        assert case.closing == pytest.approx(2.0 * 4.55, rel=1e-2)
    assert found.corner_impulse / found.plastic_impulse == pytest.approx(2.0 * found.share, rel=1e-13)


def test_the_corners_speed_is_the_rate_of_its_crush() -> None:
    moving = motion(2e6)
    before, after = moving.points_at([0.2 - 1e-5, 0.2 + 1e-5]).crush[1]
    assert rear_speed(moving, 0.2) == pytest.approx((after - before) / 2e-5, rel=1e-7)


def test_omega_converges_on_newtons(found: WholeImpact) -> None:
    off = [
        abs(omega - found.omegas["newton"]) for omega in (*(c.omega for c in found.cases), found.nearly_rigid)
    ]
    assert off == sorted(off, reverse=True)
    assert off[-1] < 2e-4 * found.omegas["newton"]


def test_a_mean_lengthens_a_strike_that_stands_free_by_its_width(found: WholeImpact) -> None:
    for case in found.cases:
        assert case.read["mean_50ms"] - case.rear_duration == pytest.approx(0.05, abs=2e-3)


def test_the_corner_leaves_and_comes_back_last(found: WholeImpact) -> None:
    for case in found.cases:
        assert 0.0 < case.released < case.rear_start < case.back
        assert case.gap > 0.1
        assert not math.isnan(case.back)
