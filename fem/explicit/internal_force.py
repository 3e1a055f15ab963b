"""Internal forces of the plate for any element and any material, compiled.

The formulation is total Lagrangian. Elements are taken in SIMD blocks (`simd_blocks`): quadrilaterals with all
quadrature points at once (`point_force`, `nine_nodes`), other elements point by point. The nodal values of a block lie
in one scratch array, row after row. Inside one array, with row numbers that are constants to the compiler, it can prove
that rows do not overlap, and packs neighbouring slots into vector instructions; over many separate arrays it cannot.
`BlockRows` names the rows.

Shape functions sum to one. Gradients are therefore taken of differences from the first node, whose force balances
those of the other nodes, and its own gradients are not needed. Elements of several points that are not congruent are
mapped from the reference element at each step: reading their nodes takes a sixth of the memory traffic of their
gradients.
"""

from typing import NamedTuple

import numpy as np

from fem.explicit.elastic_damping import SUMS
from fem.explicit.nine_nodes import SIZES, SQUARE, rectangle_sizes, set_nine_nodes
from fem.explicit.point_force import add_point, set_quadrilaterals, set_stabilised_point
from fem.explicit.simd_blocks import (
    BLOCK_SIZE,
    VECTOR_SIZE,
    Lattice,
    aligned,
    balance,
    block_rows,
    clear_idle,
    find_lattice,
    gather,
    in_blocks,
    point_of,
    scatter,
    slot_count,
    subtract_first,
)
from fem.plate.discretisation import UNIFORM_TOLERANCE, ElementTable, Hourglass
from machine_code.compiled import compiled


class Viscosity(NamedTuple):
    """Constants of a viscous stress on the Green strain rate [Pa s].

    They have the meaning of a material's constants.
    """

    c_11: float
    c_12: float
    c_33: float


class Quadrilateral(NamedTuple):
    """Gradients of the modes of quadrilaterals with several points, see `set_quadrilaterals`."""

    linear: tuple[float, ...] | None
    twists: tuple[tuple[float, ...], ...]


class Scratch(NamedTuple):
    """Workspace of one block, with the element table in its order.

    rows: see `BlockRows`. gradients, weights: of all nodes but the first. Those of congruent elements are tuples,
    with a tuple of gradients and a weight per point, constants of the loop over the slots; otherwise arrays with
    one row per block. hourglass: vectors in the same form, then the three stiffnesses; None without control.
    reference: reference positions [m] of the nodes of mapped elements, shape (2, nodes); `gradients` and `weights`
    are then those of the table's `Mapping`. motion: sums over the nodes, shape (SUMS,). quadrilateral: None for
    other elements. nine_nodes: sizes that `set_nine_nodes` takes in place of gradients and weights; None for other
    elements. Compiled code cannot allocate.
    """

    rows: np.ndarray
    gradients: np.ndarray | tuple[tuple[float, ...], ...]
    weights: np.ndarray | tuple[float, ...]
    lattice: Lattice | None
    motion: np.ndarray
    hourglass: np.ndarray | tuple[tuple[float, ...], ...] | None = None
    reference: np.ndarray | None = None
    quadrilateral: Quadrilateral | None = None
    nine_nodes: np.ndarray | tuple[tuple[float, ...]] | None = None


def scratch_for(table: ElementTable, hourglass: Hourglass | None = None) -> Scratch:
    """Return the workspace of a table and its hourglass control."""
    points, nodes = len(table.weights), len(table.per_element)
    rows = aligned(block_rows.py_func(nodes).size)
    lattice, motion = find_lattice(table.connectivity), np.zeros(SUMS)
    shapes = table.gradients.reshape(points, nodes, 2, -1)
    sizes = rectangle_sizes(shapes, table.weights, UNIFORM_TOLERANCE)
    if sizes is not None:
        nine_nodes = in_blocks(sizes, lattice) if sizes.shape[1] > 1 else (tuple(sizes[:, 0].tolist()),)
        return Scratch(rows, (), (), lattice, motion, nine_nodes=nine_nodes)
    if table.mapping is not None:
        natural, weights, reference = table.mapping
        if points == nodes == 9:
            square = ((*SQUARE, 4.0 * sum(weights)),)
            return Scratch(rows, (), (), lattice, motion, None, reference, nine_nodes=square)
        bilinear = len(natural[0]) == 2
        quadrilateral = Quadrilateral(None, tuple((eta, xi) for xi, eta in natural)) if bilinear else None
        return Scratch(rows, natural, weights, lattice, motion, None, reference, quadrilateral)
    gradients = table.gradients.reshape(points, 2 * nodes, -1)[:, 2:]
    control = None if hourglass is None else np.concatenate([hourglass.vectors[1:], hourglass.stiffness])
    if table.weights.shape[1] == 1:
        congruent = tuple(tuple(point) for point in gradients[:, :, 0].tolist())
        one_control = None if control is None else (tuple(control[:, 0].tolist()),)
        weights = tuple(table.weights[:, 0].tolist())
        quadrilateral = _parallelogram(shapes[..., 0])
        return Scratch(rows, congruent, weights, lattice, motion, one_control, None, quadrilateral)
    rows_of_gradients = in_blocks(gradients.reshape(points * 2 * (nodes - 1), -1), lattice)
    control_blocks = None if control is None else in_blocks(control, lattice)
    weights_in_blocks = in_blocks(table.weights, lattice)
    return Scratch(rows, rows_of_gradients, weights_in_blocks, lattice, motion, control_blocks)


def _parallelogram(gradients: np.ndarray) -> Quadrilateral | None:
    """Return the gradients of the modes of congruent parallelograms.

    gradients: of the shape functions, shape (points, nodes, 2) [1/m]. None for other elements, and with one point.
    """
    points, nodes, _ = gradients.shape
    linear = (gradients[:, 1:-1] + gradients[:, 2:]).reshape(points, -1)  # of four nodes, those of xi and eta
    if nodes != 4 or points == 1 or np.ptp(linear, axis=0).max() > UNIFORM_TOLERANCE * np.abs(linear).max():
        return None
    return Quadrilateral(tuple(linear.mean(axis=0).tolist()), tuple(map(tuple, gradients[:, 2].tolist())))


@compiled
def subtract_internal_forces(positions, velocities, viscosity, hourglass, force, table, material, scratch):
    """Subtract the internal forces [N] of all elements from `force`.

    force: shape (2, nodes). positions, velocities: [m], [m/s], shape (2, nodes). viscosity: None or a `Viscosity`.
    hourglass: None or an `Hourglass`, which `scratch` has in its order. What is None is compiled out. Returns the
    viscous power [W].
    """
    slots = slot_count(table.connectivity, scratch.lattice)
    return subtract_forces_of(
        0, slots, positions, velocities, viscosity, hourglass, force, table, material, scratch, None
    )


@compiled
def subtract_forces_of(
    begin, end, positions, velocities, viscosity, hourglass, force, table, material, scratch, energies
):
    """Subtract the internal forces of a range of slots.

    begin: the first slot of a block; end: one more than the last slot. energies: None, or an array to which the
    energies [J] of strain and of hourglass control are added. Other arguments and the result as
    `subtract_internal_forces`.
    """
    nodes, rows = len(table.per_element), scratch.rows
    at = block_rows(nodes)
    energy_rows = rows[at.strain_energy :]
    connectivity, lattice = table.connectivity, scratch.lattice
    power = 0.0
    for first in range(begin, end, BLOCK_SIZE):
        count = min(BLOCK_SIZE, end - first)
        vectors = (count + VECTOR_SIZE - 1) // VECTOR_SIZE
        gather(positions, connectivity, lattice, first, count, rows)
        if viscosity is not None:
            gather(velocities, connectivity, lattice, first, count, rows[at.velocities :])
            rows[at.viscous_power : at.viscous_power + BLOCK_SIZE] = 0.0
        if scratch.reference is not None:
            shape = rows[at.reference :]
            gather(scratch.reference, connectivity, lattice, first, count, shape)
        if energies is not None:
            energy_rows[: 2 * BLOCK_SIZE] = 0.0
        if scratch.quadrilateral is not None:
            linear, twists = scratch.quadrilateral
            set_quadrilaterals(material, viscosity, rows, linear, twists, scratch.weights, energies, vectors)
        elif scratch.nine_nodes is not None:
            sizes = point_of(scratch.nine_nodes, first // BLOCK_SIZE, 0, SIZES)
            set_nine_nodes(material, viscosity, scratch.reference, rows, sizes, energies, vectors)
        else:
            _set_by_points(
                first // BLOCK_SIZE, viscosity, hourglass, table, material, scratch, energies, vectors
            )
        forces = rows[at.forces : at.velocities]
        clear_idle(lattice, first // BLOCK_SIZE, 2 * nodes, forces)
        scatter(force, connectivity, lattice, first, count, forces)
        if viscosity is not None:
            powers = rows[at.viscous_power :]
            clear_idle(lattice, first // BLOCK_SIZE, 1, powers)
            for slot in range(count):
                power += powers[slot]
        if energies is not None:
            clear_idle(lattice, first // BLOCK_SIZE, 2, energy_rows)
            for slot in range(count):
                energies[0] += energy_rows[slot]
                energies[1] += energy_rows[BLOCK_SIZE + slot]
    return power


@compiled
def _set_by_points(block, viscosity, hourglass, table, material, scratch, energies, vectors):
    """Fill the block's rows with forces, point by point."""
    other_nodes, at, rows = table.per_element[1:], block_rows(len(table.per_element)), scratch.rows
    reference = scratch.reference
    subtract_first(other_nodes, rows)
    if viscosity is not None:
        subtract_first(other_nodes, rows[at.velocities :])
    if reference is not None:
        subtract_first(other_nodes, rows[at.reference :])
    if hourglass is None:
        rows[at.forces : at.velocities] = 0.0
    for point in range(table.weights.shape[0]):
        gradients = point_of(scratch.gradients, block, point, 2 * len(other_nodes))
        weights = point_of(scratch.weights, block, point, 1)
        if hourglass is not None:
            control = point_of(scratch.hourglass, block, point, len(other_nodes) + 3)
            set_stabilised_point(
                other_nodes, material, viscosity, rows, gradients, weights, control, energies, vectors
            )
        else:
            add_point(
                reference, other_nodes, material, viscosity, rows, gradients, weights, energies, vectors
            )
    if hourglass is None:
        balance(other_nodes, rows[at.forces : at.velocities])
