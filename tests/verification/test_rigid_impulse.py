"""Verification: Stage 1 against the momentum balances it stands for, and Stage 3 and the body by hand."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from solver import CONVENTIONS, RectangularBody, corner_impulse, strike_force

TRUCK = RectangularBody(10.0, 2.438, 9979.0)
fixed = settings(derandomize=True, max_examples=60, deadline=None, database=None)


def balances(
    body: RectangularBody[float], speed: float, angle: float, friction: float, rebound: float
) -> np.ndarray:
    """Solve the balances for (normal impulse, omega, corner speed, v_GX, v_GY) after; SI.

    m (v_G - v_0) = impulse; I omega = its moment about G; v_G = v_P + omega x r; v_PY = rebound v_0 sin.
    """
    phi = angle + math.atan(body.width / body.length)
    x, y = -math.hypot(body.length, body.width) / 2 * np.array([math.cos(phi), -math.sin(phi)])  # from P to G
    m, inertia = body.mass, body.mass * (body.length**2 + body.width**2) / 12
    matrix = np.array(
        [
            [friction, 0.0, 0.0, m, 0.0],
            [-1.0, 0.0, 0.0, 0.0, m],
            [x + friction * y, inertia, 0.0, 0.0, 0.0],  # arm from G to P: -(x, y); impulse: (-mu, 1)
            [0.0, y, -1.0, 1.0, 0.0],
            [0.0, -x, 0.0, 0.0, 1.0],
        ]
    )
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
    omega = (
        2 * (1 - restitution) * speed * math.sin(angle)
        / (c * (math.sin(beta) / (3 * math.sin(beta - phi)) + math.cos(phi)))
    )  # fmt: skip
    impulse = omega * 9979.0 * c / (6 * math.sin(beta - phi))
    corner = speed * math.cos(angle) - impulse / 9979.0 * math.cos(beta) + omega * c / 2 * math.sin(phi)
    assert result.omega == pytest.approx(omega, rel=1e-14)
    assert result.impulse == pytest.approx(impulse, rel=1e-14)
    assert result.corner_speed == pytest.approx(corner, rel=1e-14)


def test_the_conventions_differ_by_the_factor_of_the_impulse():
    paper, newton = (corner_impulse(TRUCK, 25.0, 0.26, 0.47, 0.22, name) for name in ("paper", "newton"))
    assert newton.omega / paper.omega == pytest.approx(1.22 / 0.78, rel=1e-14)
    assert newton.impulse / paper.impulse == pytest.approx(1.22 / 0.78, rel=1e-14)


def test_a_perfectly_elastic_corner_in_the_papers_convention_is_not_stopped_at_all():
    result = corner_impulse(TRUCK, 25.0, 0.26, 0.47, 1.0)
    assert (result.omega, result.impulse) == (0.0, 0.0)
    assert result.corner_speed == 25.0 * math.cos(0.26)


def test_broadcasting_equals_single_calls():
    angles, frictions = np.array([[0.1], [0.3]]), np.array([0.0, 0.47, 0.9])
    body = RectangularBody(np.array([6.0, 8.0, 10.0]), 2.4, 9000.0)
    together = corner_impulse(body, 20.0, angles, frictions, 0.2)
    assert together.omega.shape == together.corner_speed.shape == together.impulse.shape == (2, 3)
    for i, j in np.ndindex(2, 3):
        one = RectangularBody(float(body.length[j]), 2.4, 9000.0)
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
    assert body.corner_radius == 5.0
    assert body.corner_angle == math.atan2(8.0, 6.0)
    assert body.moment_of_inertia == pytest.approx(100.0, rel=1e-15)
    bodies = RectangularBody(np.array([6.0, 3.0]), np.array([8.0, 4.0]), 12.0)
    assert bodies.corner_radius.tolist() == [5.0, 2.5]
    assert bodies.moment_of_inertia == pytest.approx([100.0, 25.0], rel=1e-15)


def test_the_triangular_pulse_holds_the_momentum():
    force = strike_force(1000.0, np.array([-3.0, 3.0]), 0.1)
    assert force.impulse.tolist() == [3000.0, 3000.0]
    assert force.peak_force == pytest.approx([60000.0, 60000.0], rel=1e-15)
    assert force.duration.tolist() == [0.1, 0.1]
    assert force.peak_force * force.duration / 2 == pytest.approx(force.impulse, rel=1e-15)
