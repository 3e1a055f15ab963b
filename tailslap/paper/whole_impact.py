"""The whole impact of Table 1's truck, rigid, on a wall that only pushes: what Stages 1 to 3 assume, computed.

The crush stiffness of such a truck's corners is not known: every answer is given for three values.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from solver.impact import CrushLaw, ImpactMotion, ImpactVehicle, WallContact, first_touch, solve_impact
from tailslap.impact.answers import rigid_answer
from tailslap.paper.method import estimate
from tailslap.paper.printed import ANGLE, FRICTION, LENGTH, MASS, RESTITUTION, WIDTH
from tailslap.paper.table_1 import SPEEDS

STIFFNESSES = (1e6, 2e6, 3e6)
"""Of a corner's crush [N/m]; assumed."""

NEARLY_RIGID = 2e8
"""Stiffness that comes close to an instantaneous impact [N/m]."""

INTERVAL = 2e-4
"""Between the rows of force histories [s]."""

TRUCK = ImpactVehicle(LENGTH, WIDTH, MASS)


@dataclass(frozen=True)
class StiffnessCase:
    """The impact with one crush stiffness [N/m], SI.

    omega: after the first strike; released: its end. rear_start, rear_duration, rear_peak, rear_impulse: of the rear
    corner's strike; closing: the rear corner's speed into the wall at its start; share: impulse over (1 + e) m closing.
    read: by curve, the second strike's duration from valley to valley. gap: how far the crushed front corner is from
    the wall at most before the rear one strikes; back: when it touches again, NaN if it does not.
    """

    stiffness: float
    omega: float
    released: float
    rear_start: float
    rear_duration: float
    rear_peak: float
    rear_impulse: float
    closing: float
    share: float
    read: dict[str, float]
    gap: float
    back: float


@dataclass(frozen=True)
class WholeImpact:
    """Cases, and what the paper's stages have in their place, SI.

    share, share_friction: m_eff/m of the rear corner at angle zero, without and with friction. plastic_impulse: m
    |v_GY| of the paper for e = 0; corner_impulse: that of the rear corner, m_eff 2 |v_GY|. paper_impulse: m |v_GY| for
    e = 0.22, paper_time: when. omegas: after Stage 1 by "paper" and "newton"; nearly_rigid: by the crush law.
    """

    cases: tuple[StiffnessCase, ...]
    share: float
    share_friction: float
    plastic_impulse: float
    corner_impulse: float
    paper_impulse: float
    paper_time: float
    omegas: dict[str, float]
    nearly_rigid: float


def whole_impact() -> WholeImpact:
    """All of it; some tenths of a second."""
    speed = SPEEDS["56 mph"]
    paper, plastic = estimate(speed), estimate(speed, restitution=0.0)
    newton = estimate(speed, convention="newton")
    stopped = MASS * abs(plastic.strike.v_gy)
    return WholeImpact(
        tuple(_case(stiffness) for stiffness in STIFFNESSES),
        corner_share(0.0),
        corner_share(FRICTION),
        stopped,
        2.0 * corner_share(0.0) * stopped,
        MASS * abs(paper.strike.v_gy),
        paper.strike.t,
        {"paper": paper.stage1.omega, "newton": newton.stage1.omega},
        motion(NEARLY_RIGID, end=0.05).end.omega,
    )


def corner_share(friction: float) -> float:
    """m_eff/m of a uniform rectangle whose rear corner strikes, its side along the wall.

    1/m_eff = 1/m + (L/2) (L/2 + mu B/2)/I with I = m (L^2 + B^2)/12.
    """
    return 1.0 / (1.0 + 3.0 * LENGTH * (LENGTH + friction * WIDTH) / (LENGTH**2 + WIDTH**2))


def motion(stiffness: float, end: float | None = None) -> ImpactMotion:
    """The rigid truck's impact, corners alone, e and friction as printed; to `end` [s]."""
    contact = WallContact(CrushLaw(stiffness, 0.0, RESTITUTION), FRICTION)
    return solve_impact(TRUCK, contact, first_touch(TRUCK, ANGLE, SPEEDS["56 mph"]), end, after_second=0.2)


def _case(stiffness: float) -> StiffnessCase:
    found = motion(stiffness)
    front, rear = (next(s for s in found.strikes if s.corner == name) for name in ("front", "rear"))
    again = [s.start for s in found.strikes if s.corner == "front" and s.start > rear.start]
    instants = np.linspace(front.end, rear.start, 101)
    crush = found.points_at(instants).crush[0]
    closing = rear_speed(found, rear.start)
    curves = rigid_answer(found, INTERVAL * np.arange(int(found.t_end / INTERVAL) + 1)).second_strike
    return StiffnessCase(
        stiffness,
        float(found.at(instants[50]).omega),
        front.end,
        rear.start,
        rear.duration,
        rear.peak_force,
        rear.impulse,
        closing,
        rear.impulse / ((1.0 + RESTITUTION) * MASS * closing),
        {name: curve["duration"] for name, curve in curves.items()},
        float(crush[0] - crush.min()),
        again[0] if again else math.nan,
    )


def rear_speed(found: ImpactMotion, instant: float) -> float:
    """Speed of the rear corner into the wall at an instant [m/s]."""
    at, along, across = found.at(instant), float(found.points.along[1]), float(found.points.across[1])
    ahead = along * math.cos(float(at.theta)) + across * math.sin(float(at.theta))
    return -float(at.v_gy) - float(at.omega) * ahead
