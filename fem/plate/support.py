"""The corner's constraint as support of the plate."""

from __future__ import annotations

import math
from typing import NamedTuple

from fem.laws.constraints import CornerConstraint


class Support(NamedTuple):
    """Support of the corner, by default none.

    nodes: on which the constraint acts. across: weights of their x and then their y unknowns in the direction across
    the wall in the body frame, for each angle of the plate that is examined. spring [N/m]; dashpot [N s/m].
    """

    nodes: tuple[int, ...] = ()
    across: tuple[tuple[float, ...], ...] = ((),)
    spring: float = 0.0
    dashpot: float = 0.0


def corner_support(
    corner: CornerConstraint, angles: tuple[float, ...] = (0.0,), modulus: float = 1.0
) -> Support:
    """Return the support of a plate of unit modulus by this corner.

    modulus [Pa]: of the plate that the corner belongs to. angles [rad]: of the plate during its run; the constraint
    acts across the wall, and therefore rotates in the body frame.
    """
    if not corner.spring:  # the angle makes no difference
        return Support()
    weights, nodes = corner.weights.tolist(), corner.nodes.tolist()
    turned = ((-math.sin(angle), math.cos(angle)) for angle in angles)
    across = tuple(tuple(part * weight for part in direction for weight in weights) for direction in turned)
    return Support(
        tuple(nodes), across, _rounded(corner.spring / modulus), _rounded(corner.dashpot / math.sqrt(modulus))
    )


def _rounded(value: float) -> float:
    """Round to twelve digits.

    In these the quotients of proportional springs and moduli are equal.
    """
    return float(f"{value:.12g}")
