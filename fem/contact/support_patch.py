"""The corner as one node, or as a support patch of the side.

A point support has no finite compliance in two-dimensional elasticity: it grows with the logarithm of the mesh. Spread
over a given length of side PE, it converges.
"""

from __future__ import annotations

import numpy as np

from fem.discretisation.elements import Discretisation
from fem.discretisation.properties import ModelError


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
