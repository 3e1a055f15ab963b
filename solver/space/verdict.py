"""Compiled end and outcome of a motion in space.

A motion ends with a unit that has rolled by 90 deg; or where the wall has not pushed for `QUIET` by more than the tenth
of its largest force, all wheels are loaded, all units roll back and are not about to cross the wall; or at the longest
time, at which a unit behind the upper edge of the wall is over it.
"""

import numpy as np

from machine_code.compiled import compiled
from solver.space import state as col
from solver.space.dynamics import cross, rotated

QUIET, SOONEST, LEANING = 0.3, 0.6, 0.1
"""Time without force of the wall that ends a motion, within which no centre may cross the wall either [s]; its earliest
end [s]; and the force over the largest up to which a vehicle merely leans on the wall."""

LEVEL = 0.02
"""Sine of the roll up to which a unit counts as rolling back."""


@compiled
def verdict(units, bodies, joints, edge, most, t, answer):
    """Update the largest angles.

    Returns the outcome so far, and True while the motion goes on: a unit rolls outwards, has a wheel off the ground,
    or is about to cross the wall. most: heights of a unit by which its centre is behind the edge before it is over.
    """
    outcome, unsettled = col.UPRIGHT, False
    for u in range(units.shape[0]):
        b = bodies[u]
        sine = abs(b[7])
        past, ahead = abs(b[col.LARGEST]) * b[8], sine * b[col.LARGEST + 1]
        if ahead > past:  # their difference is the sine of that of both angles
            b[col.LARGEST], b[col.LARGEST + 1], b[col.LARGEST + 2] = b[7], b[8], t
        if abs(b[6]) > abs(answer[col.PITCH]):
            answer[col.PITCH], answer[col.PITCH_TIME] = -b[6], t
        unsettled = unsettled or (sine > LEVEL and b[7] * b[col.NOW + 3] > 0.0)
        beyond = edge - b[col.AT + 1] - b[3] * units[u, col.WHOLE_X] - b[5] * units[u, col.WHOLE_Z]
        if not np.isfinite(beyond + sine):
            outcome = col.LOST
        elif b[8] <= 0.0:
            outcome = col.OVER if beyond > 0.0 else col.ON_ITS_SIDE
        elif beyond > most * units[u, col.HEIGHT]:
            outcome = col.OVER
        unsettled = unsettled or beyond > QUIET * b[col.NOW + 1]
    for a in range(joints.shape[0]):
        unsettled = unsettled or joints[a, col.WHEEL] <= 0.0 or joints[a, col.WHEEL + 1] <= 0.0
    return outcome, unsettled


@compiled
def leave(unit, b, answer):
    """Store speed and directions of the first unit at a contact.

    Its axles are taken as at rest on the body.
    """
    x, y, z = cross(b[col.NOW + 3], b[col.NOW + 4], b[col.NOW + 5], unit[col.WHOLE_X], 0.0, unit[col.WHOLE_Z])
    vx, vy, _ = rotated(b, x, y, z)
    vx, vy = b[col.NOW] + vx, b[col.NOW + 1] + vy
    answer[col.EXIT_SPEED], answer[col.EXIT_ANGLE] = np.hypot(vx, vy), np.arctan2(vy, vx)
    answer[col.EXIT_YAW] = np.arctan2(b[3], b[0])


@compiled
def finish(answer, rolls, bodies, outcome, reached, touched, row):
    """Store outcome, end and last contact, and complete the angles."""
    answer[col.OUTCOME], answer[col.REACHED] = outcome, reached
    answer[col.TOUCHED], answer[col.ROWS_WRITTEN] = touched, row
    answer[col.PITCH] = np.arcsin(min(max(answer[col.PITCH], -1.0), 1.0))  # the sine up to here
    for u in range(rolls.size):
        rolls[u] = np.arctan2(bodies[u, col.LARGEST], bodies[u, col.LARGEST + 1])
        if abs(rolls[u]) > abs(answer[col.ROLL]):
            answer[col.ROLL], answer[col.ROLL_TIME] = rolls[u], bodies[u, col.LARGEST + 2]
    if outcome in (col.ON_ITS_SIDE, col.OVER):  # the end is on a row, a moment later than the roll of 90 deg
        answer[col.ROLL] = min(max(answer[col.ROLL], -0.5 * np.pi), 0.5 * np.pi)
        for u in range(rolls.size):
            rolls[u] = min(max(rolls[u], -0.5 * np.pi), 0.5 * np.pi)
