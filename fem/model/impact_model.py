"""The model of a whole impact: the plate, its boundary in unilateral contact with the wall, and the modes of a
deformable wall, from its mesh and properties.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from fem.explicit.impact_loop import ImpactLoopParameters
from fem.laws import materials, unilateral
from fem.laws.wall_contact import BoundaryContact, ElasticWall
from fem.model import plate_model
from fem.model.plate_model import PlateModel
from fem.plate import spectrum
from fem.plate.discretisation import Discretisation, stiffness_matrix
from fem.plate.nodal_masses import row_sum_masses
from fem.plate.properties import (
    ContactProperties,
    ModelError,
    PlateProperties,
    StepProperties,
    UnitProperties,
    WallProperties,
)


def build_impact_model(
    units: Sequence[UnitProperties], step: StepProperties, wall: WallProperties | None = None
) -> PlateModel:
    """Assemble the model of a vehicle, or of a train, a plate a unit; the plates do not touch one another.

    Parameters
    ----------
    units : sequence of UnitProperties
        From the first; one for a single vehicle.
    step : StepProperties
        Time step and damping; elastic velocities of a train cannot be damped.
    wall : WallProperties or None
        A deformable one; None for a rigid one.

    Returns
    -------
    PlateModel
        Its `loop` is an `ImpactLoopParameters`, of a train with hinges.

    Raises
    ------
    ModelError
        Where a mesh cannot carry the inertia, or has too few nodes for the patch of a corner; where a hinge cannot be
        spread as asked for; where the wall has no foundation or too many elements.
    """
    first, hinges = units[0], None
    if len(units) > 1:
        from fem.model.train_model import train_plate

        unit, parts, hinges = train_plate(units)
    else:
        unit = plate_model.unit_plate(first.mesh, first.plate)
        parts = [(unit.discretisation, np.arange(unit.masses.size))]
    touching = [(*part, own.contact) for part, own in zip(parts, units, strict=True)]
    contact = wall_contact(touching, unit.masses, first.plate)
    densest = replace(first.plate, density=max(own.plate.density for own in units))
    model = plate_model.unfinished_model(
        unit, densest, ImpactLoopParameters, contact=contact, wall=None, hinges=hinges
    )
    # Contact does not bound the step: fem.laws.unilateral. Nor do hinges: fem.laws.hinges.
    model = plate_model.with_time_step(model, spectrum.FREE, densest, step)
    return model if wall is None else with_wall(model, wall, step)


def wall_contact(
    parts: Sequence[tuple[Discretisation, np.ndarray, ContactProperties]],
    masses: np.ndarray,
    plate: PlateProperties,
) -> BoundaryContact:
    """Contact points with their law, plate by plate. A corner that crushes and has a layer is there twice.

    parts: of each plate its discretisation, its nodes in the model, and its contact; masses: of all nodes [kg].
    Raises ModelError where the patch of a corner does not lie on its side.
    """
    points, laws, contact = list[Any](), list[list[np.ndarray]](), parts[0][2]
    for discretisation, every, own in parts:
        boundary, lengths = boundary_of(discretisation)
        found: list[Any] = [(np.array([node]), np.ones(1)) for node in boundary]
        if own.law == "crush":
            found, *crush = _crushing(discretisation.positions, boundary, lengths, own)
            laws.append(crush)
        points += [(every[nodes], weights) for nodes, weights in found]
    count = len(points)
    if contact.law == "exact":
        law: Any = unilateral.ExactContact(count)
    elif contact.law == "penalty":
        stiffness = unilateral.penalty_stiffness(plate.youngs_modulus, plate.thickness, contact.penalty_scale)
        law = unilateral.PenaltyContact(np.full(count, stiffness))
    elif contact.law == "crush":
        stiffnesses, initial = map(np.concatenate, zip(*laws, strict=True))
        law = unilateral.Crush(stiffnesses, initial, contact.restitution**2)
    else:
        raise ValueError(f"there is no contact law {contact.law!r}")
    nodes, weights = (np.concatenate(each) for each in zip(*points, strict=True))
    first = np.cumsum([0, *(len(point[0]) for point in points)])
    mobility = np.add.reduceat(weights**2 / masses[nodes], first[:-1])
    return BoundaryContact(first, nodes.astype(np.int64), weights, mobility, law, contact.friction)


def boundary_of(discretisation: Discretisation) -> tuple[np.ndarray, np.ndarray]:
    """Nodes of the boundary, and lengths of the sides that each stands for [m], of shape (boundary nodes,) each."""
    import skfem

    scalar = discretisation.scalar
    sides = skfem.FacetBasis(scalar.mesh, scalar.elem)
    lengths = skfem.LinearForm(lambda v, w: v).assemble(sides)
    nodes = np.unique(scalar.get_dofs().flatten())
    return nodes.astype(np.int64), lengths[nodes]


def _crushing(
    positions: np.ndarray, boundary: np.ndarray, lengths: np.ndarray, contact: ContactProperties
) -> tuple[list[Any], np.ndarray, np.ndarray]:
    """The corners, each a node or a patch of its side, and with a layer all nodes of the boundary; stiffness [N/m] and
    initial force [N] of each.

    Corners are front and rear on the side of the wall, then on the far side.
    """
    (left, low), (right, high) = positions.min(axis=1), positions.max(axis=1)
    places = ((right, low), (left, low), (right, high), (left, high))
    nodes = [int(np.linalg.norm(positions.T - place, axis=1).argmin()) for place in places]
    points = [_corner(boundary, positions, node, contact.patch_length) for node in nodes]
    stiffness, initial = np.full(4, contact.stiffness), np.full(4, contact.initial_force)
    if contact.side_stiffness > 0.0:
        points += [(np.array([node]), np.ones(1)) for node in boundary]
        stiffness = np.concatenate([stiffness, contact.side_stiffness * lengths])
        initial = np.concatenate([initial, np.zeros(len(boundary))])
    return points, stiffness, initial


def _corner(
    boundary: np.ndarray, positions: np.ndarray, node: int, length: float
) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights of a corner, over this length [m] of the long side that it ends."""
    if length == 0.0:
        return np.array([node]), np.ones(1)
    x, y = positions
    side = boundary[np.abs(y[boundary] - y[node]) < 1e-9 * np.ptp(y)]
    side = side[np.argsort(np.abs(x[side] - x[node]))]
    return plate_model.patch_weights(side, np.abs(x[side] - x[node]), length)


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
    depth = float(np.ptp(scalar.doflocs[1]))
    masses = row_sum_masses(scalar, wall.density, wall.thickness)
    frequencies, modes = _free_modes(scalar, masses, wall)
    foundation = wall.foundation_stiffness / (wall.density * wall.thickness * depth)
    frequencies = np.sqrt(frequencies**2 + foundation)
    needed = min(FOLLOWED * math.sqrt(foundation), frequencies[-1])
    stable = min(model.stable_time_step, 2.0 / needed)
    kept = frequencies <= (1.0 + 1e-9) * 2.0 / stable
    elastic = _elastic_wall(scalar, masses, modes[:, :, kept], frequencies[kept] ** 2, foundation, depth)
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
        given = f"the wall has {2 * scalar.N} unknowns; at most {MOST} are allowed"
        raise ModelError("wall.elements", given)
    return scalar


def _free_modes(scalar: Any, masses: np.ndarray, wall: WallProperties) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies [rad/s] of the wall without foundation, and mass-normalised modes, shape (2, nodes, modes)."""
    from scipy.linalg import eigh

    moduli = materials.st_venant_kirchhoff(wall.youngs_modulus, wall.poissons_ratio)
    root = 1.0 / np.sqrt(np.tile(masses, 2))
    scaled = root[:, None] * stiffness_matrix(scalar, wall.thickness, moduli).toarray() * root
    squares, vectors = eigh(scaled)
    return np.sqrt(np.maximum(squares, 0.0)), (root[:, None] * vectors).reshape(2, masses.size, -1)


def _elastic_wall(
    scalar: Any, masses: np.ndarray, modes: np.ndarray, stiffness: np.ndarray, foundation: float, depth: float
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
        reach=depth,
        face=np.ascontiguousarray(modes[:, nodes]),
        stiffness=stiffness,
        foundation=foundation,
        momentum=np.ascontiguousarray(np.einsum("n,dnk->dk", masses, modes)),
    )
