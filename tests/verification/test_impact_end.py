"""Verify when the motion of rigid vehicles ends."""

import math
from dataclasses import astuple

import numpy as np
import pytest
from test_impact_rigid import MU, SPEED, TRUCK, impact

from solver import RigidBodyError
from solver.impact import CrushLaw, ImpactVehicle, WallContact, first_touch, solve_impact, trajectories
from solver.impact.solve import column_names


def test_the_end():
    """The second strike, and a separation without one, end the motion."""
    motion = impact(end=None, after_second=0.05)
    assert motion.t_end == pytest.approx(
        motion.strikes[1].end + max(0.05, motion.strikes[1].duration), rel=1e-12
    )
    motion = impact(after_second=0.08)
    assert motion.t_end == pytest.approx(motion.strikes[1].end + 0.08, rel=1e-12)
    third = impact().strikes[2]
    assert impact().t_end == pytest.approx(third.end + third.duration, rel=1e-12)
    single = impact(mu=2.0, longest=9.0)
    assert len(single.strikes) == 1
    assert single.end.y_g >= 0.5 * math.hypot(TRUCK.length, TRUCK.width) * (1.0 - 1e-4)
    short = impact(end=0.05)
    assert (short.t_end, short.strikes[0].end) == (pytest.approx(0.05), pytest.approx(0.05))
    complete = impact().at(0.05)
    assert short.strikes[0].impulse == pytest.approx(float(complete.impulse_normal), rel=1e-6)
    assert short.strikes[0].peak_force == pytest.approx(float(complete.force_normal), rel=1e-5)


def strikes_of_motion(motion):
    return [(strike.corner, *astuple(strike)[1:5]) for strike in motion.strikes]


@pytest.mark.parametrize("angle", [10.0, 12.0, 13.0, 15.0, 20.0])
@pytest.mark.parametrize("e", [0.0, 0.02, 0.22])
def test_a_motion_ends_between_strikes(angle, e):
    """It has the strikes of a motion half a second longer."""
    motion = impact(angle=angle, e=e)
    longer = impact(angle=angle, e=e, end=motion.t_end + 0.5, step=motion.step)
    assert not any(strike.cut for strike in motion.strikes)
    assert float(motion.at(motion.t_end).force_normal) == 0.0
    ended, continued = strikes_of_motion(motion), strikes_of_motion(longer)[: len(motion.strikes)]
    for strike, same in zip(ended, continued, strict=True):
        assert strike[0] == same[0]
        assert strike[1:] == pytest.approx(same[1:], rel=1e-3)


STEP = 1.0 + 1e-6
"""Allowance for the step, which is chosen for each end."""


def test_the_end_in_a_strike_cuts_it():
    """Values increase with the end, up to those of the complete strike."""
    complete, last = impact().strikes[2], (0.0, 0.0, 0.0)
    for end in np.linspace(complete.start + 1e-3, complete.end - 1e-3, 6):
        strikes = impact(end=end).strikes
        strike = strikes[-1]
        assert [item.cut for item in strikes] == [False, False, True]
        values = strike.duration, strike.peak_force, strike.impulse
        assert strike.end == pytest.approx(end)
        exact = (complete.duration, complete.peak_force, complete.impulse)
        assert all(a <= b * STEP and b <= c * STEP for a, b, c in zip(last, values, exact, strict=True))
        last = values
    resumed = impact(end=complete.end + 0.9 * complete.duration).strikes[2]  # it may come back
    assert (resumed.cut, resumed.impulse) == (True, pytest.approx(complete.impulse, rel=1e-4))
    assert not impact(end=complete.end + 1.1 * complete.duration).strikes[2].cut


def test_the_latest_end_may_cut_a_strike():
    assert [strike.cut for strike in impact(longest=0.33).strikes] == [False, True]


def test_a_single_strike_is_followed_for_a_tenth_of_a_second():
    """Filters require 50 ms, also after a strike of 3 ms."""
    car = ImpactVehicle(4.0, 2.0, 1500.0)
    touch = first_touch(car, math.radians(45.0), 500.0)
    motion = solve_impact(car, WallContact(CrushLaw(1e10, 0.0, 0.9), 0.0), touch)
    assert len(motion.strikes) == 1
    assert motion.strikes[0].end < 3e-3
    assert motion.t_end == pytest.approx(0.1, rel=1e-12)


def test_no_input_takes_for_ever():
    """Excessive stiffness is refused, with the error."""
    with pytest.raises(RigidBodyError) as caught:
        impact(k=1e22, end=1.0)
    assert "leave an error" in str(caught.value)


@pytest.mark.parametrize("plateau", [3.5e-7, 2e-4, 350.0])
def test_a_vehicle_that_is_not_stopped_is_refused_without_refinement(plateau, monkeypatch):
    solved, compile_once = [], trajectories.compile_once

    def also(compile_all, kernel, *arguments, on_compile):
        solved.append(arguments[6])
        compile_once(compile_all, kernel, *arguments, on_compile=on_compile)

    monkeypatch.setattr(trajectories, "compile_once", also)
    touch = first_touch(TRUCK, math.radians(15.0), SPEED)
    with pytest.raises(RigidBodyError, match="a larger stiffness or plateau force"):
        solve_impact(TRUCK, WallContact(CrushLaw(2e6, 0.0, 0.22, plateau), MU), touch)
    assert not solved[0].other_state.any()  # there is no motion with another step


def test_the_columns_of_rows_are_named():
    assert len(column_names(1)) == impact(end=0.01).rows.shape[1]


@pytest.mark.parametrize("end", [0.05, 0.1, 0.3, 0.35])
def test_the_end_is_read_from_rows_that_were_written(monkeypatch, end):
    """It is correct at a whole number of steps, with uninitialised memory."""

    def undefined(shape, *more, **options):
        return np.full(shape, np.nan, *more, **options)

    monkeypatch.setattr("solver.impact.solve.np.empty", undefined)
    motion = impact(end=end)
    last = motion.at(motion.t_end)
    for name in ("x_g", "y_g", "theta", "v_gx", "v_gy", "omega"):
        assert getattr(last, name) == pytest.approx(getattr(motion.end, name), rel=1e-4, abs=1e-4), name
