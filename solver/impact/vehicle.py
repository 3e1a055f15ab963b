"""The vehicle of a whole impact, its state, and the state at first touch."""

from __future__ import annotations

import math
from dataclasses import astuple, dataclass

from solver.errors import Gate
from solver.impact import rules
from solver.rules import LENGTH, MASS, WIDTH


@dataclass(frozen=True)
class ImpactVehicle:
    """Rigid rectangle whose centre of mass lies on its long axis.

    Parameters
    ----------
    length : float
        Of the side along the heading, L [m].
    width : float
        B [m].
    mass : float
        m [kg].
    centre_of_mass : float or None
        Behind the front, a [m]; None: L/2.
    yaw_inertia : float or None
        About the centre of mass, I [kg m^2]; None: the uniform rectangle's, m (L^2 + B^2)/12, wherever the centre is.

    Raises
    ------
    RigidBodyError
        Unless length, width and mass are positive and finite, the centre of mass is in the vehicle, and a body of that
        mass, size and centre can have that inertia: it is greatest, m (a (L - a) + B^2/4), with all mass at the
        corners; of vehicles at least a thousandth of that is taken.
    """

    length: float
    width: float
    mass: float
    centre_of_mass: float | None = None
    yaw_inertia: float | None = None

    def __post_init__(self) -> None:
        for rule in (LENGTH, WIDTH, MASS):
            rules.positive(rule, getattr(self, rule.key))
        rules.within(rules.CENTRE, self.front_distance, 0.0, self.length, length=self.length)
        inertia, most = rules.one("yaw_inertia", self.inertia), self.greatest_inertia
        rule = rules.UNIFORM if self.yaw_inertia is None else rules.INERTIA
        given = self.front_distance if self.yaw_inertia is None else inertia
        fits = rules.MIN_INERTIA * most <= inertia <= most * (1.0 + 1e-12)
        Gate().demand(rule, fits, given, inertia=inertia, most=most)

    @property
    def front_distance(self) -> float:
        """From the front to the centre of mass, a [m]."""
        return 0.5 * self.length if self.centre_of_mass is None else self.centre_of_mass

    @property
    def inertia(self) -> float:
        """Yaw inertia about the centre of mass, I [kg m^2]."""
        uniform = self.mass * (self.length**2 + self.width**2) / 12.0
        return uniform if self.yaw_inertia is None else self.yaw_inertia

    @property
    def greatest_inertia(self) -> float:
        """Of any body of that mass, size and centre of mass, m (a (L - a) + B^2/4) [kg m^2]."""
        a = self.front_distance
        return self.mass * (a * (self.length - a) + self.width**2 / 4.0)

    @property
    def reach(self) -> float:
        """From the centre of mass to the farthest corner [m]."""
        return math.hypot(max(self.front_distance, self.length - self.front_distance), self.width / 2.0)


@dataclass(frozen=True)
class ImpactState:
    """Position and velocity of the vehicle; the wall is the line Y = 0, and the vehicle above it.

    Parameters
    ----------
    x_g, y_g : float
        Centre of mass [m].
    theta : float
        Between the wall side and the wall [rad]; the heading is (cos theta, -sin theta).
    v_gx, v_gy : float
        Velocity of the centre of mass [m/s].
    omega : float
        Angular velocity [rad/s], positive where it closes the angle: d theta/dt = -omega.

    Raises
    ------
    RigidBodyError
        Unless all are finite.
    """

    x_g: float
    y_g: float
    theta: float
    v_gx: float
    v_gy: float
    omega: float

    def __post_init__(self) -> None:
        for value in astuple(self):
            Gate().demand(rules.STATE, math.isfinite(rules.one("state", value)), value)


def first_touch(vehicle: ImpactVehicle, angle: float, speed: float) -> ImpactState:
    """The state at first touch: the front corner of the wall side at X = Y = 0, the velocity along the heading.

    Parameters
    ----------
    vehicle : ImpactVehicle
        Its size and centre of mass.
    angle : float
        Between side and wall, theta [rad].
    speed : float
        [m/s].

    Returns
    -------
    ImpactState
        Without rotation.

    Raises
    ------
    RigidBodyError
        Unless 0 < angle < pi/2 and the speed is positive and finite.
    """
    theta = rules.within(rules.TOUCH_ANGLE, angle, 0.0, math.pi / 2.0)
    v = rules.positive(rules.SPEED, speed)
    s, c, a, b = math.sin(theta), math.cos(theta), vehicle.front_distance, vehicle.width / 2.0
    return ImpactState(b * s - a * c, a * s + b * c, theta, v * c, -v * s, 0.0)
