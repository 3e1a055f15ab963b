"""What kind a mode of the plate is, by a criterion that needs no eye.

symmetric about the long middle line (along it u_x even, u_y odd), by more than half of its kinetic energy:
    longitudinal    more than half of the kinetic energy is along the length
    transverse      else: the plate grows wider and narrower
else antisymmetric, as a beam bends:
    shear           more than half of the strain energy is that of shear strain
    bending         else
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fem.discretisation.model import PlateModel
from fem.discretisation.stiffness import stiffness_matrix
from fem.modal.modes import FreeModes


@dataclass(frozen=True)
class ModeKinds:
    """Names of the kinds, and the shares they follow from, shape (modes,): kinetic energy of the symmetric part and
    along the length, strain energy of shear."""

    names: tuple[str, ...]
    symmetric: np.ndarray
    along: np.ndarray
    shear: np.ndarray


class _ShearAlone(NamedTuple):
    c_11: float
    c_12: float
    c_33: float


def mode_kinds(model: PlateModel, modes: FreeModes, thickness: float) -> ModeKinds:
    """Kinds of the modes of this model; thickness [m]."""
    masses, shapes = model.loop.mass, modes.shapes
    mirrored = shapes[:, :, _mirror_nodes(model.discretisation.positions)]
    symmetric = 0.5 * (1.0 + (shapes[:, 0] * mirrored[:, 0] - shapes[:, 1] * mirrored[:, 1]) @ masses)
    along = shapes[:, 0] ** 2 @ masses
    moduli = _ShearAlone(0.0, 0.0, model.tangent_moduli.c_33)
    stiffness = stiffness_matrix(model.discretisation.scalar, thickness, moduli)
    flat = shapes.reshape(len(shapes), -1)
    shear = ((stiffness @ flat.T).T * flat).sum(axis=1) / modes.frequencies**2
    shares = zip(symmetric, along, shear, strict=True)
    return ModeKinds(tuple(_name(*share) for share in shares), symmetric, along, shear)


def _name(symmetric: float, along: float, shear: float) -> str:
    if symmetric > 0.5:
        return "longitudinal" if along > 0.5 else "transverse"
    return "shear" if shear > 0.5 else "bending"


def _mirror_nodes(positions: np.ndarray) -> np.ndarray:
    """The node nearest to each node's mirror image in the long middle line, shape (nodes,)."""
    from scipy.spatial import cKDTree

    middle = 0.5 * (positions[1].min() + positions[1].max())
    images = np.array([positions[0], 2.0 * middle - positions[1]])
    return np.asarray(cKDTree(positions.T).query(images.T)[1])
