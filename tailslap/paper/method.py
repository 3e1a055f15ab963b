"""The paper's three stages for the vehicle of its Table 1, and the cell: a printed number beside its own."""

from __future__ import annotations

from dataclasses import dataclass

from solver import (
    ImpulseResult,
    MotionState,
    PlaneMotion,
    RectangularBody,
    corner_impulse,
    plane_motion,
    strike_force,
    tail_slap,
)
from tailslap.paper.printed import ANGLE, FRICTION, LENGTH, MASS, PULSE, RESTITUTION, START, WIDTH

TRUCK = RectangularBody(LENGTH, WIDTH, MASS)


@dataclass(frozen=True)
class Cell:
    """Printed and computed value, in the same SI unit; difference: computed/printed - 1."""

    printed: float
    computed: float
    difference: float


@dataclass(frozen=True)
class Estimate:
    """Stages 1 to 3 of one impact; peak_force of the tail-slap [N] for a triangular pulse."""

    stage1: ImpulseResult[float]
    strike: MotionState[float]
    peak_force: float


def beside(printed: float, computed: float) -> Cell:
    """The cell of a printed and a computed value, neither of them zero."""
    return Cell(float(printed), float(computed), float(computed / printed - 1.0))


def estimate(
    speed: float,
    angle: float = ANGLE,
    restitution: float = RESTITUTION,
    convention: str = "paper",
    duration: float = PULSE,
    start_angle: float | None = None,
) -> Estimate:
    """All three stages for the truck of Table 1, friction as in Eqs 66-67.

    speed [m/s]; angle [rad]; duration of the pulse [s]; start_angle: what Stage 2 starts from [rad], if it
    is not the impact's own angle.
    """
    stage1 = corner_impulse(TRUCK, speed, angle, FRICTION, restitution, convention)
    theta_0 = angle if start_angle is None else start_angle
    strike = tail_slap(TRUCK, theta_0, stage1.omega, stage1.corner_speed, FRICTION)
    return Estimate(stage1, strike, strike_force(MASS, strike.v_gy, duration).peak_force)


def printed_motion(reaction: str = "drag", corner_speed: float = START.corner_speed) -> PlaneMotion:
    """Stage 2 from the start that the paper prints; corner_speed [m/s]."""
    return plane_motion(TRUCK, START.angle, START.omega, corner_speed, FRICTION, reaction)
