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
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from fem.compiled import chosen, compiled, inlined
from fem.constitutive.strain import green_strain
from fem.constitutive.stress import stress
from fem.discretisation.elements import ElementTable, Hourglass
from fem.explicit.elastic_damping import SUMS
from fem.explicit.simd_blocks import (
    BLOCK_SIZE,
    Lattice,
    aligned,
    balance,
    clear_idle,
    find_lattice,
    gather,
    in_blocks,
    scatter,
    slot_count,
    subtract_first,
)


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
    nodes' reference positions [m], shape (2, nodes); `gradients` and `weights` are then those of the reference element.
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
    """The same for the slots from `begin`, the first of a block, to before `end`."""
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
        _gather_shape(scratch.reference, connectivity, lattice, first, count, others, rows)
        for point in range(table.weights.shape[0]):
            gradients = point_of(scratch.gradients, first // BLOCK_SIZE, point, 2 * len(others))
            weights = point_of(scratch.weights, first // BLOCK_SIZE, point, 1)
            if hourglass is not None:
                control = point_of(scratch.hourglass, first // BLOCK_SIZE, point, len(others) + 3)
                _set_stabilised_point(others, material, viscosity, rows, gradients, weights, control)
            else:
                _add_any_point(scratch.reference, others, material, viscosity, rows, gradients, weights)
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


def point_of(values: Any, block: int, point: int, rows: int) -> Any:
    """Numbers of one point: of all elements, or of a block, `rows` an element; compiled code only."""
    raise NotImplementedError(type(values))


@chosen(point_of)
def _point_of(values: Any, block: Any, point: Any, rows: Any) -> Any:
    from numba import types

    if isinstance(values, types.BaseTuple):

        def numbers(values: Any, block: Any, point: Any, rows: Any) -> Any:
            return values[point]
    else:
        # Views, because an index that might be negative would keep the loop from being vectorised.
        def numbers(values: Any, block: Any, point: Any, rows: Any) -> Any:
            return values[block, rows * BLOCK_SIZE * point :]

    return numbers


def at_slot(values: Any, row: int, slot: int) -> float:
    """Number `row` of a point, or of an element in its slot; compiled code only."""
    raise NotImplementedError(type(values))


@chosen(at_slot)
def _at_slot(values: Any, row: Any, slot: Any) -> Any:
    from numba import types

    if isinstance(values, types.Float):

        def number(values: Any, row: Any, slot: Any) -> Any:
            return values
    elif isinstance(values, types.BaseTuple):

        def number(values: Any, row: Any, slot: Any) -> Any:
            return values[row]
    else:

        def number(values: Any, row: Any, slot: Any) -> Any:
            return values[row * BLOCK_SIZE + slot]

    return number


@compiled
def _gather_shape(reference, connectivity, lattice, first, count, others, rows):
    """Fill the rows of reference positions of mapped elements."""
    if reference is not None:
        shape = rows[(6 * len(others) + 7) * BLOCK_SIZE :]
        gather(reference, connectivity, lattice, first, count, shape)
        subtract_first(others, shape)


@compiled
def _add_any_point(reference, others, material, viscosity, rows, gradients, weights):
    if reference is not None:
        _add_mapped_point(others, material, viscosity, rows, gradients, weights)
    else:
        _add_point(others, material, viscosity, rows, gradients, weights)


@compiled
def _add_point(others, material, viscosity, rows, gradients, weights):
    """Add one quadrature point's nodal forces to the block's rows: P = F S, f_a = w P grad N_a."""
    nodes = len(others) + 1
    for slot in range(BLOCK_SIZE):
        f = _gradient(2, others, rows, gradients, slot)
        r = f
        if viscosity is not None:
            r = _gradient(4 * nodes + 2, others, rows, gradients, slot)
        power, weight = (6 * nodes) * BLOCK_SIZE + slot, at_slot(weights, 0, slot)
        p_11, p_12, p_21, p_22 = _stress(f, r, material, viscosity, rows, power, weight)
        for a in range(len(others)):
            g_1, g_2 = at_slot(gradients, 2 * a, slot), at_slot(gradients, 2 * a + 1, slot)
            rows[(2 * nodes + 2 * a + 2) * BLOCK_SIZE + slot] += p_11 * g_1 + p_12 * g_2
            rows[(2 * nodes + 2 * a + 3) * BLOCK_SIZE + slot] += p_21 * g_1 + p_22 * g_2


@compiled
def _add_mapped_point(others, material, viscosity, rows, gradients, weights):
    """The same for elements that are mapped from the reference element, J = dX/dxi: grad = J^-T dN/dxi."""
    nodes = len(others) + 1
    for slot in range(BLOCK_SIZE):
        j_11, j_12, j_21, j_22 = _gradient(6 * nodes + 3, others, rows, gradients, slot)
        area = j_11 * j_22 - j_12 * j_21
        once = 1.0 / area  # one division, the slowest of all operations here
        i_11, i_12, i_21, i_22 = once * j_22, -once * j_12, -once * j_21, once * j_11
        x_1, x_2, y_1, y_2 = _gradient(2, others, rows, gradients, slot)
        f = (
            x_1 * i_11 + x_2 * i_21,
            x_1 * i_12 + x_2 * i_22,
            y_1 * i_11 + y_2 * i_21,
            y_1 * i_12 + y_2 * i_22,
        )
        r = f
        if viscosity is not None:
            x_1, x_2, y_1, y_2 = _gradient(4 * nodes + 2, others, rows, gradients, slot)
            r = (
                x_1 * i_11 + x_2 * i_21,
                x_1 * i_12 + x_2 * i_22,
                y_1 * i_11 + y_2 * i_21,
                y_1 * i_12 + y_2 * i_22,
            )
        power, weight = (6 * nodes) * BLOCK_SIZE + slot, at_slot(weights, 0, slot) * abs(area)
        p_11, p_12, p_21, p_22 = _stress(f, r, material, viscosity, rows, power, weight)
        q_11, q_12 = p_11 * i_11 + p_12 * i_12, p_11 * i_21 + p_12 * i_22
        q_21, q_22 = p_21 * i_11 + p_22 * i_12, p_21 * i_21 + p_22 * i_22
        for a in range(len(others)):
            g_1, g_2 = at_slot(gradients, 2 * a, slot), at_slot(gradients, 2 * a + 1, slot)
            rows[(2 * nodes + 2 * a + 2) * BLOCK_SIZE + slot] += q_11 * g_1 + q_12 * g_2
            rows[(2 * nodes + 2 * a + 3) * BLOCK_SIZE + slot] += q_21 * g_1 + q_22 * g_2


@compiled
def _set_stabilised_point(others, material, viscosity, rows, gradients, weights, control):
    """Set the block's rows to the forces of elements of one point with hourglass control, the first node's included:
    P + q (x) K p, and gamma_a F K p at node a."""
    nodes = len(others) + 1
    for slot in range(BLOCK_SIZE):
        f = _gradient(2, others, rows, gradients, slot)
        f_11, f_12, f_21, f_22 = f
        r = f
        if viscosity is not None:
            r = _gradient(4 * nodes + 2, others, rows, gradients, slot)
        power, weight = (6 * nodes) * BLOCK_SIZE + slot, at_slot(weights, 0, slot)
        p_11, p_12, p_21, p_22 = _stress(f, r, material, viscosity, rows, power, weight)
        q_1 = q_2 = 0.0
        for a in range(len(others)):
            gamma = at_slot(control, a, slot)
            q_1 += gamma * rows[(2 * a + 2) * BLOCK_SIZE + slot]
            q_2 += gamma * rows[(2 * a + 3) * BLOCK_SIZE + slot]
        t_1, t_2 = f_11 * q_1 + f_21 * q_2, f_12 * q_1 + f_22 * q_2
        k_12 = at_slot(control, nodes + 1, slot)
        r_1 = at_slot(control, nodes - 1, slot) * t_1 + k_12 * t_2
        r_2 = k_12 * t_1 + at_slot(control, nodes, slot) * t_2
        h_1, h_2 = f_11 * r_1 + f_12 * r_2, f_21 * r_1 + f_22 * r_2
        p_11 += q_1 * r_1
        p_12 += q_1 * r_2
        p_21 += q_2 * r_1
        p_22 += q_2 * r_2
        x_sum = y_sum = 0.0
        for a in range(len(others)):
            g_1, g_2 = at_slot(gradients, 2 * a, slot), at_slot(gradients, 2 * a + 1, slot)
            gamma = at_slot(control, a, slot)
            x = p_11 * g_1 + p_12 * g_2 + gamma * h_1
            y = p_21 * g_1 + p_22 * g_2 + gamma * h_2
            rows[(2 * nodes + 2 * a + 2) * BLOCK_SIZE + slot] = x
            rows[(2 * nodes + 2 * a + 3) * BLOCK_SIZE + slot] = y
            x_sum += x
            y_sum += y
        rows[2 * nodes * BLOCK_SIZE + slot] = -x_sum
        rows[(2 * nodes + 1) * BLOCK_SIZE + slot] = -y_sum


@inlined
def _stress(f, r, material, viscosity, rows, power, weight):
    """First Piola-Kirchhoff stress times the weight of the point; what is viscous is added to its power.

    f, r: deformation gradient and its rate. power: place of the viscous power in the rows.
    """
    f_11, f_12, f_21, f_22 = f
    e_11, e_22, g_12 = green_strain(f_11, f_12, f_21, f_22)
    s_11, s_22, s_12 = stress(material, e_11, e_22, g_12)
    if viscosity is not None:
        r_11, r_12, r_21, r_22 = r
        d_11 = f_11 * r_11 + f_21 * r_21
        d_22 = f_12 * r_12 + f_22 * r_22
        d_12 = f_11 * r_12 + f_12 * r_11 + f_21 * r_22 + f_22 * r_21
        v_11 = viscosity.c_11 * d_11 + viscosity.c_12 * d_22
        v_22 = viscosity.c_12 * d_11 + viscosity.c_11 * d_22
        v_12 = viscosity.c_33 * d_12
        rows[power] += weight * (v_11 * d_11 + v_22 * d_22 + v_12 * d_12)
        s_11 += v_11
        s_22 += v_22
        s_12 += v_12
    s_11 *= weight
    s_22 *= weight
    s_12 *= weight
    return (
        f_11 * s_11 + f_12 * s_12,
        f_11 * s_12 + f_12 * s_22,
        f_21 * s_11 + f_22 * s_12,
        f_21 * s_12 + f_22 * s_22,
    )


@inlined
def _gradient(row, others, rows, gradients, slot):
    """Gradient of the vector field in the rows from `row`: F from positions, its rate from velocities."""
    t_11 = t_12 = t_21 = t_22 = 0.0
    for a in range(len(others)):
        g_1, g_2 = at_slot(gradients, 2 * a, slot), at_slot(gradients, 2 * a + 1, slot)
        x = rows[(row + 2 * a) * BLOCK_SIZE + slot]
        y = rows[(row + 2 * a + 1) * BLOCK_SIZE + slot]
        t_11 += x * g_1
        t_12 += x * g_2
        t_21 += y * g_1
        t_22 += y * g_2
    return t_11, t_12, t_21, t_22
