"""Energy that rounding feeds into the plate, and its ripple.

The reaction of a stiff plate that rotates slowly is disturbed by rounding, which an undamped plate accumulates.
Positions are rounded at every step, each node independently: a random displacement of half a unit in the last place of
the plate's length. It feeds energy into all modes equally, at a rate proportional to the stiffness, and a part of that
energy is in the corner's spring.
"""

import math
from dataclasses import dataclass

import numpy as np

from fem.model.plate_model import PlateModel

MEASURED_RATIO = 0.3
"""Measured ripple over that of equipartition among all modes, see benchmarks/rounding.py."""


@dataclass(frozen=True)
class RoundingNoise:
    """Energy that rounding feeds into the plate.

    Attributes
    ----------
    power : float
        Power by rounding [W].
    reaction : float
        Ripple of the reaction per root of energy [N/sqrt(J)].
    frequency : float
        Highest frequency of the model [rad/s].
    """

    power: float
    reaction: float
    frequency: float

    def ripple(self, duration: float) -> float:
        """Return the root mean square ripple after an undamped run.

        Parameters
        ----------
        duration : float
            Duration of the run [s].

        Returns
        -------
        float
            Ripple of the reaction [N].
        """
        return self.reaction * math.sqrt(self.power * duration)

    def rate_for(self, ripple: float) -> float:
        """Return the damping rate of elastic velocities that limits the ripple.

        Parameters
        ----------
        ripple : float
            Largest ripple of the reaction [N].

        Returns
        -------
        float
            Rate [1/s], at most the highest frequency: above it the stable time step falls as the rate rises, and
            rounding feeds in energy proportionally faster.
        """
        return min(self.power * (self.reaction / ripple) ** 2, self.frequency)


def rounding_noise(model: PlateModel) -> RoundingNoise:
    """Return the noise of a model.

    Parameters
    ----------
    model : PlateModel
        The plate.

    Returns
    -------
    RoundingNoise
        Power and ripple.
    """
    parameters, step = model.parameters, model.parameters.time_step
    corner = parameters.corner
    rounding = np.finfo(float).eps * float(np.ptp(model.discretisation.positions)) / math.sqrt(12.0)
    # Half the largest eigenvalue is a typical diagonal element of the stiffness over the mass.
    energy = 0.25 * model.mass * (model.highest_frequency * rounding) ** 2
    stiffness = 1.0 / (corner.mobility * step**2) if corner.is_exact else corner.stiffness
    return RoundingNoise(
        energy / step, MEASURED_RATIO * math.sqrt(stiffness / parameters.mass.size), model.highest_frequency
    )
