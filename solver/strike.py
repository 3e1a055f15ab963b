"""Stage 3: the lateral force of the tail-slap (Eqs 72-73)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Generic

from solver.elementary import Number, V, number
from solver.errors import Gate
from solver.rules import DURATION, LATERAL_SPEED, MASS


@dataclass(frozen=True)
class StrikeForce(Generic[V]):
    """Lateral force of the tail-slap: floats, or arrays of one shape.

    Attributes
    ----------
    impulse : float or ndarray
        F_imp2 [N s] (Eq 72 [1]_).
    duration : float or ndarray
        Of the pulse [s].
    peak_force : float or ndarray
        Of a triangular pulse [N] (Eq 73).

    References
    ----------
    .. [1] Chuong and Malla, Infrastructures 2025, 10(11), 307.
    """

    impulse: V
    duration: V
    peak_force: V


def strike_force(mass: Number, lateral_speed: Number, duration: Number) -> StrikeForce[Any]:
    """Impulse and peak force of the strike that stops the lateral motion (Stage 3); arguments broadcast.

    Parameters
    ----------
    mass : float or array_like
        Of the vehicle [kg].
    lateral_speed : float or array_like
        v_GY at the strike [m/s], of either sign: only its magnitude counts.
    duration : float or array_like
        Of the triangular pulse [s].

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
    gate.demand(MASS, (m > 0.0) & (m < math.inf), m)
    gate.demand(LATERAL_SPEED, abs(v) < math.inf, v)
    gate.demand(DURATION, (dt > 0.0) & (dt < math.inf), dt)
    impulse, peak = m * abs(v), 2.0 * m * abs(v) / dt
    return StrikeForce(impulse + 0.0 * dt, dt + 0.0 * peak, peak)
