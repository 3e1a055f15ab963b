"""Rows of the history, recorded in compiled code; and all forces at an instant."""

from __future__ import annotations

import math

from fem.compiled import compiled
from fem.contact.corner import add_corner_reaction
from fem.explicit.elastic_damping import damp
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
        _copy_state(state, before)
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
def _copy_state(state, other):
    for i in range(2):
        for node in range(state.positions.shape[1]):
            other.positions[i, node] = state.positions[i, node]
            other.velocities[i, node] = state.velocities[i, node]
    for k in range(state.sums.size):
        other.sums[k] = state.sums[k]
    other.origin[0] = state.origin[0]


@compiled
def all_forces(positions, velocities, loop, viscosity, hourglass, force, scratch):
    """Put all forces [N] into `force`; returns the normal and the tangential reaction [N], and the power [W] of the
    elastic damping with the velocities half a step back."""
    force[:] = 0.0
    subtract_internal_forces(
        positions, velocities, viscosity, hourglass, force, loop.table, loop.material, scratch
    )
    damping = damp(
        loop.elastic_damping, positions, velocities, loop.mass, loop.time_step, scratch.motion, force
    )
    normal, tangential, _, _, _ = add_corner_reaction(
        positions, velocities, loop.mass, loop.time_step, loop.corner, loop.friction, force
    )
    return normal, tangential, damping
