"""The vehicle, the record of its motion, and inputs of the rigid-body theory: conversion, the rules that they must
meet, and the error that refuses them.

One scalar solution must cost microseconds, and 100 000 of them must be one call. So the formulas are written once, for
floats and arrays alike, with the functions of `functions(...)`: those of `math` for floats, of NumPy for arrays.
"""

import math
from dataclasses import dataclass, fields
from types import SimpleNamespace
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray


class RigidBodyError(ValueError):
    """An input for which the rigid-body equations have no answer; `str()` is a sentence made of all attributes.

    Attributes
    ----------
    key : str
        Name of the input to change.
    given : object
        Its value.
    why : str
        Reason why the value is invalid.
    allowed : str
        Allowed values.
    """

    def __init__(self, key: str, given: Any, why: str, allowed: str) -> None:
        super().__init__(key, given, why, allowed)
        self.key, self.given, self.why, self.allowed = key, given, why, allowed

    def __str__(self) -> str:
        return f"{self.key} is {self.given}, but {self.why}; allowed: {self.allowed}."


class Rule(NamedTuple):
    """Condition on an input; `why` and `allowed` are templates for the details of the row that violates it."""

    key: str
    why: str
    allowed: str


def choose(key: str, given: str, options: tuple[str, ...]) -> str:
    """`given`, if it is one of `options`; raises RigidBodyError if not."""
    if given in options:
        return given
    names = ", ".join(f'"{option}"' for option in options)
    raise RigidBodyError(key, repr(given), "this option does not exist", f"one of {names}")


def holds(met: Any) -> bool:
    """True if a condition, a bool or an array of them, is met throughout."""
    return met is True or (met is not False and bool(np.all(met)))


class Gate:
    """Checks of conditions on inputs; each condition is a bool or an array of bools.

    With invalid="raise" the first violated condition raises RigidBodyError for the first row that violates it. With
    invalid="nan" the rows are recorded in `ok`, and `filled` sets them to NaN.
    """

    def __init__(self, invalid: str = "raise") -> None:
        self.fill = choose("invalid", invalid, ("raise", "nan")) == "nan"
        self.ok: Any = True

    def demand(self, rule: Rule, met: Any, given: Any, **details: Any) -> None:
        """Require that `met` holds for the value `given`."""
        if holds(met):
            return
        if not self.fill:
            raise refusal(rule, given, met, **details)
        self.ok = self.ok & met

    def positive(self, rule: Rule, value: Any) -> None:
        """Require that `value` is positive and finite."""
        self.demand(rule, (value > 0.0) & (value < math.inf), value)

    def not_negative(self, rule: Rule, value: Any) -> None:
        """Require that `value` is 0 or more, and finite."""
        self.demand(rule, (value >= 0.0) & (value < math.inf), value)

    def safe(self, *values: Any) -> tuple[Any, ...]:
        """Values with a placeholder in invalid rows."""
        return values if self.ok is True else tuple(np.where(self.ok, value, 0.5)[()] for value in values)

    def filled(self, record: Any) -> Any:
        """Record with NaN in invalid rows."""
        if self.ok is True:
            return record
        values = (getattr(record, field.name) for field in fields(record))
        return type(record)(*(np.where(self.ok, value, np.nan)[()] for value in values))


def refusal(rule: Rule, given: Any, met: Any = False, **details: Any) -> RigidBodyError:
    """Error of a rule for the first value that violates it."""
    met, given, *arrays = np.broadcast_arrays(met, given, *details.values())
    index = tuple(int(i) for i in np.argwhere(~met)[0])
    value = given[index].item()
    values = {name: array[index] for name, array in zip(details, arrays, strict=True)}
    why = rule.why.format(**values) if np.isfinite(value) else "it is not a finite number"
    place = f" at index {index if len(index) > 1 else index[0]}" if index else ""
    return RigidBodyError(rule.key, f"{value:.10g}{place}", why, rule.allowed.format(**values))


Array = NDArray[np.float64]
Number = float | Array
V = TypeVar("V", bound=Number)


_SCALAR = SimpleNamespace(
    **vars(math), maximum=max, minimum=min, where=lambda condition, yes, no: yes if condition else no
)


def functions(*values: Any) -> Any:
    """The elementary functions for these values: those of `math` if all are floats, of NumPy if not."""
    for value in values:
        if not isinstance(value, float):
            return np
    return _SCALAR


def number(key: str, value: ArrayLike) -> Any:
    """`value` as a float, or as an array of floats; raises RigidBodyError under the name `key`."""
    if type(value) is float:
        return value
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        allowed = "a number, or an array of numbers"
        raise RigidBodyError(key, repr(value), "it is not a number", allowed) from error
    return array if array.ndim else array.item()


POSITIVE = "positive and finite"

LENGTH = Rule("length", "the vehicle needs a finite extent", f"{POSITIVE}, m")
WIDTH = Rule("width", "the vehicle needs a finite extent", f"{POSITIVE}, m")
MASS = Rule("mass", "the vehicle needs a mass", f"{POSITIVE}, kg")
SPEED = Rule("speed", "there is no impact", f"{POSITIVE}, m/s")
ANGLE = Rule(
    "angle",
    "the impact must start at the front corner with the centre of mass behind it",
    "more than 0 and less than {most:.6g} rad (phi = angle + corner angle < pi/2)",
)
FRICTION = Rule("friction", "friction opposes sliding", "0 or more, and finite")
RESTITUTION = Rule("restitution", "it is a fraction of the approach velocity", "from 0 to 1")
TURNING = Rule(
    "friction",
    "the impulse does not rotate the side of the vehicle towards the wall (beta <= phi = {phi:.6g} rad)",
    "less than cot(phi) = {limit:.6g}",
)

OMEGA = Rule("omega", "the side never reaches the wall", f"{POSITIVE}, rad/s")
CORNER_SPEED = Rule(
    "corner_speed",
    "friction is defined for forward sliding of the corner",
    "finite, and positive where there is friction, m/s",
)
_PATH = "less than 4/3 = 1.33333 for every path, less than {limit:.6g} for this one"
UNIQUE = Rule(
    "friction",
    "the motion is not unique: the sign of the reaction is undefined where 1 + 3 C^2 - 3 mu S C < 0, and its minimum "
    "on the path is {least:.6g}",
    _PATH,
)
SOLVABLE = Rule(
    "friction",
    "the reaction is unbounded where D = 1 + 3 C^2 - 3 mu S C = 0, and its minimum on the path is {least:.6g}",
    _PATH,
)
GROWTH = Rule(
    "friction",
    "the angular velocity changes too abruptly on the path for double precision",
    "less, or another reaction model",
)
STOP = Rule(
    "corner_speed",
    "the corner stops before the tail-slap, at the angle {angle:.6g} rad and the time {time:.6g} s, where friction "
    "reverses",
    "more, or no friction, m/s",
)
RANGE = Rule(
    "omega", "the motion is beyond the range of double precision", "smaller, as corner_speed and mass"
)

_FAR = "the motion ends earlier"
TIME = Rule("time", _FAR, "from 0 to {latest:.10g} s (the strike is at {strike:.10g} s)")
STOPPED = Rule("time", "the corner has stopped by then, and friction reverses", "up to the strike")
LATERAL_SPEED = Rule("lateral_speed", "it is not a finite speed", "finite, m/s")
DURATION = Rule("duration", "the pulse needs a finite duration", f"{POSITIVE}, s")

FRONT_DISTANCE = Rule("front_distance", "the centre of mass must be behind the front", f"{POSITIVE}, m")
HALF_WIDTH = Rule("half_width", "the centre of mass must be inside the vehicle", f"{POSITIVE}, m")
GRAVITY = Rule("gravity", "it is the unit of deceleration", f"{POSITIVE}, m/s^2")
IMPACT_ANGLE = Rule("angle", "the vehicle must approach the wall at an angle", "between 0 and pi/2 rad")
DEFLECTION = Rule("deflection", "the barrier deflects away from the vehicle", "0 or more, and finite, m")
TRAVEL = Rule(
    "travel",
    "the centre of mass must approach the wall",
    "positive: front_distance sin(angle) + deflection > half_width (1 - cos(angle)), m",
)
AVERAGE_FORCE = Rule("average_force", "the peak force follows from it", f"{POSITIVE}, N")

STIFFNESS = Rule("stiffness", "crush needs a finite stiffness", f"{POSITIVE}, N/m")
INITIAL_FORCE = Rule("initial_force", "contact is unilateral", "0 or more, and finite, N")
RETURNED = Rule("restitution", "unloading returns e^2 of the crush energy", "from 0 to 1")
LINE = Rule(
    "restitution",
    "with an initial force, unloading that returns more than half of the energy ends in front of the wall",
    "at most sqrt(1/2) = 0.707107 with an initial force, or no initial force",
)
CENTRE = Rule(
    "centre_of_mass",
    "the centre of mass must be inside the vehicle",
    "between 0 and the length, {length:.6g} m",
)
MIN_INERTIA = 1e-3
"""Smallest yaw inertia relative to the largest possible one."""
INERTIA = Rule(
    "yaw_inertia",
    "it is impossible for this mass, size and centre of mass",
    "from 0.001 I to I = m (a (L - a) + B^2/4) = {most:.6g} kg m^2",
)
UNIFORM = Rule(
    "centre_of_mass",
    "the yaw inertia of the uniform rectangle, {inertia:.6g} kg m^2, is impossible for it",
    "closer to the middle, or a yaw_inertia of at most {most:.6g} kg m^2",
)
TOUCH_ANGLE = Rule("angle", "the front corner must touch the wall first", "between 0 and pi/2 rad")
STATE = Rule("state", "it is the initial state", "six finite numbers")
INSIDE = Rule(
    "state", "{name} is {depth:.6g} m inside the wall at the start", "outside the wall, or touching it"
)
NEVER = Rule("state", "the vehicle never touches the wall", "a motion towards the wall")
END = Rule("end", "the motion needs a finite duration", f"{POSITIVE}, s")
IMPACT_TIME = Rule("time", _FAR, "from 0 to {end:.10g} s")
POINTS = Rule("side_points", "a layer is discretised at points along each side", "1 or more")

ROLLING = {
    name: Rule(name, why, f"{POSITIVE}, {unit}")
    for name, why, unit in (
        ("mass", "a body without mass has no momentum", "kg"),
        ("centre_height", "the centre of mass is above the ground", "m"),
        ("roll_inertia", "a body without inertia has no roll", "kg m^2"),
        ("track", "a vehicle stands on wheels to either side", "m"),
        ("suspension", "wheels without a spring carry nothing", "N/m"),
        ("wall_height", "a wall without height holds nothing", "m"),
    )
}
ROLLING |= {
    name: Rule(name, "it is a size", "0 or more, and finite")
    for name in ("damping_ratio", "width", "friction", "speed")
}
"""Rules of a vehicle that rolls over a wall, by the name of the input."""
ROLL_STEPS = Rule(
    "suspension", "the vehicle oscillates on it at {rate:.3g} rad/s, too fast to be followed", "softer, N/m"
)


def one(key: str, value: Any) -> float:
    """`value` as a float; raises RigidBodyError for arrays."""
    given = number(key, value)
    if not isinstance(given, float):
        raise RigidBodyError(key, f"of shape {given.shape}", "it is an array", "a number")
    return given


def within(rule: Rule, value: Any, least: float, most: float, **details: Any) -> float:
    """`value` as a float between the bounds, without them; raises RigidBodyError by the rule."""
    given = one(rule.key, value)
    Gate().demand(rule, least < given < most, given, **details)
    return given


def positive(rule: Rule, value: Any) -> float:
    """`value` as a positive, finite float; raises RigidBodyError by the rule."""
    return within(rule, value, 0.0, math.inf)


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
            Gate().positive(rule, value)
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


REACTIONS = ("drag", "none", "signed")


@dataclass(frozen=True)
class MotionState(Generic[V]):
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
