"""Where the vehicle can touch the wall: its four corners, and points along its sides where they carry a layer."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from solver.elementary import Array
from solver.errors import Gate
from solver.impact import rules
from solver.impact.crush_law import CrushLaw
from solver.impact.vehicle import ImpactVehicle

CORNERS = ("front", "rear", "front far side", "rear far side")
SIDE_POINTS = 64  # Gauss points of a layer along each half of a side


@dataclass(frozen=True)
class WallContact:
    """What happens where the vehicle touches the wall.

    Parameters
    ----------
    crush : CrushLaw
        Of each corner.
    friction : float
        Coulomb's coefficient mu [-].
    side : CrushLaw or None
        Of a layer along the four sides, per metre of side; None: the corners alone touch.
    side_points : int
        Gauss points along each half of a side, at which the layer is taken.

    Raises
    ------
    RigidBodyError
        Unless the friction is 0 or more and finite, and there is a point.
    """

    crush: CrushLaw
    friction: float
    side: CrushLaw | None = None
    side_points: int = SIDE_POINTS

    def __post_init__(self) -> None:
        friction = rules.one("friction", self.friction)
        Gate().demand(rules.FRICTION, 0.0 <= friction < math.inf, friction)
        Gate().demand(rules.POINTS, self.side_points >= 1, self.side_points)


class ContactPoints(NamedTuple):
    """The points that can touch the wall, the four corners first; arrays of shape (points,).

    Attributes
    ----------
    along, across : ndarray
        From the centre of mass, along the heading and to its left [m], shape (points,).
    station : ndarray
        Distance behind the front [m], shape (points,).
    corner : ndarray
        Index into `CORNERS` of the nearest corner of its side, shape (points,).
    stiffness, initial_force : ndarray
        Of the point's own law [N/m], [N], shape (points,).
    restitution : ndarray
        [-], shape (points,).
    """

    along: Array
    across: Array
    station: Array
    corner: NDArray[np.int64]
    stiffness: Array
    initial_force: Array
    restitution: Array


def contact_points(vehicle: ImpactVehicle, contact: WallContact) -> ContactPoints:
    """The points of a vehicle and its laws.

    Parameters
    ----------
    vehicle : ImpactVehicle
        Its size and centre of mass.
    contact : WallContact
        Its laws.

    Returns
    -------
    ContactPoints
        Corners, then the points of the layer.
    """
    corners = _corners(vehicle)
    parts = [(corners, np.arange(4), np.ones(4), contact.crush)]
    if contact.side is not None:
        parts += _layer(corners, contact.side, contact.side_points)
    place = np.concatenate([part[0] for part in parts])
    laws = [np.outer(part[2], (part[3].stiffness, part[3].initial_force)) for part in parts]
    e = [np.full(len(part[1]), part[3].restitution) for part in parts]
    stiffness, force = np.concatenate(laws).T
    index = np.concatenate([part[1] for part in parts])
    station = vehicle.front_distance - place[:, 0]
    return ContactPoints(place[:, 0], place[:, 1], station, index, stiffness, force, np.concatenate(e))


def _corners(vehicle: ImpactVehicle) -> Array:
    front, b = vehicle.front_distance, vehicle.width / 2.0
    rear = front - vehicle.length
    return np.array([[front, -b], [rear, -b], [front, b], [rear, b]])


def _layer(
    corners: Array, law: CrushLaw, count: int
) -> list[tuple[Array, NDArray[np.int64], Array, CrushLaw]]:
    """Gauss points along each half of the four sides, from its corner to its middle."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    share = (1.0 + nodes) / 4.0
    parts = []
    for i, j in ((0, 1), (1, 0), (2, 3), (3, 2), (0, 2), (2, 0), (1, 3), (3, 1)):
        way = corners[j] - corners[i]
        length = weights / 4.0 * math.hypot(*way)
        parts.append((corners[i] + share[:, None] * way, np.full(count, i), length, law))
    return parts
