"""Vehicles and trains that strike the wall.

Signs are those of `solver.MotionState`; SI units and radians.
"""

import math
from collections.abc import Sequence
from dataclasses import astuple, dataclass
from typing import Any, NamedTuple

import numpy as np

from solver import rules
from solver.conditions import Array, Gate, Number, functions, one, positive, within
from solver.impact.crush_law import LAW, CrushLaw
from solver.impact.strips import Points, WallContact, points_of, strips_of_units

ROUNDING = 1e-13
"""Depth of the foremost point over the distance of the centre of mass, below which it is zero."""

CORNERS_ALONE = WallContact(CrushLaw(1.0), 0.0)
"""Contact at the corners of all units, where the law does not matter."""


class Train(NamedTuple):
    """Trains with equal numbers of units and points, n samples.

    Attributes
    ----------
    mass, inertia : ndarray, shape (units, n)
        [kg], [kg m^2].
    hitch, kingpin : ndarray, shape (hinges, n)
        Position of hinge h between units h and h + 1, from the centre of mass of each along its heading [m].
    unit, group : ndarray, shape (points,)
        Unit of each point, and the group to whose strikes it belongs, as of `strips`.
    along, across : ndarray, shape (points, n)
        From the unit's centre of mass, along its heading and to the left [m].
    stiffness, initial_force, plateau_force : ndarray, shape (points, n)
        k [N/m], F0 and Fy [N] of each point; Fy is infinite without a plateau.
    restitution, unloading_stiffness, hardening : ndarray, shape (points, n)
        e [-], k_u [N/m] where it is above 0, and k2 [N/m].
    friction : ndarray, shape (points, n)
        mu [-].
    load : ndarray, shape (units, 3, n)
        Constant external force along X and Y [N], and moment that turns the rear towards the wall [N m].
    """

    mass: np.ndarray
    inertia: np.ndarray
    hitch: np.ndarray
    kingpin: np.ndarray
    unit: np.ndarray
    group: np.ndarray
    along: np.ndarray
    across: np.ndarray
    stiffness: np.ndarray
    initial_force: np.ndarray
    plateau_force: np.ndarray
    restitution: np.ndarray
    unloading_stiffness: np.ndarray
    hardening: np.ndarray
    friction: np.ndarray
    load: np.ndarray


def uniform_inertia(length: Number, width: Number, mass: Number) -> Any:
    """Return the uniform rectangle's inertia, m (L^2 + B^2)/12 [kg m^2]."""
    return mass * (length**2 + width**2) / 12.0


def greatest_inertia(length: Number, width: Number, mass: Number, centre: Number) -> Any:
    """Return the greatest yaw inertia of such a body [kg m^2].

    With all mass at the corners it is m (a (L - a) + B^2/4).
    """
    return mass * (centre * (length - centre) + width**2 / 4.0)


def stiffness_of_duration(
    duration: Number,
    restitution: Number,
    mass: Number,
    inertia: Number | None,
    length: Number,
    width: Number,
    centre: Number,
) -> Any:
    """Compute crush stiffness from a rear strike's duration.

    dt = (pi/2) (1 + e) sqrt(m_eff/k), a point mass on the bilinear law, with the effective mass of the corner of a side
    that is parallel to the wall, without friction: 1/m_eff = 1/m + a^2/I, a the distance of the rear behind the centre
    of mass; 0.261 m of the truck of Chuong and Malla (2025).

    Parameters
    ----------
    duration : float or ndarray
        Duration dt [s].
    restitution : float or ndarray
        Restitution e [-].
    mass, inertia : float or ndarray
        Mass m [kg] and inertia I [kg m^2]; None: that of the uniform rectangle.
    length, width, centre : float or ndarray
        Length and width of the vehicle, and distance of its centre of mass behind the front [m].

    Returns
    -------
    float or ndarray
        k [N/m].
    """
    inertia = uniform_inertia(length, width, mass) if inertia is None else inertia
    effective = 1.0 / (1.0 / mass + (length - centre) ** 2 / inertia)
    return effective * (0.5 * math.pi * (1.0 + restitution) / duration) ** 2


def demand_body(
    length: Number, width: Number, mass: Number, centre: Number, inertia: Number, is_prescribed: bool
) -> None:
    """Require possible sizes and masses of one or many bodies.

    is_prescribed: the inertia is not the uniform one.
    """
    gate = Gate()
    for rule, value in ((rules.LENGTH, length), (rules.WIDTH, width), (rules.MASS, mass)):
        gate.positive(rule, value)
    gate.demand(rules.CENTRE, (centre > 0.0) & (centre < length), centre, length=length)
    most = greatest_inertia(length, width, mass, centre)
    fits = (inertia >= rules.MIN_INERTIA * most) & (inertia <= most * (1.0 + 1e-12))
    rule, value = (rules.INERTIA, inertia) if is_prescribed else (rules.UNIFORM, centre)
    gate.demand(rule, fits, value, inertia=inertia, most=most)


@dataclass(frozen=True)
class ImpactVehicle:
    """Rigid rectangle with its centre of mass on the long axis.

    Parameters
    ----------
    length : float
        Length of the side along the heading, L [m].
    width : float
        Width, B [m].
    mass : float
        Mass, m [kg].
    centre_of_mass : float or None
        Distance of the centre of mass behind the front, a [m]; None: L/2.
    yaw_inertia : float or None
        Inertia about the centre of mass, I [kg m^2]; None: that of the uniform rectangle,
        m (L^2 + B^2)/12, wherever the centre is.

    Raises
    ------
    RigidBodyError
        Unless length, width and mass are positive and finite, the centre of mass is in the vehicle, and a body of that
        mass, size and centre can have that inertia: it is greatest, m (a (L - a) + B^2/4), with all mass at the
        corners; vehicles must have a thousandth of that at least.
    """

    length: float
    width: float
    mass: float
    centre_of_mass: float | None = None
    yaw_inertia: float | None = None

    def __post_init__(self) -> None:
        length, width, mass = (one(key, getattr(self, key)) for key in ("length", "width", "mass"))
        centre = one("centre_of_mass", self.front_distance)
        inertia = one("yaw_inertia", self.inertia)
        demand_body(length, width, mass, centre, inertia, self.yaw_inertia is not None)

    @property
    def front_distance(self) -> float:
        """Distance from the front to the centre of mass, a [m]."""
        return 0.5 * self.length if self.centre_of_mass is None else self.centre_of_mass

    @property
    def inertia(self) -> float:
        """Yaw inertia about the centre of mass, I [kg m^2]."""
        if self.yaw_inertia is not None:
            return self.yaw_inertia
        return uniform_inertia(self.length, self.width, self.mass)


@dataclass(frozen=True)
class ImpactState:
    """Position and velocity of the vehicle.

    The wall is the line Y = 0, and the vehicle above it.

    Parameters
    ----------
    x_g, y_g : float
        Position of the centre of mass [m].
    theta : float
        Angle between the wall side and the wall [rad]; the heading is (cos theta, -sin theta).
    v_gx, v_gy : float
        Velocity of the centre of mass [m/s].
    omega : float
        Angular velocity [rad/s], positive as the rear rotates towards the wall: d theta/dt = -omega.

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
            Gate().demand(rules.STATE, math.isfinite(one("state", value)), value)


@dataclass(frozen=True)
class HitchedVehicle:
    """Vehicle hinged to the one ahead on both centre lines.

    Parameters
    ----------
    vehicle : ImpactVehicle
        The trailer.
    hitch : float
        Distance of the hinge behind the front of the vehicle ahead [m].
    kingpin : float
        Distance of the hinge behind the trailer's front; negative for a drawbar [m].
    """

    vehicle: ImpactVehicle
    hitch: float
    kingpin: float


def first_touch(
    vehicle: ImpactVehicle,
    angle: float,
    speed: float,
    trailers: Sequence[HitchedVehicle] = (),
    contact: WallContact | None = None,
) -> ImpactState:
    """Return the state at first touch.

    The front corner of the wall side is at X = 0, the first point that touches at Y = 0, the velocity along the
    heading.

    Parameters
    ----------
    vehicle : ImpactVehicle
        Its size and centre of mass.
    angle : float
        Angle between side and wall, theta [rad].
    speed : float
        Speed before the impact [m/s].
    trailers : sequence of HitchedVehicle
        Trailers in line behind it. A trailer that is wider touches first, with the vehicle's corner off the wall.
    contact : WallContact or None
        Whose strips can touch; None: the corners of all units.

    Returns
    -------
    ImpactState
        Without rotation.

    Raises
    ------
    RigidBodyError
        Unless 0 < angle < pi/2 and the speed is positive and finite.
    """
    theta = within(rules.TOUCH_ANGLE, angle, math.pi / 2.0)
    v = positive(rules.SPEED, speed)
    units = vehicle, *(trailer.vehicle for trailer in trailers)
    sizes = np.array([[unit.length, unit.width, unit.front_distance] for unit in units]).T[..., None]
    points = points_of(contact or CORNERS_ALONE, *sizes)
    state = [np.array([value]) for value in touching(vehicle.front_distance, vehicle.width, theta, v)]
    placed = cleared(state, points, distances(vehicle, trailers))
    return ImpactState(*(float(value[0]) for value in placed))


def distances(vehicle: ImpactVehicle, trailers: Sequence[HitchedVehicle]) -> list[float]:
    """Return distances of trailers behind the vehicle [m].

    They are between centres of mass of units in line.
    """
    values, ahead, distance = list[float](), vehicle, 0.0
    for trailer in trailers:
        distance += trailer.hitch - ahead.front_distance + trailer.vehicle.front_distance - trailer.kingpin
        values.append(distance)
        ahead = trailer.vehicle
    return values


def lined_up(state: Sequence[Any], behind: Sequence[Number] | Array) -> Array:
    """Return states of units in line, rotating as one body.

    behind: distances of trailers behind the vehicle [m]. Shape (units, 6, ...).
    """
    x, y, theta, u, v, w = state
    s, c = np.sin(theta), np.cos(theta)
    trailers = [(x - d * c, y + d * s, theta, u - d * w * s, v - d * w * c, w) for d in behind]
    return np.array([np.broadcast_arrays(*unit) for unit in ((x, y, theta, u, v, w), *trailers)])


def cleared(state: Sequence[Any], points: Points, behind: Sequence[Number] | Array) -> tuple[Any, ...]:
    """Return the first vehicle's state with the foremost point on the wall.

    It is displaced across the wall as far as required. behind: as of `lined_up`.
    """
    units = lined_up(state, behind)[points.unit]
    depths = point_depths(points.along, points.across, units[:, 1], units[:, 2])
    x, y, *rest = state
    inside = depths.max(axis=0)
    return x, y + np.where(np.abs(inside) > ROUNDING * np.abs(y), inside, 0.0), *rest


def point_depths(along: Array, across: Array, y_g: Any, theta: Any) -> Array:
    """Return depths behind the wall of points of a vehicle [m].

    along, across: from its centre of mass [m], as of `Train`.
    """
    return np.asarray(-(y_g + across * np.cos(theta) - along * np.sin(theta)))


def touching(centre: Number, width: Number, theta: Number, speed: Number) -> tuple[Any, ...]:
    """Return the state at first touch in the order of `state.UNIT`.

    It is that of one vehicle or of many.
    """
    f, b = functions(theta), width / 2.0
    s, c = f.sin(theta), f.cos(theta)
    return b * s - centre * c, centre * s + b * c, theta, speed * c, -speed * s, 0.0 * speed


def train_of(
    vehicles: Sequence[ImpactVehicle], contact: WallContact, hinges: Sequence[tuple[float, float]] = ()
) -> Train:
    """Return the arrays of one train for `solve_trains`.

    Parameters
    ----------
    vehicles : sequence of ImpactVehicle
        From the first.
    contact : WallContact
        Laws of their contact, of floats.
    hinges : sequence of (float, float)
        Hinges between each vehicle and the next: distances behind the fronts of both [m].

    Returns
    -------
    Train
        Arrays of shape (units, 1), (hinges, 1), (points, 1).
    """
    for law in (
        strip.law for strips in strips_of_units(contact, [v.length for v in vehicles]) for strip in strips
    ):
        for key in LAW:
            one(key, getattr(law, key))
    mass, inertia, *sizes = np.array(
        [[v.mass, v.inertia, v.length, v.width, v.front_distance] for v in vehicles]
    ).T[..., None]
    ends = [(v.front_distance - a, w.front_distance - b)
            for (a, b), v, w in zip(hinges, vehicles, vehicles[1:], strict=False)]  # fmt: skip
    hitch, kingpin = np.array(ends).reshape(-1, 2).T[..., None]
    return assembled(mass, inertia, hitch, kingpin, points_of(contact, *sizes), contact.friction)


def assembled(
    mass: Array, inertia: Array, hitch: Array, kingpin: Array, points: Points, friction: Number
) -> Train:
    """Return trains of these units and contact points, without load.

    friction: of all points, of shape (n,) or the same for all.
    """
    count, n = mass.shape
    units = map(np.ascontiguousarray, (mass, inertia, hitch, kingpin))
    law = (np.ascontiguousarray(points.law[key]) for key in LAW)
    further = np.full((points.unit.size, n), friction), np.zeros((count, 3, n))
    return Train._make([*units, points.unit, points.group, points.along, points.across, *law, *further])
