"""Table 1: the inputs, what follows from them, and the speed behind the start values of Section 3.1.1."""

from __future__ import annotations

import math
from dataclasses import dataclass

from solver import corner_impulse
from tailslap.paper.method import TRUCK, Cell, Estimate, beside, estimate
from tailslap.paper.printed import ANGLE, FRICTION, LATERAL_SPEED, MPH, RESTITUTION, SPEED, START

SPEEDS = {"56 mph": 56.0 * MPH, "90 km/h": SPEED}
"""What the start may have been computed from [m/s]: MASH's speed for the truck, and its printed metric rounding."""


@dataclass(frozen=True)
class Derived:
    """Of the vehicle and Table 1's angle: gamma, phi, beta [rad]; r_PG [m]; I_G [kg m^2] (Eqs 7, 15, 26, 63)."""

    gamma: float
    phi: float
    beta: float
    corner_radius: float
    moment_of_inertia: float


@dataclass(frozen=True)
class StartFrom:
    """Stage 1 from one speed [m/s], beside the printed start; peak_force [N], impulse F_imp [N s].

    omega, corner_speed: omega_0 [rad/s], v_P0 [m/s]. lateral_speed: v_0 sin(theta) [m/s].
    """

    speed: float
    omega: Cell
    corner_speed: Cell
    lateral_speed: Cell
    impulse: float
    peak_force: float


@dataclass(frozen=True)
class Table1:
    """derived; starts by the speed's name; implied_speed: that which gives the printed v_P0 exactly [m/s]."""

    derived: Derived
    starts: dict[str, StartFrom]
    implied_speed: float


def table_1() -> Table1:
    """Stage 1 for both speeds; every velocity is proportional to the speed, which gives the implied one."""
    unit = corner_impulse(TRUCK, 1.0, ANGLE, FRICTION, RESTITUTION)
    starts = {name: _start_from(speed) for name, speed in SPEEDS.items()}
    return Table1(_derived(), starts, START.corner_speed / unit.corner_speed)


def _derived() -> Derived:
    gamma = TRUCK.corner_angle
    beta = math.atan2(1.0, FRICTION)
    return Derived(gamma, ANGLE + gamma, beta, TRUCK.corner_radius, TRUCK.moment_of_inertia)


def _start_from(speed: float) -> StartFrom:
    result: Estimate = estimate(speed)
    return StartFrom(
        speed,
        beside(START.omega, result.stage1.omega),
        beside(START.corner_speed, result.stage1.corner_speed),
        beside(LATERAL_SPEED, speed * math.sin(ANGLE)),
        result.stage1.impulse,
        result.peak_force,
    )
