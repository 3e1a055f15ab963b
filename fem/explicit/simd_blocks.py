"""SIMD blocks of elements with their nodal values side by side, compiled.

BLOCK_SIZE elements make a block of as many slots. Nodal values are gathered into rows, one number per slot,
and forces are scattered back. A mesh that is numbered row by row has a lattice: the slots of a block are then
consecutive nodes, and a row is copied as it lies. Otherwise each slot is looked up.

The rows of the first node hold its values, those of the other nodes the difference from it. This takes fewer products,
and no digits are lost far from the origin.
"""

from typing import NamedTuple

import numpy as np

from machine_code.compiled import chosen, compiled, inlined
from machine_code.values import Number, Record

BLOCK_SIZE = 64
"""Elements per block; the rows of a block stay in the first-level cache."""

VECTOR_SIZE = 8
"""Slots that are computed as a vector; the last vector of a block may be partly idle."""

ANY_NODE = 2**31 - 1
"""Bits of a node number; with them the compiler knows that no number is negative."""


Y, NODE = BLOCK_SIZE, 2 * BLOCK_SIZE
"""Distances in a vector field from component x to y, and from node to node."""


class BlockRows(NamedTuple):
    """Place of each quantity in the workspace of a block.

    Size is that of the workspace. Vector fields have two rows per node, x and y; powers and energies have one. The
    number of a slot stands in `rows[place + node * NODE + Y + slot]`. This sum stands in the brackets: only there
    does LLVM learn that it stays within 64 bits, and vectorises.
    """

    positions: int
    forces: int
    velocities: int
    viscous_power: int
    reference: int
    strain_energy: int
    hourglass_energy: int
    size: int


@inlined
def block_rows(nodes: int) -> BlockRows:
    """Return the rows of elements with this number of nodes."""
    field = nodes * NODE
    return BlockRows(
        positions=0,
        forces=field,
        velocities=2 * field,
        viscous_power=3 * field,
        reference=3 * field + BLOCK_SIZE,
        strain_energy=4 * field + BLOCK_SIZE,
        hourglass_energy=4 * field + 2 * BLOCK_SIZE,
        size=4 * field + 3 * BLOCK_SIZE,
    )


class Lattice(NamedTuple):
    """Numbering of elements that rises by one per slot.

    Corner a of the element in slot l is node first[a] + l.

    element: of each slot; slots between two rows of the mesh hold none, -1. idle: those slots, counted within their
    block; block b has idle[idle_from[b] : idle_from[b + 1]].
    """

    first: np.ndarray
    element: np.ndarray
    idle: np.ndarray
    idle_from: np.ndarray


def find_lattice(connectivity: np.ndarray) -> Lattice | None:
    """Return the lattice of a connectivity, or None where it has none.

    connectivity: shape (nodes per element, elements).
    """
    lowest = connectivity[0].min()
    slot = connectivity[0] - lowest
    offsets = connectivity - connectivity[0]
    slots = int(slot.max()) + 1
    if (offsets != offsets[:, :1]).any() or slots > 1.25 * slot.size:
        return None
    element = np.full(slots, -1)
    element[slot] = np.arange(slot.size)
    idle = np.flatnonzero(element < 0)
    if idle.size > slots - slot.size:  # elements with a slot in common
        return None
    idle_from = np.searchsorted(idle, BLOCK_SIZE * np.arange(blocks_of(slots) + 1))
    return Lattice((lowest + offsets[:, 0]).astype(np.int64), element, idle % BLOCK_SIZE, idle_from)


def blocks_of(slots: int) -> int:
    """Return the number of blocks for this number of slots."""
    return -(-slots // BLOCK_SIZE)


def in_blocks(values: np.ndarray, lattice: Lattice | None) -> np.ndarray:
    """Arrange element values block by block, zero in idle slots.

    values: shape (rows, elements). The result has one row per block.
    """
    if lattice is not None:
        values = np.where(lattice.element < 0, 0.0, values[:, lattice.element])
    rows, slots = values.shape
    blocks = np.zeros((blocks_of(slots), rows, BLOCK_SIZE))
    for block in range(len(blocks)):
        columns = values[:, block * BLOCK_SIZE : (block + 1) * BLOCK_SIZE]
        blocks[block, :, : columns.shape[1]] = columns
    return blocks.reshape(len(blocks), rows * BLOCK_SIZE)


def aligned(size: int) -> np.ndarray:
    """Return zeros that begin at a cache line.

    No vector instruction then reads across two lines.
    """
    buffer = np.zeros(size + 8)
    skip = -(buffer.ctypes.data // buffer.itemsize) % 8
    return buffer[skip : skip + size]


@compiled
def slot_count(connectivity, lattice):
    """Return the number of slots, idle ones included."""
    if lattice is not None:
        return lattice.element.size
    return connectivity.shape[1]


@compiled
def gather(values, connectivity, lattice, first, count, rows):
    """Copy the values of each corner to its two rows.

    rows: from the first of the vector field on.
    """
    for a in range(connectivity.shape[0]):
        if lattice is not None:
            start = lattice.first[a] + first & ANY_NODE
            for i in range(2):
                for slot in range(count):
                    rows[a * NODE + i * BLOCK_SIZE + slot] = values[i, start + slot]
        else:
            for slot in range(count):
                node = connectivity[a, first + slot] & ANY_NODE
                rows[a * NODE + slot] = values[0, node]
                rows[a * NODE + Y + slot] = values[1, node]


@compiled
def subtract_first(other_nodes, rows):
    """Make the rows of all other corners relative to the first."""
    for slot in range(2 * BLOCK_SIZE):  # both components
        for a in range(len(other_nodes)):
            rows[(a + 1) * NODE + slot] -= rows[slot]


@compiled
def balance(other_nodes, rows):
    """Fill the first corner's rows so that the corners sum to zero."""
    for slot in range(2 * BLOCK_SIZE):  # both components
        total = 0.0
        for a in range(len(other_nodes)):
            total += rows[(a + 1) * NODE + slot]
        rows[slot] = -total


@compiled
def clear_idle(lattice, block, count, rows):
    """Set idle slots of a block to zero in its first rows.

    count: number of these rows.
    """
    if lattice is not None:
        for i in range(lattice.idle_from[block], lattice.idle_from[block + 1]):
            for row in range(count):
                rows[row * BLOCK_SIZE + lattice.idle[i]] = 0.0


@compiled
def scatter(force, connectivity, lattice, first, count, rows):
    """Subtract the two rows of each corner from its force.

    rows: from the first of the vector field on.
    """
    for a in range(connectivity.shape[0]):
        if lattice is not None:
            start = lattice.first[a] + first & ANY_NODE
            for i in range(2):
                for slot in range(count):
                    force[i, start + slot] -= rows[a * NODE + i * BLOCK_SIZE + slot]
        else:
            for slot in range(count):
                node = connectivity[a, first + slot] & ANY_NODE
                force[0, node] -= rows[a * NODE + slot]
                force[1, node] -= rows[a * NODE + Y + slot]


def point_of(values: np.ndarray | tuple[object, ...], block: int, point: int, rows: int) -> object:
    """Return the values of one quadrature point, in compiled code only.

    They are those of all elements where these are congruent, else those of a block, with `rows` numbers per element.
    """
    raise NotImplementedError(type(values))


@chosen(point_of)
def _point_of(values, block, point, rows):
    if isinstance(values, Record):

        def numbers(values, block, point, rows):
            return values[point]
    else:

        def numbers(values, block, point, rows):
            return values[block, rows * BLOCK_SIZE * point :]

    return numbers


def at_slot(values: np.ndarray | tuple[float, ...] | float, row: int, slot: int) -> float:
    """Return one value of a slot, in compiled code only.

    row: number of the value, slot: of the element within its block.
    """
    raise NotImplementedError(type(values))


@chosen(at_slot)
def _at_slot(values, row, slot):
    if isinstance(values, Number):

        def number(values, row, slot):
            return values
    elif isinstance(values, Record):

        def number(values, row, slot):
            return values[row]
    else:

        def number(values, row, slot):
            return values[row * BLOCK_SIZE + slot]

    return number
