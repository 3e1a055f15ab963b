"""Weights of nodes in a force that is distributed over a patch."""

import numpy as np

from fem.plate.discretisation import Discretisation
from fem.plate.properties import ModelError


def corner_weights(discretisation: Discretisation, length: float) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes and weights of the support of corner P.

    length [m]: of side PE, 0 for the node alone. The weights are the nodes' parts of w(s) = (4 - 6 s / a) / a over 0
    <= s <= a. Its integral is 1 and its first moment about P is 0, so that for every rigid motion the weighted mean
    is P itself. Raises ModelError if the length is not between two nodes and the side.
    """
    if length == 0.0:
        return np.array([discretisation.corner]), np.array([1.0])
    side = discretisation.side[np.argsort(-discretisation.positions[0, discretisation.side])]
    return patch_weights(side, -discretisation.positions[0, side], length)


def patch_weights(side: np.ndarray, s: np.ndarray, length: float) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes and weights of a patch of this length [m].

    side: nodes of a side from its corner on. s: their distances from the corner [m]. Raises ModelError if the length
    is not between two nodes and the side.
    """
    if not s[1] * (1.0 - 1e-9) <= length <= s[-1] * (1.0 + 1e-9):
        raise ModelError(
            "patch_length",
            f"a corner patch of {length:g} m does not lie between {s[1]:g} m, an element, and {s[-1]:g} m",
        )
    weights = hat_integrals(s, 0.0, length)
    used = np.abs(weights) > 0.0
    return side[used].astype(np.int64), weights[used]


def hat_integrals(s: np.ndarray, place: float, length: float) -> np.ndarray:
    """Return the nodes' parts in a load on a line.

    s: of the nodes [m]. The load extends over a length [m] about the place, as far as the line extends. Its density
    is the linear w with an integral of 1 and its first moment at the place. A part is the integral of w times the
    node's hat function, for which two Gauss points are exact.
    """
    begin = max(s[0], min(place - 0.5 * length, s[-1] - length))
    s, offset = s - begin, (place - begin) / length
    parts = np.zeros_like(s)
    for i in range(s.size - 1):
        start, end = max(s[i], 0.0), min(s[i + 1], length)
        if end <= start:
            continue
        half = 0.5 * (end - start)
        for point in (-1.0, 1.0):
            position = 0.5 * (start + end) + point * half / np.sqrt(3.0)
            load = half * (4.0 - 6.0 * offset - (6.0 - 12.0 * offset) * position / length) / length
            hat = (position - s[i]) / (s[i + 1] - s[i])
            parts[i] += load * (1.0 - hat)
            parts[i + 1] += load * hat
    return parts
