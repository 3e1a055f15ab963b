"""The plate as it is deformed at an instant of the run: its highest frequency, and for pictures and export stress and
strain energy of the elements, from the positions of the nodes.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from fem.explicit.internal_force import scratch_for, subtract_internal_forces
from fem.explicit.time_loop import LoopParameters
from fem.laws.materials import deformation_gradient, energy_density, green_strain, stress
from fem.machine_code.compiled import compiled
from fem.model.plate_model import PlateModel
from fem.plate.lanczos import largest_eigenpair
from fem.start.inertia_relief import to_global

TOLERANCE, BASIS = 1e-4, 8
"""Residual over the eigenvalue at which Lanczos ends, and vectors that it keeps."""

STEP = 1e-5
"""Displacement of the finite difference over the element's size: its error is that part of the stiffness, about."""


def deformed_frequency(model: PlateModel, positions: np.ndarray) -> float:
    """Highest circular frequency of the tangent stiffness about a deformed state.

    Lanczos on differences of the internal forces themselves, with the springs by which the wall acts on it.

    Parameters
    ----------
    model : PlateModel
        The plate.
    positions : ndarray, shape (2, nodes)
        In the wall's frame [m].

    Returns
    -------
    float
        Frequency [rad/s]; infinite where the forces are not finite.
    """
    loop = model.loop
    root, shape = 1.0 / np.sqrt(loop.mass), positions.shape
    hold = _springs(loop)
    size = STEP * math.sqrt(float(model.discretisation.scalar.dx.sum(axis=1).min()))
    place, force = positions.copy(), np.zeros(shape)
    parts = (loop.hourglass, force, loop.table, loop.material, scratch_for(loop.table, loop.hourglass))
    subtract = subtract_internal_forces.bound(place, np.zeros(shape), None, *parts)

    def forces() -> np.ndarray:
        force[:] = 0.0
        subtract()
        return force

    before = forces().copy()

    def product(vector: np.ndarray) -> np.ndarray:
        move = root * vector.reshape(shape)
        scale = size / max(np.abs(move).max(), np.finfo(float).tiny)
        np.add(positions, scale * move, out=place)
        difference = (before - forces()) / scale
        hold(move, difference)
        return np.asarray((root * difference).ravel())

    start = _first_vector(model, positions)
    if not np.isfinite(product(start)).all():
        return math.inf
    try:
        largest, _ = largest_eigenpair(product, start, TOLERANCE, BASIS)
    except FloatingPointError:  # forces that leave the finite on the way
        return math.inf
    return math.sqrt(max(largest, 0.0))


def _first_vector(model: PlateModel, positions: np.ndarray) -> np.ndarray:
    """The mode of the highest frequency of the plate at rest, turned as the plate is, and a little of all others."""
    some = np.cos(1.7 * np.arange(positions.size)) + 0.1  # fixed, so that runs repeat to the bit
    if model.highest_mode is None:
        return some
    fraction, body = model.loop.mass / model.mass, model.discretisation.positions
    x, y = positions - (positions @ fraction)[:, None]
    r_x, r_y = (body - (body @ fraction)[:, None]) * fraction
    angle = math.atan2((r_y * x - r_x * y).sum(), (r_x * x + r_y * y).sum())
    return np.asarray((to_global(angle) @ model.highest_mode).ravel() + 1e-3 * some)


def _springs(loop: Any) -> Callable[[np.ndarray, np.ndarray], None]:
    """Adds to forces [N], shape (2, nodes), those of the corner's spring that belong to a displacement [m]; unilateral
    contact does not bound the time step."""
    if not isinstance(loop, LoopParameters):
        return lambda move, forces: None
    nodes, weights, spring = loop.corner.nodes, loop.corner.weights, loop.corner.spring

    def hold(move: np.ndarray, forces: np.ndarray) -> None:
        forces[1, nodes] += spring * (move[1, nodes] @ weights) * weights

    return hold


def element_stress(model: Any, positions: np.ndarray) -> np.ndarray:
    """Elastic stress and strain energy density, means over each element.

    Parameters
    ----------
    model : PlateModel
        The plate.
    positions : ndarray, shape (2, nodes)
        In the wall's frame [m].

    Returns
    -------
    ndarray, shape (4, elements)
        Kirchhoff stress F S F' in the wall's frame, xx, yy, xy [Pa]: Cauchy's times the change of volume, which at
        small strain is one. Strain energy over reference volume [J/m^3]. Without viscous stress and hourglass control.
    """
    table = model.loop.table
    found = np.zeros((4, table.connectivity.shape[1]))
    recover(np.ascontiguousarray(positions), table, model.loop.material, found)
    return found


@compiled
def recover(positions, table, material, found):
    """Add up the points of each element, weighted by volume, and divide by its volume."""
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
            found[0, element] += weight * (t_11 * f_11 + t_12 * f_12)
            found[1, element] += weight * (t_21 * f_21 + t_22 * f_22)
            found[2, element] += weight * (t_11 * f_21 + t_12 * f_22)
            found[3, element] += weight * energy_density(material, e_11, e_22, g_12)
        for k in range(4):
            found[k, element] /= volume
