"""Explicit central differences as a compiled loop, without output.

The state between steps is positions at instant n, velocities at n - 1/2, and sums. A step computes the forces at n,
then the velocities at n + 1/2, then the positions at n + 1.
"""

from typing import NamedTuple

import numpy as np

from fem.explicit.elastic_damping import ElasticDamping, damp, power_correction
from fem.explicit.internal_force import Viscosity, subtract_forces_of
from fem.explicit.simd_blocks import slot_count
from fem.laws.constraints import CornerConstraint, add_corner_reaction
from fem.plate.discretisation import ElementTable, Hourglass
from machine_code.compiled import compiled, implements


class LoopParameters(NamedTuple):
    """Constants of a run of the plate with its corner constrained.

    There is no code for a part that is None. span: distance [m] in which the origin
    follows the corner along the wall.
    """

    table: ElementTable
    material: tuple[float, ...]
    mass: np.ndarray
    corner: CornerConstraint
    friction: tuple[float, ...] | None
    viscosity: Viscosity | None
    hourglass: Hourglass | None
    elastic_damping: ElasticDamping | None
    time_step: float
    span: float


class State(NamedTuple):
    """State of the loop, which is the plate's motion and sums.

    positions [m] and velocities half a step back [m/s], shape (2, nodes). sums, shape (4,): friction work and damping
    work on the plate [J]; impulse of the normal reaction and of its magnitude [N s]. origin [m], shape (1,): place
    along the wall from which positions are counted. It follows the plate, because coordinates far from it keep fewer
    digits of the strain, and a stiff plate sums up their rounding over millions of steps.
    """

    positions: np.ndarray
    velocities: np.ndarray
    sums: np.ndarray
    origin: np.ndarray


STRAIN, HOURGLASS, WORK = range(3)
"""Places of the values of `LastRow`."""


class LastRow(NamedTuple):
    """Forces of the plate at the last row for the next step.

    force [N]: without reactions, shape (2, nodes). values, shape (3,): energies of strain and of hourglass control [J],
    and work that damping takes in a step [J].
    """

    force: np.ndarray
    values: np.ndarray


def add_reaction(parameters: object, state: object, damping_work: float, force: np.ndarray) -> float:
    """Add the wall's reaction to the forces and update the sums.

    Bodies: `_add_corner_reaction` below, and `_add_contact_reaction` of `impact_loop`. damping_work [J]: that the
    damping of the plate takes in a step. Returns the place [m] of the node that the origin follows.
    """
    raise NotImplementedError(type(parameters))


@compiled
def follow(x, span, origin):
    """Shift the origin once its node is a span away.

    x [m]: place of the node. Returns the distance [m] by which positions are to be set back.
    """
    shift = span if x >= span else -span if x <= -span else 0.0
    origin[0] += shift
    return shift


@compiled
def advance(state, steps, parameters, force, scratch):
    """Advance the state in place by this many steps.

    force, scratch: workspace.
    """
    for _ in range(steps):
        work = plate_forces(state, parameters, force, scratch, None)
        end_step(state, work, parameters, force, scratch)


@compiled
def advance_to_row(state, stride, parameters, force, scratch, last):
    """Advance by `stride` steps from one row to the next.

    force, last: as `describe_forces` sets them, before and after. The first step takes the forces in `last`. They come
    from the kernel with energies at each row, also at the first of a call: its rounding differs from that of the kernel
    without, and the bits do not depend on the number of rows in a call.
    """
    if stride > 0:
        copy_nodal(last.force, force)
        end_step(state, last.values[WORK], parameters, force, scratch)
        advance(state, stride - 1, parameters, force, scratch)
        describe_forces(state, parameters, force, scratch, last)


@compiled
def describe_forces(state, parameters, force, scratch, last):
    """Put the forces of the plate [N] into `force`, and fill `last`."""
    last.values[:] = 0.0
    last.values[WORK] = plate_forces(state, parameters, force, scratch, last.values)
    copy_nodal(force, last.force)


@compiled
def plate_forces(state, parameters, force, scratch, energies):
    """Put the forces of the plate [N], without reactions, into `force`.

    energies: see `subtract_forces_of`. Returns the work [J] that damping takes in a step, at the velocities half a step
    back.
    """
    positions, velocities, table = state.positions, state.velocities, parameters.table
    viscosity, hourglass, material = parameters.viscosity, parameters.hourglass, parameters.material
    force[:] = 0.0
    slots = slot_count(table.connectivity, scratch.lattice)
    power = subtract_forces_of(
        0, slots, positions, velocities, viscosity, hourglass, force, table, material, scratch, energies
    )
    mass, time_step = parameters.mass, parameters.time_step
    power -= damp(parameters.elastic_damping, positions, velocities, mass, time_step, scratch.motion, force)
    return time_step * power


@compiled
def end_step(state, work, parameters, force, scratch):
    """Add the reactions to the plate's forces and advance the nodes.

    work: result of `plate_forces`.
    """
    time_step, mass = parameters.time_step, parameters.mass
    place = add_reaction(parameters, state, work, force)
    damping, nodes = parameters.elastic_damping, mass.size
    state.sums[1] += time_step * power_correction(damping, scratch.motion, state, time_step, 0, nodes, force)
    shift = follow(place, parameters.span, state.origin)
    drift(state.positions, state.velocities, force, mass, time_step, shift, 0, nodes)


@compiled
def copy_nodal(values, target):
    """Copy nodal values, shape (2, nodes)."""
    for i in range(values.shape[0]):
        for node in range(values.shape[1]):
            target[i, node] = values[i, node]


@implements(add_reaction, LoopParameters, merged=True)
def _add_corner_reaction(parameters, state, damping_work, force):
    """Add the reaction of the wall on the constrained corner."""
    positions, velocities, sums, _ = state
    time_step = parameters.time_step
    normal, tangential, slip, later_slip, dashpot_power = add_corner_reaction(
        positions, velocities, parameters.mass, time_step, parameters.corner, parameters.friction, force
    )
    sums[0] += 0.5 * time_step * tangential * (slip + later_slip)
    sums[1] += time_step * dashpot_power - damping_work
    sums[2] += time_step * normal
    sums[3] += time_step * abs(normal)
    return positions[0, parameters.corner.nodes[0]]


@compiled
def drift(positions, velocities, force, mass, time_step, shift, begin, end):
    """Advance velocities and positions of a range of nodes by one step.

    shift [m]: distance by which positions along the wall are set back.
    """
    for i in range(2):
        x, v, f, m = positions[i, begin:end], velocities[i, begin:end], force[i, begin:end], mass[begin:end]
        offset = shift if i == 0 else 0.0
        for node in range(m.size):
            v[node] += time_step * f[node] / m[node]
            x[node] += time_step * v[node] - offset
