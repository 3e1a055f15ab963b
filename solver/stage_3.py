"""Stage 3, the lateral force of the tail-slap.

After Eqs 72-73, with three earlier estimates (section 2.1, Eqs 1-5). The earlier methods stop the centre of mass
within its distance from the position parallel to the wall, and neglect rotation and friction. Arguments broadcast;
forces push the wall outwards, and are positive.
"""

import math
from dataclasses import dataclass
from typing import Any, Generic

from solver import rules
from solver.body import GRAVITY
from solver.conditions import Gate, Number, V, functions, number


@dataclass(frozen=True)
class StrikeForce(Generic[V]):
    """Lateral force of the tail-slap, floats or arrays.

    Attributes
    ----------
    impulse : float or ndarray
        Impulse, F_imp2 [N s] (Eq 72 [1]_).
    duration : float or ndarray
        Duration of the pulse [s].
    peak_force : float or ndarray
        Peak of a triangular pulse [N] (Eq 73).

    References
    ----------
    .. [1] Chuong and Malla, Infrastructures 2025, 10(11), 307.
    """

    impulse: V
    duration: V
    peak_force: V


def strike_force(mass: Number, lateral_speed: Number, duration: Number) -> StrikeForce[Any]:
    """Return impulse and peak force of the tail-slap.

    The strike stops the lateral motion (Stage 3); arguments broadcast.

    Parameters
    ----------
    mass : float or array_like
        Mass of the vehicle [kg].
    lateral_speed : float or array_like
        v_GY at the strike [m/s], of either sign: only its magnitude counts.
    duration : float or array_like
        Duration of the triangular pulse [s].

    Returns
    -------
    StrikeForce
        The force is positive, and pushes the wall outwards.

    Raises
    ------
    RigidBodyError
        For mass <= 0, duration <= 0 and whatever is not finite.

    References
    ----------
    .. [1] Chuong and Malla, Infrastructures 2025, 10(11), 307, Eqs 72-73.
    """
    m, v, dt = number("mass", mass), number("lateral_speed", lateral_speed), number("duration", duration)
    gate = Gate()
    gate.positive(rules.MASS, m)
    gate.demand(rules.LATERAL_SPEED, abs(v) < math.inf, v)
    gate.positive(rules.DURATION, dt)
    impulse, peak = m * abs(v), 2.0 * m * abs(v) / dt
    return StrikeForce(impulse + 0.0 * dt, dt + 0.0 * peak, peak)


def triangle_mean(peak_force: float, duration: float, window: float) -> float:
    """Return the largest mean of a triangular pulse over a window.

    Parameters
    ----------
    peak_force : float
        Peak of the pulse [N].
    duration, window : float
        Both positive [s].

    Returns
    -------
    float
        Mean force over the window about the peak [N].
    """
    if window < duration:
        return peak_force * (1.0 - 0.5 * window / duration)
    return 0.5 * peak_force * duration / window


@dataclass(frozen=True)
class OlsonForce(Generic[V]):
    """Olson's estimate, as floats or arrays of one shape.

    Attributes
    ----------
    travel : float or ndarray
        Travel of the centre of mass towards the wall until the vehicle is parallel to it [m].
    time : float or ndarray
        Time of this travel, t [s].
    deceleration : float or ndarray
        Average lateral deceleration, G_lat,avg [multiples of gravity] (Eq 1 [1]_).
    average_force : float or ndarray
        Average lateral force, F_lat,avg [N] (Eq 2).

    References
    ----------
    .. [1] Chuong and Malla, Infrastructures 2025, 10(11), 307, section 2.1.
    """

    travel: V
    time: V
    deceleration: V
    average_force: V


@dataclass(frozen=True)
class RitterForce(Generic[V]):
    """Ritter's estimate, as floats or arrays of one shape.

    Attributes
    ----------
    impulse : float or ndarray
        Lateral impulse, J_lat [N s] (Eq 4 [1]_).
    time : float or ndarray
        Olson's time, half the pulse [s].
    peak_force : float or ndarray
        Peak lateral force, F_lat,peak [N] (Eq 5).

    References
    ----------
    .. [1] Chuong and Malla, Infrastructures 2025, 10(11), 307, section 2.1.
    """

    impulse: V
    time: V
    peak_force: V


def olson_force(
    mass: Number,
    speed: Number,
    angle: Number,
    front_distance: Number,
    half_width: Number,
    deflection: Number = 0.0,
    gravity: Number = GRAVITY,
) -> OlsonForce[Any]:
    """Return the average lateral force by Olson's method.

    Arguments broadcast.

    Parameters
    ----------
    mass : float or array_like
        Mass of the vehicle [kg].
    speed : float or array_like
        Speed of the vehicle, V_I [m/s].
    angle : float or array_like
        Angle between vehicle and wall, theta [rad].
    front_distance : float or array_like
        Distance from the front to the centre of mass, A_L [m].
    half_width : float or array_like
        Half the vehicle's width, Olson's B [m].
    deflection : float or array_like
        Deflection of the barrier, D [m].
    gravity : float or array_like
        Unit of the deceleration [m/s^2]; the force does not depend on it.

    Returns
    -------
    OlsonForce
        Floats, or arrays of the common shape.

    Raises
    ------
    RigidBodyError
        Unless mass, speed, front_distance, half_width and gravity are positive, the angle is between 0 and pi/2,
        the deflection is 0 or more, and the centre of mass comes closer to the wall.

    References
    ----------
    .. [1] Chuong and Malla, Infrastructures 2025, 10(11), 307, Eqs 1-2.
    """
    m, v, theta = number("mass", mass), number("speed", speed), number("angle", angle)
    a, b = number("front_distance", front_distance), number("half_width", half_width)
    d, g = number("deflection", deflection), number("gravity", gravity)
    gate, f = Gate(), functions(theta, v)
    for rule, value in (
        (rules.MASS, m),
        (rules.SPEED, v),
        (rules.FRONT_DISTANCE, a),
        (rules.HALF_WIDTH, b),
        (rules.GRAVITY, g),
    ):
        gate.positive(rule, value)
    gate.demand(rules.IMPACT_ANGLE, (theta > 0.0) & (theta < math.pi / 2.0), theta)
    gate.not_negative(rules.DEFLECTION, d)
    travel = a * f.sin(theta) - b * (1.0 - f.cos(theta)) + d
    gate.demand(rules.TRAVEL, travel > 0.0, travel)
    lateral_speed = v * f.sin(theta)
    time = travel / (0.5 * lateral_speed)
    deceleration = lateral_speed / (g * time)  # Eq 1, its last member; the one before it is half of that
    return OlsonForce(travel, time, deceleration, deceleration * m * g)


def hirsch_force(average_force: Number) -> Any:
    """Return a linear spring's peak lateral force.

    It is pi/2 times the average force (Hirsch).

    Parameters
    ----------
    average_force : float or array_like
        Average force [N].

    Returns
    -------
    float or ndarray
        Peak force [N].

    Raises
    ------
    RigidBodyError
        Unless the average is positive and finite.

    References
    ----------
    .. [1] Chuong and Malla, Infrastructures 2025, 10(11), 307, Eq 3.
    """
    average = number("average_force", average_force)
    Gate().positive(rules.AVERAGE_FORCE, average)
    return math.pi / 2.0 * average


def ritter_force(
    mass: Number,
    speed: Number,
    angle: Number,
    front_distance: Number,
    half_width: Number,
    deflection: Number = 0.0,
) -> RitterForce[Any]:
    """Return the peak lateral force by Ritter's method.

    Elastic rebound over a triangular pulse of twice Olson's time.

    Parameters
    ----------
    mass : float or array_like
        Mass of the vehicle [kg].
    speed : float or array_like
        Speed of the vehicle, V_I [m/s].
    angle : float or array_like
        Angle between vehicle and wall, theta [rad].
    front_distance : float or array_like
        Distance from the front to the centre of mass, A_L [m].
    half_width : float or array_like
        Half the vehicle's width, Olson's B [m].
    deflection : float or array_like
        Deflection of the barrier, D [m].

    Returns
    -------
    RitterForce
        Floats, or arrays of the common shape.

    Raises
    ------
    RigidBodyError
        As `olson_force`.

    References
    ----------
    .. [1] Chuong and Malla, Infrastructures 2025, 10(11), 307, Eqs 4-5.
    """
    time = olson_force(mass, speed, angle, front_distance, half_width, deflection).time
    m, v, theta = number("mass", mass), number("speed", speed), number("angle", angle)
    impulse = 2.0 * m * v * functions(theta).sin(theta)  # Eq 4
    return RitterForce(impulse, time, impulse / time)  # Eq 5
