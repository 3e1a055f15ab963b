"""Strain of the elements from the positions of their nodes, in compiled code."""

from __future__ import annotations

from fem.compiled import inlined


@inlined
def deformation_gradient(positions, table, point, element):
    """F (11, 12, 21, 22) at a quadrature point of an element; of one of no motion, the identity."""
    nodes, column = len(table.per_element), 0 if table.gradients.shape[1] == 1 else element
    f_11 = f_12 = f_21 = f_22 = 0.0
    for a in range(nodes):
        node = table.connectivity[a, element]
        g_1 = table.gradients[(point * nodes + a) * 2, column]
        g_2 = table.gradients[(point * nodes + a) * 2 + 1, column]
        f_11 += positions[0, node] * g_1
        f_12 += positions[0, node] * g_2
        f_21 += positions[1, node] * g_1
        f_22 += positions[1, node] * g_2
    return f_11, f_12, f_21, f_22


@inlined
def green_strain(f_11, f_12, f_21, f_22):
    """Green strain (11, 22, twice 12)."""
    return (
        0.5 * (f_11 * f_11 + f_21 * f_21 - 1.0),
        0.5 * (f_12 * f_12 + f_22 * f_22 - 1.0),
        f_11 * f_12 + f_21 * f_22,
    )
