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

from fem.explicit.elastic_damping import SUMS
from fem.explicit.point_force import (
    add_bilinear_point,
    add_mapped_point,
    add_point,
    from_modes,
    point_of,
    set_stabilised_point,
    to_modes,
)
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
from fem.machine_code.compiled import compiled
from fem.plate.elements import ElementTable, Hourglass


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
