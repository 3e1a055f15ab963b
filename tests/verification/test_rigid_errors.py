"""Verification: whatever the theory has no answer to is refused by name, and costs no heavy import."""

import math
import pickle
import subprocess
import sys
from collections.abc import Callable
from dataclasses import fields
from typing import Any

import numpy as np
import pytest

from solver import (
    MotionState,
    RectangularBody,
    RigidBodyError,
    corner_impulse,
    plane_motion,
    stage_2,
    strike_force,
    tail_slap,
)

TRUCK = RectangularBody(10.0, 2.438, 9979.0)
IMPACT = {"speed": 25.0, "angle": 0.26, "friction": 0.47, "restitution": 0.22}
START = {"angle": 0.26, "omega": 0.707, "corner_speed": 25.053, "friction": 0.47}
MOST = math.pi / 2.0 - TRUCK.corner_angle
NAN, INF = math.nan, math.inf


def impact(**changes: Any) -> Any:
    return corner_impulse(TRUCK, **{**IMPACT, **changes})


def motion(**changes: Any) -> Any:
    return plane_motion(TRUCK, **{**START, **changes})


REFUSED: list[tuple[Callable[[], Any], str, str, str]] = [
    (lambda: RectangularBody(0.0, 2.0, 1.0), "length", "0", "positive and finite, m"),
    (lambda: RectangularBody(9.0, -2.0, 1.0), "width", "-2", "positive and finite, m"),
    (lambda: RectangularBody(9.0, 2.0, [1.0, INF]), "mass", "inf at index 1", "positive and finite, kg"),
    (lambda: RectangularBody("long", 2.0, 1.0), "length", "'long'", "a number, or an array of numbers"),
    (lambda: impact(speed=0.0), "speed", "0", "positive and finite, m/s"),
    (lambda: impact(speed=NAN), "speed", "nan", "positive and finite, m/s"),
    (lambda: impact(angle=0.0), "angle", "0", f"more than 0 and less than {MOST:.6g} rad"),
    (lambda: impact(angle=INF), "angle", "inf", f"more than 0 and less than {MOST:.6g} rad"),
    (lambda: impact(angle=MOST + 1e-9), "angle", "1.3316", f"more than 0 and less than {MOST:.6g} rad"),
    (lambda: impact(friction=-0.1), "friction", "-0.1", "0 or more"),
    (lambda: impact(friction=1.9), "friction", "1.9", "less than cot(phi) = 1.83"),
    (lambda: impact(restitution=-0.1), "restitution", "-0.1", "from 0 to 1"),
    (lambda: impact(restitution=1.1), "restitution", "1.1", "from 0 to 1"),
    (lambda: impact(convention="poisson"), "convention", "'poisson'", 'one of "paper", "newton"'),
    (lambda: impact(invalid="ignore"), "invalid", "'ignore'", 'one of "raise", "nan"'),
    (lambda: motion(omega=0.0), "omega", "0", "positive and finite, rad/s"),
    (lambda: motion(omega=-0.7), "omega", "-0.7", "positive and finite, rad/s"),
    (lambda: motion(omega=INF), "omega", "inf", "positive and finite, rad/s"),
    (lambda: motion(omega=1e200), "omega", "1e+200", "smaller, as corner_speed and mass"),
    (lambda: motion(angle=0.0), "angle", "0", f"more than 0 and less than {MOST:.6g} rad"),
    (lambda: motion(angle=MOST), "angle", "1.3316", f"more than 0 and less than {MOST:.6g} rad"),
    (lambda: motion(friction=-1.0), "friction", "-1", "0 or more"),
    (lambda: motion(friction=NAN), "friction", "nan", "0 or more"),
    (lambda: motion(corner_speed=0.0), "corner_speed", "0", "positive where there is friction"),
    (lambda: motion(corner_speed=-5.0, reaction="signed"), "corner_speed", "-5", "positive where there is"),
    (lambda: motion(corner_speed=INF, reaction="none"), "corner_speed", "inf", "finite"),
    (lambda: motion(corner_speed=0.3), "corner_speed", "0.3", "more, or no friction, m/s"),
    (lambda: motion(angle=1.2, friction=1.4), "friction", "1.4", "less than 4/3"),
    (lambda: motion(angle=1.2, friction=1.4, reaction="signed"), "friction", "1.4", "less than 4/3"),
    (
        lambda: motion(angle=1.2, friction=1.33333, reaction="signed"),
        "friction",
        "1.33333",
        "another reaction model",
    ),
    (lambda: motion(reaction="push"), "reaction", "'push'", 'one of "drag", "none", "signed"'),
    (lambda: motion(omega=np.array([0.7, 0.8])), "shape", "(2,)", "`tail_slap` takes arrays"),
    (lambda: motion().at([0.1, -0.1]), "time", "-0.1 at index 1", "from 0 to 0.3877993375 s"),
    (lambda: motion().at(0.4), "time", "0.4", "the strike is at 0.3839597401 s"),
    (lambda: strike_force(0.0, 3.0, 0.1), "mass", "0", "positive and finite, kg"),
    (lambda: strike_force(1.0, NAN, 0.1), "lateral_speed", "nan", "finite, m/s"),
    (lambda: strike_force(1.0, 3.0, 0.0), "duration", "0", "positive and finite, s"),
]


@pytest.mark.parametrize(("call", "key", "given", "allowed"), REFUSED)
def test_the_message_names_key_value_and_what_is_allowed(call, key, given, allowed):
    with pytest.raises(RigidBodyError) as refused:
        call()
    error = refused.value
    assert error.key == key
    assert str(error.given).startswith(given)
    assert allowed in error.allowed
    assert str(error) == f"{key} is {error.given}, but {error.why}; allowed: {error.allowed}."
    assert isinstance(error, ValueError)
    assert str(pickle.loads(pickle.dumps(error))) == str(error)


def test_what_is_not_finite_is_called_so():
    for value in (NAN, INF, -INF):
        with pytest.raises(RigidBodyError, match="but it is not a finite number; allowed"):
            motion(corner_speed=value)


def test_the_first_offending_row_is_named():
    omega = np.array([[0.7, 0.7, 0.7], [0.7, -1.0, -2.0]])
    with pytest.raises(RigidBodyError, match=r"omega is -1 at index \(1, 1\), but"):
        tail_slap(TRUCK, 0.26, omega, 25.0, 0.47)
    friction = np.array([0.1, 0.2, 1.9])
    with pytest.raises(
        RigidBodyError,
        match=r"friction is 1.9 at index 2, .*\(beta <= phi = 0.499.* rad\); .*cot\(phi\) = 1.83",
    ):
        impact(friction=friction)
    bodies = RectangularBody(10.0, np.array([[2.0], [5.0]]), 9979.0)
    with pytest.raises(RigidBodyError, match=r"angle is 1.3 at index \(1, 2\), .* less than 1.10715 rad"):
        tail_slap(bodies, np.array([0.1, 0.2, 1.3]), 0.7, 25.0, 0.1)


def test_a_stop_is_where_the_corner_stops():
    """A start just fast enough for the named angle comes to rest at that angle, at the named time."""
    speeds = np.array([25.0, 6.0, 0.3])
    with pytest.raises(RigidBodyError, match="corner_speed is 6 at index 1, but the corner stops") as refused:
        tail_slap(TRUCK, 0.8, 2.0, speeds, 0.9)
    words = refused.value.why.split()
    angle, time = float(words[words.index("angle") + 1]), float(words[words.index("time") + 1])
    gamma = TRUCK.corner_angle + angle
    r = TRUCK.corner_radius
    thicker = RectangularBody(2.0 * r * math.cos(gamma), 2.0 * r * math.sin(gamma), 9979.0)
    rest = plane_motion(thicker, 0.8 - angle, 2.0, 6.0 + 1e-4, 0.9).strike
    assert rest.v_p == pytest.approx(0.0, abs=2e-3)
    assert rest.t == pytest.approx(time, rel=1e-5)


def test_a_stop_just_past_the_strike_is_not_passed_over():
    low, high = 0.1, 20.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        try:
            motion(corner_speed=middle)
            high = middle
        except RigidBodyError:
            low = middle
    slowest = motion(corner_speed=high)
    assert 0.0 <= slowest.strike.v_p < 1e-10
    assert slowest.at(0.999 * slowest.strike.t).v_p > 0.0
    with pytest.raises(RigidBodyError, match=r"time is .*, but the corner has stopped by then"):
        slowest.at(1.005 * slowest.strike.t)


def test_the_friction_named_as_the_limit_is_the_limit():
    for reaction, margin in (("drag", 1e-5), ("signed", 2e-4)):
        with pytest.raises(RigidBodyError, match="less than 4/3") as refused:
            motion(angle=0.7, friction=2.0, corner_speed=90.0, reaction=reaction)
        limit = float(refused.value.allowed.split()[-4])
        tangent = math.tan(0.7 + TRUCK.corner_angle)
        assert limit == pytest.approx((tangent**2 + 4.0) / (3.0 * tangent), rel=1e-5)
        motion(angle=0.7, friction=limit - margin, corner_speed=90.0, reaction=reaction)
        with pytest.raises(RigidBodyError, match="less than 4/3"):
            motion(angle=0.7, friction=limit + 1e-5, corner_speed=90.0, reaction=reaction)
    assert motion(angle=1.2, friction=4.0 / 3.0, corner_speed=90.0).strike.t > 0.0


def test_nan_rows_stay_alone():
    values: dict[str, list[float]] = {
        "angle": [0.26, -1.0, 1.5, INF, 0.26, 0.26, 0.26, 1.2, 0.26, 0.26],
        "omega": [0.707, 0.7, 0.7, 0.7, 0.0, NAN, 0.7, 0.7, 0.7, 1e200],
        "corner_speed": [25.053, 25.0, 25.0, 25.0, 25.0, 25.0, -5.0, 25.0, 0.3, 25.0],
        "friction": [0.47, 0.4, 0.4, 0.4, 0.4, 0.4, 0.4, 1.5, 0.47, 0.4],
    }
    arrays = {name: np.array(column) for name, column in values.items()}
    for reaction in ("drag", "signed"):
        strikes = tail_slap(TRUCK, **arrays, reaction=reaction, invalid="nan")
        alone = motion(reaction=reaction).strike
        for field in fields(MotionState):
            column = getattr(strikes, field.name)
            assert column[0] == pytest.approx(getattr(alone, field.name), rel=1e-14)
            assert np.all(np.isnan(column[1:])), field.name
    assert np.isnan(tail_slap(TRUCK, 0.26, -1.0, 25.0, 0.47, invalid="nan").t)


def test_nan_rows_of_stage_1_pass_through_stage_2():
    first = corner_impulse(
        TRUCK, [25.0, 0.0, 25.0, 25.0, 25.0], 0.26, [0.4, 0.4, -1.0, 9.0, NAN], 0.2, invalid="nan"
    )
    expected = [False, True, True, True, True]
    assert np.isnan(first.omega).tolist() == np.isnan(first.corner_speed).tolist() == expected
    assert np.isnan(first.impulse).tolist() == expected
    second = tail_slap(TRUCK, 0.26, first.omega, first.corner_speed, 0.4, invalid="nan")
    assert np.isnan(second.t).tolist() == expected
    assert np.isnan(corner_impulse(TRUCK, 25.0, 0.26, 9.0, 0.2, invalid="nan").omega)


def test_a_time_that_does_not_converge_is_refused(monkeypatch):
    monkeypatch.setattr(stage_2, "BISECTIONS", 2)
    hard = {"angle": 1.3, "friction": 1.32, "reaction": "signed"}
    with pytest.raises(RigidBodyError, match="changes too abruptly"):
        motion(**hard)
    easy = np.array([0.0, 1.32, 0.1])
    strikes = tail_slap(TRUCK, 1.3, 0.7, 25.0, easy, "signed", invalid="nan")
    assert np.isnan(strikes.t).tolist() == [False, True, False]


@pytest.mark.parametrize(("limit", "value"), [("PANELS", 1), ("CLOSE", -1.0)])
def test_a_clock_that_does_not_converge_is_refused(monkeypatch, limit, value):
    monkeypatch.setattr(stage_2, limit, value)
    hard = motion(angle=1.3, friction=1.3, reaction="signed")
    with pytest.raises(RigidBodyError, match="changes too abruptly"):
        hard.at(0.1)


def test_no_scipy_unless_it_integrates():
    code = (
        "import sys, solver; body = solver.RectangularBody(10.0, 2.438, 9979.0)\n"
        "motion = solver.plane_motion(body, 0.26, 0.707, 25.053, 0.47); motion.at([0.1, 0.2])\n"
        "print(*sorted({name.partition('.')[0] for name in sys.modules} - sys.stdlib_module_names))\n"
        "solver.integrate_odes(body, 0.26, 0.707, 25.053, 0.47); print('scipy' in sys.modules)"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    first, second = run.stdout.splitlines()
    loaded = {name for name in first.split() if not name.startswith(("_", "sitecustomize"))}
    assert loaded & {"scipy", "numba", "matplotlib", "pyvista", "vtk", "gmsh", "fem", "meshes"} == set()
    assert {"numpy", "solver"} <= loaded
    assert second == "True"
