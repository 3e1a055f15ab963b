"""The model of a whole impact: the plate, its boundary in unilateral contact with the wall, and the modes of a
deformable wall, from its mesh and properties.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from fem.explicit.impact_loop import ImpactLoop
from fem.laws.elastic_wall import ElasticWall
from fem.laws.materials import MATERIALS, st_venant_kirchhoff
from fem.model.contact_points import wall_contact
from fem.model.plate_model import (
    PlateModel,
    carried_span,
    hourglass_of,
    unfinished_model,
    unit_plate,
    with_time_step,
)
from fem.plate.elements import stiffness_matrix
from fem.plate.kinds import (
    ContactProperties,
    ModelError,
    PlateProperties,
    StepProperties,
    WallProperties,
    row_sum_masses,
)
from fem.plate.spectrum import FREE

if TYPE_CHECKING:
    import meshio


def build_impact_model(
    mesh: meshio.Mesh,
    plate: PlateProperties,
    contact: ContactProperties,
    step: StepProperties,
    wall: WallProperties | None = None,
) -> PlateModel:
    """Assemble the model on a plate mesh in its body frame.

    Parameters
    ----------
    mesh : meshio.Mesh
        With the groups "corner_p" and "side_pe".
    plate : PlateProperties
        What the plate is made of.
    contact : ContactProperties
        How its boundary touches the wall.
    step : StepProperties
        Time step and damping.
    wall : WallProperties or None
        One that gives; None for a rigid one.

    Returns
    -------
    PlateModel
        Its `loop` is an `ImpactLoop`.

    Raises
    ------
    ModelError
        Where the mesh cannot carry the inertia, or has too few nodes for the patch of a corner; where the wall has no
        foundation or too many elements.
    """
    unit, moduli = unit_plate(mesh, plate), st_venant_kirchhoff(plate.youngs_modulus, plate.poissons_ratio)
    loop = ImpactLoop(
        table=unit.discretisation.table,
        material=MATERIALS[plate.material].make(plate.youngs_modulus, plate.poissons_ratio),
        mass=unit.masses,
        contact=wall_contact(unit.discretisation, unit.masses, plate, contact),
        viscosity=None,
        hourglass=hourglass_of(unit, plate),
        elastic_damping=None,
        time_step=math.nan,
        span=carried_span(unit.discretisation),
        wall=None,
    )
    model = unfinished_model(unit, plate, moduli, loop)
    # Contact does not bound the step: fem.laws.unilateral.
    model = with_time_step(model, FREE, plate, step)
    if wall is None:
        return model
    return with_wall(model, wall, step)


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
