"""The vehicle, a rectangular rigid plate that meets the wall with a corner, and the record of its motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Generic

from solver import rules


@dataclass(frozen=True)
class RectangularBody(Generic[rules.V]):
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

    length: rules.V
    width: rules.V
    mass: rules.V

    def __post_init__(self) -> None:
        for rule in (rules.LENGTH, rules.WIDTH, rules.MASS):
            value = rules.number(rule.key, getattr(self, rule.key))
            rules.Gate().positive(rule, value)
            object.__setattr__(self, rule.key, value)

    @property
    def corner_radius(self) -> rules.V:
        """Distance from the corner to the centre of mass, r_PG = sqrt(L^2 + B^2)/2 [m] (Eq 15)."""
        radius: rules.V = rules.functions(self.length, self.width).hypot(self.length, self.width) / 2.0
        return radius

    @property
    def corner_angle(self) -> rules.V:
        """Angle between the side and the line from corner to centre, gamma = atan(B/L) [rad] (Eq 63)."""
        angle: rules.V = rules.functions(self.length, self.width).atan2(self.width, self.length)
        return angle

    @property
    def moment_of_inertia(self) -> rules.V:
        """Moment of inertia about the centre of mass, I = m (L^2 + B^2)/12 [kg m^2] (Eq 26)."""
        radius: Any = self.corner_radius
        inertia: rules.V = self.mass * radius * radius / 3.0
        return inertia


REACTIONS = ("drag", "none", "signed")


@dataclass(frozen=True)
class MotionState(Generic[rules.V]):
    """The vehicle at an instant: floats, or arrays of one shape.

    X runs along the wall, forwards; Y away from it. Every field is signed.

    Attributes
    ----------
    t : float or ndarray
        Time since the start of Stage 2 [s].
    theta : float or ndarray
        Angle between the side and the wall [rad], falling to 0.
    omega : float or ndarray
        Angular velocity [rad/s], positive where theta falls (Eq 68 [1]_).
    v_gx, v_gy : float or ndarray
        Velocity of the centre of mass [m/s] (Eqs 70-71); v_gy < 0 is towards the wall.
    v_p : float or ndarray
        Velocity of the corner along the wall [m/s].
    slide : float or ndarray
        Displacement of the corner along the wall, s [m] (Eq 69).
    reaction_normal : float or ndarray
        Of the wall on the vehicle along Y [N]; negative: it pulls, as it does throughout.
    reaction_tangential : float or ndarray
        The same along X [N].
    kinetic_energy : float or ndarray
        Of translation and rotation [J].
    friction_work : float or ndarray
        Done on the vehicle since the start [J]; kinetic_energy - friction_work is constant.

    References
    ----------
    .. [1] Chuong and Malla, Infrastructures 2025, 10(11), 307.
    """

    t: rules.V
    theta: rules.V
    omega: rules.V
    v_gx: rules.V
    v_gy: rules.V
    v_p: rules.V
    slide: rules.V
    reaction_normal: rules.V
    reaction_tangential: rules.V
    kinetic_energy: rules.V
    friction_work: rules.V
