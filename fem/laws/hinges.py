"""Compiled hinges between the plates of a train.

A hinge joins a point of a plate to a point of the next, each a node or the weighted mean of some. Its force ends every
step with both in one place: a constraint by forward-increment multipliers (Carpenter, Taylor and Katona, Int. J. Numer.
Meth. Eng. 32, 1991). Two hinged nodes have the motion of one node with the mass of both, and a hinge absorbs no energy,
since its gap is zero at every instant. A constraint lowers frequencies, so that no hinge bounds the time step.

Besides, the columns of the rigid motion of each plate.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from machine_code.compiled import compiled, inlined

UNIT = ("x_g", "y_g", "theta", "omega", "v_gx", "v_gy")
"""Columns of the rigid motion of a plate, as those of `ImpactMeasures`."""

HINGE = ("impulse_x", "impulse_y")
"""Columns of a hinge: impulse of the plate behind on the one ahead since the start [N s]."""

SUMS = 11


class Hinges(NamedTuple):
    """Hinges of a train.

    first, shape (hinges + 1,): where each hinge's nodes and weights begin in `nodes` and `weights`; those of the plate
    behind are negative; inertia, shape (hinges, hinges): inverse of the mobilities of the gaps [kg]; unit, shape (all
    nodes,): number of each node's plate.
    """

    first: np.ndarray
    nodes: np.ndarray
    weights: np.ndarray
    inertia: np.ndarray
    unit: np.ndarray


class HingeState(NamedTuple):
    """State of the hinges.

    impulse, shape (2, hinges): on the plate ahead [N s]. Workspace: force [N] and gap [m] of the last step, shape (2,
    hinges) each; sums over the nodes of each plate, shape (units, SUMS).
    """

    impulse: np.ndarray
    force: np.ndarray
    gap: np.ndarray
    sums: np.ndarray


def unloaded(hinges: Any) -> HingeState | None:
    """Return hinges without forces, None without hinges."""
    if hinges is None:
        return None
    count = len(hinges.inertia)
    impulse, force, gap = np.zeros((3, 2, count))
    return HingeState(impulse, force, gap, np.zeros((count + 1, SUMS)))


@inlined
def join(hinges, hinge_state, positions, velocities, mass, time_step, force):
    """Add the forces of the hinges to `force`.

    `force` must hold all other forces. They are stored in `hinge_state`.
    """
    if hinges is None:
        return
    count = hinges.inertia.shape[0]
    for axis in range(2):
        x, v, f = positions[axis], velocities[axis], force[axis]
        for h in range(count):
            gap = 0.0
            for k in range(hinges.first[h], hinges.first[h + 1]):
                i = hinges.nodes[k]
                gap += hinges.weights[k] * (x[i] + time_step * (v[i] + time_step * f[i] / mass[i]))
            hinge_state.gap[axis, h] = gap
        for h in range(count):
            closing = 0.0
            for k in range(count):
                closing -= hinges.inertia[h, k] * hinge_state.gap[axis, k]
            hinge_state.force[axis, h] = closing / time_step**2
            for k in range(hinges.first[h], hinges.first[h + 1]):
                f[hinges.nodes[k]] += hinges.weights[k] * hinge_state.force[axis, h]


@inlined
def add_impulses(hinges, hinge_state, time_step):
    """Add the impulses of hinges over a step."""
    if hinges is None:
        return
    for axis in range(2):
        for h in range(hinges.inertia.shape[0]):
            hinge_state.impulse[axis, h] += time_step * hinge_state.force[axis, h]


@compiled
def describe_units(hinges, hinge_state, state, force, mass, time_step, reference, row):
    """Fill a row with the columns of plates and hinges.

    They are `UNIT` of each plate and `HINGE` of each hinge. `force` is complete.
    """
    if hinges is None:
        return
    sums, half = hinge_state.sums, 0.5 * time_step
    x, y, v_x, v_y = state.positions[0], state.positions[1], state.velocities[0], state.velocities[1]
    sums[:] = 0.0
    for i in range(mass.size):
        m, p, q, total = mass[i], reference[0, i], reference[1, i], sums[hinges.unit[i]]
        u, v = v_x[i] + half * force[0, i] / m, v_y[i] + half * force[1, i] / m
        total[0] += m
        total[1] += m * x[i]
        total[2] += m * y[i]
        total[3] += m * u
        total[4] += m * v
        total[5] += m * p
        total[6] += m * q
        total[7] += m * (p * x[i] + q * y[i])
        total[8] += m * (p * y[i] - q * x[i])
        total[9] += m * (x[i] * v - y[i] * u)
        total[10] += m * (x[i] * x[i] + y[i] * y[i])
    for number in range(sums.shape[0]):
        s = sums[number]
        for k in range(1, s.size):
            s[k] /= s[0]
        cosine = s[7] - s[5] * s[1] - s[6] * s[2]
        sine = s[8] - s[5] * s[2] + s[6] * s[1]
        unit = row[len(UNIT) * number :]
        unit[0], unit[1], unit[2] = state.origin[0] + s[1], s[2], -math.atan2(sine, cosine)
        unit[3] = (s[9] - s[1] * s[4] + s[2] * s[3]) / (s[10] - s[1] * s[1] - s[2] * s[2])
        unit[4], unit[5] = s[3], s[4]
    for h in range(hinges.inertia.shape[0]):
        for axis in range(2):
            place = len(UNIT) * sums.shape[0] + len(HINGE) * h + axis
            row[place] = hinge_state.impulse[axis, h] + half * hinge_state.force[axis, h]
