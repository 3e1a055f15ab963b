"""Highest frequency and stress of the plate in deformed positions.

The frequency needs no stiffness matrix.
"""

import math
from collections.abc import Callable

import numpy as np

from fem.explicit.internal_force import elastic_forces
from fem.explicit.time_loop import LoopParameters
from fem.laws.materials import deformation_gradient, energy_density, green_strain, stress
from fem.model.plate_model import PlateModel
from fem.plate.lanczos import fixed_vector, largest_eigenpair
from fem.start.inertia_relief import to_global
from machine_code.compiled import compiled

TOLERANCE, BASIS = 1e-4, 8
"""Residual over the eigenvalue at which Lanczos ends, and size of its basis."""

RELATIVE_DISPLACEMENT = 1e-5
"""Displacement of the finite difference over the element's size.

The relative error of the stiffness is about as large.
"""


def deformed_frequency(model: PlateModel, positions: np.ndarray) -> float:
    """Return the highest circular frequency about a deformed state.

    Lanczos is applied to differences of the internal forces, with the springs of the wall.

    Parameters
    ----------
    model : PlateModel
        The plate.
    positions : ndarray, shape (2, nodes)
        Positions of the nodes in the wall's frame [m].

    Returns
    -------
    float
        Frequency [rad/s]; infinite where the forces are not finite.
    """
    parameters = model.parameters
    root, shape = 1.0 / np.sqrt(parameters.mass), positions.shape
    add_springs, forces = _springs(parameters), elastic_forces(parameters)
    size = RELATIVE_DISPLACEMENT * math.sqrt(float(model.discretisation.scalar.dx.sum(axis=1).min()))
    before = forces(positions)

    def product(vector: np.ndarray) -> np.ndarray:
        displacement = root * vector.reshape(shape)
        scale = size / max(np.abs(displacement).max(), np.finfo(float).tiny)
        difference = (forces(positions + scale * displacement) - before) / scale
        add_springs(displacement, difference)
        return np.asarray((root * difference).ravel())

    start = _first_vector(model, positions)
    if not np.isfinite(product(start)).all():
        return math.inf
    try:
        largest, _ = largest_eigenpair(product, start, TOLERANCE, BASIS)
    except FloatingPointError:  # forces become infinite
        return math.inf
    return math.sqrt(max(largest, 0.0))


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


def _springs(parameters: object) -> Callable[[np.ndarray, np.ndarray], None]:
    """Return a function that adds the forces of the corner's spring.

    It takes a displacement [m] and forces [N], shape (2, nodes) each. Unilateral contact does not bound the time
    step, and adds nothing.
    """
    if not isinstance(parameters, LoopParameters):
        return lambda displacement, forces: None
    nodes, weights, spring = parameters.corner.nodes, parameters.corner.weights, parameters.corner.spring

    def add_spring(displacement: np.ndarray, forces: np.ndarray) -> None:
        forces[1, nodes] += spring * (displacement[1, nodes] @ weights) * weights

    return add_spring


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
