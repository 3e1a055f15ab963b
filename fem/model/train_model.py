"""The plates of a train as one: their masses and nodes in the mesh of them all, and the hinges between them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from fem.laws.hinges import Hinges
from fem.model import plate_model
from fem.plate.discretisation import Discretisation, discretise
from fem.plate.properties import ModelError, UnitProperties

if TYPE_CHECKING:
    import meshio


def train_plate(
    units: Sequence[UnitProperties],
) -> tuple[plate_model.UnitPlate, list[tuple[Discretisation, np.ndarray]], Hinges]:
    """The plates of a straight train as one of unit modulus; of each its discretisation and its nodes in that one; the
    hinges.

    Raises ModelError where a mesh cannot carry the inertia or a hinge.
    """
    first = units[0].plate
    whole = discretise(_straight(units), first.thickness, first.element)
    masses, parts, begin = np.empty(whole.positions.shape[1]), list[tuple[Discretisation, np.ndarray]](), 0
    for unit in units:
        own = discretise(unit.mesh, first.thickness, first.element)
        dofs = own.scalar.element_dofs
        nodes = np.empty(own.positions.shape[1], dtype=np.int64)
        nodes[dofs] = whole.scalar.element_dofs[:, begin : begin + dofs.shape[1]]
        masses[nodes] = plate_model.nodal_masses(own, unit.plate)
        parts.append((own, nodes))
        begin += dofs.shape[1]
    hinges = _hinges(units, parts, masses)
    return plate_model.assembled(whole, masses, first, hinges), parts, hinges


def _straight(units: Sequence[UnitProperties]) -> meshio.Mesh:
    """The mesh of a straight train, plate by plate, middle lines in one; no two plates share a node. Its groups are the
    first plate's."""
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
    nodes, weights = list[np.ndarray](), list[np.ndarray]()
    for number, (ahead, behind, unit) in enumerate(zip(parts, parts[1:], units[1:], strict=False)):
        try:
            for (own, places), at, sign in ((ahead, unit.hitch, 1.0), (behind, unit.kingpin, -1.0)):
                found, weight = hinge_weights(own.positions, at, unit.hitch_length)
                nodes.append(places[found])
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
    """Nodes and weights of a hinge on the middle line of a plate.

    Parameters
    ----------
    positions : ndarray, shape (2, nodes)
        In the plate's body frame [m].
    place : float
        Of the hinge, behind the front [m]; outside the plate the nodes nearest to it are extrapolated.
    length : float
        Of the middle line over which it is spread, on both sides as far as there is plate [m]; 0 for a point.

    Returns
    -------
    nodes, weights : ndarray
        Whose mean is the hinge in every rigid motion: the nodes' parts of the linear w(s) that has the integral 1 and
        its first moment at the hinge. A point on a node has that node alone.

    Raises
    ------
    ValueError
        For a length that is not between an element and the plate.
    """
    middle = np.abs(positions[1] - 0.5 * positions[1].max())
    row = np.flatnonzero(middle < middle.min() + 1e-9 * middle.max())  # or both beside it
    _, column, number = np.unique(np.round(-positions[0, row], 9), return_inverse=True, return_counts=True)
    s = np.bincount(column, -positions[0, row]) / number
    weights = (_parts(s, place, length) / number)[column]
    used = np.abs(weights) > 1e-12
    return row[used], weights[used] / weights[used].sum()


def _parts(s: np.ndarray, place: float, length: float) -> np.ndarray:
    """Parts of nodes in a line, s [m], in the load of a hinge."""
    if length > 0.0:
        if not np.diff(s).max() <= length * (1.0 + 1e-9) <= (s[-1] - s[0]) * (1.0 + 2e-9):
            raise ValueError(
                f"a hinge over {length:g} m does not lie between {np.diff(s).max():g} m, an element, "
                f"and {s[-1] - s[0]:g} m"
            )
        return plate_model.hat_integrals(s, place, length)
    parts, before = np.zeros_like(s), int(np.clip(np.searchsorted(s, place, side="right") - 1, 0, s.size - 2))
    ahead = (place - s[before]) / (s[before + 1] - s[before])
    parts[before : before + 2] = 1.0 - ahead, ahead
    return parts
