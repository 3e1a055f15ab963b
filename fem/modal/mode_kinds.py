"""Kinds of the plate's modes by fractions of their energies.

symmetric about the long middle line (along it u_x even, u_y odd), by more than half of its kinetic energy:
    longitudinal    more than half of the kinetic energy is along the length
    transverse      else: the plate grows wider and narrower
else antisymmetric, as a beam bends:
    shear           more than half of the strain energy is that of shear strain
    bending         else
"""

import numpy as np

from fem.model.plate_model import PlateModel
from fem.plate.discretisation import stiffness_matrix
from fem.plate.free_modes import FreeModes


def mode_kinds(model: PlateModel, modes: FreeModes) -> tuple[tuple[str, ...], dict[str, np.ndarray]]:
    """Return the kinds of a model's modes.

    Also returns the fractions that define the kinds, shape (modes,): kinetic energy of the symmetric part and along the
    length, strain energy of shear.
    """
    masses, shapes, hinges = model.parameters.mass, modes.shapes, getattr(model.parameters, "hinges", None)
    unit = np.zeros(masses.size) if hinges is None else hinges.unit
    mirrored = shapes[:, :, _mirror_nodes(model.discretisation.positions, unit)]
    symmetric = 0.5 * (1.0 + (shapes[:, 0] * mirrored[:, 0] - shapes[:, 1] * mirrored[:, 1]) @ masses)
    along = shapes[:, 0] ** 2 @ masses
    moduli = model.tangent_moduli._replace(c_11=0.0, c_12=0.0)  # shear alone
    stiffness = stiffness_matrix(model.discretisation.table, moduli)
    flat = shapes.reshape(len(shapes), -1)
    shear = ((stiffness @ flat.T).T * flat).sum(axis=1) / modes.frequencies**2
    fractions = {"symmetric": symmetric, "along": along, "shear": shear}
    return tuple(map(_name, *fractions.values())), fractions


def _name(symmetric: float, along: float, shear: float) -> str:
    """Return the kind of mode for these fractions."""
    if symmetric > 0.5:
        return "longitudinal" if along > 0.5 else "transverse"
    return "shear" if shear > 0.5 else "bending"


def _mirror_nodes(positions: np.ndarray, unit: np.ndarray) -> np.ndarray:
    """Return the node nearest to each node's mirror image, shape (nodes,).

    The image is that in the long middle line, and the node belongs to the same unit.
    """
    from scipy.spatial import cKDTree

    x, y = positions
    offset = unit * np.ptp(positions)  # plates overlap
    images = np.array([x, y.min() + y.max() - y, offset])
    return np.asarray(cKDTree(np.array([x, y, offset]).T).query(images.T)[1])
