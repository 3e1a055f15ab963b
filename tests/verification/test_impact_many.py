"""Verification: many impacts at once against the event-driven solution, and what they refuse."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from solver import RigidBodyError
from solver.elementary import Array
from solver.impact import (
    CORNERS,
    CrushLaw,
    ImpactMotion,
    Impacts,
    ImpactVehicle,
    WallContact,
    first_touch,
    solve_impact,
    solve_impacts,
)

pytestmark = pytest.mark.verification

TRUCK = {
    "length": 10.0, "width": 2.438, "mass": 9979.0, "speed": 56 * 0.44704, "angle": math.radians(15.0),
    "stiffness": 2e6, "restitution": 0.22, "friction": 0.47,
}  # fmt: skip


def drawn(seed: int, n: int, steepest: float, roughest: float) -> dict[str, Array]:
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


def exact(row: dict[str, float]) -> ImpactMotion:
    size = row["length"], row["width"], row["mass"]
    vehicle = ImpactVehicle(*size, row.get("centre_of_mass"), row.get("yaw_inertia"))
    law = CrushLaw(row["stiffness"], row.get("initial_force", 0.0), row["restitution"])
    return solve_impact(
        vehicle, WallContact(law, row["friction"]), first_touch(vehicle, row["angle"], row["speed"])
    )


def compare(found: Impacts, i: int, motion: ImpactMotion, tolerance: float) -> None:
    for k, strike in enumerate(motion.strikes[:2]):
        assert CORNERS[found.corner[k, i]] == strike.corner
        assert found.impulse[k, i] == pytest.approx(strike.impulse, rel=tolerance)
        assert found.peak_force[k, i] == pytest.approx(strike.peak_force, rel=tolerance)
        assert found.duration[k, i] == pytest.approx(strike.duration, rel=tolerance)
        assert found.start[k, i] == pytest.approx(strike.start, rel=tolerance, abs=1e-9)
    if len(motion.strikes) == 1:
        assert found.corner[1, i] == -1
        assert math.isnan(found.impulse[1, i])
    t = np.linspace(0.0, motion.t_end, 20_001)
    impulse = motion.at(t).impulse_normal
    mean = (np.interp(t + 0.05, t, impulse) - impulse).max() / 0.05
    assert found.mean_50ms[i] == pytest.approx(mean, rel=tolerance)


@pytest.mark.parametrize(
    ("seed", "steepest", "roughest"), [(2, 30.0, 0.8), pytest.param(3, 85.0, 2.0, marks=pytest.mark.long)]
)
def test_against_the_event_driven_solution(seed: int, steepest: float, roughest: float) -> None:
    """Slender and steep, slip and stick: within 1e-3."""
    given = drawn(seed, 15, steepest, roughest)
    found = solve_impacts(**given)
    for i in range(15):
        compare(found, i, exact({key: float(value[i]) for key, value in given.items()}), 1e-3)


def test_a_steep_impact_that_sticks() -> None:
    """Both front corners come to rest along the wall."""
    steep = {**TRUCK, "angle": math.radians(70.0), "friction": 1.5}
    compare(solve_impacts(**{key: np.array([value]) for key, value in steep.items()}), 0, exact(steep), 1e-3)


def test_the_truck_as_numbers_and_broadcast() -> None:
    """One impact has the shape (), stiffness times restitution the product's."""
    one = solve_impacts(**TRUCK)
    assert one.mean_50ms.shape == ()
    assert one.impulse.shape == (2,)
    assert one.impulse == pytest.approx([28.583e3, 26.675e3], rel=1e-4)
    assert float(one.mean_50ms) == pytest.approx(493.74e3, rel=1e-4)
    e = np.array([0.22, 0.5])
    grid = solve_impacts(**{**TRUCK, "stiffness": np.array([[1e6], [2e6], [3e6]]), "restitution": e})
    assert grid.impulse.shape == (2, 3, 2)
    assert grid.impulse[:, 1, 0] == pytest.approx(one.impulse, rel=1e-9)
    assert np.all(np.diff(grid.peak_force[0], axis=0) > 0.0)


def test_an_initial_force_and_an_upright_line() -> None:
    with_force = {**TRUCK, "initial_force": 1e5}
    found = solve_impacts(**{key: np.array([value]) for key, value in with_force.items()})
    compare(found, 0, exact(with_force), 1e-3)
    plastic = {**TRUCK, "restitution": 0.0}
    first, strike = solve_impacts(**plastic), exact(plastic).strikes[0]
    assert float(first.impulse[0]) == pytest.approx(strike.impulse, rel=0.03)  # e = 0.02
    assert float(first.peak_force[0]) == pytest.approx(strike.peak_force, rel=1e-4)


def test_a_smaller_step_comes_closer(monkeypatch: pytest.MonkeyPatch) -> None:
    """Second order: the error of the peak falls by four with half the step."""
    from solver.impact.many import leapfrog

    peak = exact(TRUCK).strikes[1].peak_force
    errors = []
    for phase in (0.08, 0.04):
        monkeypatch.setattr(leapfrog, "PHASE", phase)
        errors.append(abs(float(solve_impacts(**TRUCK).peak_force[1]) / peak - 1.0))
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.15)


@pytest.mark.parametrize(
    ("key", "value", "allowed"),
    [
        ("length", -1.0, "positive"),
        ("mass", 0.0, "positive"),
        ("speed", math.inf, "positive"),
        ("angle", 0.0, "between 0 and pi/2"),
        ("stiffness", [1e6, -1.0], "at index 1"),
        ("restitution", 1.5, "from 0 to 1"),
        ("friction", -0.1, "0 or more"),
        ("initial_force", -1.0, "0 or more"),
        ("centre_of_mass", 11.0, "between 0 and the length"),
        ("centre_of_mass", 0.2, "nearer to the middle"),
        ("yaw_inertia", 1e7, "at most m (a (L - a)"),
        ("yaw_inertia", 1.0, "from a thousandth of m (a (L - a)"),
    ],
)
def test_what_cannot_be_is_refused(key: str, value: Any, allowed: str) -> None:
    with pytest.raises(RigidBodyError) as caught:
        solve_impacts(**{**TRUCK, key: value})
    assert caught.value.key == key
    assert allowed in str(caught.value)
