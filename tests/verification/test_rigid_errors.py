"""Verify refusals of the rigid theory, and earlier methods by hand."""

import math
import pickle
from dataclasses import fields
from typing import Any

import numpy as np
import pytest

from solver import (
    MotionState,
    RectangularBody,
    RigidBodyError,
    corner_impulse,
    hirsch_force,
    olson_force,
    plane_motion,
    ritter_force,
    stage_2,
    strike_force,
    tail_slap,
)

TRUCK = RectangularBody(10.0, 2.438, 9979.0)
IMPACT = {"speed": 25.0, "angle": 0.26, "friction": 0.47, "restitution": 0.22}
START = {"angle": 0.26, "omega": 0.707, "corner_speed": 25.053, "friction": 0.47}
BLOW = {"mass": 9979.0, "speed": 25.0, "angle": math.pi / 6, "front_distance": 4.0, "half_width": 1.2}
MOST = math.pi / 2.0 - TRUCK.corner_angle
NAN, INF = math.nan, math.inf


def impact(**changes):
    return corner_impulse(TRUCK, **{**IMPACT, **changes})


def motion(**changes):
    return plane_motion(TRUCK, **{**START, **changes})


def signed(**changes):
    return motion(reaction="signed", **changes)


BELOW_MOST = f"more than 0 and less than {MOST:.6g} rad"
LONG: Any = "long"
REFUSED = [
    (lambda: RectangularBody(0.0, 2.0, 1.0), "length", "0", "positive and finite, m"),
    (lambda: RectangularBody(9.0, -2.0, 1.0), "width", "-2", "positive and finite, m"),
    (
        lambda: RectangularBody(9.0, 2.0, np.array([1.0, INF])),
        "mass",
        "inf at index 1",
        "positive and finite, kg",
    ),
    (lambda: RectangularBody(LONG, 2.0, 1.0), "length", "'long'", "a number, or an array of numbers"),
    (lambda: impact(speed=0.0), "speed", "0", "positive and finite, m/s"),
    (lambda: impact(speed=NAN), "speed", "nan", "positive and finite, m/s"),
    (lambda: impact(angle=0.0), "angle", "0", BELOW_MOST),
    (lambda: impact(angle=INF), "angle", "inf", BELOW_MOST),
    (lambda: impact(angle=MOST + 1e-9), "angle", "1.3316", BELOW_MOST),
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
    (lambda: motion(angle=0.0), "angle", "0", BELOW_MOST),
    (lambda: motion(angle=MOST), "angle", "1.3316", BELOW_MOST),
    (lambda: motion(friction=-1.0), "friction", "-1", "0 or more"),
    (lambda: motion(friction=NAN), "friction", "nan", "0 or more"),
    (lambda: motion(corner_speed=0.0), "corner_speed", "0", "positive where there is friction"),
    (lambda: signed(corner_speed=-5.0), "corner_speed", "-5", "positive where there is"),
    (lambda: motion(corner_speed=INF, reaction="none"), "corner_speed", "inf", "finite"),
    (lambda: motion(corner_speed=0.3), "corner_speed", "0.3", "more, or no friction, m/s"),
    (lambda: motion(angle=1.2, friction=1.4), "friction", "1.4", "less than 4/3"),
    (lambda: signed(angle=1.2, friction=1.4), "friction", "1.4", "less than 4/3"),
    (lambda: signed(angle=1.2, friction=1.33333), "friction", "1.33333", "another reaction model"),
    (lambda: motion(reaction="push"), "reaction", "'push'", 'one of "drag", "none", "signed"'),
    (lambda: motion(omega=np.array([0.7, 0.8])), "shape", "(2,)", "`tail_slap` takes arrays"),
    (lambda: motion().at([0.1, -0.1]), "time", "-0.1 at index 1", "from 0 to 0.3877993375 s"),
    (lambda: motion().at(0.4), "time", "0.4", "the strike is at 0.3839597401 s"),
    (lambda: strike_force(0.0, 3.0, 0.1), "mass", "0", "positive and finite, kg"),
    (lambda: strike_force(1.0, NAN, 0.1), "lateral_speed", "nan", "finite, m/s"),
    (lambda: strike_force(1.0, 3.0, 0.0), "duration", "0", "positive and finite, s"),
    (lambda: olson_force(**{**BLOW, "mass": 0.0}), "mass", "0", "positive and finite, kg"),
    (lambda: olson_force(**{**BLOW, "speed": NAN}), "speed", "nan", "positive and finite, m/s"),
    (lambda: olson_force(**{**BLOW, "angle": 0.0}), "angle", "0", "between 0 and pi/2 rad"),
    (lambda: olson_force(**{**BLOW, "angle": math.pi / 2}), "angle", "1.57", "between 0 and pi/2 rad"),
    (lambda: olson_force(**{**BLOW, "front_distance": -1.0}), "front_distance", "-1", "positive"),
    (lambda: olson_force(**{**BLOW, "half_width": INF}), "half_width", "inf", "positive"),
    (lambda: olson_force(**BLOW, gravity=0.0), "gravity", "0", "positive"),
    (lambda: ritter_force(**BLOW, deflection=-0.1), "deflection", "-0.1", "0 or more"),
    (lambda: ritter_force(**{**BLOW, "half_width": 20.0}), "travel", "-", "positive: front_distance"),
    (lambda: hirsch_force(0.0), "average_force", "0", "positive and finite, N"),
]


@pytest.mark.parametrize(("call", "key", "value", "allowed"), REFUSED)
def test_the_message_names_key_value_and_what_is_allowed(call, key, value, allowed):
    with pytest.raises(RigidBodyError) as refused:
        call()
    error = refused.value
    assert error.key == key
    assert str(error.value).startswith(value)
    assert allowed in error.allowed
    assert str(error) == f"{key} is {error.value}, but {error.why}; allowed: {error.allowed}."
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
    message = r"friction is 1.9 at index 2, .*\(beta <= phi = 0.499.* rad \(28.6 deg\)\); .*cot\(phi\) = 1.83"
    with pytest.raises(RigidBodyError, match=message):
        impact(friction=friction)
    bodies = RectangularBody(10.0, np.array([[2.0], [5.0]]), 9979.0)
    with pytest.raises(RigidBodyError, match=r"angle is 1.3 at index \(1, 2\), .* less than 1.10715 rad"):
        tail_slap(bodies, np.array([0.1, 0.2, 1.3]), 0.7, 25.0, 0.1)


def test_a_stop_is_where_the_corner_stops():
    """A start at the stated speed rests at the stated angle."""
    speeds = np.array([25.0, 6.0, 0.3])
    with pytest.raises(RigidBodyError, match="corner_speed is 6 at index 1, but the corner stops") as refused:
        tail_slap(TRUCK, 0.8, 2.0, speeds, 0.9)
    words = refused.value.why.split()
    angle, time = float(words[words.index("angle") + 1]), float(words[words.index("time") + 1])
    gamma = TRUCK.corner_angle + angle
    r = TRUCK.corner_radius
    thicker = RectangularBody(2.0 * r * math.cos(gamma), 2.0 * r * math.sin(gamma), 9979.0)
    rest = plane_motion(thicker, 0.8 - angle, 2.0, 6.0 + 1e-4, 0.9).strike
    assert (rest.v_p, rest.t) == (pytest.approx(0.0, abs=2e-3), pytest.approx(time, rel=1e-5))


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
    values = {
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
    frictions = np.array([0.4, 0.4, -1.0, 9.0, NAN])
    first = corner_impulse(
        TRUCK, np.array([25.0, 0.0, 25.0, 25.0, 25.0]), 0.26, frictions, 0.2, invalid="nan"
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


def test_no_scipy_unless_it_integrates(python):
    code = (
        "import sys, solver; body = solver.RectangularBody(10.0, 2.438, 9979.0)\n"
        "motion = solver.plane_motion(body, 0.26, 0.707, 25.053, 0.47); motion.at([0.1, 0.2])\n"
        "print(*sorted({name.partition('.')[0] for name in sys.modules} - sys.stdlib_module_names))\n"
        "solver.integrate_odes(body, 0.26, 0.707, 25.053, 0.47); print('scipy' in sys.modules)"
    )
    run = python(code, check=True)
    first, second = run.stdout.splitlines()
    loaded = {name for name in first.split() if not name.startswith(("_", "sitecustomize"))}
    assert loaded & {"scipy", "matplotlib", "pyvista", "vtk", "gmsh", "fem", "meshes"} == set()
    assert {"numpy", "solver"} <= loaded
    assert second == "True"


def test_olson_by_hand():
    """30 degrees have 4/2 - 1.2 (1 - sqrt(3)/2) and 12.5 m/s."""
    travel = 2.0 - 1.2 * (1.0 - math.sqrt(3.0) / 2.0)
    force = olson_force(**BLOW)
    assert force.travel == pytest.approx(travel, rel=1e-15)
    assert force.time == pytest.approx(travel / 6.25, rel=1e-14)
    assert force.deceleration == pytest.approx(12.5**2 / (2.0 * 9.80665 * travel), rel=1e-14)
    assert force.average_force == pytest.approx(9979.0 * 12.5**2 / (2.0 * travel), rel=1e-14)


def test_the_average_force_stops_the_lateral_motion_in_the_way_there_is():
    """Work and impulse of a constant force, with a yielding barrier."""
    force = olson_force(**BLOW, deflection=0.5)
    energy, momentum = 0.5 * 9979.0 * 12.5**2, 9979.0 * 12.5
    assert force.average_force * force.travel == pytest.approx(energy, rel=1e-14)
    assert force.average_force * force.time == pytest.approx(momentum, rel=1e-14)
    same = olson_force(**BLOW).average_force
    assert olson_force(**BLOW, gravity=1.62).average_force == pytest.approx(same, rel=1e-14)
    assert force.travel == pytest.approx(olson_force(**BLOW).travel + 0.5, rel=1e-14)


def test_hirsch_and_ritter_are_olson_times_a_number():
    average = olson_force(**BLOW, deflection=0.1).average_force
    ritter = ritter_force(**BLOW, deflection=0.1)
    assert hirsch_force(average) == pytest.approx(math.pi / 2.0 * average, rel=1e-15)
    assert ritter.peak_force == pytest.approx(2.0 * average, rel=1e-14)
    assert ritter.impulse == pytest.approx(2.0 * 9979.0 * 12.5, rel=1e-14)
    assert ritter.peak_force * (2.0 * ritter.time) / 2.0 == pytest.approx(ritter.impulse, rel=1e-14)


def test_broadcasting_equals_single_calls():
    angles, masses = np.array([[0.1], [0.4]]), np.array([1000.0, 2000.0, 4000.0])
    together = olson_force(masses, 20.0, angles, 4.0, 1.2)
    pulses, peaks = ritter_force(masses, 20.0, angles, 4.0, 1.2), hirsch_force(together.average_force)
    for i, j in np.ndindex(2, 3):
        alone = olson_force(float(masses[j]), 20.0, float(angles[i, 0]), 4.0, 1.2)
        pulse = ritter_force(float(masses[j]), 20.0, float(angles[i, 0]), 4.0, 1.2)
        assert isinstance(alone.average_force, float)
        assert together.average_force[i, j] == pytest.approx(alone.average_force, rel=1e-14)
        assert pulses.peak_force[i, j] == pytest.approx(pulse.peak_force, rel=1e-14)
        assert peaks[i, j] == pytest.approx(hirsch_force(alone.average_force), rel=1e-14)
