"""Verification: occupant risk of motions with closed forms, and design forces as tabled."""

import math

import numpy as np
import pytest

from postprocess.signals.design_forces import LEVELS, design_forces
from postprocess.signals.occupant_risk import (
    GRAVITY,
    RiskMeasure,
    VehicleMotion,
    head_contact,
    occupant_contact,
    occupant_risk,
)

T = np.linspace(0.0, 0.6, 6001)
ZERO = np.zeros_like(T)


def measures(motion: VehicleMotion) -> dict[str, RiskMeasure]:
    return {measure.name: measure for measure in occupant_risk(motion)}


def straight(ax: np.ndarray | float, ay: np.ndarray | float) -> VehicleMotion:
    return VehicleMotion(T, ax + ZERO, ay + ZERO, ZERO, ZERO)


@pytest.mark.parametrize(
    ("ax", "ay", "distance"), [(-50.0, 0.0, 0.6), (0.0, 40.0, 0.3), (0.0, -40.0, 0.3), (-20.0, 30.0, 0.3)]
)
def test_constant_deceleration(ax, ay, distance):
    """The axis that is first through: v = sqrt(2 a d), t = sqrt(2 d / a); nothing else changes either way."""
    found, first = measures(straight(ax, ay)), abs(ay or ax)
    time = math.sqrt(2.0 * distance / first)
    assert found["OIV longitudinal"].time == pytest.approx(time, rel=1e-12)
    assert found["OIV longitudinal"].value == pytest.approx(abs(ax) * time, rel=1e-12)
    assert found["OIV lateral"].value == pytest.approx(abs(ay) * time, rel=1e-12)
    assert max(abs(ax), abs(ay)) * time == pytest.approx(math.sqrt(2.0 * first * distance))
    assert found["THIV"].value == pytest.approx(math.hypot(ax, ay) * time, rel=1e-12)
    assert found["ORA longitudinal"].value == pytest.approx(abs(ax) / GRAVITY, rel=1e-9)
    assert found["ORA lateral"].value == pytest.approx(abs(ay) / GRAVITY, rel=1e-9)
    assert found["PHD"].value == pytest.approx(math.hypot(ax, ay) / GRAVITY, rel=1e-9)


@pytest.mark.parametrize("name", ["ASI 1998, 50 ms mean", "ASI 2010, 13 Hz"])
def test_severity_of_constant_accelerations(name):
    found = measures(straight(-6.0 * GRAVITY, 4.5 * GRAVITY))[name]
    assert found.value == pytest.approx(math.sqrt(0.5), rel=0.1 if "2010" in name else 1e-9)
    assert "lower bound" in found.lacks


def test_severity_of_a_half_sine():
    """Of 50 ms means the closed form; of 13 Hz the gain of a long wave."""
    length = 0.12
    pulse = 5.0 * GRAVITY * np.sin(math.pi * np.clip(T / length, 0.0, 1.0))
    found = measures(straight(0.0, pulse))["ASI 1998, 50 ms mean"]
    exact = 5.0 / 9.0 * 2.0 * length / (math.pi * 0.05) * math.sin(0.025 * math.pi / length)
    assert found.value == pytest.approx(exact, rel=1e-5)
    assert found.time == pytest.approx(0.06, abs=2e-4)
    wave = 5.0 * GRAVITY * np.sin(math.pi * T / 0.6) ** 2 * np.sin(2.0 * math.pi * 13.0 * T)
    found = measures(straight(0.0, wave))["ASI 2010, 13 Hz"]
    assert found.value == pytest.approx(5.0 / 9.0 * math.sqrt(0.5), rel=0.02)


def test_growing_deceleration_of_few_instants():
    """a = j t: x = j t^3 / 6, v = j t^2 / 2, exact between instants 50 ms apart; so for a head in front."""
    t = np.linspace(0.0, 0.6, 13)
    motion = VehicleMotion(t, -200.0 * t, 0.0 * t, 0.0 * t, 0.0 * t)
    time = (6.0 * 0.6 / 200.0) ** (1.0 / 3.0)
    for contact in (occupant_contact(motion), head_contact(motion), head_contact(motion, ahead=2.0)):
        assert contact is not None
        assert contact.time == pytest.approx(time, rel=1e-12)
        assert contact.forward == pytest.approx(100.0 * time**2, rel=1e-12)


def test_half_sine_of_deceleration():
    """x = (a L / pi) (t - (L / pi) sin(pi t / L)), v = (a L / pi) (1 - cos(pi t / L)) while it lasts."""
    length, size = 0.2, 120.0
    contact = occupant_contact(straight(-size * np.sin(math.pi * np.clip(T / length, 0.0, 1.0)), 0.0))
    assert contact is not None
    phase, scale = math.pi * contact.time / length, size * length / math.pi
    assert scale * (contact.time - length / math.pi * math.sin(phase)) == pytest.approx(0.6, rel=1e-6)
    assert contact.forward == pytest.approx(scale * (1.0 - math.cos(phase)), rel=1e-6)


def test_ridedown_begins_after_contact():
    """A pulse before the contact does not count, one after it does, as its mean over 10 ms."""
    early = 60.0 * ((T > 0.01) & (T < 0.05))
    late = 100.0 * ((T > 0.4) & (T < 0.405))
    found = measures(straight(-early - late, 0.0))
    assert found["OIV longitudinal"].value == pytest.approx(2.4, rel=1e-2)
    assert found["ORA longitudinal"].time == pytest.approx(0.4025, abs=0.006)
    assert found["ORA longitudinal"].value == pytest.approx(50.0 / GRAVITY, rel=0.03)


def test_head_goes_straight_on_while_the_vehicle_turns():
    """A steady circle: relative to the centre of mass the head leaves on an involute's chord."""
    speed, rate = 20.0, 1.5
    motion = VehicleMotion(T, ZERO, ZERO + speed * rate, ZERO + rate, rate * T)
    contact = head_contact(motion)
    assert contact is not None

    def inside(t: float) -> np.ndarray:
        turned = rate * t
        away = np.array(
            [speed * t - speed / rate * math.sin(turned), -speed / rate * (1.0 - math.cos(turned))]
        )
        cos, sin = math.cos(turned), math.sin(turned)
        return np.array([cos * away[0] + sin * away[1], cos * away[1] - sin * away[0]])

    assert inside(contact.time)[1] == pytest.approx(-0.3, abs=1e-8)
    speeds = (inside(contact.time + 1e-5) - inside(contact.time - 1e-5)) / 2e-5
    assert (contact.forward, contact.sideways) == pytest.approx(tuple(speeds), abs=1e-5)


def test_a_head_ahead_of_the_centre_is_met_by_the_turning_side():
    """The centre at rest, the vehicle begins to turn: at 2 m ahead the side comes at rate times 2 m."""
    spin = 8.0
    motion = VehicleMotion(T, ZERO, ZERO, spin * T, 0.5 * spin * T**2)
    contact = head_contact(motion, ahead=2.0)
    assert contact is not None
    turned = math.asin(0.15)
    assert 0.5 * spin * contact.time**2 == pytest.approx(turned, rel=1e-7)
    assert contact.sideways == pytest.approx(-2.0 * spin * contact.time * math.cos(turned), rel=1e-6)
    assert head_contact(motion) is None


def test_a_flight_that_does_not_end_has_no_value():
    found = measures(straight(-1.0, 0.5))
    empty = {name for name, measure in found.items() if measure.value is None and measure.time is None}
    assert empty == {"THIV", "PHD", "OIV longitudinal", "OIV lateral", "ORA longitudinal", "ORA lateral"}


def test_every_measure_says_what_it_lacks():
    assert all(m.lacks and m.limits == "limits not given" for m in measures(straight(-50.0, 0.0)).values())


def test_motions_that_are_refused():
    with pytest.raises(ValueError, match=r"arrays of shapes \[\(2,\), \(6001,\)\]: must be one shape"):
        VehicleMotion(T, ZERO, ZERO, ZERO, ZERO[:2])
    with pytest.raises(ValueError, match="must rise evenly"):
        VehicleMotion(T**2, ZERO, ZERO, ZERO, ZERO)
    with pytest.raises(ValueError, match=r"at most 0\.0005556 s"):
        occupant_risk(VehicleMotion(10.0 * T, ZERO, ZERO, ZERO, ZERO))
    short = slice(0, 600)
    with pytest.raises(ValueError, match=r"history of 0\.0601 s: must last at least 0\.07692 s"):
        occupant_risk(VehicleMotion(*(values[short] for values in (T, ZERO, ZERO, ZERO, ZERO))))


def test_design_forces_of_the_test_levels():
    """The table in kip and in kN, as printed in both."""
    rows = [design_forces(level)[0] for level in LEVELS]
    assert [round(row.force / 1e3) for row in rows] == [60, 120, 240, 240, 552, 778]
    assert [row.longitudinal for row in rows] == [4.5, 9.0, 18.0, 18.0, 41.0, 58.0]
    assert [row.length for row in rows] == [4.0, 4.0, 4.0, 3.5, 8.0, 8.0]
    assert rows[3].length_m == pytest.approx(1.0668)
    assert rows[3].longitudinal_force == pytest.approx(80.07e3, rel=1e-4)


def test_design_forces_of_mash():
    _, tti, acceleration = design_forces("TL-4")
    assert round(tti.force / 1e3) == 356
    assert tti.longitudinal_force is None
    assert tti.length_m is None
    assert round(acceleration.kip) == 99
    assert acceleration.force == pytest.approx(440e3, rel=5e-3)
    assert all(row.source for level in LEVELS for row in design_forces(level))


def test_another_test_level_is_refused():
    with pytest.raises(ValueError, match="test level 'TL-7': must be one of TL-1, TL-2"):
        design_forces("TL-7")
