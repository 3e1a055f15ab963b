"""The wall that gives: from its mesh and properties to its modes."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from fem.constitutive.materials import st_venant_kirchhoff
from fem.contact.elastic_wall import ElasticWall
from fem.discretisation.mass import row_sum_masses
from fem.discretisation.model import PlateModel
from fem.discretisation.properties import ModelError, StepProperties, WallProperties
from fem.discretisation.stiffness import stiffness_matrix

FOLLOWED = 40.0
"""Times w_0, up to which the step follows the wall's modes whatever the plate's is: those of a beam that are above have
1e-3 of its deflection under a point force, (w_0/w)^(3/2) / 3.3; with the dent under the force it is 1e-2."""

MOST = 4000
"""Unknowns of a wall, whose modes are found all at once."""


def with_wall(model: PlateModel, wall: WallProperties, step: StepProperties) -> PlateModel:
    """The model with this wall in place of the rigid one. Its step is the plate's, unless the wall needs a shorter one,
    and the wall moves in all modes that the step is stable for.

    Raises ModelError for a wall without foundation, one with more than MOST unknowns, and uneven nodes on its face.
    """
    scalar = _basis(wall)
    masses = row_sum_masses(scalar, wall.density, wall.thickness)
    frequencies, modes = _free_modes(scalar, masses, wall)
    foundation = wall.foundation_stiffness / (wall.density * wall.thickness * _depth(scalar))
    frequencies = np.sqrt(frequencies**2 + foundation)
    needed = min(FOLLOWED * math.sqrt(foundation), frequencies[-1])
    stable = min(model.stable_time_step, 2.0 / needed)
    kept = frequencies <= (1.0 + 1e-9) * 2.0 / stable
    elastic = _elastic_wall(scalar, masses, modes[:, :, kept], frequencies[kept] ** 2, foundation)
    time_step = min(step.safety_factor * stable, step.longest)
    loop = model.loop._replace(wall=elastic, time_step=time_step)
    return replace(model, undamped_time_step=stable, stable_time_step=stable, loop=loop)


def _basis(wall: WallProperties) -> Any:
    """Nine-node elements: one across the depth bends as a beam does, where four-node ones are far too stiff."""
    import skfem
    from skfem.io.meshio import from_meshio

    if wall.foundation_stiffness <= 0.0:
        raise ModelError(
            "wall.foundation_stiffness",
            f"the foundation's stiffness is {wall.foundation_stiffness:g}; it must be above 0",
        )
    scalar = skfem.CellBasis(from_meshio(wall.mesh), skfem.ElementQuad2(), intorder=4)
    if 2 * scalar.N > MOST:
        raise ModelError("wall.elements", f"the wall has {2 * scalar.N} unknowns; it may have up to {MOST}")
    return scalar


def _depth(scalar: Any) -> float:
    return float(np.ptp(scalar.doflocs[1]))


def _free_modes(scalar: Any, masses: np.ndarray, wall: WallProperties) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies [rad/s] of the wall without foundation, and mass-normalised modes, shape (2, nodes, modes)."""
    from scipy.linalg import eigh

    moduli = st_venant_kirchhoff(wall.youngs_modulus, wall.poissons_ratio)
    root = 1.0 / np.sqrt(np.tile(masses, 2))
    scaled = root[:, None] * stiffness_matrix(scalar, wall.thickness, moduli).toarray() * root
    squares, vectors = eigh(scaled)
    return np.sqrt(np.maximum(squares, 0.0)), (root[:, None] * vectors).reshape(2, masses.size, -1)


def _elastic_wall(
    scalar: Any, masses: np.ndarray, modes: np.ndarray, stiffness: np.ndarray, foundation: float
) -> ElasticWall:
    nodes = scalar.get_dofs("wall_face").flatten()
    nodes = nodes[np.argsort(scalar.doflocs[0, nodes])]
    places = scalar.doflocs[0, nodes]
    spacing = float(places[-1] - places[0]) / (nodes.size - 1)
    if not np.allclose(np.diff(places), spacing, rtol=1e-9):
        raise ModelError("wall.elements", "the nodes on the wall's face are not evenly spaced")
    return ElasticWall(
        start=float(places[0]),
        spacing=spacing,
        reach=_depth(scalar),
        face=np.ascontiguousarray(modes[:, nodes]),
        stiffness=stiffness,
        foundation=foundation,
        momentum=np.ascontiguousarray(np.einsum("n,dnk->dk", masses, modes)),
    )
