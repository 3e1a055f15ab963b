"""Internal forces of the plate: total Lagrangian, any element, any material; compiled.

The elements go through in blocks of lanes (`simd_blocks`). A block's nodal values lie in one scratch array, row
after row: inside one array, with row numbers that are constants to the compiler, it can see that rows do not
overlap, and packs the lanes into vector instructions; over many separate arrays it cannot. The rows, with n nodes
an element:

    positions 2n | forces 2n | velocities 2n | viscous power 1

Shape functions sum to one, so gradients are taken of differences from the first node, and its force is what
balances the others': its own gradients are not needed.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import types
from numba.extending import overload

from fem.compiled import compiled, inlined
from fem.constitutive.materials import stress
from fem.discretisation.elements import ElementTable
from fem.explicit.simd_blocks import (
    LANES,
    Lattice,
    aligned,
    balance,
    clear_idle,
    find_lattice,
    gather,
    in_blocks,
    lane_count,
    scatter,
    subtract_first,
)


class Viscosity(NamedTuple):
    """Viscous stress on the rate of Green strain, with constants like a material's [Pa s]."""

    c_11: float
    c_12: float
    c_33: float


class Scratch(NamedTuple):
    """Room for one block, and the element table as the lanes want it.

    rows: as above. gradients, weights: of all nodes but the first; of congruent elements as tuples, a tuple of
    gradients and a weight a point, constants of the loop over the lanes; else as arrays, a row a block.
    """

    rows: np.ndarray
    gradients: Any
    weights: Any
    lattice: Lattice | None


def scratch_for(table: ElementTable) -> Scratch:
    """Make room, and lay out the table."""
    points, nodes = len(table.weights), len(table.per_element)
    rows = aligned((6 * nodes + 1) * LANES)
    lattice = find_lattice(table.connectivity)
    gradients = table.gradients.reshape(points, 2 * nodes, -1)[:, 2:]
    if table.weights.shape[1] == 1:
        congruent = tuple(tuple(point) for point in gradients[:, :, 0].tolist())
        return Scratch(rows, congruent, tuple(table.weights[:, 0].tolist()), lattice)
    flat = gradients.reshape(points * 2 * (nodes - 1), -1)
    return Scratch(rows, in_blocks(flat, lattice), in_blocks(table.weights, lattice), lattice)


@compiled
def subtract_internal_forces(positions, velocities, viscosity, hourglass, force, table, material, scratch):
    """Subtract the internal forces [N] from `force`, shape (2, nodes); return the viscous power [W].

    positions, velocities: [m], [m/s], shape (2, nodes). viscosity: None, or a `Viscosity`; hourglass: None, or
    an `Hourglass`. What is None is compiled out.
    """
    lanes = lane_count(table.connectivity, scratch.lattice)
    return subtract_forces_of(
        0, lanes, positions, velocities, viscosity, hourglass, force, table, material, scratch
    )


@compiled
def subtract_forces_of(
    begin, end, positions, velocities, viscosity, hourglass, force, table, material, scratch
):
    """The same for the lanes from `begin`, the first of a block, to before `end`."""
    others, nodes, rows = table.per_element[1:], len(table.per_element), scratch.rows
    connectivity, lattice = table.connectivity, scratch.lattice
    power = 0.0
    for first in range(begin, end, LANES):
        count = min(LANES, end - first)
        gather(positions, connectivity, lattice, first, count, rows)
        subtract_first(others, rows)
        rows[2 * nodes * LANES : 4 * nodes * LANES] = 0.0
        if viscosity is not None:
            rates = rows[4 * nodes * LANES :]
            gather(velocities, connectivity, lattice, first, count, rates)
            subtract_first(others, rates)
            rows[6 * nodes * LANES :] = 0.0
        for point in range(table.weights.shape[0]):
            gradients = point_of(scratch.gradients, first // LANES, point, 2 * len(others))
            weights = point_of(scratch.weights, first // LANES, point, 1)
            _add_point(others, material, viscosity, rows, gradients, weights)
        if hourglass is not None:
            _add_hourglass(hourglass, first, count, others, lattice, rows)
        forces = rows[2 * nodes * LANES : 4 * nodes * LANES]
        balance(others, forces)
        clear_idle(lattice, first // LANES, 2 * nodes, forces)
        scatter(force, connectivity, lattice, first, count, forces)
        if viscosity is not None:
            powers = rows[6 * nodes * LANES :]
            clear_idle(lattice, first // LANES, 1, powers)
            for lane in range(count):
                power += powers[lane]
    return power


def point_of(values: Any, block: int, point: int, rows: int) -> Any:
    """Numbers of one point: of all elements, or of a block, `rows` an element; compiled code only."""
    raise NotImplementedError(type(values))


@overload(point_of, inline="always")
def _point_of(values: Any, block: Any, point: Any, rows: Any) -> Any:
    if isinstance(values, types.BaseTuple):

        def numbers(values: Any, block: Any, point: Any, rows: Any) -> Any:
            return values[point]
    else:
        # Views, because an index that might be negative would keep the lanes from being packed.
        def numbers(values: Any, block: Any, point: Any, rows: Any) -> Any:
            return values[block, rows * LANES * point :]

    return numbers


def at_lane(values: Any, row: int, lane: int) -> float:
    """Number `row` of a point, or of an element in its lane; compiled code only."""
    raise NotImplementedError(type(values))


@overload(at_lane, inline="always")
def _at_lane(values: Any, row: Any, lane: Any) -> Any:
    if isinstance(values, types.Float):

        def number(values: Any, row: Any, lane: Any) -> Any:
            return values
    elif isinstance(values, types.BaseTuple):

        def number(values: Any, row: Any, lane: Any) -> Any:
            return values[row]
    else:

        def number(values: Any, row: Any, lane: Any) -> Any:
            return values[row * LANES + lane]

    return number


@compiled
def _add_point(others, material, viscosity, rows, gradients, weights):
    """Add one quadrature point's nodal forces to the block's rows: P = F S, f_a = w P grad N_a."""
    nodes = len(others) + 1
    for lane in range(LANES):
        weight = at_lane(weights, 0, lane)
        f_11, f_12, f_21, f_22 = _gradient(2, others, rows, gradients, lane)
        e_11 = 0.5 * (f_11 * f_11 + f_21 * f_21 - 1.0)
        e_22 = 0.5 * (f_12 * f_12 + f_22 * f_22 - 1.0)
        g_12 = f_11 * f_12 + f_21 * f_22
        s_11, s_22, s_12 = stress(material, e_11, e_22, g_12)
        if viscosity is not None:
            r_11, r_12, r_21, r_22 = _gradient(4 * nodes + 2, others, rows, gradients, lane)
            d_11 = f_11 * r_11 + f_21 * r_21
            d_22 = f_12 * r_12 + f_22 * r_22
            d_12 = f_11 * r_12 + f_12 * r_11 + f_21 * r_22 + f_22 * r_21
            v_11 = viscosity.c_11 * d_11 + viscosity.c_12 * d_22
            v_22 = viscosity.c_12 * d_11 + viscosity.c_11 * d_22
            v_12 = viscosity.c_33 * d_12
            rows[6 * nodes * LANES + lane] += weight * (v_11 * d_11 + v_22 * d_22 + v_12 * d_12)
            s_11 += v_11
            s_22 += v_22
            s_12 += v_12
        s_11 *= weight
        s_22 *= weight
        s_12 *= weight
        p_11 = f_11 * s_11 + f_12 * s_12
        p_12 = f_11 * s_12 + f_12 * s_22
        p_21 = f_21 * s_11 + f_22 * s_12
        p_22 = f_21 * s_12 + f_22 * s_22
        for a in range(len(others)):
            g_1, g_2 = at_lane(gradients, 2 * a, lane), at_lane(gradients, 2 * a + 1, lane)
            rows[(2 * nodes + 2 * a + 2) * LANES + lane] += p_11 * g_1 + p_12 * g_2
            rows[(2 * nodes + 2 * a + 3) * LANES + lane] += p_21 * g_1 + p_22 * g_2


@inlined
def _gradient(row, others, rows, gradients, lane):
    """Gradient of the vector field in the rows from `row`: F from positions, its rate from velocities."""
    t_11 = t_12 = t_21 = t_22 = 0.0
    for a in range(len(others)):
        g_1, g_2 = at_lane(gradients, 2 * a, lane), at_lane(gradients, 2 * a + 1, lane)
        x = rows[(row + 2 * a) * LANES + lane]
        y = rows[(row + 2 * a + 1) * LANES + lane]
        t_11 += x * g_1
        t_12 += x * g_2
        t_21 += y * g_1
        t_22 += y * g_2
    return t_11, t_12, t_21, t_22


@compiled
def _add_hourglass(hourglass, first, count, others, lattice, rows):
    """Add k gamma_a (sum gamma_b x_b) to the block's forces; zero for every linear field, rigid motion included."""
    nodes = len(others) + 1
    for lane in range(count):
        column = first + lane
        if lattice is not None:
            column = lattice.element[column]
        if hourglass.stiffness.size == 1:
            column = 0
        q_1 = q_2 = 0.0
        for a in range(1, nodes):
            q_1 += hourglass.vectors[a, column] * rows[2 * a * LANES + lane]
            q_2 += hourglass.vectors[a, column] * rows[(2 * a + 1) * LANES + lane]
        q_1 *= hourglass.stiffness[column]
        q_2 *= hourglass.stiffness[column]
        for a in range(1, nodes):
            rows[(2 * nodes + 2 * a) * LANES + lane] += hourglass.vectors[a, column] * q_1
            rows[(2 * nodes + 2 * a + 1) * LANES + lane] += hourglass.vectors[a, column] * q_2
