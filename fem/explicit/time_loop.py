"""Explicit central differences: the compiled loop. Output is not part of it.

State between steps: positions at instant n, velocities at n - 1/2, and what has been summed up so far. A step is:
forces at n, then velocities to n + 1/2, then positions to n + 1.
"""

from typing import Any, NamedTuple

import numpy as np

from fem.explicit.internal_force import damp, gained, subtract_forces_of
from fem.explicit.point_force import slot_count
from fem.laws.constraints import CornerConstraint, add_corner_reaction
from fem.machine_code.compiled import compiled, implements
from fem.plate.discretisation import ElementTable


class LoopParameters(NamedTuple):
    """Everything that stays as it is during a run; a part that is None is compiled out of the loop,
    by the type of an argument: see `advance`."""

    table: ElementTable
    material: Any
    mass: np.ndarray
    corner: CornerConstraint
    friction: Any
    viscosity: Any
    hourglass: Any
    elastic_damping: Any
    time_step: float
    span: float  # [m], by which the origin follows the corner along the wall


class State(NamedTuple):
    """State of the loop: the plate's motion, and sums so far.

    positions [m] and velocities half a step back [m/s], shape (2, nodes). sums, shape (4,): friction work and
    damping work done on the plate [J]; impulse of the normal reaction and of its magnitude [N s]. origin [m], shape
    (1,): place along the wall that the positions are counted from. It follows the plate: far from it a coordinate
    keeps fewer digits of the strain, and a stiff plate sums up their rounding over millions of steps.
    """

    positions: np.ndarray
    velocities: np.ndarray
    sums: np.ndarray
    origin: np.ndarray


def react(loop: Any, state: Any, lost: float, force: Any) -> float:
    """Add the wall's reaction, and what it and the damping, power `lost`, do to the sums; returns the place [m] of the
    node that the origin follows. Compiled code only."""
    raise NotImplementedError(type(loop))


@compiled
def follow(x, span, origin):
    """Move the origin by the span [m] once its node is as far from it; by how much the positions are to be set back."""
    shift = span if x >= span else -span if x <= -span else 0.0
    origin[0] += shift
    return shift


@compiled
def advance(state, steps, loop, viscosity, hourglass, force, scratch):
    """Advance the state in place by this many steps. `force` and `scratch` are workspace.

    viscosity, hourglass: the fields of `loop`. They come as arguments too because Numba drops a branch on `is None` for
    an argument, by its type, but not for the field of a record: only so is their code left out where they are None.
    """
    positions, velocities = state.positions, state.velocities
    slots, nodes = slot_count(loop.table.connectivity, scratch.lattice), loop.mass.size
    motion = scratch.motion
    for _ in range(steps):
        force[:] = 0.0
        power = subtract_forces_of(
            0, slots, positions, velocities, viscosity, hourglass, force, loop.table, loop.material, scratch
        )
        power -= damp(loop.elastic_damping, positions, velocities, loop.mass, loop.time_step, motion, force)
        place = react(loop, state, power, force)
        state.sums[1] += loop.time_step * gained(
            loop.elastic_damping, motion, state, loop.time_step, 0, nodes, force
        )
        shift = follow(place, loop.span, state.origin)
        drift(positions, velocities, force, loop.mass, loop.time_step, shift, 0, nodes)


@implements(react, LoopParameters, merged=True)
def _react_at_corner(loop, state, lost, force):
    positions, velocities, sums, _ = state
    time_step = loop.time_step
    normal, tangential, slip, later_slip, dashpot_power = add_corner_reaction(
        positions, velocities, loop.mass, time_step, loop.corner, loop.friction, force
    )
    sums[0] += 0.5 * time_step * tangential * (slip + later_slip)
    sums[1] += time_step * (dashpot_power - lost)
    sums[2] += time_step * normal
    sums[3] += time_step * abs(normal)
    return positions[0, loop.corner.nodes[0]]


@compiled
def drift(positions, velocities, force, mass, time_step, shift, begin, end):
    for i in range(2):
        x, v, f, m = positions[i, begin:end], velocities[i, begin:end], force[i, begin:end], mass[begin:end]
        back = shift if i == 0 else 0.0
        for node in range(m.size):
            v[node] += time_step * f[node] / m[node]
            x[node] += time_step * v[node] - back
