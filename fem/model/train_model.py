"""Plates of a train as one model with hinges between them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from fem.laws.hinges import Hinges
from fem.model import plate_model
from fem.plate.discretisation import Discretisation, discretise, hat_integrals
from fem.plate.properties import ModelError, UnitProperties

if TYPE_CHECKING:
    import meshio


def train_plate(
    units: Sequence[UnitProperties],
) -> tuple[plate_model.UnitPlate, list[tuple[Discretisation, np.ndarray]], Hinges]:
    """Return the plates of a straight train as one of unit modulus.

    Also returns the discretisation of each plate with its nodes in the whole, and the hinges. Raises ModelError where
    a mesh cannot carry the inertia or a hinge.
    """
    first = units[0].plate
    whole = discretise(_straight(units), first.thickness, first.element)
    masses, parts, begin = np.empty(whole.positions.shape[1]), list[tuple[Discretisation, np.ndarray]](), 0
    for unit in units:
        part = discretise(unit.mesh, first.thickness, first.element)
        dofs = part.scalar.element_dofs
        nodes = np.empty(part.positions.shape[1], dtype=np.int64)
        nodes[dofs] = whole.scalar.element_dofs[:, begin : begin + dofs.shape[1]]
        masses[nodes] = plate_model.nodal_masses(part, unit.plate)
        parts.append((part, nodes))
        begin += dofs.shape[1]
    hinges = _hinges(units, parts, masses)
    return plate_model.assembled(whole, masses, first, hinges), parts, hinges


def _straight(units: Sequence[UnitProperties]) -> meshio.Mesh:
    """Return the mesh of a straight train, plate by plate.

    The middle lines coincide, and no two plates have a node in common. The groups are those of the first plate.
    """
    import meshio

    widths = [np.ptp(unit.mesh.points[:, 1]) for unit in units]
    places = np.cumsum([unit.kingpin - unit.hitch for unit in units])
    points = [
        unit.mesh.points + np.array([place, 0.5 * (widths[0] - width), 0.0])
        for unit, place, width in zip(units, places, widths, strict=True)
    ]
    begin = np.cumsum([0, *map(len, points)])
    cells = [
        (block.type, block.data + first)
        for unit, first in zip(units, begin, strict=False)
        for block in unit.mesh.cells
    ]
    empty = [np.empty(0, dtype=np.int64)] * (len(cells) - len(units[0].mesh.cells))
    groups = {name: [*blocks, *empty] for name, blocks in units[0].mesh.cell_sets.items()}
    return meshio.Mesh(np.concatenate(points), cells, cell_sets=groups)


def _hinges(
    units: Sequence[UnitProperties], parts: list[tuple[Discretisation, np.ndarray]], masses: np.ndarray
) -> Hinges:
    """Return the hinges of a train with their nodes on both plates."""
    nodes, weights = list[np.ndarray](), list[np.ndarray]()
    for number, (ahead, behind, unit) in enumerate(zip(parts, parts[1:], units[1:], strict=False)):
        try:
            for (part, places), position, sign in ((ahead, unit.hitch, 1.0), (behind, unit.kingpin, -1.0)):
                rows, weight = hinge_weights(part.positions, position, unit.hitch_length)
                nodes.append(places[rows])
                weights.append(sign * weight)
        except ValueError as error:
            raise ModelError(f"trailer.{number}.hitch_length", str(error)) from None
    gaps = np.zeros((len(units) - 1, masses.size))
    for k, (i, w) in enumerate(zip(nodes, weights, strict=True)):
        gaps[k // 2, i] = w
    numbers = np.empty(masses.size, dtype=np.int64)
    for number, (_, places) in enumerate(parts):
        numbers[places] = number
    first = np.cumsum([0, *(len(one) + len(two) for one, two in zip(nodes[::2], nodes[1::2], strict=True))])
    inertia = np.linalg.inv(gaps / masses @ gaps.T)
    return Hinges(first, np.concatenate(nodes), np.concatenate(weights), inertia, numbers)


def hinge_weights(positions: np.ndarray, place: float, length: float) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes and weights of a hinge on a plate's middle line.

    Parameters
    ----------
    positions : ndarray, shape (2, nodes)
        Positions of the nodes in the plate's body frame [m].
    place : float
        Distance of the hinge behind the front [m]; outside the plate the nearest nodes are extrapolated.
    length : float
        Length of the middle line over which it is distributed, on both sides as far as the plate extends [m]; 0
        for a point.

    Returns
    -------
    nodes, weights : ndarray
        Their weighted mean is the hinge in every rigid motion: the nodes' parts of the linear w(s) with an integral
        of 1 and its first moment at the hinge. A point on a node has that node alone.

    Raises
    ------
    ValueError
        For a length that is not between an element and the plate.
    """
    middle = np.abs(positions[1] - 0.5 * positions[1].max())
    row = np.flatnonzero(middle < middle.min() + 1e-9 * middle.max())  # or both rows beside it
    _, column, number = np.unique(np.round(-positions[0, row], 9), return_inverse=True, return_counts=True)
    s = np.bincount(column, -positions[0, row]) / number
    weights = (_parts(s, place, length) / number)[column]
    used = np.abs(weights) > 1e-12
    return row[used], weights[used] / weights[used].sum()


def _parts(s: np.ndarray, place: float, length: float) -> np.ndarray:
    """Return the nodes' parts in the load of a hinge.

    s: of the nodes [m].
    """
    if length > 0.0:
        if not np.diff(s).max() <= length * (1.0 + 1e-9) <= (s[-1] - s[0]) * (1.0 + 2e-9):
            raise ValueError(
                f"a hinge over {length:g} m does not lie between {np.diff(s).max():g} m, an element, "
                f"and {s[-1] - s[0]:g} m"
            )
        return hat_integrals(s, place, length)
    parts, index = np.zeros_like(s), int(np.clip(np.searchsorted(s, place, side="right") - 1, 0, s.size - 2))
    ahead = (place - s[index]) / (s[index + 1] - s[index])
    parts[index : index + 2] = 1.0 - ahead, ahead
    return parts
