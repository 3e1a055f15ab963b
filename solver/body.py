"""Rectangular vehicle and the record of its motion."""

from dataclasses import dataclass
from typing import Any, Generic

from solver.conditions import Gate, V, functions, number
from solver.rules import LENGTH, MASS, WIDTH

REACTIONS = ("drag", "none", "signed")

GRAVITY = 9.80665
"""Standard gravity [m/s^2]."""


@dataclass(frozen=True)
class RectangularBody(Generic[V]):
    """Rectangle of uniform mass, as floats or arrays that broadcast.

    Parameters
    ----------
    length : float or ndarray
        Length of the side along the heading, L [m].
    width : float or ndarray
        Width, B [m].
    mass : float or ndarray
        Mass, m [kg].

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
            Gate().positive(rule, value)
            object.__setattr__(self, rule.key, value)

    @property
    def corner_radius(self) -> V:
        """Distance from the corner to the centre of mass [m].

        r_PG = sqrt(L^2 + B^2)/2 (Eq 15).
        """
        radius: V = functions(self.length, self.width).hypot(self.length, self.width) / 2.0
        return radius

    @property
    def corner_angle(self) -> V:
        """Angle between the side and the line from corner to centre [rad].

        gamma = atan(B/L) (Eq 63).
        """
        angle: V = functions(self.length, self.width).atan2(self.width, self.length)
        return angle

    @property
    def moment_of_inertia(self) -> V:
        """Moment of inertia about the centre of mass [kg m^2].

        I = m (L^2 + B^2)/12 (Eq 26).
        """
        radius: Any = self.corner_radius
        inertia: V = self.mass * radius * radius / 3.0
        return inertia


@dataclass(frozen=True)
class MotionState(Generic[V]):
    """State of the vehicle, as floats or arrays of one shape.

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
        Reaction of the wall on the vehicle along Y [N]; it is negative, because the wall pulls.
    reaction_tangential : float or ndarray
        Reaction of the wall on the vehicle along X [N].
    kinetic_energy : float or ndarray
        Kinetic energy of translation and rotation [J].
    friction_work : float or ndarray
        Work of friction on the vehicle since the start [J]; kinetic_energy - friction_work is constant.

    References
    ----------
    .. [1] Chuong and Malla, Infrastructures 2025, 10(11), 307.
    """

    t: V
    theta: V
    omega: V
    v_gx: V
    v_gy: V
    v_p: V
    slide: V
    reaction_normal: V
    reaction_tangential: V
    kinetic_energy: V
    friction_work: V
