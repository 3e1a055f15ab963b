"""Stage 1 (Eqs 6-33), the impulse at the front corner."""

import math
from dataclasses import dataclass
from typing import Any, Generic

from solver import rules
from solver.body import RectangularBody
from solver.conditions import Gate, Number, V, choose, functions, number

CONVENTIONS = ("paper", "newton")


@dataclass(frozen=True)
class ImpulseResult(Generic[V]):
    """State after the impulse, as floats or arrays of one shape.

    Attributes
    ----------
    omega : float or ndarray
        Angular velocity [rad/s], positive where it turns the side towards the wall (Eq 31 [1]_).
    corner_speed : float or ndarray
        Velocity of the corner along the wall [m/s], positive forwards (Eq 33).
    impulse : float or ndarray
        Magnitude of the impulse of normal force and friction together [N s] (Eq 32).

    References
    ----------
    .. [1] Chuong and Malla, Infrastructures 2025, 10(11), 307.
    """

    omega: V
    corner_speed: V
    impulse: V


def corner_impulse(
    body: RectangularBody[Any],
    speed: Number,
    angle: Number,
    friction: Number,
    restitution: Number,
    convention: str = "paper",
    *,
    invalid: str = "raise",
) -> ImpulseResult[Any]:
    """Return the velocities after the front corner has struck the wall.

    Arguments broadcast.

    Parameters
    ----------
    body : RectangularBody
        The vehicle.
    speed : float or array_like
        Speed of the vehicle, v_0 [m/s].
    angle : float or array_like
        Angle between its side and the wall, theta [rad].
    friction : float or array_like
        Friction coefficient mu [-].
    restitution : float or array_like
        Coefficient of restitution e [-].
    convention : {"paper", "newton"}
        "paper" (Eq 24 [1]_) lets the corner go on into the wall at e v_0 sin(theta), so that the impulse is
        proportional to 1 - e; "newton" lets it rebound: 1 + e.
    invalid : {"raise", "nan"}
        Whether rows without an answer raise, or are NaN.

    Returns
    -------
    ImpulseResult
        Floats, or arrays of the common shape.

    Raises
    ------
    RigidBodyError
        For an input that is not finite, speed <= 0, friction < 0, restitution outside 0 to 1, an angle outside
        0 < theta < pi/2 - gamma, and for friction >= cot(phi), where the impulse no longer turns the vehicle
        towards the wall.

    References
    ----------
    .. [1] Chuong and Malla, Infrastructures 2025, 10(11), 307, Eqs 6-33.
    """
    choose("convention", convention, CONVENTIONS)
    v_0, theta = number("speed", speed), number("angle", angle)
    mu, e = number("friction", friction), number("restitution", restitution)
    gate, gamma = Gate(invalid), body.corner_angle
    gate.positive(rules.SPEED, v_0)
    open_ = (theta > 0.0) & (theta + gamma < math.pi / 2.0)
    gate.demand(rules.ANGLE, open_, theta, most=math.pi / 2.0 - gamma)
    gate.not_negative(rules.FRICTION, mu)
    gate.demand(rules.RESTITUTION, (e >= 0.0) & (e <= 1.0), e)
    v_0, theta, mu, e = gate.safe(v_0, theta, mu, e)
    phi, f = theta + gamma, functions(theta + gamma, mu)
    limit = f.cos(phi) / f.sin(phi)
    gate.demand(rules.TURNING, mu < limit, mu, phi=phi, limit=limit)  # beta > phi
    v_0, theta, mu, e = gate.safe(v_0, theta, mu, e)
    k, phi = (1.0 - e if convention == "paper" else 1.0 + e), theta + gamma
    numbers = after_impulse(functions(phi, v_0, mu, k, body.mass), body, v_0, theta, mu, k)
    result: ImpulseResult[Any] = ImpulseResult(*numbers)
    return gate.filled(result)


def after_impulse(
    f: Any, body: Any, v_0: Number, theta: Number, mu: Number, k: Number
) -> tuple[Any, Any, Any]:
    """Return the numbers of an `ImpulseResult`, in the language of kernels too.

    f: see `functions`; body: with corner_angle, corner_radius and mass; k: 1 - e or 1 + e. Eqs 31-33: as tan(beta) =
    1/mu, cos(beta) is mu sin(beta), and sin(beta - phi) is (c - mu s) sin(beta).
    """
    phi, r, m = theta + body.corner_angle, body.corner_radius, body.mass
    s, c = f.sin(phi), f.cos(phi)
    normal = k * v_0 * f.sin(theta) / (1.0 + 3.0 * c * (c - mu * s))  # F sin(beta)/m: Eqs 31 and 32
    omega = 3.0 * (c - mu * s) * normal / r  # Eq 30, where B^2 + L^2 = 4 r^2
    v_p = v_0 * f.cos(theta) - mu * normal + omega * r * s  # Eq 33
    impulse = m * normal * f.sqrt(1.0 + mu * mu)
    return omega + 0.0 * impulse, v_p + 0.0 * impulse, impulse
