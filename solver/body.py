"""The vehicle: a rectangular rigid plate that meets the wall with a corner."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Generic

from solver.elementary import V, functions, number
from solver.errors import Gate
from solver.rules import LENGTH, MASS, WIDTH


@dataclass(frozen=True)
class RectangularBody(Generic[V]):
    """Rectangle of uniform mass: floats, or arrays that broadcast with each other.

    Parameters
    ----------
    length : float or ndarray
        Of the side along the heading, L [m].
    width : float or ndarray
        B [m].
    mass : float or ndarray
        m [kg].

    Raises
    ------
    RigidBodyError
        Unless all are positive and finite.

    References
    ----------
    .. [1] Chuong and Malla, Infrastructures 2025, 10(11), 307, Figure 6.
    """

    length: V
    width: V
    mass: V

    def __post_init__(self) -> None:
        for rule in (LENGTH, WIDTH, MASS):
            value = number(rule.key, getattr(self, rule.key))
            Gate().demand(rule, (value > 0.0) & (value < math.inf), value)
            object.__setattr__(self, rule.key, value)

    @property
    def corner_radius(self) -> V:
        """Distance from the corner to the centre of mass, r_PG = sqrt(L^2 + B^2)/2 [m] (Eq 15)."""
        radius: V = functions(self.length, self.width).hypot(self.length, self.width) / 2.0
        return radius

    @property
    def corner_angle(self) -> V:
        """Angle between the side and the line from corner to centre, gamma = atan(B/L) [rad] (Eq 63)."""
        angle: V = functions(self.length, self.width).atan2(self.width, self.length)
        return angle

    @property
    def moment_of_inertia(self) -> V:
        """Moment of inertia about the centre of mass, I = m (L^2 + B^2)/12 [kg m^2] (Eq 26)."""
        radius: Any = self.corner_radius
        inertia: V = self.mass * radius * radius / 3.0
        return inertia
