"""Which nodes of the boundary may touch the wall, and what their contact law takes from each."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from fem.contact.support_patch import patch_weights
from fem.contact.unilateral import Crush, ExactContact, PenaltyContact, penalty_stiffness
from fem.contact.wall_contact import WallContact
from fem.discretisation.elements import Discretisation
from fem.discretisation.properties import ContactProperties, PlateProperties


@dataclass(frozen=True)
class Boundary:
    """The plate's boundary.

    Attributes
    ----------
    corners : ndarray, shape (4,)
        Nodes at the corners: front and rear on the side of the wall, front and rear on the far side.
    nodes : ndarray, shape (boundary nodes,)
        All of them.
    lengths : ndarray, shape (boundary nodes,)
        Of the sides, that each stands for [m].
    """

    corners: np.ndarray
    nodes: np.ndarray
    lengths: np.ndarray


def boundary_of(discretisation: Discretisation) -> Boundary:
    """The boundary of the plate, a rectangle along the axes of its body frame."""
    import skfem

    scalar, positions = discretisation.scalar, discretisation.positions
    sides = skfem.FacetBasis(scalar.mesh, scalar.elem)
    lengths = skfem.LinearForm(lambda v, w: v).assemble(sides)
    low, high = positions.min(axis=1), positions.max(axis=1)
    places = [(high[0], low[1]), (low[0], low[1]), (high[0], high[1]), (low[0], high[1])]
    corners = [int(np.linalg.norm(positions.T - place, axis=1).argmin()) for place in places]
    nodes = np.unique(scalar.get_dofs().flatten())
    return Boundary(np.array(corners), nodes.astype(np.int64), lengths[nodes])


def wall_contact(
    discretisation: Discretisation, masses: np.ndarray, plate: PlateProperties, contact: ContactProperties
) -> WallContact:
    """Contact points with their law. A corner that crushes and has a layer is there twice.

    Raises ModelError where the patch of a corner does not lie on its side.
    """
    boundary = boundary_of(discretisation)
    alone = [(np.array([node]), np.ones(1)) for node in boundary.nodes]
    points, count = alone, len(alone)
    if contact.law == "exact":
        law: Any = ExactContact(count)
    elif contact.law == "penalty":
        stiffness = penalty_stiffness(plate.youngs_modulus, plate.thickness, contact.penalty_scale)
        law = PenaltyContact(np.full(count, stiffness))
    elif contact.law == "crush":
        points, law = _crushing(boundary, discretisation.positions, alone, contact)
    else:
        raise ValueError(f"there is no contact law {contact.law!r}")
    nodes, weights = (np.concatenate(parts) for parts in zip(*points, strict=True))
    first = np.cumsum([0, *(len(point[0]) for point in points)])
    mobility = np.add.reduceat(weights**2 / masses[nodes], first[:-1])
    return WallContact(first, nodes.astype(np.int64), weights, mobility, law, contact.friction)


def _crushing(
    boundary: Boundary, positions: np.ndarray, alone: list[Any], contact: ContactProperties
) -> tuple[list[Any], Crush]:
    """The corners, each a node or a patch of its side, and with a layer all nodes of the boundary."""
    points = [_corner(boundary, positions, node, contact.patch_length) for node in boundary.corners]
    stiffness, initial = np.full(4, contact.stiffness), np.full(4, contact.initial_force)
    if contact.side_stiffness > 0.0:
        points = points + alone
        stiffness = np.concatenate([stiffness, contact.side_stiffness * boundary.lengths])
        initial = np.concatenate([initial, np.zeros(len(alone))])
    return points, Crush(stiffness, initial, contact.restitution**2)


def _corner(
    boundary: Boundary, positions: np.ndarray, node: int, length: float
) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights of a corner, over this length [m] of the long side that it ends."""
    if length == 0.0:
        return np.array([node]), np.ones(1)
    (x, y), nodes = positions, boundary.nodes
    side = nodes[np.abs(y[nodes] - y[node]) < 1e-9 * np.ptp(y)]
    side = side[np.argsort(np.abs(x[side] - x[node]))]
    return patch_weights(side, np.abs(x[side] - x[node]), length)
