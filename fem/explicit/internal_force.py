"""Internal forces of the plate: total Lagrangian, any element, any material; compiled.

The elements go through in SIMD blocks (`simd_blocks`), one slot an element. A block's nodal values lie in one scratch
array, row after row: inside one array, with row numbers that are constants to the compiler, it can see that rows do not
overlap, and packs neighbouring slots into vector instructions; over many separate arrays it cannot. The rows, with n
nodes an element:

    positions 2n | forces 2n | velocities 2n | viscous power 1 | reference positions 2n

Shape functions sum to one, so gradients are taken of differences from the first node, and its force is what
balances the others': its own gradients are not needed. Elements of several points that are not congruent are mapped
from the reference element as they are needed: reading their nodes takes a sixth of the memory traffic of their
gradients.

Damping of the elastic velocities alone: rigid-body motion, and with it momentum and spin, stays as it is; compiled.

    rigid motion    r = V + w x (x - x_G), the one that fits the nodal velocities best in the mass-weighted sense: the
                    mean axes of the flexible body (Canavin and Likins, J. Spacecraft Rockets 14, 1977)
    force           f = -c m (v - r), at the velocities half a step back

Turned back by half a step, a rigid velocity field is w x (x - x_G) + w^2 dt/2 (x - x_G) on the positions x that are at
hand; without the second part the damping would press on every turning plate. The forces have no resultant and no
moment. A mode that grows at less than c/2 by itself decays, whatever its frequency. Without damping the parameters are
None, and the code is compiled out.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from fem.explicit.point_force import (
    BLOCK_SIZE,
    Lattice,
    add_bilinear_point,
    add_mapped_point,
    add_point,
    aligned,
    balance,
    clear_idle,
    find_lattice,
    from_modes,
    gather,
    in_blocks,
    point_of,
    scatter,
    set_stabilised_point,
    slot_count,
    subtract_first,
    to_modes,
)
from fem.machine_code.compiled import compiled, implements, optional
from fem.plate.discretisation import ElementTable, Hourglass

SUMS = 6
"""Mass times x, y, v_x, v_y; moment of momentum and second moment about the origin."""


class ElasticDamping(NamedTuple):
    """Rate c [1/s] at which elastic velocities are taken out; mass of the plate [kg]."""

    rate: float
    mass: float


def damped_time_step(frequency: float, rate: float) -> float:
    """Largest stable step [s] of a mode of this highest frequency [rad/s], its damping force half a step late."""
    half = 0.5 * rate
    return 2.0 / (half + math.sqrt(half**2 + frequency**2))


@optional()
def add_up(damping, positions, velocities, mass, begin, end, sums):
    """Fill `sums`, shape (SUMS,), over the nodes from `begin` to before `end`."""


@optional()
def resist(damping, sums, positions, velocities, mass, time_step, begin, end, force):
    """Add the damping forces on these nodes, `sums` being those of all nodes; their power [W] at these velocities."""
    return 0.0


@optional()
def gained(damping, sums, state, time_step, begin, end, force):
    """Change of their power [W] on the mean of the velocities half a step before and after, `force` being
    complete: with that the energy balance closes to rounding."""
    return 0.0


@implements(add_up, ElasticDamping)
def _add_up(damping, positions, velocities, mass, begin, end, sums):
    x, y, m = positions[0, begin:end], positions[1, begin:end], mass[begin:end]
    v_x, v_y = velocities[0, begin:end], velocities[1, begin:end]
    m_x = m_y = p_x = p_y = spin = second = 0.0
    for node in range(m.size):
        m_x += m[node] * x[node]
        m_y += m[node] * y[node]
        p_x += m[node] * v_x[node]
        p_y += m[node] * v_y[node]
        spin += m[node] * (x[node] * v_y[node] - y[node] * v_x[node])
        second += m[node] * (x[node] * x[node] + y[node] * y[node])
    sums[0], sums[1], sums[2], sums[3], sums[4], sums[5] = m_x, m_y, p_x, p_y, spin, second


@compiled
def rigid_motion(damping, sums, time_step):
    """Numbers a, b, w, k of r = (a - w y + k x, b + w x + k y), shape (4,)."""
    c_x, c_y = sums[0] / damping.mass, sums[1] / damping.mass
    v_x, v_y = sums[2] / damping.mass, sums[3] / damping.mass
    inertia = sums[5] - damping.mass * (c_x * c_x + c_y * c_y)
    spin = (sums[4] - damping.mass * (c_x * v_y - c_y * v_x)) / inertia
    lag = 0.5 * time_step * spin * spin
    return v_x + spin * c_y - lag * c_x, v_y - spin * c_x - lag * c_y, spin, lag


@implements(resist, ElasticDamping)
def _resist(damping, sums, positions, velocities, mass, time_step, begin, end, force):
    a, b, spin, lag = rigid_motion(damping, sums, time_step)
    x, y, m = positions[0, begin:end], positions[1, begin:end], mass[begin:end]
    v_x, v_y = velocities[0, begin:end], velocities[1, begin:end]
    f_x, f_y, rate, power = force[0, begin:end], force[1, begin:end], damping.rate, 0.0
    for node in range(m.size):
        e_x = v_x[node] - (a - spin * y[node] + lag * x[node])
        e_y = v_y[node] - (b + spin * x[node] + lag * y[node])
        f_x[node] -= rate * m[node] * e_x
        f_y[node] -= rate * m[node] * e_y
        # Power on v: what is rigid in v is orthogonal to e and is left out, the lag is not.
        power += m[node] * (e_x * (e_x + lag * x[node]) + e_y * (e_y + lag * y[node]))
    return -rate * power


@implements(gained, ElasticDamping)
def _gained(damping, sums, state, time_step, begin, end, force):
    a, b, spin, lag = rigid_motion(damping, sums, time_step)
    x, y = state.positions[0, begin:end], state.positions[1, begin:end]
    v_x, v_y = state.velocities[0, begin:end], state.velocities[1, begin:end]
    f_x, f_y, power = force[0, begin:end], force[1, begin:end], 0.0
    for node in range(x.size):
        e_x = v_x[node] - (a - spin * y[node] + lag * x[node])
        e_y = v_y[node] - (b + spin * x[node] + lag * y[node])
        power += e_x * f_x[node] + e_y * f_y[node]
    return -0.5 * time_step * damping.rate * power


@compiled
def damp(damping, positions, velocities, mass, time_step, sums, force):
    """Add the damping forces on all nodes; returns their power [W] at these velocities. `sums` is filled."""
    add_up(damping, positions, velocities, mass, 0, mass.size, sums)
    return resist(damping, sums, positions, velocities, mass, time_step, 0, mass.size, force)


def elastic_damping(rate: float, mass: np.ndarray) -> ElasticDamping | None:
    """The law for this rate [1/s]; None for zero: then there is no damping code."""
    return ElasticDamping(rate, float(mass.sum())) if rate > 0.0 else None


class Viscosity(NamedTuple):
    """Viscous stress on the rate of Green strain, with constants like a material's [Pa s]."""

    c_11: float
    c_12: float
    c_33: float


class Scratch(NamedTuple):
    """Workspace of one block, and the element table as it is read there.

    rows: as above. gradients, weights: of all nodes but the first; of congruent elements as tuples, a tuple of
    gradients and a weight a point, constants of the loop over the slots; else as arrays, a row a block. hourglass:
    vectors likewise, then the three stiffnesses; None where there is no control. reference: of mapped elements the
    nodes' reference positions [m], shape (2, nodes); `gradients` and `weights` are then those of its table's `Mapping`.
    motion: sums over the nodes, shape (SUMS,). Compiled code allocates nothing: its errors would take a third of it.
    """

    rows: np.ndarray
    gradients: Any
    weights: Any
    lattice: Lattice | None
    motion: np.ndarray
    hourglass: Any = None
    reference: np.ndarray | None = None


def scratch_for(table: ElementTable, hourglass: Hourglass | None = None) -> Scratch:
    """The workspace, and the table and its control laid out for it."""
    points, nodes = len(table.weights), len(table.per_element)
    rows = aligned((8 * nodes + 1) * BLOCK_SIZE)
    lattice, motion = find_lattice(table.connectivity), np.zeros(SUMS)
    if table.mapping is not None:
        natural, weights, reference = table.mapping
        return Scratch(rows, natural, weights, lattice, motion, reference=reference)
    gradients = table.gradients.reshape(points, 2 * nodes, -1)[:, 2:]
    control = None if hourglass is None else np.concatenate([hourglass.vectors[1:], hourglass.stiffness])
    if table.weights.shape[1] == 1:
        congruent = tuple(tuple(point) for point in gradients[:, :, 0].tolist())
        same = None if control is None else (tuple(control[:, 0].tolist()),)
        return Scratch(rows, congruent, tuple(table.weights[:, 0].tolist()), lattice, motion, same)
    flat = gradients.reshape(points * 2 * (nodes - 1), -1)
    laid = None if control is None else in_blocks(control, lattice)
    return Scratch(rows, in_blocks(flat, lattice), in_blocks(table.weights, lattice), lattice, motion, laid)


@compiled
def subtract_internal_forces(positions, velocities, viscosity, hourglass, force, table, material, scratch):
    """Subtract the internal forces [N] from `force`, shape (2, nodes); return the viscous power [W].

    positions, velocities: [m], [m/s], shape (2, nodes). viscosity: None, or a `Viscosity`; hourglass: None, or
    an `Hourglass`, which `scratch` has laid out. What is None is compiled out.
    """
    slots = slot_count(table.connectivity, scratch.lattice)
    return subtract_forces_of(
        0, slots, positions, velocities, viscosity, hourglass, force, table, material, scratch
    )


@compiled
def subtract_forces_of(
    begin, end, positions, velocities, viscosity, hourglass, force, table, material, scratch
):
    """Subtract the forces of the slots from `begin`, the first of a block, to before `end`."""
    others, nodes, rows = table.per_element[1:], len(table.per_element), scratch.rows
    connectivity, lattice = table.connectivity, scratch.lattice
    power = 0.0
    for first in range(begin, end, BLOCK_SIZE):
        count = min(BLOCK_SIZE, end - first)
        gather(positions, connectivity, lattice, first, count, rows)
        subtract_first(others, rows)
        if hourglass is None:
            rows[2 * nodes * BLOCK_SIZE : 4 * nodes * BLOCK_SIZE] = 0.0
        if viscosity is not None:
            rates = rows[4 * nodes * BLOCK_SIZE :]
            gather(velocities, connectivity, lattice, first, count, rates)
            subtract_first(others, rates)
            rows[6 * nodes * BLOCK_SIZE : (6 * nodes + 1) * BLOCK_SIZE] = 0.0
        shape, place = scratch.reference, point_of(scratch.gradients, 0, 0, 2 * len(others))
        _begin_mapping(shape, place, connectivity, lattice, first, count, viscosity, others, rows)
        for point in range(table.weights.shape[0]):
            gradients = point_of(scratch.gradients, first // BLOCK_SIZE, point, 2 * len(others))
            weights = point_of(scratch.weights, first // BLOCK_SIZE, point, 1)
            if hourglass is not None:
                control = point_of(scratch.hourglass, first // BLOCK_SIZE, point, len(others) + 3)
                set_stabilised_point(others, material, viscosity, rows, gradients, weights, control)
            else:
                _add_any_point(shape, others, material, viscosity, rows, gradients, weights)
        _end_mapping(shape, place, rows)
        forces = rows[2 * nodes * BLOCK_SIZE : 4 * nodes * BLOCK_SIZE]
        if hourglass is None:
            balance(others, forces)
        clear_idle(lattice, first // BLOCK_SIZE, 2 * nodes, forces)
        scatter(force, connectivity, lattice, first, count, forces)
        if viscosity is not None:
            powers = rows[6 * nodes * BLOCK_SIZE :]
            clear_idle(lattice, first // BLOCK_SIZE, 1, powers)
            for slot in range(count):
                power += powers[slot]
    return power


@compiled
def _begin_mapping(reference, place, connectivity, lattice, first, count, viscosity, others, rows):
    """Fill the rows of reference positions of mapped elements; make the rows of bilinear ones their modes."""
    if reference is not None:
        shape = rows[(6 * len(others) + 7) * BLOCK_SIZE :]
        gather(reference, connectivity, lattice, first, count, shape)
        subtract_first(others, shape)
        if len(place) == 2:
            to_modes(2, rows)
            to_modes(27, rows)
            if viscosity is not None:
                to_modes(18, rows)


@compiled
def _end_mapping(reference, place, rows):
    """Make nodal forces of those on the modes of bilinear elements."""
    if reference is not None:  # noqa: SIM102  Numba drops a branch by each condition alone
        if len(place) == 2:
            from_modes(10, rows)


@compiled
def _add_any_point(reference, others, material, viscosity, rows, gradients, weights):
    if reference is None:
        add_point(others, material, viscosity, rows, gradients, weights)
    elif len(gradients) == 2:
        add_bilinear_point(material, viscosity, rows, gradients, weights)
    else:
        add_mapped_point(others, material, viscosity, rows, gradients, weights)
