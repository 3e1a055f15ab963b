"""Verification: the exact Stage 2 against Eqs 66-71 integrated numerically, over the admissible inputs."""

import math
import timeit
from collections.abc import Callable
from dataclasses import fields
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from solver import REACTIONS, MotionState, RectangularBody, RigidBodyError, integrate_odes, plane_motion

TRUCK = RectangularBody(10.0, 2.438, 9979.0)
START = (0.26, 0.707, 25.053, 0.47)
NAMES = [field.name for field in fields(MotionState)]
fixed = settings(derandomize=True, deadline=None, database=None)
shapes, shares = st.floats(-2.0, 0.0).map(lambda power: 10.0**power), st.floats(0.001, 0.999)
frictions = st.floats(0.0, 1.25) | st.floats(1.34, 2.5)  # next to 4/3 a signed motion has no ten digits


def arguments(ratio: float, share: float, omega: float, speed_ratio: float) -> tuple:
    body = RectangularBody(8.0, 8.0 * ratio, 5000.0)
    angle = share * (math.pi / 2 - body.corner_angle)
    return body, angle, omega, speed_ratio * omega * body.corner_radius


def attempt(solve: Callable[..., Any], motion: tuple) -> Any:
    """The state at the strike, or the key of the refusal."""
    try:
        return solve(*motion).strike
    except RigidBodyError as error:
        return error.key


motions = {
    **{"ratio": shapes, "share": shares, "omega": st.floats(0.05, 10.0), "speed_ratio": st.floats(2.0, 30.0)},
    **{"friction": frictions, "reaction": st.sampled_from(REACTIONS)},
}


@settings(fixed, max_examples=60)
@given(**motions)
def test_both_agree_or_both_refuse(**motion: Any) -> None:
    agree_or_refuse(**motion)


@pytest.mark.long
@settings(fixed, max_examples=400)
@given(**motions)
def test_many_agree_or_both_refuse(**motion: Any) -> None:
    agree_or_refuse(**motion)


def agree_or_refuse(
    ratio: float, share: float, omega: float, speed_ratio: float, friction: float, reaction: str
) -> None:
    motion = (*arguments(ratio, share, omega, speed_ratio), friction, reaction)
    exact, integrated = attempt(plane_motion, motion), attempt(integrate_odes, motion)
    if isinstance(exact, str) or isinstance(integrated, str):
        # Where the motion is both ambiguous and brought to a stop, each reports what it meets first.
        assert {exact, integrated} <= {"friction", "corner_speed"}
        return
    for name in NAMES:
        value = getattr(exact, name)
        assert value == pytest.approx(getattr(integrated, name), rel=1e-10, abs=1e-300), name


@pytest.mark.parametrize("reaction", REACTIONS)
def test_the_motion_in_between(reaction):
    exact = plane_motion(TRUCK, *START, reaction)
    integrated = integrate_odes(TRUCK, *START, reaction)
    times = np.linspace(0.0, 0.99 * exact.strike.t, 21).reshape(3, 7)
    here, there = exact.at(times), integrated.at(times)
    for name in NAMES:
        assert getattr(there, name).shape == (3, 7)
        assert getattr(here, name) == pytest.approx(getattr(there, name), rel=1e-9, abs=1e-9), name


def test_the_hyperbolic_form_past_the_critical_friction():
    """Paths on one side of the roots of T^2 - 3 mu T + 4, T = tan(phi): below both, and above both."""
    for body, angle in ((TRUCK, 0.6), (RectangularBody(1.0, 3.5, 10.0), 0.2)):
        for reaction in ("drag", "signed"):
            motion = (body, angle, 1.0, 60.0, 1.45, reaction)
            exact, integrated = plane_motion(*motion).strike, integrate_odes(*motion).strike
            for name in NAMES:
                assert getattr(exact, name) == pytest.approx(getattr(integrated, name), rel=1e-11), name


def test_a_tighter_tolerance_comes_closer():
    exact = plane_motion(TRUCK, 1.2, 0.5, 25.0, 0.9).strike
    errors = [
        abs(
            integrate_odes(TRUCK, 1.2, 0.5, 25.0, 0.9, method="RK45", rtol=rtol, atol=rtol).strike.slide
            - exact.slide
        )
        for rtol in (1e-4, 1e-7, 1e-10)
    ]
    assert errors[0] > 50.0 * errors[1] > 2500.0 * errors[2] > 0.0


def test_the_integrator_refuses_what_has_no_answer(monkeypatch):
    with pytest.raises(RigidBodyError, match=r"omega is -1, but .*; allowed: positive"):
        integrate_odes(TRUCK, 0.26, -1.0, 25.0, 0.47)
    with pytest.raises(RigidBodyError, match=r"shape is \(2,\), but this is one motion"):
        integrate_odes(TRUCK, np.array([0.2, 0.3]), 0.7, 25.0, 0.47)  # type: ignore[arg-type]
    with pytest.raises(RigidBodyError, match=r'reaction is \'pull\', .*"drag", "none", "signed"'):
        integrate_odes(TRUCK, *START, "pull")
    with pytest.raises(
        RigidBodyError, match=r"friction is 1.4, .* from the angle 0.9 rad on; allowed: less than 4/3"
    ):
        integrate_odes(TRUCK, 0.9, 0.7, 250.0, 1.4)
    upper_root = (4.2 + math.sqrt(4.2**2 - 16.0)) / 2.0
    angle = math.atan(upper_root) - TRUCK.corner_angle
    with pytest.raises(RigidBodyError, match=rf"friction is 1.4, .* from the angle {angle:.6g} rad on"):
        integrate_odes(TRUCK, 1.1, 0.7, 250.0, 1.4)
    with pytest.raises(RigidBodyError, match=r"friction is 1.4, .* from the angle") as refused:
        integrate_odes(TRUCK, 1.1, 0.7, 250.0, 1.4, "signed")
    assert float(refused.value.why.split()[-3]) == pytest.approx(angle, abs=1e-4)
    with pytest.raises(
        RigidBodyError, match=r"time is 1 at index 1, but .*; allowed: from 0 to 0.3839597401 s"
    ):
        integrate_odes(TRUCK, *START).at([0.0, 1.0])
    monkeypatch.setattr("solver.motion._LONGEST", 0.1)
    with pytest.raises(
        RigidBodyError, match=r"friction is 0.47, but the angular velocity changes too abruptly"
    ):
        integrate_odes(TRUCK, *START)


def test_a_corner_that_stops_is_reported_at_the_same_place():
    """Both name the angle and the time, found by a root search and by an event."""
    motion = (TRUCK, 0.8, 2.0, 6.0, 0.9)
    messages = []
    for solve in (plane_motion, integrate_odes):
        with pytest.raises(
            RigidBodyError, match="the corner stops before the strike, at the angle"
        ) as refused:
            solve(*motion)
        messages.append(str(refused.value))
    assert messages[0] == messages[1]


def test_the_exact_solution_costs_a_twentieth_of_an_integration():
    def fastest(call: Callable[[], Any], number: int) -> float:
        return min(timeit.repeat(call, number=number, repeat=5)) / number

    exact = fastest(lambda: plane_motion(TRUCK, *START), 100)
    assert exact < fastest(lambda: integrate_odes(TRUCK, *START, rtol=1e-10), 5) / 20.0
