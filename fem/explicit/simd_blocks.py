"""Elements in lanes: nodal values are gathered into rows, one lane an element, and summed back; compiled.

LANES elements make a block. Where the nodes of all elements are numbered alike, as those of a mesh numbered row
by row are, the lanes of a block are consecutive nodes, and a row is copied as it lies; else each lane is looked up.
Rows of the first node hold its values, rows of the others the difference from it: fewer products, and no digits
lost far from the origin.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fem.compiled import compiled

LANES = 64
"""Elements a block; the rows of a block stay in the first-level cache."""


class Lattice(NamedTuple):
    """Elements numbered alike: corner a of the element in lane l is node first[a] + l.

    element: of each lane; lanes between two rows of the mesh hold none, -1. idle: those lanes, within their
    block; block b has idle[idle_from[b] : idle_from[b + 1]].
    """

    first: np.ndarray
    element: np.ndarray
    idle: np.ndarray
    idle_from: np.ndarray


def find_lattice(connectivity: np.ndarray) -> Lattice | None:
    """The lattice of this connectivity, shape (nodes per element, elements); None if it has none."""
    lowest = connectivity[0].min()
    lane = connectivity[0] - lowest
    offsets = connectivity - connectivity[0]
    lanes = int(lane.max()) + 1
    if (offsets != offsets[:, :1]).any() or lanes > 1.25 * lane.size or np.unique(lane).size < lane.size:
        return None
    element = np.full(lanes, -1)
    element[lane] = np.arange(lane.size)
    idle = np.flatnonzero(element < 0)
    idle_from = np.searchsorted(idle, LANES * np.arange(blocks_of(lanes) + 1))
    return Lattice((lowest + offsets[:, 0]).astype(np.int64), element, idle % LANES, idle_from)


def blocks_of(lanes: int) -> int:
    """Number of blocks that hold these lanes."""
    return -(-lanes // LANES)


def in_blocks(values: np.ndarray, lattice: Lattice | None) -> np.ndarray:
    """Element values of shape (rows, elements), a row of the result for each block, zero in idle lanes."""
    if lattice is not None:
        values = np.where(lattice.element < 0, 0.0, values[:, lattice.element])
    rows, lanes = values.shape
    laid = np.zeros((blocks_of(lanes), rows, LANES))
    for block in range(len(laid)):
        part = values[:, block * LANES : (block + 1) * LANES]
        laid[block, :, : part.shape[1]] = part
    return laid.reshape(len(laid), rows * LANES)


def aligned(size: int) -> np.ndarray:
    """Zeros that begin at a cache line, so that no vector lies across two."""
    room = np.zeros(size + 8)
    skip = -(room.ctypes.data // room.itemsize) % 8
    return room[skip : skip + size]


@compiled
def lane_count(connectivity, lattice):
    """Lanes in all, idle ones included."""
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
                source, target = values[i, start : start + count], rows[(2 * a + i) * LANES :]
                for lane in range(source.size):
                    target[lane] = source[lane]
        else:
            for lane in range(count):
                node = connectivity[a, first + lane]
                rows[2 * a * LANES + lane] = values[0, node]
                rows[(2 * a + 1) * LANES + lane] = values[1, node]


@compiled
def subtract_first(others, rows):
    """Make the rows of all corners but the first relative to it."""
    for lane in range(2 * LANES):
        for a in range(len(others)):
            rows[(2 * a + 2) * LANES + lane] -= rows[lane]


@compiled
def balance(others, rows):
    """Fill the first corner's rows with what makes the sum of all corners zero."""
    for lane in range(2 * LANES):
        total = 0.0
        for a in range(len(others)):
            total += rows[(2 * a + 2) * LANES + lane]
        rows[lane] = -total


@compiled
def clear_idle(lattice, block, count, rows):
    """Zero the first `count` rows in lanes of this block that hold no element."""
    if lattice is not None:
        for i in range(lattice.idle_from[block], lattice.idle_from[block + 1]):
            for row in range(count):
                rows[row * LANES + lattice.idle[i]] = 0.0


@compiled
def scatter(force, connectivity, lattice, first, count, rows):
    """Subtract rows 2 a and 2 a + 1 from corner a's `force`."""
    for a in range(connectivity.shape[0]):
        if lattice is not None:
            start = lattice.first[a] + first
            for i in range(2):
                target, source = force[i, start : start + count], rows[(2 * a + i) * LANES :]
                for lane in range(target.size):
                    target[lane] -= source[lane]
        else:
            for lane in range(count):
                node = connectivity[a, first + lane]
                force[0, node] -= rows[2 * a * LANES + lane]
                force[1, node] -= rows[(2 * a + 1) * LANES + lane]
