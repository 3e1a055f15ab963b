"""From the arguments of Stage 2 to the record its formulas take: all floats, or all arrays of one shape."""

from __future__ import annotations

from typing import Any

import numpy as np

from solver.body import RectangularBody
from solver.closed_form import Path, Start
from solver.elementary import number
from solver.errors import RigidBodyError, choose
from solver.state import REACTIONS

MU_SIGN = {"drag": 1.0, "none": 0.0, "signed": -1.0}  # of the coefficient in Eqs 66-67


def gather(
    body: RectangularBody[Any], angle: Any, omega: Any, corner_speed: Any, friction: Any, reaction: str
) -> tuple[Start, Any]:
    """The start, and the friction coefficient without its model's sign."""
    sign = MU_SIGN[choose("reaction", reaction, REACTIONS)]
    mu = number("friction", friction)
    values: tuple[Any, ...] = (
        body.corner_angle,
        number("angle", angle),
        sign * mu,
        body.mass,
        body.corner_radius,
        number("omega", omega),
        number("corner_speed", corner_speed),
        mu,
    )
    for value in values:
        if not isinstance(value, float):
            values = np.broadcast_arrays(*values)
            break
    return Start(Path(*values[:3]), *values[3:7]), values[7]


def gather_one(
    body: RectangularBody[float], angle: Any, omega: Any, corner_speed: Any, friction: Any, reaction: str
) -> tuple[Start, float]:
    """The same for one motion; raises RigidBodyError for arrays."""
    start, mu = gather(body, angle, omega, corner_speed, friction, reaction)
    if not isinstance(mu, float):
        raise RigidBodyError("shape", mu.shape, "this is one motion", "(), numbers; `tail_slap` takes arrays")
    return start, mu
