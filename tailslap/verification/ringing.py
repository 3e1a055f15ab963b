"""What a ringing reaction does to the motion: friction follows |N|, and brakes more than the motion's own reaction."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tailslap.planning.fe_plan import FePlan

RINGING, CORRUPTED = 2e-3, 0.1
"""Friction by ringing that is allowed, and at which a run is given up."""


def friction_by_ringing(fe_plan: FePlan, row: Mapping[str, float]) -> float:
    """Friction follows |N|: where N rings through zero it brakes more than the motion's own reaction would.

    row: of the history. The share of v_GX or omega, whichever is more, that this has taken off by then.
    """
    rectified = row["normal_impulse_magnitude"] - abs(row["normal_impulse"])
    speed = fe_plan.case.scene.corner_friction * rectified / fe_plan.model.mass
    radius, strike = fe_plan.case.body.corner_radius, fe_plan.case.motion.strike
    return max(abs(speed / (strike.v_gx or math.inf)), 0.75 * abs(speed) / (radius * strike.omega))
