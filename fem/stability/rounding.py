"""What rounding does to the reaction of a stiff plate that moves slowly: an undamped plate sums it up.

Positions are rounded at every step, each node by itself: a random displacement of half a unit in the last place of
the plate's length. It feeds energy into all modes alike, at a rate that goes with the stiffness, and the corner's
spring has its share of that energy.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fem.discretisation.model import PlateModel

SEEN = 0.3
"""Ripple that is seen over that of energy shared equally by all modes, see benchmarks/rounding.py."""


@dataclass(frozen=True)
class RoundingNoise:
    """What rounding feeds into the plate.

    Attributes
    ----------
    power : float
        Of the energy [W].
    reaction : float
        Ripple of the reaction for it [N/sqrt(J)].
    """

    power: float
    reaction: float

    def ripple(self, duration: float) -> float:
        """Ripple of the reaction at the end of an undamped run, root mean square.

        Parameters
        ----------
        duration : float
            Of the run [s].

        Returns
        -------
        float
            [N].
        """
        return self.reaction * math.sqrt(self.power * duration)

    def rate_for(self, ripple: float) -> float:
        """Damping of elastic velocities that keeps the ripple at this.

        Parameters
        ----------
        ripple : float
            [N].

        Returns
        -------
        float
            Rate [1/s].
        """
        return self.power * (self.reaction / ripple) ** 2


def rounding_noise(model: PlateModel) -> RoundingNoise:
    """The noise of a model.

    Parameters
    ----------
    model : PlateModel
        The plate.

    Returns
    -------
    RoundingNoise
        Power and ripple.
    """
    loop, step = model.loop, model.loop.time_step
    corner = loop.corner
    moved = np.finfo(float).eps * float(np.ptp(model.discretisation.positions)) / math.sqrt(12.0)
    # Half the largest eigenvalue is a typical diagonal element of the stiffness over the mass.
    energy = 0.25 * model.mass * (model.highest_frequency * moved) ** 2
    stiffness = 1.0 / (corner.mobility * step**2) if corner.is_exact else corner.stiffness
    return RoundingNoise(energy / step, SEEN * math.sqrt(stiffness / loop.mass.size))
