"""Nodal forces of the quadrature points of a block of elements, compiled.

P = F S, f_a = w P grad N_a

The rows are those of `internal_force`. Gradients of congruent elements are stored. Those of mapped elements follow
from their nodes, J = dX/dxi and F = dx/dxi J^-1, and P J^-T multiplies the derivatives on the reference element.

Quadrilaterals with several points take all of them at once. Of their modes, x = x_0 + xi a + eta b + xi eta c, the
gradient is F = a (x) grad xi + b (x) grad eta + c (x) grad (xi eta), of which the first two are constant in a
parallelogram.
"""

from fem.explicit.simd_blocks import NODE, VECTOR_SIZE, Y, at_slot, block_rows
from fem.laws.materials import energy_density, green_strain, stress
from machine_code.compiled import inlined, reordered


@reordered
def add_point(reference, other_nodes, material, viscosity, rows, gradients, weights, energies, vectors):
    """Add the nodal forces of one quadrature point to the block's rows.

    P = F S, f_a = w P grad N_a. reference: None, or the reference positions of mapped elements, whose gradients are on
    the reference element. energies: None where the strain energy is not added to its row. vectors: number, of
    VECTOR_SIZE slots each.
    """
    at = block_rows(len(other_nodes) + 1)
    for slot in range(VECTOR_SIZE * vectors):
        shape = (1.0, 0.0, 0.0, 1.0)
        if reference is not None:
            shape = _gradient(at.reference, other_nodes, rows, gradients, slot)
        f = _gradient(at.positions, other_nodes, rows, gradients, slot)
        r = f
        if viscosity is not None:
            r = _gradient(at.velocities, other_nodes, rows, gradients, slot)
        weight = at_slot(weights, 0, slot)
        p = mapped_stress(f, r, shape, weight, material, viscosity, reference, rows, at, energies, slot)
        _add_to_nodes(p, other_nodes, rows, gradients, slot)


@reordered
def set_quadrilaterals(material, viscosity, rows, linear, twists, weights, energies, vectors):
    """Fill the block's rows with forces of quadrilaterals, the first node included.

    linear: gradients of xi and eta in congruent parallelograms, in a row; None for mapped elements. twists: gradient of
    xi eta at each point; of mapped elements on the reference element.
    """
    at = block_rows(4)
    for slot in range(VECTOR_SIZE * vectors):
        x, x_twist = _modes(at.positions, rows, slot)
        v, v_twist = x, x_twist
        if viscosity is not None:
            v, v_twist = _modes(at.velocities, rows, slot)
        shape, shape_twist = x, x_twist
        if linear is None:
            shape, shape_twist = _modes(at.reference, rows, slot)
        s_11 = s_12 = s_21 = s_22 = t_1 = t_2 = 0.0
        for point in range(len(twists)):
            if linear is not None:
                inverted, twist, weight = linear, twists[point], weights[point]
            else:
                area, inverted = inverse(_twisted(shape, shape_twist, twists[point]))
                twist, weight = _row_product(twists[point], inverted), weights[point] * abs(area)
            f = _twisted(product(x, inverted), x_twist, twist)
            r = f
            if viscosity is not None:
                r = _twisted(product(v, inverted), v_twist, twist)
            p = weighted_stress(f, r, material, viscosity, rows, at, weight, energies, slot)
            t_1 += p[0] * twist[0] + p[1] * twist[1]
            t_2 += p[2] * twist[0] + p[3] * twist[1]
            if linear is None:
                p = product_with_transpose(p, inverted)
            s_11, s_12, s_21, s_22 = s_11 + p[0], s_12 + p[1], s_21 + p[2], s_22 + p[3]
        if linear is not None:
            s_11, s_12, s_21, s_22 = product_with_transpose((s_11, s_12, s_21, s_22), linear)
        forces = at.forces
        rows[forces + slot] = t_1 - s_11 - s_12
        rows[forces + Y + slot] = t_2 - s_21 - s_22
        rows[forces + NODE + slot] = s_11 - t_1
        rows[forces + NODE + Y + slot] = s_21 - t_2
        rows[forces + 2 * NODE + slot] = t_1
        rows[forces + 2 * NODE + Y + slot] = t_2
        rows[forces + 3 * NODE + slot] = s_12 - t_1
        rows[forces + 3 * NODE + Y + slot] = s_22 - t_2


@inlined
def _modes(field, rows, slot):
    """Return the linear modes of a quadrilateral, and its twist.

    field: place of the nodal values.
    """
    x, y = rows[field + slot], rows[field + Y + slot]
    x_xi, y_xi = rows[field + NODE + slot] - x, rows[field + NODE + Y + slot] - y
    x_eta, y_eta = rows[field + 3 * NODE + slot] - x, rows[field + 3 * NODE + Y + slot] - y
    x_twist = rows[field + 2 * NODE + slot] - x - x_xi - x_eta
    y_twist = rows[field + 2 * NODE + Y + slot] - y - y_xi - y_eta
    return (x_xi, x_eta, y_xi, y_eta), (x_twist, y_twist)


@inlined
def _twisted(linear, twist, gradient):
    """Return the gradient of a field, the sum of both parts."""
    return (
        linear[0] + twist[0] * gradient[0],
        linear[1] + twist[0] * gradient[1],
        linear[2] + twist[1] * gradient[0],
        linear[3] + twist[1] * gradient[1],
    )


@reordered
def set_stabilised_point(
    other_nodes, material, viscosity, rows, gradients, weights, control, energies, vectors
):
    """Fill the block's rows with forces of one-point elements.

    Hourglass control is included, and so is the first node: the stress is P + q (x) K p, and node a receives gamma_a
    F K p in addition.
    """
    at = block_rows(len(other_nodes) + 1)
    for slot in range(VECTOR_SIZE * vectors):
        f = _gradient(at.positions, other_nodes, rows, gradients, slot)
        f_11, f_12, f_21, f_22 = f
        r = f
        if viscosity is not None:
            r = _gradient(at.velocities, other_nodes, rows, gradients, slot)
        weight = at_slot(weights, 0, slot)
        p_11, p_12, p_21, p_22 = weighted_stress(f, r, material, viscosity, rows, at, weight, energies, slot)
        q_1 = q_2 = 0.0
        for a in range(len(other_nodes)):
            gamma = at_slot(control, a, slot)
            q_1 += gamma * rows[at.positions + (a + 1) * NODE + slot]
            q_2 += gamma * rows[at.positions + (a + 1) * NODE + Y + slot]
        t_1, t_2 = f_11 * q_1 + f_21 * q_2, f_12 * q_1 + f_22 * q_2
        k_12 = at_slot(control, len(other_nodes) + 2, slot)
        r_1 = at_slot(control, len(other_nodes), slot) * t_1 + k_12 * t_2
        r_2 = k_12 * t_1 + at_slot(control, len(other_nodes) + 1, slot) * t_2
        if energies is not None:
            rows[at.hourglass_energy + slot] += 0.5 * (t_1 * r_1 + t_2 * r_2)
        h_1, h_2 = f_11 * r_1 + f_12 * r_2, f_21 * r_1 + f_22 * r_2
        p_11 += q_1 * r_1
        p_12 += q_1 * r_2
        p_21 += q_2 * r_1
        p_22 += q_2 * r_2
        x_sum = y_sum = 0.0
        for a in range(len(other_nodes)):
            g_1, g_2 = at_slot(gradients, 2 * a, slot), at_slot(gradients, 2 * a + 1, slot)
            gamma = at_slot(control, a, slot)
            x = p_11 * g_1 + p_12 * g_2 + gamma * h_1
            y = p_21 * g_1 + p_22 * g_2 + gamma * h_2
            rows[at.forces + (a + 1) * NODE + slot] = x
            rows[at.forces + (a + 1) * NODE + Y + slot] = y
            x_sum += x
            y_sum += y
        rows[at.forces + slot] = -x_sum
        rows[at.forces + Y + slot] = -y_sum


@inlined
def mapped_stress(f, r, shape, weight, material, viscosity, reference, rows, at, energies, slot):
    """Return the weighted stress that multiplies gradients of the coordinates.

    f, r, shape: gradients of positions, velocities and reference positions; reference: None where they are those in the
    reference configuration.
    """
    if reference is None:
        return weighted_stress(f, r, material, viscosity, rows, at, weight, energies, slot)
    area, inverted = inverse(shape)
    f, r, volume = product(f, inverted), product(r, inverted), abs(area) * weight
    p = weighted_stress(f, r, material, viscosity, rows, at, volume, energies, slot)
    return product_with_transpose(p, inverted)


@inlined
def weighted_stress(f, r, material, viscosity, rows, at, weight, energies, slot):
    """Return the weighted first Piola-Kirchhoff stress of a point.

    The viscous power, and the strain energy unless `energies` is None, are added to the rows. f, r: deformation
    gradient and its rate. at: the `BlockRows`.
    """
    f_11, f_12, f_21, f_22 = f
    e_11, e_22, g_12 = green_strain(f_11, f_12, f_21, f_22)
    s_11, s_22, s_12 = stress(material, e_11, e_22, g_12)
    if energies is not None:
        rows[at.strain_energy + slot] += weight * energy_density(material, e_11, e_22, g_12)
    if viscosity is not None:
        r_11, r_12, r_21, r_22 = r
        d_11 = f_11 * r_11 + f_21 * r_21
        d_22 = f_12 * r_12 + f_22 * r_22
        d_12 = f_11 * r_12 + f_12 * r_11 + f_21 * r_22 + f_22 * r_21
        v_11 = viscosity.c_11 * d_11 + viscosity.c_12 * d_22
        v_22 = viscosity.c_12 * d_11 + viscosity.c_11 * d_22
        v_12 = viscosity.c_33 * d_12
        rows[at.viscous_power + slot] += weight * (v_11 * d_11 + v_22 * d_22 + v_12 * d_12)
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
def _add_to_nodes(p, other_nodes, rows, gradients, slot):
    """Add P grad N_a to all nodal forces but the first."""
    forces, (p_11, p_12, p_21, p_22) = block_rows(len(other_nodes) + 1).forces, p
    for a in range(len(other_nodes)):
        g_1, g_2 = at_slot(gradients, 2 * a, slot), at_slot(gradients, 2 * a + 1, slot)
        rows[forces + (a + 1) * NODE + slot] += p_11 * g_1 + p_12 * g_2
        rows[forces + (a + 1) * NODE + Y + slot] += p_21 * g_1 + p_22 * g_2


@inlined
def _gradient(field, other_nodes, rows, gradients, slot):
    """Return the gradient of a vector field at the point.

    field: place of the nodal values. The gradient is F for positions, and the rate of F for velocities.
    """
    t_11 = t_12 = t_21 = t_22 = 0.0
    for a in range(len(other_nodes)):
        g_1, g_2 = at_slot(gradients, 2 * a, slot), at_slot(gradients, 2 * a + 1, slot)
        x = rows[field + (a + 1) * NODE + slot]
        y = rows[field + (a + 1) * NODE + Y + slot]
        t_11 += x * g_1
        t_12 += x * g_2
        t_21 += y * g_1
        t_22 += y * g_2
    return t_11, t_12, t_21, t_22


@inlined
def inverse(a):
    """Return the determinant and the inverse of a 2 x 2 matrix."""
    determinant = a[0] * a[3] - a[1] * a[2]
    reciprocal = 1.0 / determinant  # the only division, which is the slowest operation here
    return determinant, (reciprocal * a[3], -reciprocal * a[1], -reciprocal * a[2], reciprocal * a[0])


@inlined
def product(a, b):
    """Return A B of 2 x 2 matrices."""
    return (
        a[0] * b[0] + a[1] * b[2],
        a[0] * b[1] + a[1] * b[3],
        a[2] * b[0] + a[3] * b[2],
        a[2] * b[1] + a[3] * b[3],
    )


@inlined
def _row_product(a, b):
    """Return the row A B."""
    return a[0] * b[0] + a[1] * b[2], a[0] * b[1] + a[1] * b[3]


@inlined
def product_with_transpose(a, b):
    """Return A B^T of 2 x 2 matrices."""
    return (
        a[0] * b[0] + a[1] * b[1],
        a[0] * b[2] + a[1] * b[3],
        a[2] * b[0] + a[3] * b[1],
        a[2] * b[2] + a[3] * b[3],
    )
