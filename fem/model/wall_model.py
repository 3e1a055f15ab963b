"""Modes of a deformable wall on its foundation."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from fem.laws import materials
from fem.laws.wall_contact import ElasticWall
from fem.model.plate_model import PlateModel
from fem.plate.discretisation import element_table, stiffness_matrix
from fem.plate.nodal_masses import row_sum_masses
from fem.plate.properties import ModelError, StepProperties, WallProperties

if TYPE_CHECKING:
    from skfem import CellBasis

RESOLVED = 40.0
"""Frequency over w_0 up to which the time step resolves the wall's modes.

Modes of a beam above it have 1e-3 of its deflection under a point force, (w_0/w)^(3/2) / 3.3, with the dent under the
force 1e-2.
"""

MAX_UNKNOWNS = 4000
"""Largest number of unknowns of a wall, whose modes are all computed at once."""


def with_wall(model: PlateModel, wall: WallProperties, step: StepProperties) -> PlateModel:
    """Return the model with this wall in place of the rigid one.

    The time step is the plate's, unless the wall requires a shorter one, and the wall has all modes for which that
    step is stable. Raises ModelError for a wall without foundation, one with more than MAX_UNKNOWNS unknowns, and
    uneven nodes on its face.
    """
    scalar = _basis(wall)
    depth = float(np.ptp(scalar.doflocs[1]))
    masses = row_sum_masses(scalar, wall.density, wall.thickness)
    frequencies, modes = _free_modes(scalar, masses, wall)
    foundation = wall.foundation_stiffness / (wall.density * wall.thickness * depth)
    frequencies = np.sqrt(frequencies**2 + foundation)
    required = min(RESOLVED * math.sqrt(foundation), frequencies[-1])
    stable = min(model.stable_time_step, 2.0 / required)
    retained = frequencies <= (1.0 + 1e-9) * 2.0 / stable
    elastic = _elastic_wall(
        scalar, masses, modes[:, :, retained], frequencies[retained] ** 2, foundation, depth
    )
    time_step = min(step.safety_factor * stable, step.longest)
    parameters = model.parameters._replace(wall=elastic, time_step=time_step)
    return replace(model, undamped_time_step=stable, stable_time_step=stable, parameters=parameters)


def _basis(wall: WallProperties) -> CellBasis:
    """Return the basis of nine-node elements on the wall.

    One across the depth bends as a beam does, where four-node elements are far too stiff.
    """
    import skfem
    from skfem.io.meshio import from_meshio

    if wall.foundation_stiffness <= 0.0:
        raise ModelError(
            "wall.foundation_stiffness",
            f"the foundation's stiffness is {wall.foundation_stiffness:g}; it must be above 0",
        )
    scalar = skfem.CellBasis(from_meshio(wall.mesh), skfem.ElementQuad2(), intorder=4)
    if 2 * scalar.N > MAX_UNKNOWNS:
        why = f"the wall has {2 * scalar.N} unknowns; at most {MAX_UNKNOWNS} are allowed"
        raise ModelError("wall.elements", why)
    return scalar


def _free_modes(scalar: CellBasis, masses: np.ndarray, wall: WallProperties) -> tuple[np.ndarray, np.ndarray]:
    """Return frequencies [rad/s] and modes of the wall without foundation.

    The modes are mass-normalised, shape (2, nodes, modes).
    """
    from scipy.linalg import eigh

    moduli = materials.st_venant_kirchhoff(wall.youngs_modulus, wall.poissons_ratio)
    root = 1.0 / np.sqrt(np.tile(masses, 2))
    scaled = root[:, None] * stiffness_matrix(element_table(scalar, wall.thickness), moduli).toarray() * root
    squares, vectors = eigh(scaled)
    return np.sqrt(np.maximum(squares, 0.0)), (root[:, None] * vectors).reshape(2, masses.size, -1)


def _elastic_wall(
    scalar: CellBasis,
    masses: np.ndarray,
    modes: np.ndarray,
    stiffness: np.ndarray,
    foundation: float,
    depth: float,
) -> ElasticWall:
    """Return the wall with the motion of its face in these modes."""
    nodes = scalar.get_dofs("wall_face").flatten()
    nodes = nodes[np.argsort(scalar.doflocs[0, nodes])]
    places = scalar.doflocs[0, nodes]
    spacing = float(places[-1] - places[0]) / (nodes.size - 1)
    if not np.allclose(np.diff(places), spacing, rtol=1e-9):
        raise ModelError("wall.elements", "the nodes on the wall's face are not evenly spaced")
    return ElasticWall(
        start=float(places[0]),
        spacing=spacing,
        reach=depth,
        face=np.ascontiguousarray(modes[:, nodes]),
        stiffness=stiffness,
        foundation=foundation,
        momentum=np.ascontiguousarray(np.einsum("n,dnk->dk", masses, modes)),
    )
