"""Compiled faces of a wall with a profile."""

import numpy as np

from machine_code.compiled import reordered


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
