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
    """impulse: F_imp2 [N s] (Eq 72); duration: of the pulse [s]; peak_force: of a triangle [N] (Eq 73)."""

    impulse: V
    duration: V
    peak_force: V


def strike_force(mass: Number, lateral_speed: Number, duration: Number) -> StrikeForce[Any]:
    """Impulse and peak force of the strike that stops the lateral motion, Eqs 72-73; arguments broadcast.

    mass [kg]; lateral_speed: v_GY at the strike [m/s], of either sign, as only its magnitude counts;
    duration of the triangular pulse [s]. The force is positive, and pushes the wall outwards.
    Raises RigidBodyError for mass <= 0, duration <= 0 and whatever is not finite.
    """
    m, v, dt = number("mass", mass), number("lateral_speed", lateral_speed), number("duration", duration)
    gate = Gate()
    gate.demand(MASS, (m > 0.0) & (m < math.inf), m)
    gate.demand(LATERAL_SPEED, abs(v) < math.inf, v)
    gate.demand(DURATION, (dt > 0.0) & (dt < math.inf), dt)
    impulse, peak = m * abs(v), 2.0 * m * abs(v) / dt
    return StrikeForce(impulse + 0.0 * dt, dt + 0.0 * peak, peak)
