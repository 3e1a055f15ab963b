"""What the sign of restitution does: "paper", Eq 24, against "newton", each through all three stages."""

from __future__ import annotations

import math
from dataclasses import dataclass

from solver import CONVENTIONS
from tailslap.paper.method import TRUCK, Estimate, estimate
from tailslap.paper.printed import ANGLE, FRICTION, MASS
from tailslap.paper.table_1 import SPEEDS


@dataclass(frozen=True)
class Restitution:
    """One convention at 56 mph.

    corner_recoil: the corner's velocity across the wall after Stage 1 [m/s], negative into the wall.
    omega [rad/s]; peak_force [N]; change: of the peak force against the paper's convention.
    """

    corner_recoil: float
    omega: float
    peak_force: float
    change: float


def restitutions() -> dict[str, Restitution]:
    """Both conventions with e = 0.22, and e = 0, where they are one."""
    cases = {name: estimate(SPEEDS["56 mph"], convention=name) for name in CONVENTIONS}
    cases["e = 0"] = estimate(SPEEDS["56 mph"], restitution=0.0)
    paper = cases["paper"].peak_force
    return {name: _restitution(result, result.peak_force / paper - 1.0) for name, result in cases.items()}


def _restitution(result: Estimate, change: float) -> Restitution:
    return Restitution(_recoil(result), result.stage1.omega, result.peak_force, change)


def _recoil(result: Estimate) -> float:
    """v_Py = F sin(beta)/m - v_0 sin(theta) + omega_1 r cos(phi), Eq 21 [m/s]."""
    normal = result.stage1.impulse * math.sin(math.atan2(1.0, FRICTION)) / MASS
    turning = result.stage1.omega * TRUCK.corner_radius * math.cos(ANGLE + TRUCK.corner_angle)
    return normal - SPEEDS["56 mph"] * math.sin(ANGLE) + turning
