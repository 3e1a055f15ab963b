"""Highest frequency and stress of the plate in deformed positions.

The frequency needs no stiffness matrix.
"""

import math
from collections.abc import Iterable

import numpy as np

from fem.explicit.internal_force import scratch_for, subtract_internal_forces
from fem.explicit.time_loop import LoopParameters
from fem.laws.materials import energy_density, green_strain, stress
from fem.model.plate_model import PlateModel
from fem.plate.lanczos import fixed_vector, largest_eigenpair
from fem.start.inertia_relief import to_global
from machine_code.compiled import compact, compiled, inlined, reordered
from machine_code.object_code import Prepared

TOLERANCE, BASIS = 1e-3, 8
"""Residual over the eigenvalue at which Lanczos ends, and size of its basis.

The frequency is then within 1e-5, the error of the differences.
"""

RELATIVE_DISPLACEMENT = 1e-5
"""Displacement of the finite difference over the element's size.

The relative error of the stiffness is about as large.
"""

TINY = 1e-300
"""Least displacement of an unknown vector [m]."""


def deformed_frequency(model: PlateModel, shapes: Iterable[np.ndarray]) -> float:
    """Return the highest circular frequency about some deformed states.

    Lanczos is applied to differences of the internal forces, with the springs of the wall.

    Parameters
    ----------
    model : PlateModel
        The plate.
    shapes : iterable of ndarray, shape (2, nodes)
        Positions of the nodes in the wall's frame [m]. Those that are not finite are ignored.

    Returns
    -------
    float
        Frequency [rad/s]; infinite where forces are not finite, and without any finite positions.
    """
    finite = [positions for positions in shapes if np.isfinite(positions).all()]
    parameters, workspace = model.parameters, np.empty((4, 2, model.parameters.mass.size))
    size = RELATIVE_DISPLACEMENT * math.sqrt(float(model.discretisation.scalar.dx.sum(axis=1).min()))
    plate = parameters.hourglass, parameters.table, parameters.material
    scratch = scratch_for(parameters.table, parameters.hourglass)
    root = 1.0 / np.sqrt(parameters.mass)
    operator = Prepared((workspace, root, size, _corner_spring(parameters), *plate, scratch))

    def extend(rows: np.ndarray, projected: np.ndarray, begin: int) -> tuple[int, float]:
        filled: tuple[int, float] = extend_by_differences(rows, projected, begin, operator)
        return filled

    def frequency(positions: np.ndarray) -> float:
        workspace[0] = positions
        try:
            largest, _ = largest_eigenpair(extend, _first_vector(model, positions), TOLERANCE, BASIS)
        except FloatingPointError:  # forces become infinite
            return math.inf
        return math.sqrt(max(largest, 0.0))

    return max(map(frequency, finite), default=math.inf)


@compiled
def extend_by_differences(rows, projected, begin, operator):
    """Extend a basis by differences of the internal forces, see `Extend`.

    operator: positions [m] and workspace, shape (4, 2, nodes); inverse roots of the masses, shape (nodes,);
    displacement of the differences [m]; the corner's spring; hourglass control, element table and material with their
    scratch.
    """
    workspace, root, size, spring, hourglass, table, material, scratch = operator
    positions, before, displaced, force = workspace[0], workspace[1], workspace[2], workspace[3]
    nodes, length = root.size, 0.0
    if begin == 0:
        before[:] = 0.0
        subtract_internal_forces(positions, positions, None, hourglass, before, table, material, scratch)
    for row in range(begin, projected.shape[0]):
        largest = 0.0
        for unknown in range(2 * nodes):
            largest = max(largest, abs(root[unknown % nodes] * rows[row, unknown]))
        scale = size / max(largest, TINY)
        for axis in range(2):
            for node in range(nodes):
                displacement = scale * root[node] * rows[row, axis * nodes + node]
                displaced[axis, node] = positions[axis, node] + displacement
        force[:] = 0.0
        subtract_internal_forces(displaced, displaced, None, hourglass, force, table, material, scratch)
        for axis in range(2):
            for node in range(nodes):
                difference = (before[axis, node] - force[axis, node]) / scale
                rows[row + 1, axis * nodes + node] = root[node] * difference
        _add_spring(spring, root, rows, row)
        length = _orthogonalise(rows, projected, row)
        if not length > 0.0:
            return row + 1, length
    return projected.shape[0], length


@compiled
def _orthogonalise(rows, projected, row):
    """Make row `row` + 1 a unit vector orthogonal to all before.

    The overlaps are those of `projected`. Returns the length of the orthogonal part, 0 where it is rounding.
    """
    last, size = row + 1, _overlap(rows, row + 1, row + 1)
    for _ in range(2):  # as `extend_by`
        for earlier in range(last):
            overlap = _overlap(rows, earlier, last)
            for unknown in range(rows.shape[1]):
                rows[last, unknown] -= overlap * rows[earlier, unknown]
            projected[row, earlier] += overlap
            projected[earlier, row] = projected[row, earlier]
    length = _overlap(rows, last, last)
    if length <= 1e-28 * size:
        return 0.0
    length = math.sqrt(length)
    for unknown in range(rows.shape[1]):
        rows[last, unknown] /= length
    return length


@reordered
def _overlap(rows, first, second):
    overlap = 0.0
    for unknown in range(rows.shape[1]):
        overlap += rows[first, unknown] * rows[second, unknown]
    return overlap


@compact
def _add_spring(spring, root, rows, row):
    if spring is not None:
        corner, weights, stiffness = spring
        across = 0.0
        for k in range(corner.size):
            across += weights[k] * root[corner[k]] * rows[row, root.size + corner[k]]
        for k in range(corner.size):
            rows[row + 1, root.size + corner[k]] += root[corner[k]] * weights[k] * stiffness * across


def _first_vector(model: PlateModel, positions: np.ndarray) -> np.ndarray:
    """Return the vector with which the search begins.

    It is the mode of the highest frequency of the plate at rest, rotated with the plate, with a small part of all
    other modes.
    """
    some = fixed_vector(positions.size)
    if model.highest_mode is None:
        return some
    fraction, body = model.parameters.mass / model.mass, model.discretisation.positions
    x, y = positions - (positions @ fraction)[:, None]
    r_x, r_y = (body - (body @ fraction)[:, None]) * fraction
    angle = math.atan2((r_y * x - r_x * y).sum(), (r_x * x + r_y * y).sum())
    return np.asarray((to_global(angle) @ model.highest_mode).ravel() + 1e-3 * some)


def _corner_spring(parameters: object) -> tuple[np.ndarray, np.ndarray, float] | None:
    """Return nodes, weights and stiffness [N/m] of the corner's spring.

    Unilateral contact does not bound the time step, and has None.
    """
    if not isinstance(parameters, LoopParameters):
        return None
    return parameters.corner.nodes, parameters.corner.weights, float(parameters.corner.spring)


def element_stress(model: PlateModel, positions: np.ndarray) -> np.ndarray:
    """Return elastic stress and strain energy density as means over elements.

    Parameters
    ----------
    model : PlateModel
        The plate.
    positions : ndarray, shape (2, nodes)
        Positions of the nodes in the wall's frame [m].

    Returns
    -------
    ndarray, shape (4, elements)
        Kirchhoff stress F S F' in the wall's frame, xx, yy, xy [Pa]: Cauchy's times the change of volume, which at
        small strain is one. Strain energy over reference volume [J/m^3]. Without viscous stress and hourglass
        control.
    """
    table = model.parameters.table
    means = np.zeros((4, table.connectivity.shape[1]))
    recover(np.ascontiguousarray(positions), table, model.parameters.material, means)
    return means


@compiled
def recover(positions, table, material, means):
    """Fill the means of stress and energy density over each element.

    They are weighted by the volume of the quadrature points.
    """
    congruent = table.weights.shape[1] == 1
    for element in range(table.connectivity.shape[1]):
        column, volume = 0 if congruent else element, 0.0
        for point in range(table.weights.shape[0]):
            f_11, f_12, f_21, f_22 = deformation_gradient(positions, table, point, element)
            e_11, e_22, g_12 = green_strain(f_11, f_12, f_21, f_22)
            s_11, s_22, s_12 = stress(material, e_11, e_22, g_12)
            weight = table.weights[point, column]
            volume += weight
            t_11, t_12 = f_11 * s_11 + f_12 * s_12, f_11 * s_12 + f_12 * s_22
            t_21, t_22 = f_21 * s_11 + f_22 * s_12, f_21 * s_12 + f_22 * s_22
            means[0, element] += weight * (t_11 * f_11 + t_12 * f_12)
            means[1, element] += weight * (t_21 * f_21 + t_22 * f_22)
            means[2, element] += weight * (t_11 * f_21 + t_12 * f_22)
            means[3, element] += weight * energy_density(material, e_11, e_22, g_12)
        for k in range(4):
            means[k, element] /= volume


@inlined
def deformation_gradient(positions, table, point, element):
    """Return the deformation gradient at a quadrature point.

    F (11, 12, 21, 22), the identity for an element at rest.
    """
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
