"""Validation: the numbers that Chuong and Malla (2025) print for the MASH TL-4 single-unit truck.

They give ABAQUS and analytical results in Table 3, read off charts; a chart's reading is held to a unit of
its last digit, or two where the unit is a millimetre per second.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from solver import RectangularBody, corner_impulse, plane_motion, strike_force

TRUCK = RectangularBody(10.0, 2.438, 9979.0)  # Table 1; 22 000 lb
ANGLE, FRICTION, RESTITUTION = math.radians(15.0), 0.47, 0.22  # Table 1
MPH, KM_PER_HOUR = 0.44704, 1.0 / 3.6
START = (0.26, 0.707, 25.053)  # section 3.1.1: theta_0, omega_0, v_P0


def test_stage_1_from_56_miles_per_hour():
    """omega_0 = 0.707 rad/s and v_P0 = 25,053 mm/s are those of 56 mph, not of the 90 km/h of Table 1."""
    result = corner_impulse(TRUCK, 56.0 * MPH, ANGLE, FRICTION, RESTITUTION)
    assert result.omega == pytest.approx(0.707, abs=0.0005)
    assert result.corner_speed == pytest.approx(25.053, abs=0.001)
    metric = corner_impulse(TRUCK, 90.0 * KM_PER_HOUR, ANGLE, FRICTION, RESTITUTION)
    assert abs(metric.corner_speed - 25.053) > 0.03
    assert abs(metric.omega - 0.707) > 0.0008


@pytest.mark.parametrize(
    ("name", "printed", "unit"),
    [
        ("t", 0.383, 0.001),
        ("v_gy", -3.274, 0.002),
        ("v_gx", 23.270, 0.01),
        ("omega", 0.65, 0.01),
        ("slide", 9.420, 0.01),
    ],
)
def test_the_analytical_column_of_table_3(name, printed, unit):
    strike = plane_motion(TRUCK, *START, FRICTION).strike
    assert getattr(strike, name) == pytest.approx(printed, abs=unit)


def test_the_abaqus_column_is_a_motion_without_friction_read_before_the_strike():
    """Where the corner has slid the printed 8.915 m, the frictionless motion has the printed speeds."""
    free, drag = (plane_motion(TRUCK, *START, FRICTION, reaction) for reaction in ("none", "drag"))
    t = float(np.interp(8.915, *(getattr(free.at(np.linspace(0.0, 0.38, 2001)), x) for x in ("slide", "t"))))
    state = free.at(t)
    assert t == pytest.approx(0.3625, abs=0.0002)
    assert state.v_gx == pytest.approx(23.305, abs=0.01)
    assert state.v_gy == pytest.approx(-3.289, abs=0.01)
    assert state.omega == pytest.approx(0.66, abs=0.005)
    assert abs(drag.at(t).v_gx - 23.305) > 3.0 * abs(state.v_gx - 23.305)


def test_the_peak_force_from_the_analytical_column():
    """654 kN for a pulse of 0.1 s, Eqs 72-73: 2 x 9979 kg x 3.2755 m/s / 0.1 s."""
    force = strike_force(9979.0, plane_motion(TRUCK, *START, FRICTION).strike.v_gy, 0.1)
    assert force.peak_force == pytest.approx(654e3, abs=0.5e3)


def test_the_factor_between_restitutions_is_that_of_row_b():
    """Row b of Table 4 prints 680 kN for e = 0.22 and 872 kN for e = 0, to the kilonewton."""
    peaks = []
    for restitution in (0.22, 0.0):
        start = corner_impulse(TRUCK, 57.4 * MPH, math.radians(15.4), FRICTION, restitution)
        strike = plane_motion(TRUCK, math.radians(15.4), start.omega, start.corner_speed, FRICTION).strike
        peaks.append(strike_force(9979.0, strike.v_gy, 0.1).peak_force)
    assert 871.5 / 680.5 < peaks[1] / peaks[0] < 872.5 / 679.5
