"""Profiles of walls across their length, and their compiled facets.

A profile is a line of points (y, z) from the ground upwards: y across the wall, 0 at its toe and negative behind it,
z the height. Its last part continues upwards at the same slope; the height of a wall ends it. The top of the wall is
level and extends without end behind the face.

References
----------
.. [1] Shapes of the New Jersey and the F-shape barrier, single slope of 11 deg: `shared/vehicle.md`, section 3.
"""

import math
from collections.abc import Sequence
from types import MappingProxyType

import numpy as np

from machine_code.compiled import reordered
from solver import rules
from solver.conditions import Array, Gate, RigidBodyError

INCH = 0.0254
STEEP = 1.0 / math.tan(math.radians(84.0))
"""Horizontal over vertical length of the upper face of New Jersey and F-shape."""

MOST_POINTS = 20
"""Largest number of points of a profile."""

PROFILES = MappingProxyType(
    {
        "vertical": ((0.0, 0.0), (0.0, 1.0)),
        "single-slope": ((0.0, 0.0), (-math.tan(math.radians(11.0)), 1.0)),
        "f-shape": (
            (0.0, 0.0),
            (0.0, 3 * INCH),
            (-5 * INCH, 10 * INCH),
            (-5 * INCH - STEEP, 10 * INCH + 1.0),
        ),
        "new-jersey": (
            (0.0, 0.0),
            (0.0, 3 * INCH),
            (-7 * INCH, 13 * INCH),
            (-7 * INCH - STEEP, 13 * INCH + 1.0),
        ),
    }
)
"""Points (y, z) of the named profiles [m]. Safety shapes have 3 in upright, a slope, and a steep upper face."""


def profile_points(profile: str | Sequence[Sequence[float]]) -> Array:
    """Return the points of a profile.

    Parameters
    ----------
    profile : str or sequence of pairs
        A name of `PROFILES`, or points (y, z) from [0, 0] upwards [m].

    Returns
    -------
    ndarray, shape (points, 2)
        [m].

    Raises
    ------
    RigidBodyError
        For an unknown name, and a line that overhangs or does not lead upwards from [0, 0].
    """
    if isinstance(profile, str):
        if profile not in PROFILES:
            names = ", ".join(f'"{name}"' for name in PROFILES)
            raise RigidBodyError(rules.PROFILE.key, repr(profile), "this profile does not exist", names)
        return np.array(PROFILES[profile])
    points = np.array(profile, dtype=np.float64)
    shaped = points.ndim == 2 and points.shape[1] == 2 and len(points) > 1 and bool(np.isfinite(points).all())
    if (
        not shaped
        or points[0].any()
        or (np.diff(points[:, 1]) <= 0.0).any()
        or (np.diff(points[:, 0]) > 0.0).any()
    ):
        raise RigidBodyError(rules.PROFILE.key, repr(profile), rules.PROFILE.why, rules.PROFILE.allowed)
    Gate().demand(rules.PROFILE_POINTS, len(points) <= MOST_POINTS, float(len(points)), most=MOST_POINTS)
    return points


def face_at(points: Array, height: Array | float) -> Array:
    """Return positions y of the face at heights [m], same shape."""
    (y0, z0), (y1, z1) = points[-2:]
    beyond = y1 + (np.asarray(height) - z1) * (y1 - y0) / (z1 - z0)
    within = np.interp(height, points[:, 1], points[:, 0])
    return np.where(np.asarray(height) > z1, beyond, within)


@reordered
def wall_facets(profile, height, wall):
    """Set the facets of a wall of a height.

    Returns their number.
    """
    last = profile.shape[0] - 2
    count = 0
    for k in range(last + 1):
        y0, z0, y1, z1 = profile[k, 0], profile[k, 1], profile[k + 1, 0], profile[k + 1, 1]
        if z0 >= height:
            break
        if k == last or z1 > height:
            y1, z1 = y0 + (height - z0) * (y1 - y0) / (z1 - z0), height
        size = np.hypot(y0 - y1, z1 - z0)
        wall[count, 0], wall[count, 1], wall[count, 2], wall[count, 3] = y0, z0, y1, z1
        wall[count, 4], wall[count, 5] = (z1 - z0) / size, (y0 - y1) / size
        wall[count, 6] = (y1 - y0) / (z1 - z0)
        count += 1
    return count


@reordered
def point_of_face(wall, facets, z):
    """Return the face's position y and its facet at a height.

    Above the top it is that of the upper edge.
    """
    level, k = min(z, wall[facets - 1, 3]), 0
    while level > wall[k, 3]:
        k += 1
    return wall[k, 0] + max(level - wall[k, 1], 0.0) * wall[k, 6], k


@reordered
def mean_normal(wall, facets, k, low, high):
    """Return the mean normal of the face between two heights.

    k: facet of the middle.
    """
    if high <= wall[k, 3] and (k == 0 or low >= wall[k, 1]):
        return wall[k, 4], wall[k, 5]
    ny, nz = 0.0, 0.0
    for j in range(facets):
        bottom = wall[j, 1] if j > 0 else min(low, wall[j, 1])
        part = max(min(high, wall[j, 3]) - max(low, bottom), 0.0)
        ny, nz = ny + part * wall[j, 4], nz + part * wall[j, 5]
    size = np.sqrt(ny * ny + nz * nz)
    return (ny / size, nz / size) if size > 0.0 else (1.0, 0.0)
