"""The earlier methods of Section 2.1 for the vehicle of Table 1, beside the paper's own."""

from __future__ import annotations

from dataclasses import dataclass

from solver import hirsch_force, olson_force, ritter_force
from tailslap.paper.method import estimate
from tailslap.paper.printed import ANGLE, LENGTH, MASS, WIDTH
from tailslap.paper.table_1 import SPEEDS

FRONT_DISTANCE, HALF_WIDTH, DEFLECTION = LENGTH / 2.0, WIDTH / 2.0, 0.0
"""Assumed: centre of mass at half the length, Olson's B half the width, a rigid barrier, D = 0 [m]."""


@dataclass(frozen=True)
class EarlierMethods:
    """Inputs, Olson's travel [m] and time to parallel [s], and forces [N].

    olson_first_member: F_avg by the first member of Eq 1, V sin(theta)/(2 g t), which is half of its last.
    paper: peak force of the tail-slap for a pulse of 0.1 s.
    """

    speed: float
    angle: float
    front_distance: float
    half_width: float
    deflection: float
    travel: float
    time: float
    olson: float
    olson_first_member: float
    hirsch: float
    ritter: float
    paper: float


def earlier_methods() -> EarlierMethods:
    """Olson, Hirsch and Ritter at 56 mph and 15 degrees."""
    speed = SPEEDS["56 mph"]
    inputs = (speed, ANGLE, FRONT_DISTANCE, HALF_WIDTH, DEFLECTION)
    olson, ritter = olson_force(MASS, *inputs), ritter_force(MASS, *inputs)
    average = olson.average_force
    forces = (average, 0.5 * average, hirsch_force(average), ritter.peak_force, estimate(speed).peak_force)
    return EarlierMethods(*inputs, olson.travel, olson.time, *forces)
