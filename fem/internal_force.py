"""Internal forces of the plate: total Lagrangian, any element, any material; compiled.

The elements go through in blocks of LANES. A block's nodal values lie in one scratch array, row after row, one
lane an element: inside one array, with row numbers that are constants to the compiler, it can see that rows do
not overlap, and packs the lanes into vector instructions; over many separate arrays it cannot. The rows, with
n nodes an element:

    positions 2n | forces 2n | velocities 2n | viscous power 1
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fem.compiled import compiled, inlined
from fem.elements import ElementTable
from fem.materials import stress

LANES = 32
"""Elements a block; every row of a block stays in the first-level cache."""


class Viscosity(NamedTuple):
    """Viscous stress on the rate of Green strain, with constants like a material's [Pa s]."""

    c_11: float
    c_12: float
    c_33: float


class Scratch(NamedTuple):
    """Room for one block: the rows above, and the block's gradients (2n a point) and weights (1 a point)."""

    rows: np.ndarray
    gradients: np.ndarray
    weights: np.ndarray


def scratch_for(table: ElementTable) -> Scratch:
    """Make room; the gradients of congruent elements are laid down here once and for all."""
    rows = np.zeros((6 * len(table.per_element) + 1) * LANES)
    gradients, weights = np.zeros((len(table.gradients), LANES)), np.zeros((len(table.weights), LANES))
    if table.weights.shape[1] == 1:
        gradients[:], weights[:] = table.gradients, table.weights
    return Scratch(rows, gradients.ravel(), weights.ravel())


@compiled
def subtract_internal_forces(positions, velocities, viscosity, hourglass, force, table, material, scratch):
    """Subtract the internal forces [N] from `force`, shape (2, nodes); return the viscous power [W].

    positions, velocities: [m], [m/s], shape (2, nodes). viscosity: None, or a `Viscosity`; hourglass: None, or
    an `Hourglass`. What is None is compiled out.
    """
    elements = table.connectivity.shape[1]
    return subtract_forces_of(
        0, elements, positions, velocities, viscosity, hourglass, force, table, material, scratch
    )


@compiled
def subtract_forces_of(
    begin, end, positions, velocities, viscosity, hourglass, force, table, material, scratch
):
    """The same for the elements from `begin` to before `end`."""
    tag, nodes, rows = table.per_element, len(table.per_element), scratch.rows
    power = 0.0
    for first in range(begin, end, LANES):
        count = min(LANES, end - first)
        _gather(positions, table.connectivity, first, count, 0, rows)
        rows[2 * nodes * LANES : 4 * nodes * LANES] = 0.0
        if table.weights.shape[1] != 1:
            _copy_block(table.gradients, first, count, scratch.gradients)
            _copy_block(table.weights, first, count, scratch.weights)
        if viscosity is not None:
            _gather(velocities, table.connectivity, first, count, 4 * nodes, rows)
            rows[6 * nodes * LANES :] = 0.0
        for point in range(table.weights.shape[0]):
            # Views, because an index that might be negative would keep the lanes from being packed.
            gradients = scratch.gradients[2 * nodes * LANES * point :]
            _add_point(tag, material, viscosity, rows, gradients, scratch.weights[LANES * point :])
        if hourglass is not None:
            _add_hourglass(hourglass, first, count, tag, rows)
        _scatter(force, table.connectivity, first, count, 2 * nodes, rows)
        if viscosity is not None:
            for lane in range(count):
                power += rows[6 * nodes * LANES + lane]
    return power


@compiled
def _gather(values, connectivity, first, count, row, rows):
    for a in range(connectivity.shape[0]):
        for lane in range(count):
            node = connectivity[a, first + lane]
            rows[(row + 2 * a) * LANES + lane] = values[0, node]
            rows[(row + 2 * a + 1) * LANES + lane] = values[1, node]


@compiled
def _copy_block(values, first, count, block):
    for row in range(values.shape[0]):
        source, target = values[row, first : first + count], block[row * LANES : row * LANES + count]
        for lane in range(count):
            target[lane] = source[lane]


@compiled
def _scatter(force, connectivity, first, count, row, rows):
    for a in range(connectivity.shape[0]):
        for lane in range(count):
            node = connectivity[a, first + lane]
            force[0, node] -= rows[(row + 2 * a) * LANES + lane]
            force[1, node] -= rows[(row + 2 * a + 1) * LANES + lane]


@compiled
def _add_point(tag, material, viscosity, rows, gradients, weights):
    """Add one quadrature point's nodal forces to the block's rows: P = F S, f_a = w P grad N_a."""
    nodes = len(tag)
    for lane in range(LANES):
        weight = weights[lane]
        f_11, f_12, f_21, f_22 = _gradient(0, tag, rows, gradients, lane)
        e_11 = 0.5 * (f_11 * f_11 + f_21 * f_21 - 1.0)
        e_22 = 0.5 * (f_12 * f_12 + f_22 * f_22 - 1.0)
        g_12 = f_11 * f_12 + f_21 * f_22
        s_11, s_22, s_12 = stress(material, e_11, e_22, g_12)
        if viscosity is not None:
            r_11, r_12, r_21, r_22 = _gradient(4 * nodes, tag, rows, gradients, lane)
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
        p_11 = weight * (f_11 * s_11 + f_12 * s_12)
        p_12 = weight * (f_11 * s_12 + f_12 * s_22)
        p_21 = weight * (f_21 * s_11 + f_22 * s_12)
        p_22 = weight * (f_21 * s_12 + f_22 * s_22)
        for a in range(len(tag)):
            g_1 = gradients[2 * a * LANES + lane]
            g_2 = gradients[(2 * a + 1) * LANES + lane]
            rows[(2 * nodes + 2 * a) * LANES + lane] += p_11 * g_1 + p_12 * g_2
            rows[(2 * nodes + 2 * a + 1) * LANES + lane] += p_21 * g_1 + p_22 * g_2


@inlined
def _gradient(row, tag, rows, gradients, lane):
    """Gradient of the vector field in the rows from `row`: F from positions, its rate from velocities."""
    t_11 = t_12 = t_21 = t_22 = 0.0
    for a in range(len(tag)):
        g_1 = gradients[2 * a * LANES + lane]
        g_2 = gradients[(2 * a + 1) * LANES + lane]
        x = rows[(row + 2 * a) * LANES + lane]
        y = rows[(row + 2 * a + 1) * LANES + lane]
        t_11 += x * g_1
        t_12 += x * g_2
        t_21 += y * g_1
        t_22 += y * g_2
    return t_11, t_12, t_21, t_22


@compiled
def _add_hourglass(hourglass, first, count, tag, rows):
    """Add k gamma_a (sum gamma_b x_b) to the block's forces; zero for every linear field, rigid motion included."""
    nodes = len(tag)
    congruent = hourglass.stiffness.size == 1
    for lane in range(count):
        column = 0 if congruent else first + lane
        q_1 = q_2 = 0.0
        for a in range(len(tag)):
            q_1 += hourglass.vectors[a, column] * rows[2 * a * LANES + lane]
            q_2 += hourglass.vectors[a, column] * rows[(2 * a + 1) * LANES + lane]
        q_1 *= hourglass.stiffness[column]
        q_2 *= hourglass.stiffness[column]
        for a in range(len(tag)):
            rows[(2 * nodes + 2 * a) * LANES + lane] += hourglass.vectors[a, column] * q_1
            rows[(2 * nodes + 2 * a + 1) * LANES + lane] += hourglass.vectors[a, column] * q_2
