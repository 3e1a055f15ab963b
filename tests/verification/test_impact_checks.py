"""Verification: checks of a whole impact: a force on a node of a soft plate has no limit; a vibration's phase."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tailslap.case.checks import Check, evaluated
from tailslap.case.impact.checks import CHECKS, FLOOR, MODAL_SHARE, SHARE, WEDGE, unknown_by_vibration

MASS, LENGTH = 9979.0, 10.0


def point_outcome(
    modulus: float, patch: float | None = None, stiffness: float | None = 2e6, off: float = 0.0
) -> Any:
    contact = SimpleNamespace(stiffness=stiffness, patch_length=patch)
    plan = SimpleNamespace(scene=SimpleNamespace(needed_contact=contact))
    plate = SimpleNamespace(modulus=modulus, thickness=0.05)
    return SimpleNamespace(
        fe_plan=SimpleNamespace(case=plan, plate=plate), difference={"strike_1.impulse": off}
    )


def point_contact(made: Any) -> Check:
    (check,) = evaluated([kind for kind in CHECKS if kind.name == "point contact"], made)
    return check


def test_the_wedge_s_constant():
    """Half the sum of both components' constants of a right-angled wedge, each 2/(pi/2 +- 1)."""
    along, across = 2.0 / (0.5 * math.pi + 1.0), 2.0 / (0.5 * math.pi - 1.0)
    assert pytest.approx(0.5 * (along + across), rel=1e-15) == WEDGE


def test_a_point_on_a_soft_plate_fails():
    """E t = 1e7 N/m against k = 2e6 N/m: 0.2 WEDGE log 2 = 0.297."""
    check = point_contact(point_outcome(2e8))
    assert check.value == pytest.approx(0.2 * WEDGE * math.log(2.0), rel=1e-12)
    assert (check.limit, check.passed) == (FLOOR, False)
    assert point_contact(point_outcome(2e8, off=0.2)).limit == pytest.approx(FLOOR + 0.2 * SHARE)


def test_what_has_a_limit_passes():
    assert point_contact(point_outcome(2e11)).passed
    assert point_contact(point_outcome(2e8, patch=1.0)).value == 0.0
    assert point_contact(point_outcome(2e8, stiffness=None)).value == 0.0


def outcome(
    speed: float, frequency: float, flight: float, lasts: float, error: float, corner: str = "rear"
) -> Any:
    """A plate whose ends move at this speed, that flies towards the wall at 8 m/s and turns by 0.4 rad/s, so that its
    rear corner comes at 10 m/s and its front corner at 6."""
    t = np.linspace(0.0, flight + 0.3, 400)
    energy = 0.5 * MODAL_SHARE * MASS * speed**2 * np.cos(40.0 * t) ** 2
    still = {"t": t, "v_gy": np.full_like(t, -8.0), "omega": np.full_like(t, 0.4), "theta": np.zeros_like(t)}
    strikes = [SimpleNamespace(corner="front", start=0.0, end=0.1, duration=0.1)]
    strikes.append(
        SimpleNamespace(corner=corner, start=0.1 + flight, end=0.1 + flight + lasts, duration=lasts)
    )
    plan = SimpleNamespace(vehicle=SimpleNamespace(front_distance=5.0, length=LENGTH))
    return SimpleNamespace(
        fe=SimpleNamespace(strikes=strikes),
        run=SimpleNamespace(history={**still, "strain_energy": energy}),
        fe_plan=SimpleNamespace(case=plan, model=SimpleNamespace(mass=MASS), first_frequency=frequency),
        frequency_error=error,
    )


def test_modal_mass_of_a_free_beam():
    """Its first mode, scaled to 1 at the ends: the mean of its square is 1/4 (cosh a cos a = 1)."""
    a = 4.730040744862704
    x = np.linspace(0.0, 1.0, 20001) * a
    ratio = (math.cosh(a) - math.cos(a)) / (math.sinh(a) - math.sin(a))
    shape = np.cosh(x) + np.cos(x) - ratio * (np.sinh(x) + np.sin(x))
    mean = np.trapezoid(shape**2, x) / a / shape[0] ** 2
    assert mean == pytest.approx(MODAL_SHARE, rel=1e-6)


@pytest.mark.parametrize("lasts", [1e-4, 0.02, 0.1, 0.37])
def test_no_phase_moves_the_mean_velocity_of_a_strike_by_more(lasts):
    """Of a velocity of 0.5 m/s at 8 Hz beside an approach at 10 m/s."""
    phases = np.linspace(0.0, 2.0 * math.pi, 721)
    t = np.linspace(0.0, lasts, 2001)
    means = [abs(np.trapezoid(0.5 * np.cos(16.0 * math.pi * t + phase), t) / lasts) for phase in phases]
    found = unknown_by_vibration(outcome(0.5, 8.0, 2.0, lasts, 1.0))
    assert max(means) / 10.0 <= found * (1.0 + 1e-3)
    assert found <= 0.05 * (1.0 + 1e-3)
    assert found == pytest.approx(0.05 * min(1.0, 1.0 / (math.pi * 8.0 * lasts)), rel=1e-3)


def test_a_mesh_that_tells_the_phase_leaves_little():
    """16 cycles at a frequency 1e-4 off: a phase of 0.01 rad."""
    known, unknown = (unknown_by_vibration(outcome(0.5, 8.0, 2.0, 0.01, error)) for error in (1e-4, -1.0))
    assert known / unknown == pytest.approx(2.0 * math.pi * 16.0 * 1e-4)


def test_it_is_of_the_corner_that_strikes():
    rear, front = (
        unknown_by_vibration(outcome(0.5, 8.0, 2.0, 0.01, 1.0, corner)) for corner in ("rear", "front")
    )
    assert front / rear == pytest.approx(10.0 / 6.0)


def test_without_flight_or_second_strike_there_is_none():
    assert unknown_by_vibration(outcome(0.5, 8.0, 0.0, 0.01, 1.0)) == 0.0
    single = outcome(0.5, 8.0, 2.0, 0.01, 1.0)
    single.fe.strikes.pop()
    assert unknown_by_vibration(single) == 0.0


def test_without_a_second_mesh_no_phase_is_known():
    none, unknown = (unknown_by_vibration(outcome(0.5, 8.0, 2.0, 0.01, error)) for error in (math.nan, 1.0))
    assert none == unknown
