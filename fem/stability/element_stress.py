"""Stress and strain energy density of the elements in deformed positions."""

import numpy as np

from fem.laws.materials import deformation_gradient, energy_density, green_strain, stress
from fem.model.plate_model import PlateModel
from machine_code.compiled import compiled


def element_stress(model: PlateModel, positions: np.ndarray) -> np.ndarray:
    """Return elastic stress and strain energy density as means over elements.

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
