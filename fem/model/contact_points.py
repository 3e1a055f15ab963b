"""Nodes at which the wall reacts: the corner as one node or as a support patch of the side, and the whole boundary.

A point support has no finite compliance in two-dimensional elasticity: it grows with the logarithm of the mesh. Spread
over a given length of side PE, it converges.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from fem.laws.unilateral import Crush, ExactContact, PenaltyContact, penalty_stiffness
from fem.laws.wall_contact import WallContact
from fem.plate.elements import Discretisation
from fem.plate.kinds import ContactProperties, ModelError, PlateProperties


def corner_weights(discretisation: Discretisation, length: float) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights by which the corner P is held; length [m] of side PE, 0 for the node alone.

    The weights are the nodes' shares of w(s) = (4 - 6 s / a) / a over 0 <= s <= a: its integral is 1 and its
    first moment about P is 0, so that for every rigid motion the weighted mean is P itself. Raises ModelError
    if the length is not between two nodes and the side.
    """
    if length == 0.0:
        return np.array([discretisation.corner]), np.array([1.0])
    side = discretisation.side[np.argsort(-discretisation.positions[0, discretisation.side])]
    return patch_weights(side, -discretisation.positions[0, side], length)


def patch_weights(side: np.ndarray, s: np.ndarray, length: float) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights of a patch of this length [m]; side: nodes of a side from its corner on, s: their distances
    from it [m]. Raises ModelError if the length is not between two nodes and the side."""
    if not s[1] * (1.0 - 1e-9) <= length <= s[-1] * (1.0 + 1e-9):
        raise ModelError(
            "patch_length",
            f"a corner patch of {length:g} m does not lie between {s[1]:g} m, an element, and {s[-1]:g} m",
        )
    weights = _shares(s, length)
    used = np.abs(weights) > 0.0
    return side[used].astype(np.int64), weights[used]


def _shares(s: np.ndarray, length: float) -> np.ndarray:
    """Integrals of w times each node's hat function; two Gauss points are exact for this cubic's pieces."""
    shares = np.zeros_like(s)
    for i in range(s.size - 1):
        end = min(s[i + 1], length)
        if end <= s[i]:
            break
        half = 0.5 * (end - s[i])
        for point in (-1.0, 1.0):
            at = 0.5 * (s[i] + end) + point * half / np.sqrt(3.0)
            load = half * (4.0 - 6.0 * at / length) / length
            hat = (at - s[i]) / (s[i + 1] - s[i])
            shares[i] += load * (1.0 - hat)
            shares[i + 1] += load * hat
    return shares


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
