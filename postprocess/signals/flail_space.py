"""How an occupant, or a head, free in the vehicle, flies until the interior stops it. Numbers alone, SI units.

The vehicle's axes are x ahead and y to the left; yaw turns counter-clockwise. Accelerations are taken as linear between
their instants and integrated exactly.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

AHEAD, ASIDE = 0.6, 0.3
"""Free distances [m]: to the dashboard, to either side."""


@dataclass(frozen=True)
class VehicleMotion:
    """Motion of the centre of mass in the plane from first touch; arrays of shape (n,).

    t: even instants [s]; ax, ay: acceleration along the vehicle's own axes [m/s^2]; yaw_rate [rad/s]; yaw [rad].
    """

    t: Floats
    ax: Floats
    ay: Floats
    yaw_rate: Floats
    yaw: Floats

    def __post_init__(self) -> None:
        shapes = {values.shape for values in vars(self).values()}
        if len(shapes) != 1 or self.t.ndim != 1 or self.t.size < 3:
            raise ValueError(
                f"motion with arrays of shapes {sorted(shapes)}: must be one shape (n,), n at least 3"
            )
        steps = np.diff(self.t)
        if not (steps > 0.0).all() or np.ptp(steps) > 1e-6 * steps.mean():
            raise ValueError(f"instants {steps.min():g} to {steps.max():g} s apart: must rise evenly")

    @property
    def interval(self) -> float:
        """Time between instants [s]."""
        return float((self.t[-1] - self.t[0]) / (self.t.size - 1))


@dataclass(frozen=True)
class Contact:
    """Where a free flight ends: instant [s], velocity relative to the vehicle [m/s], forward and to the left."""

    time: float
    forward: float
    sideways: float

    @property
    def speed(self) -> float:
        """Resultant [m/s]."""
        return math.hypot(self.forward, self.sideways)


def occupant_contact(motion: VehicleMotion) -> Contact | None:
    """Flail space: both axes by themselves, the vehicle's turning left out; None if neither distance is used up."""
    speeds = [_integral(motion.t, -values) for values in (motion.ax, motion.ay)]
    ways = [_integral_of_linear(motion.t, -values) for values in (motion.ax, motion.ay)]
    return _first_contact(motion.t, ways, speeds)


def head_contact(motion: VehicleMotion, ahead: float = 0.0) -> Contact | None:
    """Free head, in the plane: straight on as the vehicle turns about it; None if it touches nothing.

    ahead: how far in front of the centre of mass it sits [m].
    """
    t, turned = motion.t - motion.t[0], motion.yaw - motion.yaw[0]
    cos, sin = np.cos(turned), np.sin(turned)
    along = cos * motion.ax - sin * motion.ay, sin * motion.ax + cos * motion.ay
    start = np.array([ahead, 0.0]), np.array([0.0, ahead * motion.yaw_rate[0]])
    x, y = (p + v * t - _integral_of_linear(t, a) for p, v, a in zip(*start, along, strict=True))
    u, v = (v - _integral(t, a) for v, a in zip(start[1], along, strict=True))
    inside = np.array([cos * x + sin * y, cos * y - sin * x])
    speeds = np.array([cos * u + sin * v, cos * v - sin * u])
    speeds += motion.yaw_rate * np.array([inside[1], -inside[0]])
    return _first_contact(motion.t, [inside[0] - ahead, inside[1]], list(speeds))


def _first_contact(t: Floats, ways: list[Floats], speeds: list[Floats]) -> Contact | None:
    """The first instant at which a way reaches its distance, by cubics through ways and speeds."""
    from scipy.interpolate import CubicHermiteSpline

    forward, sideways = (CubicHermiteSpline(t, way, speed) for way, speed in zip(ways, speeds, strict=True))
    limits = ((forward, AHEAD), (sideways, ASIDE), (sideways, -ASIDE))
    found = np.concatenate([way.solve(limit, extrapolate=False) for way, limit in limits])
    if not found.size:
        return None
    time = float(found.min())
    return Contact(time, *(float(way.derivative()(time)) for way in (forward, sideways)))


def _integral(t: Floats, values: Floats) -> Floats:
    """From the first instant, values linear in between."""
    return np.concatenate(([0.0], np.cumsum(0.5 * np.diff(t) * (values[1:] + values[:-1]))))


def _integral_of_linear(t: Floats, values: Floats) -> Floats:
    """The integral of `_integral`, exact as well."""
    steps = np.diff(t)
    gained = steps * _integral(t, values)[:-1] + steps**2 * (2.0 * values[:-1] + values[1:]) / 6.0
    return np.concatenate(([0.0], np.cumsum(gained)))
