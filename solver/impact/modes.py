"""The mode of every contact point between two events: how its crush goes, and whether it slides.

A point is free, on its virgin curve, on its unloading line, or held: with e = 0 the line is upright, and a point which
the others press on stays at its greatest crush under whatever force below that of the curve keeps it there.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from solver.elementary import Array
from solver.impact.contact import ContactPoints
from solver.impact.crush_law import line_length, virgin_force

FREE, LOADING, LINE, HELD = range(4)
Integers = NDArray[np.int64]


class Modes(NamedTuple):
    """Arrays of shape (points,).

    Attributes
    ----------
    crush : ndarray
        FREE, LOADING, LINE or HELD.
    sliding : ndarray
        Sign of the velocity along the wall; 0: the point sticks.
    max_crush : ndarray
        Greatest crush before, D [m]; on the virgin curve the present one takes its place.
    """

    crush: Integers
    sliding: Array
    max_crush: Array


class Pressed(NamedTuple):
    """The touching points, and their forces as far as the modes settle them.

    Attributes
    ----------
    points : ndarray
        Their indices.
    along, across : ndarray
        Their places on the body [m].
    offset, slope : ndarray
        The force is offset + slope d [N], [N/m].
    friction : ndarray
        T = friction N: -mu times the sign of the sliding; 0 where the point sticks.
    stuck, held : ndarray
        Positions, within `points`, of points whose tangential or normal force follows from their rest.
    """

    points: Integers
    along: Array
    across: Array
    offset: Array
    slope: Array
    friction: Array
    stuck: Integers
    held: Integers


def touch_crush(points: ContactPoints, max_crush: Array) -> Array:
    """Crush at which a free point is pressed again, shape (points,) [m]."""
    return np.where(max_crush > 0.0, np.maximum(max_crush - line_length(points, max_crush), 0.0), 0.0)


def pressed_points(points: ContactPoints, modes: Modes, mu: float) -> Pressed:
    """The points that touch in these modes."""
    index = np.flatnonzero(modes.crush != FREE)
    offset, slope = _force_line(points, modes)
    crush, sliding = modes.crush[index], modes.sliding[index]
    stuck = np.flatnonzero(sliding == 0.0) if mu else np.zeros(0, dtype=np.int64)
    held = np.flatnonzero(crush == HELD)
    places = points.along[index], points.across[index]
    return Pressed(index, *places, offset[index], slope[index], -mu * sliding, stuck, held)


def _force_line(points: ContactPoints, modes: Modes) -> tuple[Array, Array]:
    """Offset and slope of each point's force over crush; both 0 where it is free or held."""
    most, on_line = modes.max_crush, modes.crush == LINE
    length = line_length(points, most)
    slope = np.divide(
        virgin_force(points, most), length, out=np.zeros_like(most), where=on_line & (length > 0.0)
    )
    offset = np.where(on_line, -slope * touch_crush(points, most), 0.0)
    loading = modes.crush == LOADING
    return np.where(loading, points.initial_force, offset), np.where(loading, points.stiffness, slope)
