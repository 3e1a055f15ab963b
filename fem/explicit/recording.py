"""Rows of the history, recorded in compiled code; and all forces at an instant."""

from __future__ import annotations

import math

import numpy as np

from fem.compiled import compiled
from fem.contact.corner import add_corner_reaction
from fem.explicit.elastic_damping import SUMS, damp
from fem.explicit.internal_force import subtract_internal_forces
from fem.explicit.measures import measure
from fem.explicit.time_loop import advance


@compiled
def advance_and_measure(state, before, stride, loop, viscosity, hourglass, reference, force, scratch, rows):
    """Advance the state in place, and write its `Measures` into each of the rows, `stride` steps apart.

    Ends after a row with an angle that is not above zero, or with a number that is not finite; `before` is then the
    state of the row before it. Returns how many rows were written. Others arguments: as `measure`.
    """
    for row in range(rows.shape[0]):
        before.positions[:] = state.positions
        before.velocities[:] = state.velocities
        before.sums[:] = state.sums
        before.origin[:] = state.origin
        advance(state, stride, loop, viscosity, hourglass, force, scratch)
        measures = measure(state, loop, viscosity, hourglass, reference, force, scratch)
        finite = True
        for column in range(rows.shape[1]):
            rows[row, column] = measures[column]
            finite = finite and math.isfinite(rows[row, column])
        if not (finite and measures.theta > 0.0):
            return row + 1
    return rows.shape[0]


@compiled
def all_forces(positions, velocities, loop, viscosity, hourglass, force, scratch):
    """Put all forces [N] into `force`; returns the normal and the tangential reaction [N], and the power [W] of the
    elastic damping with the velocities half a step back."""
    force[:] = 0.0
    subtract_internal_forces(
        positions, velocities, viscosity, hourglass, force, loop.table, loop.material, scratch
    )
    motion = np.zeros(SUMS)
    damping = damp(loop.elastic_damping, positions, velocities, loop.mass, loop.time_step, motion, force)
    normal, tangential, _, _, _ = add_corner_reaction(
        positions, velocities, loop.mass, loop.time_step, loop.corner, loop.friction, force
    )
    return normal, tangential, damping
