"""Elements in SIMD blocks: nodal values are gathered into rows, one slot an element, and summed back; compiled.

BLOCK_SIZE elements make a block. Where the nodes of all elements are numbered alike, as those of a mesh numbered row
by row are, the slots of a block are consecutive nodes, and a row is copied as it lies; else each slot is looked up.
Rows of the first node hold its values, rows of the others the difference from it: fewer products, and no digits
lost far from the origin.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fem.machine_code.compiled import compiled

BLOCK_SIZE = 64
"""Elements a block; the rows of a block stay in the first-level cache."""


class Lattice(NamedTuple):
    """Elements numbered alike: corner a of the element in slot l is node first[a] + l.

    element: of each slot; slots between two rows of the mesh hold none, -1. idle: those slots, within their
    block; block b has idle[idle_from[b] : idle_from[b + 1]].
    """

    first: np.ndarray
    element: np.ndarray
    idle: np.ndarray
    idle_from: np.ndarray


def find_lattice(connectivity: np.ndarray) -> Lattice | None:
    """The lattice of this connectivity, shape (nodes per element, elements); None if it has none."""
    lowest = connectivity[0].min()
    slot = connectivity[0] - lowest
    offsets = connectivity - connectivity[0]
    slots = int(slot.max()) + 1
    if (offsets != offsets[:, :1]).any() or slots > 1.25 * slot.size or np.unique(slot).size < slot.size:
        return None
    element = np.full(slots, -1)
    element[slot] = np.arange(slot.size)
    idle = np.flatnonzero(element < 0)
    idle_from = np.searchsorted(idle, BLOCK_SIZE * np.arange(blocks_of(slots) + 1))
    return Lattice((lowest + offsets[:, 0]).astype(np.int64), element, idle % BLOCK_SIZE, idle_from)


def blocks_of(slots: int) -> int:
    """Number of blocks that hold these slots."""
    return -(-slots // BLOCK_SIZE)


def in_blocks(values: np.ndarray, lattice: Lattice | None) -> np.ndarray:
    """Element values of shape (rows, elements), a row of the result for each block, zero in idle slots."""
    if lattice is not None:
        values = np.where(lattice.element < 0, 0.0, values[:, lattice.element])
    rows, slots = values.shape
    laid = np.zeros((blocks_of(slots), rows, BLOCK_SIZE))
    for block in range(len(laid)):
        part = values[:, block * BLOCK_SIZE : (block + 1) * BLOCK_SIZE]
        laid[block, :, : part.shape[1]] = part
    return laid.reshape(len(laid), rows * BLOCK_SIZE)


def aligned(size: int) -> np.ndarray:
    """Zeros that begin at a cache line, so that no vector lies across two."""
    buffer = np.zeros(size + 8)
    skip = -(buffer.ctypes.data // buffer.itemsize) % 8
    return buffer[skip : skip + size]


@compiled
def slot_count(connectivity, lattice):
    """Slots in all, idle ones included."""
    if lattice is not None:
        return lattice.element.size
    return connectivity.shape[1]


@compiled
def gather(values, connectivity, lattice, first, count, rows):
    """Fill rows 2 a and 2 a + 1 with the values of corner a."""
    for a in range(connectivity.shape[0]):
        if lattice is not None:
            start = lattice.first[a] + first
            for i in range(2):
                source, target = values[i, start : start + count], rows[(2 * a + i) * BLOCK_SIZE :]
                for slot in range(source.size):
                    target[slot] = source[slot]
        else:
            for slot in range(count):
                node = connectivity[a, first + slot]
                rows[2 * a * BLOCK_SIZE + slot] = values[0, node]
                rows[(2 * a + 1) * BLOCK_SIZE + slot] = values[1, node]


@compiled
def subtract_first(others, rows):
    """Make the rows of all corners but the first relative to it."""
    for slot in range(2 * BLOCK_SIZE):
        for a in range(len(others)):
            rows[(2 * a + 2) * BLOCK_SIZE + slot] -= rows[slot]


@compiled
def balance(others, rows):
    """Fill the first corner's rows with what makes the sum of all corners zero."""
    for slot in range(2 * BLOCK_SIZE):
        total = 0.0
        for a in range(len(others)):
            total += rows[(2 * a + 2) * BLOCK_SIZE + slot]
        rows[slot] = -total


@compiled
def clear_idle(lattice, block, count, rows):
    """Zero the first `count` rows in slots of this block that hold no element."""
    if lattice is not None:
        for i in range(lattice.idle_from[block], lattice.idle_from[block + 1]):
            for row in range(count):
                rows[row * BLOCK_SIZE + lattice.idle[i]] = 0.0


@compiled
def scatter(force, connectivity, lattice, first, count, rows):
    """Subtract rows 2 a and 2 a + 1 from corner a's `force`."""
    for a in range(connectivity.shape[0]):
        if lattice is not None:
            start = lattice.first[a] + first
            for i in range(2):
                target, source = force[i, start : start + count], rows[(2 * a + i) * BLOCK_SIZE :]
                for slot in range(target.size):
                    target[slot] -= source[slot]
        else:
            for slot in range(count):
                node = connectivity[a, first + slot]
                force[0, node] -= rows[2 * a * BLOCK_SIZE + slot]
                force[1, node] -= rows[(2 * a + 1) * BLOCK_SIZE + slot]
