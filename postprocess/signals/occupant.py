"""Occupant risk of a motion in the plane or in space.

ASI, THIV and PHD of EN 1317-1, OIV and ORA of MASH. ASI: the largest value of sqrt((ax / 12 g)^2 + (ay / 9 g)^2 + (az
/ 10 g)^2), of 50 ms means (EN 1317-1:1998), or, after CFC 180, of accelerations through a four-pole phaseless
Butterworth filter of 13 Hz (EN 1317-1:2010; taken as 3 dB down forward and backward together). THIV: speed of a free
head relative to the interior at contact; PHD: from then on the largest 10 ms mean of the resultant acceleration. OIV:
velocities of a free occupant relative to the vehicle when the first of the two flail distances is reached; ORA: from
then on the largest 10 ms mean along each axis.

An occupant, or a head, is free in the vehicle until the interior stops it. The vehicle's axes are x forward and y to
the left; yaw is positive counter-clockwise. Accelerations are taken as linear between their instants and integrated
exactly.

Sources: EN 1317-1; AASHTO, Manual for Assessing Safety Hardware, as in the manuals of NI DIAdem (ChnASICalc,
ChnTHIVCalc, ChnOIVCalc) and Oasys T/HIS (THIV and PHD).
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial

from postprocess.signals.filters import Floats, cfc_filter, low_pass, moving_mean

AHEAD, ASIDE = 0.6, 0.3
"""Flail distances to the dashboard and to either side [m]."""

GRAVITY = 9.80665
"""[m/s^2]"""

RIDEDOWN = 0.01
"""Width of the means after contact [s]."""

PLANAR = "planar: without vertical acceleration, roll and pitch a lower bound"

IN_SPACE = "rigid body; motion alone, without gravity"

AXES = "axes of the vehicle; without its rotation"

HEAD = "planar by definition; head above the centre of mass, not in a seat"

LIMITS = "limits not given"


@dataclass(frozen=True)
class VehicleMotion:
    """Motion of the centre of mass from first touch.

    Arrays of shape (n,). t: even instants [s]; ax, ay, az: acceleration along the vehicle's axes, in the plane
    without az [m/s^2]; yaw_rate [rad/s]; yaw [rad].
    """

    t: Floats
    ax: Floats
    ay: Floats
    yaw_rate: Floats
    yaw: Floats
    az: Floats | None = None

    def __post_init__(self) -> None:
        shapes = {values.shape for values in vars(self).values() if values is not None}
        if len(shapes) != 1 or self.t.ndim != 1 or self.t.size < 3:
            why = f"motion with arrays of shapes {sorted(shapes)}: must be one shape (n,), n at least 3"
            raise ValueError(why)
        steps = np.diff(self.t)
        if not (steps > 0.0).all() or np.ptp(steps) > 1e-6 * steps.mean():
            raise ValueError(f"instants {steps.min():g} to {steps.max():g} s apart: must rise evenly")

    @property
    def interval(self) -> float:
        """Time between instants [s]."""
        return float((self.t[-1] - self.t[0]) / (self.t.size - 1))


@dataclass(frozen=True)
class FlightEnd:
    """End of a free flight.

    Instant [s]; velocity relative to the vehicle [m/s], forward and to the left.
    """

    time: float
    forward: float
    sideways: float

    @property
    def speed(self) -> float:
        """Resultant velocity [m/s]."""
        return math.hypot(self.forward, self.sideways)


def occupant_contact(motion: VehicleMotion) -> FlightEnd | None:
    """Return the end of a flight in the flail space.

    Both axes are independent, and yaw is neglected. None if neither distance is reached.
    """
    speeds = [_integral(motion.t, -values) for values in (motion.ax, motion.ay)]
    displacements = [_integral_of_linear(motion.t, -values) for values in (motion.ax, motion.ay)]
    return _first_contact(motion.t, displacements, speeds)


def head_contact(motion: VehicleMotion, ahead: float = 0.0) -> FlightEnd | None:
    """Return the end of the planar flight of a free head.

    The velocity of the head is constant while the vehicle rotates. None without contact. ahead: distance in front of
    the centre of mass [m].
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


def _first_contact(t: Floats, displacements: list[Floats], speeds: list[Floats]) -> FlightEnd | None:
    """Return the first instant at which a displacement reaches its distance.

    Displacements are interpolated by cubics.
    """
    reached = (displacements[0] >= AHEAD) | (np.abs(displacements[1]) >= ASIDE)
    if not reached.any():
        return None
    k = int(reached.argmax()) - 1
    step = t[k + 1] - t[k]
    cubics = [_cubic(*x[k : k + 2], *step * v[k : k + 2]) for x, v in zip(displacements, speeds, strict=True)]
    low, high = 0.0, 1.0
    for _ in range(53):  # bisection, to the last digit
        middle = 0.5 * (low + high)
        forward, sideways = (cubic(middle) for cubic in cubics)
        low, high = (low, middle) if forward >= AHEAD or abs(sideways) >= ASIDE else (middle, high)
    return FlightEnd(float(t[k] + high * step), *(float(cubic.deriv()(high) / step) for cubic in cubics))


def _cubic(start: float, end: float, rate: float, last_rate: float) -> Polynomial:
    """Return the cubic Hermite polynomial of an interval."""
    rise = end - start
    return Polynomial([start, rate, 3.0 * rise - 2.0 * rate - last_rate, rate + last_rate - 2.0 * rise])


def _integral(t: Floats, values: Floats) -> Floats:
    """Integrate piecewise linear values from the first instant."""
    return np.concatenate(([0.0], np.cumsum(0.5 * np.diff(t) * (values[1:] + values[:-1]))))


def _integral_of_linear(t: Floats, values: Floats) -> Floats:
    """Integrate the result of `_integral`, exactly."""
    steps = np.diff(t)
    increments = steps * _integral(t, values)[:-1] + steps**2 * (2.0 * values[:-1] + values[1:]) / 6.0
    return np.concatenate(([0.0], np.cumsum(increments)))


@dataclass(frozen=True)
class RiskMeasure:
    """Measure of occupant risk.

    value: in its unit, None if the flight does not end; time: instant [s]; `lacks`: restrictions; limits.
    """

    name: str
    value: float | None
    unit: str
    time: float | None
    lacks: str
    limits: str = LIMITS


def occupant_risk(motion: VehicleMotion) -> tuple[RiskMeasure, ...]:
    """Return all measures of occupant risk.

    ValueError for a motion sampled below 1800 Hz, or shorter than 77 ms (a period of 13 Hz).
    """
    return (*severity_indices(motion), *head_measures(motion), *flail_measures(motion))


def severity_indices(motion: VehicleMotion) -> tuple[RiskMeasure, ...]:
    """Return ASI after both editions.

    Before first touch there is no acceleration.
    """
    interval = motion.interval
    limits = [(motion.ax, 12.0), (motion.ay, 9.0)]
    limits += [] if motion.az is None else [(motion.az, 10.0)]
    lacks = PLANAR if motion.az is None else IN_SPACE
    axes = [np.concatenate(([0.0], a / (limit * GRAVITY))) for a, limit in limits]
    means = [moving_mean(a, interval, 0.05) for a in axes]
    filtered = [low_pass(cfc_filter(a, interval, 180), interval, 13.0) for a in axes]
    return tuple(
        _largest(f"ASI {edition}", "-", lacks, motion.t, np.linalg.norm(components, axis=0)[1:])
        for edition, components in (("1998, 50 ms mean", means), ("2010, 13 Hz", filtered))
    )


def head_measures(motion: VehicleMotion) -> tuple[RiskMeasure, RiskMeasure]:
    """Return THIV [m/s] and PHD [g]."""
    contact = head_contact(motion)
    time, speed = (contact.time, contact.speed) if contact else (None, None)
    resultant = np.hypot(motion.ax, motion.ay)
    return (RiskMeasure("THIV", speed, "m/s", time, HEAD), _after("PHD", HEAD, motion, contact, resultant))


def flail_measures(motion: VehicleMotion) -> tuple[RiskMeasure, ...]:
    """Return OIV [m/s] and ORA [g] along both axes, without sign."""
    contact = occupant_contact(motion)
    time, speeds = (contact.time, (contact.forward, contact.sideways)) if contact else (None, (None, None))
    axes = (("longitudinal", speeds[0], motion.ax), ("lateral", speeds[1], motion.ay))
    return (
        *(RiskMeasure(f"OIV {axis}", speed and abs(speed), "m/s", time, AXES) for axis, speed, _ in axes),
        *(_after(f"ORA {axis}", AXES, motion, contact, values) for axis, _, values in axes),
    )


def _after(
    name: str, lacks: str, motion: VehicleMotion, contact: FlightEnd | None, values: Floats
) -> RiskMeasure:
    """Return the largest 10 ms mean [g] after the contact.

    Means end within the history.
    """
    t, half = motion.t, 0.5 * RIDEDOWN
    means = np.abs(moving_mean(values, motion.interval, RIDEDOWN)) / GRAVITY
    later = np.zeros(t.size, bool) if contact is None else (t >= contact.time + half) & (t <= t[-1] - half)
    return _largest(name, "g", lacks, t[later], means[later])


def _largest(name: str, unit: str, lacks: str, t: Floats, values: Floats) -> RiskMeasure:
    if not values.size:
        return RiskMeasure(name, None, unit, None, lacks)
    place = int(values.argmax())
    return RiskMeasure(name, float(values[place]), unit, float(t[place]), lacks)
