"""Verify impulse and motion of the rigid body by balances and integration."""

import math
from dataclasses import fields
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import ellipeinc

from solver import (
    CONVENTIONS,
    REACTIONS,
    MotionState,
    RectangularBody,
    RigidBodyError,
    corner_impulse,
    integrate_odes,
    plane_motion,
    strike_force,
    tail_slap,
)

TRUCK = RectangularBody(10.0, 2.438, 9979.0)
fixed = settings(derandomize=True, max_examples=60, deadline=None, database=None)


def balances(body, speed, angle, friction, rebound):
    """Solve the balances for the impulse and the state after it.

    m (v_G - v_0) = impulse; I omega = its moment about G; v_G = v_P + omega x r; v_PY = rebound v_0 sin. Returns normal
    impulse, omega, corner speed, v_GX and v_GY in SI.
    """
    phi = angle + math.atan(body.width / body.length)
    x, y = -math.hypot(body.length, body.width) / 2 * np.array([math.cos(phi), -math.sin(phi)])  # from P to G
    m, inertia = body.mass, body.mass * (body.length**2 + body.width**2) / 12
    matrix = [
        [friction, 0.0, 0.0, m, 0.0],
        [-1.0, 0.0, 0.0, 0.0, m],
        [x + friction * y, inertia, 0.0, 0.0, 0.0],  # arm from G to P: -(x, y); impulse: (-mu, 1)
        [0.0, y, -1.0, 1.0, 0.0],
        [0.0, -x, 0.0, 0.0, 1.0],
    ]
    v_x, v_y = speed * math.cos(angle), -speed * math.sin(angle)
    return np.linalg.solve(matrix, np.array([m * v_x, m * v_y, 0.0, 0.0, -rebound * v_y]))


@fixed
@given(
    ratio=st.floats(0.01, 1.0),
    share=st.floats(0.01, 0.99),
    friction_share=st.floats(0.0, 0.99),
    restitution=st.floats(0.0, 1.0),
    speed=st.floats(0.1, 100.0),
    convention=st.sampled_from(CONVENTIONS),
)
def test_the_impulse_balances_momentum(ratio, share, friction_share, restitution, speed, convention):
    body = RectangularBody(8.0, 8.0 * ratio, 5000.0)
    angle = share * (math.pi / 2 - body.corner_angle)
    friction = friction_share / math.tan(angle + body.corner_angle)
    result = corner_impulse(body, speed, angle, friction, restitution, convention)
    rebound = restitution if convention == "newton" else -restitution
    normal, omega, corner_speed, _, _ = balances(body, speed, angle, friction, rebound)
    scale = speed * np.array([body.mass, 1.0 / body.corner_radius, 1.0])
    impulse = normal * math.hypot(1.0, friction)
    got = np.array([result.impulse, result.omega, result.corner_speed])
    assert np.all(abs(got - [impulse, omega, corner_speed]) <= 1e-13 * scale)


def test_equation_31_as_printed():
    angle, friction, restitution, speed = 0.3, 0.6, 0.1, 20.0
    result = corner_impulse(TRUCK, speed, angle, friction, restitution)
    beta, phi, c = math.atan(1 / friction), angle + math.atan(2.438 / 10.0), math.hypot(10.0, 2.438)
    turning = math.sin(beta) / (3 * math.sin(beta - phi)) + math.cos(phi)
    omega = 2 * (1 - restitution) * speed * math.sin(angle) / (c * turning)
    impulse = omega * 9979.0 * c / (6 * math.sin(beta - phi))
    corner = speed * math.cos(angle) - impulse / 9979.0 * math.cos(beta) + omega * c / 2 * math.sin(phi)
    for name, value in (("omega", omega), ("impulse", impulse), ("corner_speed", corner)):
        assert getattr(result, name) == pytest.approx(value, rel=1e-14), name


def test_the_conventions_differ_by_the_factor_of_the_impulse():
    paper, newton = (corner_impulse(TRUCK, 25.0, 0.26, 0.47, 0.22, name) for name in ("paper", "newton"))
    assert newton.omega / paper.omega == pytest.approx(1.22 / 0.78, rel=1e-14)
    assert newton.impulse / paper.impulse == pytest.approx(1.22 / 0.78, rel=1e-14)


def test_a_perfectly_elastic_corner_in_the_papers_convention_is_not_stopped_at_all():
    result = corner_impulse(TRUCK, 25.0, 0.26, 0.47, 1.0)
    assert ((result.omega, result.impulse), result.corner_speed) == ((0.0, 0.0), 25.0 * math.cos(0.26))


def test_impulses_of_arrays_equal_single_calls():
    angles, frictions = np.array([[0.1], [0.3]]), np.array([0.0, 0.47, 0.9])
    body = RectangularBody(np.array([6.0, 8.0, 10.0]), 2.4, 9000.0)
    together = corner_impulse(body, 20.0, angles, frictions, 0.2)
    assert together.omega.shape == together.corner_speed.shape == together.impulse.shape == (2, 3)
    for i, j in np.ndindex(2, 3):
        one = RectangularBody(float(np.asarray(body.length)[j]), 2.4, 9000.0)
        alone = corner_impulse(one, 20.0, float(angles[i, 0]), float(frictions[j]), 0.2)
        assert isinstance(alone.omega, float)
        for name in ("omega", "corner_speed", "impulse"):
            assert getattr(together, name)[i, j] == pytest.approx(getattr(alone, name), rel=1e-14)


def test_every_field_has_the_common_shape():
    """Even where a field does not depend on what varies."""
    bodies = RectangularBody(10.0, 2.438, np.array([5000.0, 9979.0]))
    results = corner_impulse(bodies, 25.0, 0.26, 0.47, 0.22)
    assert results.omega.shape == results.corner_speed.shape == results.impulse.shape == (2,)
    force = strike_force(9979.0, 3.0, np.array([0.1, 0.2, 0.4]))
    assert force.impulse.shape == force.duration.shape == force.peak_force.shape == (3,)


def test_the_body():
    body = RectangularBody(6.0, 8.0, 12.0)
    assert (body.corner_radius, body.corner_angle) == (5.0, math.atan2(8.0, 6.0))
    assert body.moment_of_inertia == pytest.approx(100.0, rel=1e-15)
    bodies = RectangularBody(np.array([6.0, 3.0]), np.array([8.0, 4.0]), 12.0)
    assert np.asarray(bodies.corner_radius).tolist() == [5.0, 2.5]
    assert bodies.moment_of_inertia == pytest.approx([100.0, 25.0], rel=1e-15)


def test_the_triangular_pulse_holds_the_momentum():
    force = strike_force(1000.0, np.array([-3.0, 3.0]), 0.1)
    assert force.impulse.tolist() == [3000.0, 3000.0]
    assert force.peak_force == pytest.approx([60000.0, 60000.0], rel=1e-15)
    assert force.duration.tolist() == [0.1, 0.1]
    assert force.peak_force * force.duration / 2 == pytest.approx(force.impulse, rel=1e-15)


START: dict[str, Any] = {"angle": 0.26, "omega": 0.707, "corner_speed": 25.053, "friction": 0.47}
NAMES = [field.name for field in fields(MotionState)]
# t, v_GY, v_GX; omega, s, v_P at theta = 0 for START: Eqs 66-71 by Taylor series with 30 digits.
FIRST_THREE = {
    "drag": (0.38395974012062573, -3.2755267205481329, 23.273331109008525),
    "none": (0.3831252875274082, -3.2868596946836896, 23.31135347503563),
    "signed": (0.38198946853831261, -3.3020660056320637, 23.361849305052182),
}
LAST_THREE = {
    "drag": (0.65510534410962657, 9.4236754418595056, 24.071904523478159),
    "none": (0.65737193893673792, 9.412600304860043, 24.112689868599513),
    "signed": (0.66041320112641275, 9.3974582231843572, 24.16689299722528),
}


@pytest.mark.parametrize("reaction", REACTIONS)
def test_the_strike_to_fifteen_digits(reaction):
    strike = plane_motion(TRUCK, **START, reaction=reaction).strike
    got = (strike.t, strike.v_gy, strike.v_gx, strike.omega, strike.slide, strike.v_p)
    expected = (*FIRST_THREE[reaction], *LAST_THREE[reaction])
    assert (got, strike.theta) == (pytest.approx(expected, rel=5e-15), 0.0)


def test_without_friction_time_is_an_elliptic_integral():
    """omega_0 sqrt(D_0) t = 2 [E(phi_0|3/4) - E(gamma|3/4)].

    omega^2 (1 + 3 cos^2) is constant.
    """
    shares = np.concatenate([np.logspace(-6, -1, 30), np.linspace(0.1, 0.999, 40), [1.0 - 1e-9]])
    body = RectangularBody(10.0, 10.0 * np.array([[0.01], [0.2438], [1.0]]), 1000.0)
    phi = body.corner_angle + shares * (math.pi / 2 - body.corner_angle)
    angle = phi - body.corner_angle
    strike = tail_slap(body, angle, 0.7, 30.0, 0.9, "none")
    integral = 2.0 * (ellipeinc(phi, 0.75) - ellipeinc(body.corner_angle, 0.75))
    expected = integral / (0.7 * np.sqrt(1.0 + 3.0 * np.cos(phi) ** 2))
    # The difference of the two integrals rounds like 1 part in angle.
    assert np.all(abs(strike.t / expected - 1.0) < 2e-15 + 2e-15 / angle)


def test_without_friction_the_invariant_holds_and_nothing_is_lost():
    motion = plane_motion(TRUCK, **START, reaction="none")
    states = motion.at(np.linspace(0.0, motion.strike.t, 50))
    phi = states.theta + TRUCK.corner_angle
    assert np.ptp(states.omega**2 * (1 + 3 * np.cos(phi) ** 2)) < 1e-14
    assert np.ptp(states.v_gx) == 0.0
    assert np.ptp(states.kinetic_energy) < 1e-14 * motion.strike.kinetic_energy
    assert not np.any(states.friction_work)
    assert not np.any(states.reaction_tangential)
    assert states.theta == pytest.approx(plane_motion(TRUCK, 0.26, 0.707, -9.0, 0.0).at(states.t).theta)


@pytest.mark.parametrize("reaction", REACTIONS)
def test_each_rate_is_the_derivative_of_what_it_should_be(reaction):
    """Newton's law and the kinematics, by differentiating a polynomial through `at`."""
    motion = plane_motion(TRUCK, 0.6, 1.3, 20.0, 0.9, reaction)
    end = motion.strike.t
    nodes = 0.5 * end * (1.0 - np.cos(math.pi * (np.arange(40) + 0.5) / 40))
    states = motion.at(nodes)

    def rate(values):
        return np.polynomial.Chebyshev.fit(nodes, values, 39, domain=[0.0, end]).deriv()(nodes)

    phi, r = states.theta + TRUCK.corner_angle, TRUCK.corner_radius
    inward = np.cos(phi) * states.reaction_normal + np.sin(phi) * states.reaction_tangential
    pairs = {
        "omega": (states.omega, -rate(states.theta)),
        "v_p": (states.v_p, rate(states.slide)),
        "v_gx": (states.v_gx, rate(states.slide - r * np.cos(phi))),
        "v_gy": (states.v_gy, rate(r * np.sin(phi))),
        "normal": (states.reaction_normal, TRUCK.mass * rate(states.v_gy)),
        "tangential": (states.reaction_tangential, TRUCK.mass * rate(states.v_gx)),
        "power": (states.reaction_tangential * states.v_p, rate(states.friction_work)),
        "moment": (TRUCK.moment_of_inertia * rate(states.omega), r * inward),
    }
    for name, (value, expected) in pairs.items():
        scale = abs(states.reaction_normal).max() if name == "tangential" else abs(value).max()
        assert value == pytest.approx(expected, rel=0.0, abs=1e-9 * scale), name


@pytest.mark.parametrize(("reaction", "sign"), [("drag", 1.0), ("signed", -1.0)])
def test_reaction_and_friction(reaction, sign):
    motion = plane_motion(TRUCK, **START, reaction=reaction)
    states = motion.at(np.linspace(0.0, motion.strike.t, 20))
    assert np.all(states.reaction_normal < 0.0)
    assert states.reaction_tangential == pytest.approx(sign * 0.47 * states.reaction_normal, rel=1e-15)
    assert np.all(sign * np.diff(states.friction_work) < 0.0)


@pytest.mark.parametrize("reaction", ["drag", "signed"])
def test_energy_balances_and_the_work_is_that_of_the_force(reaction):
    motion = plane_motion(TRUCK, 0.9, 2.0, 25.0, 0.8, reaction)
    x, w = np.polynomial.legendre.leggauss(30)
    end = motion.strike.t
    states = motion.at(0.5 * end * (1.0 + x))
    work = 0.5 * end * np.sum(w * states.reaction_tangential * states.v_p)
    assert motion.strike.friction_work == pytest.approx(work, rel=1e-12)
    before = motion.at(0.0).kinetic_energy
    assert states.kinetic_energy - states.friction_work == pytest.approx(before, rel=1e-14)
    assert motion.strike.kinetic_energy - motion.strike.friction_work == pytest.approx(before, rel=1e-14)


def test_the_motion_begins_at_its_start_and_passes_the_strike():
    motion = plane_motion(TRUCK, **START)
    first = motion.at(0.0)
    assert (first.theta, first.omega, first.slide) == pytest.approx((0.26, 0.707, 0.0), rel=1e-15, abs=1e-15)
    assert first.v_p == pytest.approx(25.053, rel=1e-15)
    assert isinstance(first.theta, float)
    for name in NAMES:
        assert getattr(motion.first, name) == pytest.approx(getattr(first, name), rel=1e-13, abs=1e-13)
    there = motion.at([motion.strike.t])
    for name in NAMES:
        expected = getattr(motion.strike, name)
        assert getattr(there, name) == pytest.approx([expected], rel=1e-14, abs=1e-15), name
    past = motion.at([[motion.latest]])
    assert (motion.latest, past.theta.shape) == (1.01 * motion.strike.t, (1, 1))
    expected = -0.01 * motion.strike.t * motion.strike.omega
    assert past.theta == pytest.approx(expected, rel=1e-3)


def test_a_motion_is_followed_no_further_than_its_equations_hold():
    """A thin body continues to phi = 0."""
    thin = plane_motion(RectangularBody(10.0, 1e-4, 1.0), 1.2, 1.0, 30.0, 0.5)
    assert thin.strike.t < thin.latest < 1.001 * thin.strike.t
    assert thin.at(thin.latest).theta == pytest.approx(-1e-5, rel=1e-9)
    upper_root = (4.2 + math.sqrt(4.2**2 - 16.0)) / 2.0
    start = (RectangularBody(1.0, upper_root + 0.02, 1.0), 0.2, 1.0, 30.0, 1.4, "signed")
    singular, integrated = plane_motion(*start), integrate_odes(*start)
    assert singular.latest == pytest.approx(singular.strike.t, rel=1e-12)
    t = 0.9 * singular.strike.t
    assert singular.at(t).v_p == pytest.approx(integrated.at(t).v_p, rel=1e-9)


@pytest.mark.parametrize("reaction", REACTIONS)
def test_times_and_angles_are_each_others_inverse(reaction):
    """A thicker body, started closer, needs the time to an angle."""
    friction = 1.25
    motion = plane_motion(RectangularBody(10.0, 0.1, 1.0), 1.5, 1.0, 300.0, friction, reaction)
    times = np.linspace(0.05, 0.99, 30) * motion.strike.t
    states = motion.at(times)
    phi_0 = motion.body.corner_angle + 1.5
    gamma = motion.body.corner_angle + states.theta
    thicker = RectangularBody(np.cos(gamma), np.sin(gamma), 1.0)
    until = tail_slap(thicker, phi_0 - gamma, 1.0, 300.0, friction, reaction)
    assert until.t == pytest.approx(times, rel=1e-13)
    assert until.omega == pytest.approx(states.omega, rel=1e-12)


def test_omega_is_proportional_to_its_start():
    factors = np.array([0.1, 1.0, 10.0])
    strikes = tail_slap(TRUCK, 0.7, factors, 300.0, 0.8)
    for name, power in (("omega", 1.0), ("t", -1.0), ("reaction_normal", 2.0)):
        values = getattr(strikes, name)
        assert values / values[1] == pytest.approx(factors**power, rel=1e-14), name


def test_the_ratio_of_forces_for_two_restitutions_is_exact():
    """F(e = 0)/F(e) = 1/(1 - e) for any corner speed."""
    lateral = []
    for restitution in (0.0, 0.22):
        start = corner_impulse(TRUCK, 25.0, 0.26, 0.47, restitution)
        lateral.append(plane_motion(TRUCK, 0.26, start.omega, start.corner_speed, 0.47).strike.v_gy)
    assert lateral[0] / lateral[1] == pytest.approx(1.0 / 0.78, rel=1e-14)


def test_small_angles():
    for angle in (1e-3, 1e-6, 1e-9):
        strike = plane_motion(TRUCK, angle, 0.5, 20.0, 0.47).strike
        for name, value in (("t", angle / 0.5), ("slide", 20.0 * angle / 0.5), ("omega", 0.5)):
            assert getattr(strike, name) == pytest.approx(value, rel=2.0 * angle + 1e-14), name


def test_drag_and_signed_meet_in_none():
    """The change is linear in mu for small mu, and opposite."""
    none = plane_motion(TRUCK, **START, reaction="none").strike
    small = {**START, "friction": 1e-5}
    drag, signed = (plane_motion(TRUCK, **small, reaction=name).strike for name in ("drag", "signed"))
    for name in ("t", "omega", "v_gx", "v_gy", "slide", "kinetic_energy"):
        up, down = getattr(drag, name) - getattr(none, name), getattr(signed, name) - getattr(none, name)
        assert up == pytest.approx(-down, rel=1e-4), name
        assert up != 0.0
    for name in NAMES:
        frictionless = plane_motion(TRUCK, 0.26, 0.707, 25.053, 0.0, "drag").strike
        assert getattr(frictionless, name) == getattr(none, name)


@pytest.mark.parametrize(
    ("reaction", "angle", "steps"),
    [("drag", 0.6, (-1, 0, 1)), ("signed", 0.6, (-1, 0, 1)), ("drag", 1.3, (-2, -1, 0))],
)
def test_the_closed_form_is_smooth_across_the_critical_friction(reaction, angle, steps):
    """The second difference across mu = 4/3 is rounding.

    The form is atan below, atanh above.
    """
    frictions = (4.0 / 3.0 + 1e-9 * step for step in steps)
    a, b, c = (plane_motion(TRUCK, angle, 1.0, 80.0, friction, reaction).strike for friction in frictions)
    for name in set(NAMES) - {"theta"}:
        first, middle, last = (getattr(state, name) for state in (a, b, c))
        assert first - 2.0 * middle + last == pytest.approx(0.0, abs=1e-13 * abs(middle)), name
        assert first != last, name


def test_broadcasting_equals_single_calls():
    widths, angles = np.array([[0.2], [2.438], [9.0]]), np.array([0.05, 0.26, 0.7])
    body = RectangularBody(10.0, widths, 9979.0)
    for reaction in REACTIONS:
        together = tail_slap(body, angles, 0.7, 25.0, np.array([0.0, 0.47, 1.2]), reaction)
        for i, j in np.ndindex(3, 3):
            one = RectangularBody(10.0, float(widths[i, 0]), 9979.0)
            alone = plane_motion(one, float(angles[j]), 0.7, 25.0, [0.0, 0.47, 1.2][j], reaction).strike
            for name in NAMES:
                value = getattr(together, name)
                assert value.shape == (3, 3)
                assert value[i, j] == pytest.approx(getattr(alone, name), rel=2e-14, abs=1e-12), name


def test_numbers_in_numbers_out():
    """Integers and scalars of NumPy count as numbers."""
    body = RectangularBody(10, 2.438, np.float64(9979.0))
    scalar: Any = np.float32(25.0)
    without_dimension: Any = np.array(0)
    first = plane_motion(TRUCK, 0.26, 1, scalar, without_dimension).strike
    strikes = (first, tail_slap(body, np.float64(0.26), 1, 25, 0))
    for strike in strikes:
        assert {type(getattr(strike, name)) for name in NAMES} == {float}
    assert strikes[0] == strikes[1]


def test_a_hundred_thousand_motions_are_finite():
    random = np.random.default_rng(0)
    n = 100_000
    body = RectangularBody(10.0, random.uniform(0.1, 3.0, n), 9979.0)
    limits = ((0.05, 1.2), (0.1, 1.0), (30.0, 60.0), (0.0, 1.3))
    angle, omega, speed, friction = (random.uniform(*ends, n) for ends in limits)
    assert np.all(np.isfinite(tail_slap(body, angle, omega, speed, friction).t))


BEGUN = (0.26, 0.707, 25.053, 0.47)
searched = settings(derandomize=True, deadline=None, database=None)
shapes, shares = st.floats(-2.0, 0.0).map(lambda power: 10.0**power), st.floats(0.001, 0.999)
frictions = st.floats(0.0, 1.25) | st.floats(1.34, 2.5)  # next to 4/3 a signed motion has no ten digits


def arguments(ratio, share, omega, speed_ratio):
    body = RectangularBody(8.0, 8.0 * ratio, 5000.0)
    angle = share * (math.pi / 2 - body.corner_angle)
    return body, angle, omega, speed_ratio * omega * body.corner_radius


def attempt(solve, motion):
    """The state at the strike, or the key of the refusal."""
    try:
        return solve(*motion).strike
    except RigidBodyError as error:
        return error.key


motions = {
    "ratio": shapes, "share": shares, "omega": st.floats(0.05, 10.0), "speed_ratio": st.floats(2.0, 30.0),
}  # fmt: skip
motions |= {"friction": frictions, "reaction": st.sampled_from(REACTIONS)}


def agree_or_refuse(ratio, share, omega, speed_ratio, friction, reaction):
    """The values are drawn by Hypothesis and passed by name."""
    motion = (*arguments(ratio, share, omega, speed_ratio), friction, reaction)
    exact, integrated = attempt(plane_motion, motion), attempt(integrate_odes, motion)
    if isinstance(exact, str) or isinstance(integrated, str):
        # Where the motion is both ambiguous and brought to a stop, each reports the first of them.
        assert {exact, integrated} <= {"friction", "corner_speed"}
        return
    for name in NAMES:
        value = getattr(exact, name)
        assert value == pytest.approx(getattr(integrated, name), rel=1e-10, abs=1e-300), name


test_both_agree_or_both_refuse = settings(searched, max_examples=60)(given(**motions)(agree_or_refuse))
many = settings(searched, max_examples=400)(given(**motions)(agree_or_refuse))
test_many_agree_or_both_refuse = pytest.mark.long(many)


@pytest.mark.parametrize("reaction", REACTIONS)
def test_the_motion_in_between(reaction):
    exact = plane_motion(TRUCK, *BEGUN, reaction)
    integrated = integrate_odes(TRUCK, *BEGUN, reaction)
    times = np.linspace(0.0, 0.99 * exact.strike.t, 21).reshape(3, 7)
    here, there = exact.at(times), integrated.at(times)
    for name in NAMES:
        assert getattr(there, name).shape == (3, 7)
        assert getattr(here, name) == pytest.approx(getattr(there, name), rel=1e-9, abs=1e-9), name


def test_the_hyperbolic_form_past_the_critical_friction():
    """Paths are on either side of the singular angles.

    These are roots of T^2 - 3 mu T + 4 with T = tan(phi); one body is below both, one above.
    """
    for body, angle in ((TRUCK, 0.6), (RectangularBody(1.0, 3.5, 10.0), 0.2)):
        for reaction in ("drag", "signed"):
            motion = (body, angle, 1.0, 60.0, 1.45, reaction)
            exact, integrated = plane_motion(*motion).strike, integrate_odes(*motion).strike
            for name in NAMES:
                assert getattr(exact, name) == pytest.approx(getattr(integrated, name), rel=1e-11), name


def test_a_tighter_tolerance_comes_closer():
    exact = plane_motion(TRUCK, 1.2, 0.5, 25.0, 0.9).strike
    errors = []
    for rtol in (1e-4, 1e-7, 1e-10):
        numerical = integrate_odes(TRUCK, 1.2, 0.5, 25.0, 0.9, method="RK45", rtol=rtol, atol=rtol).strike
        errors.append(abs(numerical.slide - exact.slide))
    assert errors[0] > 50.0 * errors[1] > 2500.0 * errors[2] > 0.0


UPPER_ROOT = (4.2 + math.sqrt(4.2**2 - 16.0)) / 2.0
STEEPEST = math.atan(UPPER_ROOT) - TRUCK.corner_angle
REFUSED = [
    ((0.26, -1.0, 25.0, 0.47), r"omega is -1, but .*; allowed: positive"),
    ((np.array([0.2, 0.3]), 0.7, 25.0, 0.47), r"shape is \(2,\), but this is one motion"),
    ((*BEGUN, "pull"), r'reaction is \'pull\', .*"drag", "none", "signed"'),
    ((0.9, 0.7, 250.0, 1.4), r"friction is 1.4, .* from the angle 0.9 rad on; allowed: less than 4/3"),
    ((1.1, 0.7, 250.0, 1.4), rf"friction is 1.4, .* from the angle {STEEPEST:.6g} rad on"),
]


@pytest.mark.parametrize(("motion", "message"), REFUSED)
def test_the_integrator_refuses_what_has_no_answer(motion, message):
    with pytest.raises(RigidBodyError, match=message):
        integrate_odes(TRUCK, *motion)


def test_the_integrator_refuses_on_its_way(monkeypatch):
    with pytest.raises(RigidBodyError, match=r"friction is 1.4, .* from the angle") as refused:
        integrate_odes(TRUCK, 1.1, 0.7, 250.0, 1.4, "signed")
    assert float(refused.value.why.split()[-3]) == pytest.approx(STEEPEST, abs=1e-4)
    with pytest.raises(RigidBodyError, match=r"time is 1 at index 1, but .*from 0 to 0.3839597401 s"):
        integrate_odes(TRUCK, *BEGUN).at([0.0, 1.0])
    monkeypatch.setattr("solver.odes._LONGEST", 0.1)
    with pytest.raises(RigidBodyError, match=r"friction is 0.47, but the angular velocity changes too abr"):
        integrate_odes(TRUCK, *BEGUN)


def test_a_corner_that_stops_is_reported_at_the_same_place():
    """Both name the angle and the time, by root and event."""
    messages = []
    for solve in (plane_motion, integrate_odes):
        with pytest.raises(RigidBodyError, match="stops before the tail-slap, at the angle") as refused:
            solve(TRUCK, 0.8, 2.0, 6.0, 0.9)
        messages.append(str(refused.value))
    assert messages[0] == messages[1]
