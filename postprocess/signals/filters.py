"""Filters of crash practice, what is read off a filtered force, design forces of railings, and occupant risk.

Low-passes, by frequency class (CFC) or cut-off frequency, are Butterworth filters of second order, once forward and
once backward, so nothing is delayed. With w_a the tangent at the corner of one pass, their gain is 1 / (1 + (tan(pi f
T) / w_a)^4). Both ends are padded by the end values, for 10 ms and at least three periods of the cut-off frequency:
long enough for the filter to settle, so that the result is that of a signal which holds its end values for ever, and a
constant stays as it is. The mean is centred. Values are uniform samples, each the mean over its interval T; sample i
stands for the instant (i + 1/2) T.

Sources: SAE J211-1, Instrumentation for impact test; its class CFC is 3 dB down at CFC / 0.6. Sample rate of at least
ten times the class, six times the cut-off frequency: as FlexPro's documentation of its CFC filter has it.

The duration follows Chuong and Malla (2025), section 3: on a curve of force over time the second sharp peak is the
tail-slap; it begins and ends where the force is lowest just before its rise and just after its decline. They read it by
eye, off 50 ms means and SAE-filtered curves; here, a valley is the first bottom on the way down that lies no more than
5 % of the peak above the lowest force between this strike and the next. A mean over w widens a strike that stands
free by w.

Occupant risk of a planar motion is ASI, THIV and PHD of EN 1317-1, OIV and ORA of MASH.

ASI: the largest value of sqrt((ax / 12 g)^2 + (ay / 9 g)^2 + (az / 10 g)^2), of 50 ms means (EN 1317-1:1998), or, after
CFC 180, of accelerations through a four-pole phaseless Butterworth filter of 13 Hz (EN 1317-1:2010; taken as 3 dB down
forward and backward together). THIV: speed of a free head relative to the inside that it meets; PHD: from then on
the largest 10 ms mean of the resultant acceleration. OIV: velocities of a free occupant relative to the vehicle where
the first of the two flail distances is used up; ORA: from then on the largest 10 ms mean along each axis.

An occupant, or a head, free in the vehicle, flies until the interior stops it. The vehicle's axes are x ahead and y to
the left; yaw turns counter-clockwise. Accelerations are taken as linear between their instants and integrated exactly.

Sources: EN 1317-1; AASHTO, Manual for Assessing Safety Hardware, by way of the manuals of
NI DIAdem (ChnASICalc, ChnTHIVCalc, ChnOIVCalc) and Oasys T/HIS (THIV and PHD).
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

CLASSES = (60, 180, 600, 1000)
PAD = 0.01
"""Least padding of each end [s]."""

PERIODS = 3.0
SAMPLES_A_PERIOD = 6.0


def cfc_filter(values: Floats, interval: float, frequency_class: int) -> Floats:
    """Values through the filter of a channel frequency class: 60, 180, 600 or 1000; 3 dB down at class / 0.6.

    values: shape (n,), any unit; interval: T [s]. ValueError for another class, too long an interval or too short a
    history.
    """
    if frequency_class not in CLASSES:
        raise ValueError(f"frequency class {frequency_class}: must be one of {', '.join(map(str, CLASSES))}")
    cutoff = frequency_class / 0.6
    check_samples(values, interval, 1.0 / cutoff, cutoff)
    return _both_ways(values, interval, cutoff, math.tan(math.pi * frequency_class * 2.0775 * interval))


def low_pass(values: Floats, interval: float, cutoff: float) -> Floats:
    """Values through a filter whose gain, forward and backward together, is 1 / sqrt 2 at `cutoff` [Hz].

    values: shape (n,), any unit; interval: T [s]. ValueError as for `cfc_filter`.
    """
    check_samples(values, interval, 1.0 / cutoff, cutoff)
    corner = math.tan(math.pi * cutoff * interval) / (math.sqrt(2.0) - 1.0) ** 0.25
    return _both_ways(values, interval, cutoff, corner)


def cutoff_60hz(values: Floats, interval: float) -> Floats:
    """Values through `low_pass` at 60 Hz: what "SAE filter, 60 Hz cut-off" says, and CFC 60 (100 Hz) is not."""
    return low_pass(values, interval, 60.0)


def moving_mean(values: Floats, interval: float, width: float) -> Floats:
    """Centred mean over `width` [s], at the instant of each sample; beyond the ends the end values hold.

    values: shape (n,), any unit; interval: T [s]. From the cumulated integral, interpolated: any width will do.
    ValueError if the history is shorter than the width.
    """
    check_samples(values, interval, width)
    added = math.ceil(0.5 * width / interval) + 1
    held = np.pad(values, added, mode="edge")
    edges = interval * (np.arange(held.size + 1) - added)
    integral = np.concatenate(([0.0], np.cumsum(held))) * interval
    centres = interval * (np.arange(values.size) + 0.5)
    after, before = (np.interp(centres + side, edges, integral) for side in (0.5 * width, -0.5 * width))
    return np.asarray((after - before) / width)


def check_samples(values: Floats, interval: float, shortest: float, cutoff: float = 0.0) -> None:
    """ValueError unless these are finite samples over `shortest` [s], often enough for the cut-off frequency [Hz]."""
    if values.ndim != 1 or not np.isfinite(values).all():
        raise ValueError(f"values of shape {values.shape}: must be finite numbers in one dimension")
    if not (0.0 < interval < math.inf and interval * SAMPLES_A_PERIOD * cutoff <= 1.0 + 1e-9):
        limit = 1.0 / (SAMPLES_A_PERIOD * cutoff) if cutoff else math.inf
        most = f", at most {limit:.4g} s for a cut-off at {cutoff:.4g} Hz" if cutoff else ""
        raise ValueError(f"sample interval {interval:g} s: must be positive{most}")
    if values.size * interval < shortest * (1.0 - 1e-9):
        raise ValueError(f"history of {values.size * interval:.4g} s: must last at least {shortest:.4g} s")


def _both_ways(values: Floats, interval: float, cutoff: float, corner: float) -> Floats:
    """Forward and backward through the second-order filter with this w_a, from the steady state at both ends."""
    from scipy.signal import filtfilt

    added = math.ceil(max(PAD, PERIODS / cutoff) / interval)
    held = np.pad(values, added, mode="edge")
    found = filtfilt(*_coefficients(corner), held, padlen=0)
    return np.asarray(found[added:-added])


def _coefficients(corner: float) -> tuple[Floats, Floats]:
    """Coefficients of input and output in the difference equation, SAE's a0 to a2 and 1, -b1, -b2."""
    scale = 1.0 + math.sqrt(2.0) * corner + corner**2
    entering = corner**2 / scale * np.array([1.0, 2.0, 1.0])
    leaving = np.array([scale, 2.0 * (corner**2 - 1.0), 1.0 - math.sqrt(2.0) * corner + corner**2]) / scale
    return entering, leaving


PROMINENCE = 0.25
"""Height of a peak above the valleys beside it, over the largest value, from which it counts as a strike."""

LOWEST = 0.05
"""Height of a valley above the lowest force, over the peak, at most: undershoot of filters elsewhere is no valley."""


FILTERS: Mapping[str, Callable[[Floats, float], Floats]] = {
    "raw": lambda force, interval: force,
    "mean_50ms": lambda force, interval: moving_mean(force, interval, 0.05),
    "cfc60": lambda force, interval: cfc_filter(force, interval, 60),
    "cfc180": lambda force, interval: cfc_filter(force, interval, 180),
    "cutoff_60hz": cutoff_60hz,
}
"""Peaks of a force [N] with this interval [s]."""


@dataclass(frozen=True)
class StrikeDuration:
    """A strike from valley to valley: instants [s], peak [N], impulse [N s]."""

    start: float
    end: float
    peak: float
    impulse: float

    @property
    def duration(self) -> float:
        """From valley to valley [s]."""
        return self.end - self.start

    @property
    def triangle(self) -> float:
        """Duration [s] of the triangular pulse of the same impulse and peak, 2 J / F."""
        return 2.0 * self.impulse / self.peak


def force_curves(force: Floats, interval: float, names: Iterable[str] = tuple(FILTERS)) -> dict[str, Floats]:
    """The force [N] itself and by each filter, under the names of `summary.json`; shape (n,) each.

    force: shape (n,), each sample the mean over its interval [s]. It starts at first touch: before there is none.
    names: of `FILTERS`.
    ValueError for samples too rare for CFC 180 (1800 Hz), and for a history shorter than 50 ms.
    """
    touched = np.concatenate(([0.0], force))
    return {name: FILTERS[name](touched, interval)[1:] for name in names}


def force_peaks(curves: Mapping[str, Floats]) -> dict[str, float]:
    """The largest value of each curve, by its name."""
    return {name: float(values.max()) for name, values in curves.items()}


def second_strike(curve: Floats, interval: float) -> StrikeDuration:
    """The second strike of a curve of `force_curves`, by the paper's rule. ValueError if it has no second peak.

    curve: force on the wall [N], shape (n,), pressing positive; interval [s].
    """
    from scipy.signal import find_peaks

    largest = float(curve.max(initial=0.0))
    ends = np.concatenate(([0.0], curve, [0.0]))
    above = PROMINENCE * largest
    height = ends.min() + above  # lower ones are not prominent: looking for their valleys takes long
    peaks = find_peaks(ends, height=height, prominence=above)[0] - 1 if largest > 0.0 else np.empty(0, int)
    if peaks.size < 2:
        raise ValueError(f"a curve with {peaks.size} peaks has no second strike: must have at least 2")
    first, second, last = (int(place) for place in (*peaks, curve.size - 1)[:3])
    start = second - _valley(curve[first : second + 1][::-1])
    end = second + _valley(curve[second : last + 1])
    return StrikeDuration(
        start=(start + 0.5) * interval,
        end=(end + 0.5) * interval,
        peak=float(curve[second]),
        impulse=float(0.5 * interval * np.sum(curve[start:end] + curve[start + 1 : end + 1])),
    )


def _valley(falling: Floats) -> int:
    """Samples from the first one, the peak, to the first low bottom of the force."""
    low = int(np.argmax(falling <= falling.min() + LOWEST * falling[0]))
    rising = np.diff(falling[low:]) >= 0.0
    return low + (int(np.argmax(rising)) if rising.any() else rising.size)


KIP, FOOT = 4448.2216152605, 0.3048
"""[N], [m]"""

LEVELS = tuple(f"TL-{number}" for number in range(1, 7))


@dataclass(frozen=True)
class DesignForce:
    """A transverse force for a test level [kip], as given, and its source.

    longitudinal: force along the rail [kip]; length: of rail over which both are spread [ft]; None: not given. where:
    the rails that it is meant for.
    """

    test_level: str
    name: str
    kip: float
    source: str
    longitudinal: float | None = None
    length: float | None = None
    where: str = ""

    @property
    def force(self) -> float:
        """Transverse force [N]."""
        return self.kip * KIP

    @property
    def longitudinal_force(self) -> float | None:
        """Force along the rail [N]."""
        return None if self.longitudinal is None else self.longitudinal * KIP

    @property
    def length_m(self) -> float | None:
        """Length over which the forces are spread [m]."""
        return None if self.length is None else self.length * FOOT


AASHTO = "AASHTO LRFD Bridge Design Specifications, Table A13.2-1; whether later editions changed it is not confirmed"
LRFD = tuple(
    DesignForce(level, "AASHTO LRFD", transverse, AASHTO, longitudinal, length)
    for level, transverse, longitudinal, length in zip(
        LEVELS,
        (13.5, 27.0, 54.0, 54.0, 124.0, 175.0),
        (4.5, 9.0, 18.0, 18.0, 41.0, 58.0),
        (4.0, 4.0, 4.0, 3.5, 8.0, 8.0),
        strict=True,
    )
)
MASH = (
    DesignForce(
        "TL-4",
        "MASH, TTI",
        80.0,
        "Sheikh, Bligh and Menges, Determination of minimum height and lateral design load for MASH test level 4 "
        "bridge rails, Texas Transportation Institute, Report 9-1002-5 (2011)",
        where="rails of 36 in. or higher",
    ),
    DesignForce(
        "TL-4", "MASH, 4.5 g", 22.05 * 4.5, "NCHRP Web-Only Document 326, Eq. 3-4: 22 050 lb times 4.5 g"
    ),
)


def design_forces(test_level: str) -> Sequence[DesignForce]:
    """Forces for "TL-1" to "TL-6", AASHTO's first. ValueError for another level."""
    if test_level not in LEVELS:
        raise ValueError(f"test level {test_level!r}: must be one of {', '.join(LEVELS)}")
    return tuple(row for row in (*LRFD, *MASH) if row.test_level == test_level)


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
    """End of a free flight: instant [s], velocity relative to the vehicle [m/s], forward and to the left."""

    time: float
    forward: float
    sideways: float

    @property
    def speed(self) -> float:
        """Resultant [m/s]."""
        return math.hypot(self.forward, self.sideways)


def occupant_contact(motion: VehicleMotion) -> FlightEnd | None:
    """Flail space: both axes by themselves, the vehicle's turning left out; None if neither distance is used up."""
    speeds = [_integral(motion.t, -values) for values in (motion.ax, motion.ay)]
    displacements = [_integral_of_linear(motion.t, -values) for values in (motion.ax, motion.ay)]
    return _first_contact(motion.t, displacements, speeds)


def head_contact(motion: VehicleMotion, ahead: float = 0.0) -> FlightEnd | None:
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


def _first_contact(t: Floats, displacements: list[Floats], speeds: list[Floats]) -> FlightEnd | None:
    """The first instant at which a way reaches its distance, by cubics through displacements and speeds."""
    from scipy.interpolate import CubicHermiteSpline

    both = zip(displacements, speeds, strict=True)
    forward, sideways = (CubicHermiteSpline(t, way, speed) for way, speed in both)
    limits = ((forward, AHEAD), (sideways, ASIDE), (sideways, -ASIDE))
    found = np.concatenate([way.solve(limit, extrapolate=False) for way, limit in limits])
    if not found.size:
        return None
    time = float(found.min())
    return FlightEnd(time, *(float(way.derivative()(time)) for way in (forward, sideways)))


def _integral(t: Floats, values: Floats) -> Floats:
    """From the first instant, values linear in between."""
    return np.concatenate(([0.0], np.cumsum(0.5 * np.diff(t) * (values[1:] + values[:-1]))))


def _integral_of_linear(t: Floats, values: Floats) -> Floats:
    """The integral of `_integral`, exact as well."""
    steps = np.diff(t)
    gained = steps * _integral(t, values)[:-1] + steps**2 * (2.0 * values[:-1] + values[1:]) / 6.0
    return np.concatenate(([0.0], np.cumsum(gained)))


GRAVITY = 9.80665
"""[m/s^2]"""

RIDEDOWN = 0.01
"""Width of the means after contact [s]."""

PLANAR = "planar: without vertical acceleration, roll and pitch a lower bound"
AXES = "planar; the vehicle's turning left out"
HEAD = "planar; head above the centre of mass, not in a seat"
LIMITS = "limits not given"


@dataclass(frozen=True)
class RiskMeasure:
    """A measure: value in its unit, None where the flight does not end; instant [s]; what it lacks; limits."""

    name: str
    value: float | None
    unit: str
    time: float | None
    lacks: str
    limits: str = LIMITS


def occupant_risk(motion: VehicleMotion) -> tuple[RiskMeasure, ...]:
    """All measures. ValueError for a motion sampled below 1800 Hz, or shorter than 77 ms (a period of 13 Hz)."""
    return (*severity_indices(motion), *head_measures(motion), *flail_measures(motion))


def severity_indices(motion: VehicleMotion) -> tuple[RiskMeasure, ...]:
    """ASI after both editions. Before first touch there is no acceleration."""
    interval = motion.interval
    both = (motion.ax, 12.0), (motion.ay, 9.0)
    axes = [np.concatenate(([0.0], a / (limit * GRAVITY))) for a, limit in both]
    means = [moving_mean(a, interval, 0.05) for a in axes]
    filtered = [low_pass(cfc_filter(a, interval, 180), interval, 13.0) for a in axes]
    return tuple(
        _largest(f"ASI {edition}", "-", PLANAR, motion.t, np.hypot(*found)[1:])
        for edition, found in (("1998, 50 ms mean", means), ("2010, 13 Hz", filtered))
    )


def head_measures(motion: VehicleMotion) -> tuple[RiskMeasure, RiskMeasure]:
    """THIV [m/s] and PHD [g]."""
    contact = head_contact(motion)
    time, speed = (contact.time, contact.speed) if contact else (None, None)
    resultant = np.hypot(motion.ax, motion.ay)
    return (RiskMeasure("THIV", speed, "m/s", time, HEAD), _after("PHD", HEAD, motion, contact, resultant))


def flail_measures(motion: VehicleMotion) -> tuple[RiskMeasure, ...]:
    """OIV [m/s] and ORA [g], each longitudinal and lateral, without sign."""
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
    """The largest 10 ms mean [g] that begins after the contact and ends within the history."""
    t, half = motion.t, 0.5 * RIDEDOWN
    means = np.abs(moving_mean(values, motion.interval, RIDEDOWN)) / GRAVITY
    later = np.zeros(t.size, bool) if contact is None else (t >= contact.time + half) & (t <= t[-1] - half)
    return _largest(name, "g", lacks, t[later], means[later])


def _largest(name: str, unit: str, lacks: str, t: Floats, values: Floats) -> RiskMeasure:
    if not values.size:
        return RiskMeasure(name, None, unit, None, lacks)
    place = int(values.argmax())
    return RiskMeasure(name, float(values[place]), unit, float(t[place]), lacks)
