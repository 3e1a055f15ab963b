"""Nodal forces of quadrilaterals of nine nodes, compiled.

All quadrature points are taken at once. With coordinates from the middle of a rectangle, a field of the nodes is the
sum of a_ij x^i y^j over i, j <= 2. Its coefficients are differences along the lines of nodes, and its gradient at the
points of a column, x = const, is a polynomial in y. This takes half the products of the shape functions' gradients.
Forces of the nodes follow from the stresses by the transposed steps. Other elements are mapped on the square with sides
of 2, as in `point_force`.
"""

import math

import numpy as np

from fem.explicit.point_force import mapped_stress
from fem.explicit.simd_blocks import NODE, VECTOR_SIZE, Y, at_slot, block_rows
from machine_code.compiled import inlined, reordered

GAUSS = math.sqrt(0.6)
"""Outer points of Gauss's rule of three on (-1, 1)."""

COLUMNS = (-1.0, 5.0 / 18.0), (0.0, 8.0 / 18.0), (1.0, 5.0 / 18.0)
"""Place over that of the last column, and weight of each column of points."""

NODES = (0, 2, 2, 0, 1, 2, 1, 0, 1), (0, 0, 2, 2, 0, 1, 2, 1, 1)
"""Place of each node in a line of three nodes along x, and along y."""

SIZES = 7
"""Rows of `rectangle_sizes`."""

SQUARE = 0.5, 0.5, 0.5, 0.5, GAUSS, GAUSS
"""First of these for the square with sides of 2."""


def rectangle_sizes(gradients: np.ndarray, weights: np.ndarray, tolerance: float) -> np.ndarray | None:
    """Return the sizes of rectangles with nine nodes, or None.

    Other elements have None. Sizes are 1 / (2 a), 1 / (2 a^2), 1 / (2 b), 1 / (2 b^2) of half the sides a and b [1/m,
    1/m^2], x and y of the last points from the middle [m] and the volume [m^3], shape (SIZES, elements).

    gradients: of the shape functions [1/m], shape (points, nodes, 2, elements). weights: shape (points, elements)
    [m^3]. tolerance: relative, of the gradients.
    """
    if gradients.shape[:2] != (9, 9):
        return None
    first, elements = (gradients[..., :1], weights[:, :1]), weights.shape[1]
    if elements > 1 and rectangle_sizes(*first, tolerance) is None:  # spares the memory that all would take
        return None
    with np.errstate(divide="ignore", invalid="ignore"):
        half = 0.5 / gradients[4, (5, 6), (0, 1)]
    xi = GAUSS * np.array([-1.0, 0.0, 1.0])
    values = np.array([0.5 * xi * (xi - 1.0), 1.0 - xi * xi, 0.5 * xi * (xi + 1.0)])
    slopes = np.array([xi - 0.5, -2.0 * xi, xi + 0.5])
    expected = [
        np.einsum("ak,al,e->klae", x[NODES[0], :], y[NODES[1], :], 1.0 / h).reshape(9, 9, -1)
        for x, y, h in ((slopes, values, half[0]), (values, slopes, half[1]))
    ]
    if not np.abs(gradients - np.stack(expected, axis=2)).max() <= tolerance * np.abs(gradients).max():
        return None
    (x, y), (xx, yy) = 0.5 / half, 0.5 / (half * half)
    return np.array([x, xx, y, yy, GAUSS * half[0], GAUSS * half[1], weights.sum(axis=0)])


@reordered
def set_nine_nodes(material, viscosity, reference, rows, sizes, energies, vectors):
    """Fill the block's rows with the forces of all nodes.

    sizes: see `rectangle_sizes`, as `simd_blocks.at_slot` takes them. reference: None for rectangles. Other elements
    have the sizes of the square on which they are mapped, whose volume is 4 times the thickness.
    """
    at = block_rows(9)
    for slot in range(VECTOR_SIZE * vectors):
        along, across = _scales(sizes, 0, slot), _scales(sizes, 2, slot)
        x_last, height = at_slot(sizes, 4, slot), at_slot(sizes, 5, slot)
        field = _coefficients(at.positions, rows, along, across, slot)
        rate = shape = field
        if viscosity is not None:
            rate = _coefficients(at.velocities, rows, along, across, slot)
        if reference is not None:
            shape = _coefficients(at.reference, rows, along, across, slot)
        f_u = f_v = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        for place, part in COLUMNS:
            x, weight = place * x_last, part * at_slot(sizes, 6, slot)
            f, r, j = _gradients(field, x, height), _gradients(rate, x, height), _gradients(shape, x, height)
            outer, inner = COLUMNS[0][1] * weight, COLUMNS[1][1] * weight
            lower = mapped_stress(
                f[0], r[0], j[0], outer, material, viscosity, reference, rows, at, energies, slot
            )
            middle = mapped_stress(
                f[1], r[1], j[1], inner, material, viscosity, reference, rows, at, energies, slot
            )
            upper = mapped_stress(
                f[2], r[2], j[2], outer, material, viscosity, reference, rows, at, energies, slot
            )
            f_u = _with_column(f_u, lower[0], lower[1], middle[0], middle[1], upper[0], upper[1], x, height)
            f_v = _with_column(f_v, lower[2], lower[3], middle[2], middle[3], upper[2], upper[3], x, height)
        _set_nodes(f_u, at.forces, rows, along, across, slot)
        _set_nodes(f_v, at.forces + Y, rows, along, across, slot)


@inlined
def _scales(sizes, row, slot):
    return at_slot(sizes, row, slot), at_slot(sizes, row + 1, slot)


@inlined
def _coefficients(field, rows, along, across, slot):
    """Return the coefficients of a vector field, of both components.

    field: place of the nodal values.
    """
    u = _component(field, rows, along, across, slot)
    return u, _component(field + Y, rows, along, across, slot)


@inlined
def _component(component, rows, along, across, slot):
    """Return a_10, a_20, a_01, a_11, a_21, a_02, a_12 and a_22."""
    bottom, bottom_slope, bottom_bend = _line(component, 0, 4, 1, rows, along, slot)
    middle, a_10, a_20 = _line(component, 7, 8, 5, rows, along, slot)
    top, top_slope, top_bend = _line(component, 3, 6, 2, rows, along, slot)
    a_01, a_02 = _differences(bottom - middle, top - middle, across)
    a_21, a_22 = _differences(bottom_bend - a_20, top_bend - a_20, across)
    a_11, a_12 = _differences(bottom_slope - a_10, top_slope - a_10, across)
    return a_10, a_20, a_01, a_11, a_21, a_02, a_12, a_22


@inlined
def _line(component, begin, middle, end, rows, along, slot):
    """Return middle value, slope and half the curvature of a line."""
    value = rows[component + middle * NODE + slot]
    before, after = rows[component + begin * NODE + slot], rows[component + end * NODE + slot]
    slope, bend = _differences(before - value, after - value, along)
    return value, slope, bend


@inlined
def _differences(before, after, scale):
    """Return first and half the second derivative.

    before, after: values relative to the middle.
    """
    return scale[0] * (after - before), scale[1] * (before + after)


@inlined
def _gradients(field, x, height):
    """Return the gradients at the three points of a column.

    field: coefficients.
    """
    p, q, square = _column(field[0], x), _column(field[1], x), height * height
    p_even, p_odd, p_twist = p[0] + square * p[2], height * p[1], height * p[4]
    q_even, q_odd, q_twist = q[0] + square * q[2], height * q[1], height * q[4]
    return (
        (p_even - p_odd, p[3] - p_twist, q_even - q_odd, q[3] - q_twist),
        (p[0], p[3], q[0], q[3]),
        (p_even + p_odd, p[3] + p_twist, q_even + q_odd, q[3] + q_twist),
    )


@inlined
def _column(a, x):
    """Return both derivatives of a component at x, as polynomials in y.

    The first has three coefficients, the second two.
    """
    a_10, a_20, a_01, a_11, a_21, a_02, a_12, a_22 = a
    return (
        a_10 + 2.0 * x * a_20,
        a_11 + 2.0 * x * a_21,
        a_12 + 2.0 * x * a_22,
        a_01 + x * (a_11 + x * a_21),
        2.0 * (a_02 + x * (a_12 + x * a_22)),
    )


@inlined
def _with_column(f, lower_x, lower_y, middle_x, middle_y, upper_x, upper_y, x, height):
    """Return forces of the coefficients with those of a column."""
    outer = lower_x + upper_x
    p_0, p_1, p_2 = middle_x + outer, height * (upper_x - lower_x), height * height * outer
    q_0, q_1 = middle_y + lower_y + upper_y, height * (upper_y - lower_y)
    return (
        f[0] + p_0,
        f[1] + 2.0 * x * p_0,
        f[2] + q_0,
        f[3] + p_1 + x * q_0,
        f[4] + x * (2.0 * p_1 + x * q_0),
        f[5] + 2.0 * q_1,
        f[6] + p_2 + 2.0 * x * q_1,
        f[7] + 2.0 * x * (p_2 + x * q_1),
    )


@inlined
def _set_nodes(f, component, rows, along, across, slot):
    """Set the nodes' forces of a component by those of its coefficients."""
    f_10, f_20, f_01, f_11, f_21, f_02, f_12, f_22 = f
    slope, bend = across
    for side, begin, middle, end in ((-1.0, 0, 4, 1), (1.0, 3, 6, 2)):
        odd = side * slope
        value, first, second = odd * f_01 + bend * f_02, odd * f_11 + bend * f_12, odd * f_21 + bend * f_22
        _set_line(value, first, second, component, begin, middle, end, rows, along, slot)
    twice = -2.0 * bend
    _set_line(twice * f_02, f_10 + twice * f_12, f_20 + twice * f_22, component, 7, 8, 5, rows, along, slot)


@inlined
def _set_line(value, slope, bend, component, begin, middle, end, rows, along, slot):
    odd, even = along[0] * slope, along[1] * bend
    rows[component + begin * NODE + slot] = even - odd
    rows[component + middle * NODE + slot] = value - 2.0 * even
    rows[component + end * NODE + slot] = even + odd
