"""Stage 2 in closed form: everything at a given angle but the time at which it is reached.

With S = sin(phi), C = cos(phi), phi = theta + gamma, and mu the friction coefficient with the sign of its
reaction model (+ drag, 0 none, - signed), Eqs 57 and 60 say along the path
    d(omega)/omega = 3 S (C + mu S)/D d(phi),   D = 1 + 3 C^2 + 3 mu S C,
and as D' = -6 S C + 3 mu (C^2 - S^2), the right-hand side is -dD/(2 D) + (3 mu/2) d(phi)/D:
    omega/omega_0 = sqrt(D_0/D) exp((3 mu/2) J),   J = integral of d(phi)/D from phi_0 to phi.
The reaction's components keep the ratio R = mu N, so that v_GX - mu v_GY is constant; one more integration
makes X_G - mu Y_G linear in time. Only the time itself is left as an integral (`elapsed`).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from solver.elementary import Number, functions
from solver.state import MotionState


class Path(NamedTuple):
    """What the course of the angle depends on; floats or arrays. Angles [rad], mu with its model's sign."""

    gamma: Any
    theta_0: Any
    mu: Any


class Start(NamedTuple):
    """The state Stage 2 starts from, and its body; floats or arrays. SI, signs as in MotionState."""

    path: Path
    mass: Any
    radius: Any
    omega_0: Any
    v_p0: Any


def denominator(s: Any, c: Any, mu: Any) -> Any:
    """D at the angle phi whose sine and cosine are s and c: that of Eqs 66-67 over 4 r^2."""
    return 1.0 + 3.0 * c * (c + mu * s)


def slowness(path: Path, theta: Any) -> Any:
    """omega_0/omega at the angles theta [rad]."""
    return _slowness(path.mu, *_course(path, theta))


def _slowness(mu: Any, d_ratio: Any, j: Any) -> Any:
    f = functions(d_ratio)
    return f.sqrt(d_ratio) * f.exp(-1.5 * mu * j)


def _course(path: Path, theta: Any) -> tuple[Any, Any]:
    """D/D_0 and J at theta.

    J = (2/k) [atan((2 tan(phi) + p)/k) - atan((2 tan(phi_0) + p)/k)], p = 3 mu, k^2 = 16 - p^2, but as one
    angle, which has no tan to run away and no branch to lose; past |mu| = 4/3, k is imaginary.
    """
    gamma, theta_0, mu = path
    f_0, f = functions(gamma, theta_0, mu), functions(theta, gamma, theta_0, mu)
    phi_0, phi, p = gamma + theta_0, gamma + theta, 3.0 * mu
    s_0, c_0, s, c = f_0.sin(phi_0), f_0.cos(phi_0), f.sin(phi), f.cos(phi)
    k2 = (4.0 - 2.0 * mu - mu) * (4.0 + 2.0 * mu + mu)  # a factor near 0 is exact, and not 0: 4/3 is no float
    k = f_0.sqrt(abs(k2))
    opposite = (2.0 * k) * f.sin(theta - theta_0)
    b_0 = 2.0 * s_0 + p * c_0
    adjacent = (k2 * c_0 + p * b_0) * c + (2.0 * b_0) * s
    j = (2.0 / k) * _arc(f, opposite, adjacent, k2 < 0.0)
    return denominator(s, c, mu) / denominator(s_0, c_0, mu), j


def _arc(f: Any, opposite: Any, adjacent: Any, hyperbolic: Any) -> Any:
    if hyperbolic is False or not np.any(hyperbolic):
        return f.atan2(opposite, adjacent)
    ratio = opposite / f.where(hyperbolic, adjacent, 1.0)
    return f.where(hyperbolic, f.atanh(f.where(hyperbolic, ratio, 0.0)), f.atan2(opposite, adjacent))


def state(start: Start, theta: Number, t: Number) -> MotionState[Any]:
    """The exact state at the angle theta [rad], which is reached at the time t [s]."""
    (gamma, theta_0, mu), m, r, omega_0, v_p0 = start
    f_0, f = functions(gamma, theta_0), functions(theta, gamma)
    phi_0, phi = gamma + theta_0, gamma + theta
    s_0, c_0, s, c = f_0.sin(phi_0), f_0.cos(phi_0), f.sin(phi), f.cos(phi)
    d, (d_ratio, j) = denominator(s, c, mu), _course(start.path, theta)
    u, u_0 = r * omega_0 / _slowness(mu, d_ratio, j), r * omega_0
    v_gy, v_gy0, v_gx0 = -u * c, -u_0 * c_0, v_p0 - u_0 * s_0  # Eqs 70-71
    v_gx = v_gx0 + mu * (v_gy - v_gy0)
    mean, turn = 0.5 * (phi + phi_0), 2.0 * r * f.sin(0.5 * (theta - theta_0))
    slide = (v_gx0 - mu * v_gy0) * t + turn * (mu * f.cos(mean) - f.sin(mean))  # G's, and G to P
    normal = -m * u * (u / r) * s / d
    energy = 0.5 * m * (v_gx * v_gx + v_gy * v_gy + u * u / 3.0)
    # The gain of energy, m/2 (v_GX^2) + m/6 (u^2 (1 + 3 C^2)), with each difference in closed form, so that
    # it vanishes without friction; D u^2 = D_0 u_0^2 exp(3 mu J).
    turning = f.expm1(3.0 * mu * j) * u_0 * u_0 * (d / d_ratio)
    turning -= 3.0 * mu * (u * u * s * c - u_0 * u_0 * s_0 * c_0)
    work = m * (mu * (v_gy - v_gy0) * (v_gx + v_gx0) / 2.0 + turning / 6.0)
    v_p, tangential = v_gx + u * s, mu * normal
    return MotionState(t, theta, u / r, v_gx, v_gy, v_p, slide, normal, tangential + 0.0, energy, work + 0.0)
