"""Forces of one quadrature point on a block of elements; compiled.

P = F S and f_a = w P grad N_a, with the rows of `internal_force`. Gradients are given, or of mapped elements made from
the nodes: J = dX/dxi, F = dx/dxi J^-1, and P J^-T is what the derivatives on the reference element are multiplied by.
A bilinear element needs a third of the operations where its rows are made modes of its own: x = x_0 + xi a + eta b +
xi eta c, with a in the rows of its second node, b in those of its fourth, and the twist c in those of its third.

Elements in SIMD blocks: nodal values are gathered into rows, one slot an element, and summed back; compiled.

BLOCK_SIZE elements make a block. Where the nodes of all elements are numbered alike, as those of a mesh numbered row
by row are, the slots of a block are consecutive nodes, and a row is copied as it lies; else each slot is looked up.
Rows of the first node hold its values, rows of the others the difference from it: fewer products, and no digits
lost far from the origin.
"""

from typing import Any, NamedTuple

import numpy as np

from fem.laws.materials import green_strain, stress
from fem.machine_code.compiled import chosen, compiled, inlined

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
def add_point(others, material, viscosity, rows, gradients, weights):
    """Add one quadrature point's nodal forces to the block's rows: P = F S, f_a = w P grad N_a."""
    nodes = len(others) + 1
    for slot in range(BLOCK_SIZE):
        f = _gradient(2, others, rows, gradients, slot)
        r = f
        if viscosity is not None:
            r = _gradient(4 * nodes + 2, others, rows, gradients, slot)
        power, weight = (6 * nodes) * BLOCK_SIZE + slot, at_slot(weights, 0, slot)
        _add_to_nodes(_stress(f, r, material, viscosity, rows, power, weight), others, rows, gradients, slot)


@compiled
def add_mapped_point(others, material, viscosity, rows, gradients, weights):
    """Add the forces of a quadrature point of mapped elements; gradients: on the reference element."""
    nodes = len(others) + 1
    for slot in range(BLOCK_SIZE):
        area, inverse = _inverse(_gradient(6 * nodes + 3, others, rows, gradients, slot))
        f = _product(_gradient(2, others, rows, gradients, slot), inverse)
        r = f
        if viscosity is not None:
            r = _product(_gradient(4 * nodes + 2, others, rows, gradients, slot), inverse)
        power, weight = (6 * nodes) * BLOCK_SIZE + slot, at_slot(weights, 0, slot) * abs(area)
        p = _stress(f, r, material, viscosity, rows, power, weight)
        _add_to_nodes(_product_with_transpose(p, inverse), others, rows, gradients, slot)


@compiled
def add_bilinear_point(material, viscosity, rows, place, weights):
    """Add the forces of a quadrature point of bilinear elements in their modes; place: xi and eta of the point."""
    for slot in range(BLOCK_SIZE):
        area, inverse = _inverse(_bilinear_gradient(27, rows, place, slot))
        f = _product(_bilinear_gradient(2, rows, place, slot), inverse)
        r = f
        if viscosity is not None:
            r = _product(_bilinear_gradient(18, rows, place, slot), inverse)
        weight = at_slot(weights, 0, slot) * abs(area)
        p = _stress(f, r, material, viscosity, rows, 24 * BLOCK_SIZE + slot, weight)
        q_11, q_12, q_21, q_22 = _product_with_transpose(p, inverse)
        rows[10 * BLOCK_SIZE + slot] += q_11
        rows[11 * BLOCK_SIZE + slot] += q_21
        rows[12 * BLOCK_SIZE + slot] += place[1] * q_11 + place[0] * q_12
        rows[13 * BLOCK_SIZE + slot] += place[1] * q_21 + place[0] * q_22
        rows[14 * BLOCK_SIZE + slot] += q_12
        rows[15 * BLOCK_SIZE + slot] += q_22


@compiled
def to_modes(first, rows):
    """Make three nodes' rows from `first` on, relative to the first node's, a bilinear element's modes."""
    for slot in range(2 * BLOCK_SIZE):
        a, b = rows[first * BLOCK_SIZE + slot], rows[(first + 4) * BLOCK_SIZE + slot]
        rows[(first + 2) * BLOCK_SIZE + slot] -= a + b


@compiled
def from_modes(first, rows):
    """Make three nodes' rows of forces from `first` on out of those on the modes."""
    for slot in range(2 * BLOCK_SIZE):
        twist = rows[(first + 2) * BLOCK_SIZE + slot]
        rows[first * BLOCK_SIZE + slot] -= twist
        rows[(first + 4) * BLOCK_SIZE + slot] -= twist


@compiled
def set_stabilised_point(others, material, viscosity, rows, gradients, weights, control):
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
def _add_to_nodes(p, others, rows, gradients, slot):
    """Add P grad N_a to the forces of all nodes but the first."""
    nodes, (p_11, p_12, p_21, p_22) = len(others) + 1, p
    for a in range(len(others)):
        g_1, g_2 = at_slot(gradients, 2 * a, slot), at_slot(gradients, 2 * a + 1, slot)
        rows[(2 * nodes + 2 * a + 2) * BLOCK_SIZE + slot] += p_11 * g_1 + p_12 * g_2
        rows[(2 * nodes + 2 * a + 3) * BLOCK_SIZE + slot] += p_21 * g_1 + p_22 * g_2


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


@inlined
def _bilinear_gradient(row, rows, place, slot):
    """Gradient on the reference element of a bilinear element, from its modes."""
    x_twist, y_twist = rows[(row + 2) * BLOCK_SIZE + slot], rows[(row + 3) * BLOCK_SIZE + slot]
    return (
        rows[row * BLOCK_SIZE + slot] + place[1] * x_twist,
        rows[(row + 4) * BLOCK_SIZE + slot] + place[0] * x_twist,
        rows[(row + 1) * BLOCK_SIZE + slot] + place[1] * y_twist,
        rows[(row + 5) * BLOCK_SIZE + slot] + place[0] * y_twist,
    )


@inlined
def _inverse(a):
    """Determinant and inverse of a 2 x 2 matrix."""
    determinant = a[0] * a[3] - a[1] * a[2]
    once = 1.0 / determinant  # one division, the slowest of all operations here
    return determinant, (once * a[3], -once * a[1], -once * a[2], once * a[0])


@inlined
def _product(a, b):
    """A B of 2 x 2 matrices."""
    return (
        a[0] * b[0] + a[1] * b[2],
        a[0] * b[1] + a[1] * b[3],
        a[2] * b[0] + a[3] * b[2],
        a[2] * b[1] + a[3] * b[3],
    )


@inlined
def _product_with_transpose(a, b):
    """A B^T of 2 x 2 matrices."""
    return (
        a[0] * b[0] + a[1] * b[1],
        a[0] * b[2] + a[1] * b[3],
        a[2] * b[0] + a[3] * b[1],
        a[2] * b[2] + a[3] * b[3],
    )
