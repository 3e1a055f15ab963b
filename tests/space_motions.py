"""Forces on vehicles in space, and balances of their motion."""

import math
from typing import Any

import numpy as np


def pushes(
    count: int,
    along: Any = 0.0,
    across: Any = 0.0,
    up: Any = 0.0,
    ahead: float = 0.0,
    height: float = math.nan,
) -> np.ndarray:
    """Return forces and their position, a row an interval.

    Forces are numbers or arrays [N]. The position is ahead of the centre of mass and above the road [m], at the height
    of the centre without one.
    """
    return np.array([np.broadcast_to(column, count) for column in (along, across, up, ahead, height)]).T


def energy_error(history: Any) -> np.ndarray:
    """Return the energy that no force accounts for [J]."""
    energy = sum(history[f"{name}_energy"] for name in ("kinetic", "gravity", "spring", "tyre"))
    works = sum(history[f"{name}_work"] for name in ("wall", "friction", "tyre", "damping"))
    return np.asarray(energy - energy[0] - works)
