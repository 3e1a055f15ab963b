"""Strips of which abutting pieces are one.

The points of a strip divide it evenly. Pieces with equal laws that abut are joined before, so that a strip and its
pieces have the same points.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from solver.conditions import Number

LAW = ("inset", "stiffness", "initial_force", "plateau", "restitution", "unloading", "hardening")
"""Values that are equal in pieces of one strip."""

LONGEST_UPRIGHT, LONGEST_ALONG = 0.06, 0.4
"""Largest lengths of a point of a strip, upright and along the vehicle [m]."""

ABUTTING = 1e-6
"""Largest gap or overlap of pieces that abut [m]."""


@dataclass(frozen=True)
class SpaceStrip:
    """Line of a body or axle that can touch the wall.

    There is one on each side.

    Parameters
    ----------
    at : tuple of two floats or ndarrays
        Places of both ends behind the front of its unit [m]; equal for an upright strip.
    height : tuple of two floats or ndarrays
        Heights of both ends at rest [m].
    inset : float or ndarray
        Distance inwards from the side of the unit [m].
    stiffness, plateau : float or ndarray
        Stiffness and plateau of the crush law per metre of length [N/m^2], [N/m].
    initial_force : float or ndarray
        Force at zero crush per metre of length [N/m].
    restitution : float or ndarray
        Unloading returns its square of the energy [-].
    unloading : float or ndarray
        Slope of unloading per metre in place of the restitution [N/m^2], or 0.
    hardening : float or ndarray
        Slope of the crush force beyond the plateau's onset per metre [N/m^2].
    axle : int
        Number of the axle to which it belongs, or -1 for the body.
    unit : int
        Number of its unit, from 0.
    """

    at: tuple[Number, Number]
    height: tuple[Number, Number]
    stiffness: Number
    inset: Number = 0.0
    plateau: Number = math.inf
    restitution: Number = 0.0
    unloading: Number = 0.0
    axle: int = -1
    unit: int = 0
    initial_force: Number = 0.0
    hardening: Number = 0.0


def joined(strips: Sequence[SpaceStrip]) -> tuple[SpaceStrip, ...]:
    """Join abutting pieces with equal laws.

    A strip is in the place of its first piece.
    """
    result: list[SpaceStrip] = []
    for strip in strips:
        place = len(result)
        while pairs := [k for k, near in enumerate(result) if _abut(near, strip) or _abut(strip, near)]:
            place = pairs[0]
            near = result.pop(place)
            low, high = (near, strip) if _abut(near, strip) else (strip, near)
            strip = replace(low, at=(low.at[0], high.at[1]), height=(low.height[0], high.height[1]))
        result.insert(place, strip)
    return tuple(result)


def points_of(strip: SpaceStrip) -> int:
    """Return the number of points of a strip, of the first sample."""
    (x0, x1), (z0, z1) = ([float(np.ravel(value)[0]) for value in ends] for ends in (strip.at, strip.height))
    along = abs(x1 - x0) > abs(z1 - z0)
    return max(
        1, math.ceil(math.hypot(x1 - x0, z1 - z0) / (LONGEST_ALONG if along else LONGEST_UPRIGHT) - 1e-9)
    )


def _abut(low: SpaceStrip, high: SpaceStrip) -> bool:
    """Return True if one piece ends where the other begins.

    Both are upright at one place, or along the vehicle at one height.
    """
    if (low.axle, low.unit) != (high.axle, high.unit) or not all(_equal(low, high, name) for name in LAW):
        return False
    upright = all(np.all(np.equal(low.at[0], place)) for place in (low.at[1], *high.at))
    along = all(np.all(np.equal(low.height[0], level)) for level in (low.height[1], *high.height))
    gaps = (np.subtract(high.at[0], low.at[1]), np.subtract(high.height[0], low.height[1]))
    return bool((upright or along) and all(np.all(np.abs(gap) <= ABUTTING) for gap in gaps))


def _equal(one: SpaceStrip, other: SpaceStrip, name: str) -> bool:
    """Return True if both strips have the same value in all samples."""
    return bool(np.all(np.equal(getattr(one, name), getattr(other, name))))
