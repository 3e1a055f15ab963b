"""Verification: the crush law, its energy, and a point mass on it, against closed forms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from solver import RigidBodyError
from solver.impact import CrushLaw, ImpactMotion, ImpactState, ImpactVehicle, WallContact, solve_impact

pytestmark = pytest.mark.verification

BOX = ImpactVehicle(4.0, 2.0, 1500.0)
UPRIGHT = math.pi / 2.0 - math.atan(0.5)  # the front corner is below the centre of mass
REACH = math.hypot(2.0, 1.0)
SPEED = 7.0
LAWS = [CrushLaw(2e6, force, e) for force in (0.0, 4e4, 3e5) for e in (0.0, 0.05, 0.22, 0.7)] + [
    CrushLaw(2e6, 0.0, 0.9),
    CrushLaw(2e6, 0.0, 1.0),
]


def head_on(law: CrushLaw) -> ImpactMotion:
    """One corner strikes head-on through the centre of mass: a point mass on the law."""
    start = ImpactState(0.0, REACH, UPRIGHT, 0.0, -SPEED, 0.0)
    return solve_impact(BOX, WallContact(law, 0.0), start, end=0.3)


def loop(law: CrushLaw, most: float) -> tuple[Any, Any]:
    """Work of loading to a crush, and of unloading from it, by quadrature on 100 000 cells."""
    edges = np.linspace(0.0, most, 100_001)
    middle = (edges[1:] + edges[:-1]) / 2.0
    cell = edges[1]
    return law.force(middle, 0.0).sum() * cell, law.force(middle, most).sum() * cell


@pytest.mark.parametrize("law", LAWS)
def test_unloading_gives_back_e_squared_of_the_energy(law: CrushLaw) -> None:
    for most in (1e-3, 0.1, 0.7):
        up, down = loop(law, most)
        assert up == pytest.approx(float(law.energy_taken(most)), rel=1e-9)
        assert down == pytest.approx(law.restitution**2 * up, rel=2e-4, abs=1e-9 * up)
        assert float(law.stored_energy(most, most)) == pytest.approx(law.restitution**2 * up, rel=1e-9)


@pytest.mark.parametrize("law", LAWS)
def test_the_line_runs_from_the_virgin_curve_to_the_permanent_crush(law: CrushLaw) -> None:
    most = np.array([0.01, 0.3])
    top = law.virgin_force(most)
    assert law.force(most * (1.0 + 1e-12), most) == pytest.approx(top)
    assert np.all(law.force(law.residual(most) - 1e-9, most) == 0.0)
    if law.restitution:
        slope = top**2 / (2.0 * law.restitution**2 * law.energy_taken(most))
        assert law.unloading_stiffness(most) == pytest.approx(slope)
        assert law.residual(most) == pytest.approx(most - top / slope)
        half = most - 0.5 * top / slope
        assert law.force(half, most) == pytest.approx(top / 2.0)
    else:
        assert np.all(np.isinf(law.unloading_stiffness(most)))
        assert np.all(law.force(most - 1e-12, most) == 0.0)


def test_without_an_initial_force_the_slope_is_k_over_e_squared() -> None:
    law = CrushLaw(2e6, 0.0, 0.22)
    assert law.unloading_stiffness(np.array([0.0, 0.1, 2.0])) == pytest.approx(2e6 / 0.22**2)
    assert law.residual(0.5) == pytest.approx(0.5 * (1.0 - 0.22**2))


def test_no_force_in_front_of_the_wall() -> None:
    law = CrushLaw(2e6, 1e4, 0.5)
    assert law.force([-1.0, 0.0, 1e-9], 0.0) == pytest.approx([0.0, 0.0, 1e4 + 2e-3])


@pytest.mark.parametrize("e", [0.05, 0.22, 0.5, 0.9, 1.0])
def test_a_point_mass_on_the_bilinear_law(e: float) -> None:
    """F = v sqrt(k m), duration (pi/2)(1 + e) sqrt(m/k), residual crush D (1 - e^2), exit speed e v."""
    k, m = 2e6, BOX.mass
    motion = head_on(CrushLaw(k, 0.0, e))
    (strike,) = motion.strikes
    end, most = motion.at(motion.t_end), SPEED * math.sqrt(m / k)
    assert strike.corner == "front"
    assert strike.peak_force == pytest.approx(SPEED * math.sqrt(k * m), rel=1e-10)
    assert strike.duration == pytest.approx(math.pi / 2.0 * (1.0 + e) * math.sqrt(m / k), rel=1e-9)
    assert strike.impulse == pytest.approx((1.0 + e) * m * SPEED, rel=1e-10)
    assert float(end.v_gy) == pytest.approx(e * SPEED, rel=1e-10)
    assert float(motion.points_at(motion.t_end).max_crush[0]) == pytest.approx(most, rel=1e-10)
    assert float(motion.points_at(strike.end).crush[0]) == pytest.approx(
        most * (1.0 - e * e), rel=1e-9, abs=1e-11
    )
    assert strike.energy_absorbed == pytest.approx((1.0 - e * e) * m * SPEED**2 / 2.0, rel=1e-9, abs=1e-6)


@pytest.mark.parametrize("e", [0.0, 0.22, 0.7])
@pytest.mark.parametrize("force", [1e4, 3e5])
def test_a_point_mass_on_the_law_with_an_initial_force(force: float, e: float) -> None:
    """F0 D + k D^2/2 = m v^2/2; m d'' = -F0 - k d until then, and the slope that returns e^2 of it after."""
    k, m = 2e6, BOX.mass
    motion = head_on(CrushLaw(k, force, e))
    (strike,) = motion.strikes
    most = (math.sqrt(force**2 + k * m * SPEED**2) - force) / k
    top, frequency = force + k * most, math.sqrt(k / m)
    loading = math.atan2(SPEED * frequency * m, force) / frequency
    unloading = math.pi / 2.0 * e * SPEED * m / top  # a quarter period of slope top^2/(e^2 m v^2)
    assert strike.peak_force == pytest.approx(top, rel=1e-10)
    assert strike.duration == pytest.approx(loading + unloading, rel=1e-9)
    assert float(motion.at(motion.t_end).v_gy) == pytest.approx(e * SPEED, rel=1e-9, abs=1e-11)
    assert strike.impulse == pytest.approx((1.0 + e) * m * SPEED, rel=1e-10)


@pytest.mark.parametrize(
    ("key", "given", "allowed"),
    [
        ("stiffness", {"stiffness": -1.0}, "positive and finite"),
        ("stiffness", {"stiffness": math.inf}, "positive and finite"),
        ("initial_force", {"initial_force": -1.0}, "0 or more"),
        ("restitution", {"restitution": 1.1}, "from 0 to 1"),
        ("restitution", {"restitution": math.nan}, "from 0 to 1"),
        ("restitution", {"restitution": 0.8, "initial_force": 1.0}, "at most sqrt(1/2)"),
        ("stiffness", {"stiffness": [1.0, 2.0]}, "a number"),
    ],
)
def test_a_law_that_cannot_be(key: str, given: dict[str, Any], allowed: str) -> None:
    with pytest.raises(RigidBodyError) as caught:
        CrushLaw(**{"stiffness": 1e6, **given})
    assert caught.value.key == key
    assert allowed in str(caught.value)
