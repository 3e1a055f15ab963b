"""Explicit central differences: the compiled loop. Output is not part of it.

State between steps: positions at instant n, velocities at n - 1/2, and what has been summed up so far. A step is:
forces at n, then velocities to n + 1/2, then positions to n + 1.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from fem.compiled import compiled, inlined
from fem.corner import Corner, add_corner_reaction
from fem.elements import ElementTable
from fem.internal_force import subtract_forces_of
from fem.lanes import lane_count


class LoopParameters(NamedTuple):
    """Everything that stays as it is during a run; a part that is None is compiled out of the loop."""

    table: ElementTable
    material: Any
    mass: np.ndarray
    corner: Corner
    friction: Any
    viscosity: Any
    hourglass: Any
    time_step: float


class State(NamedTuple):
    """Where the plate is, and what has been summed up on the way.

    positions [m] and velocities half a step back [m/s], shape (2, nodes). sums, shape (4,): friction work and
    damping work done on the plate [J]; impulse of the normal reaction and of its magnitude [N s].
    """

    positions: np.ndarray
    velocities: np.ndarray
    sums: np.ndarray


def copy_state(state: State) -> State:
    """A state of its own, for the loop advances in place."""
    return State(*(array.copy() for array in state))


@compiled
def advance(state, steps, loop, viscosity, hourglass, force, scratch):
    """Advance the state in place by this many steps. `force` and `scratch` are room to work in."""
    positions, velocities, _ = state
    lanes = lane_count(loop.table.connectivity, scratch.lattice)
    for _ in range(steps):
        force[:] = 0.0
        power = subtract_forces_of(
            0, lanes, positions, velocities, viscosity, hourglass, force, loop.table, loop.material, scratch
        )
        react(state, loop, power, force)
        drift(positions, velocities, force, loop.mass, loop.time_step, 0, loop.mass.size)


@inlined
def react(state, loop, viscous_power, force):
    """Add the wall's reaction, and what it and the damping do to the sums."""
    positions, velocities, sums = state
    time_step = loop.time_step
    normal, tangential, slip, later_slip, dashpot_power = add_corner_reaction(
        positions, velocities, loop.mass, time_step, loop.corner, loop.friction, force
    )
    sums[0] += 0.5 * time_step * tangential * (slip + later_slip)
    sums[1] += time_step * (dashpot_power - viscous_power)
    sums[2] += time_step * normal
    sums[3] += time_step * abs(normal)


@compiled
def drift(positions, velocities, force, mass, time_step, begin, end):
    for i in range(2):
        x, v, f, m = positions[i, begin:end], velocities[i, begin:end], force[i, begin:end], mass[begin:end]
        for node in range(m.size):
            v[node] += time_step * f[node] / m[node]
            x[node] += time_step * v[node]
