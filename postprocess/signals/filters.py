"""Filters of crash practice, what is read off a filtered force, and design forces of railings.

Low-passes, by frequency class (CFC) or cut-off frequency, are Butterworth filters of second order, once forward and
once backward, so nothing is delayed. With w_a the tangent at the corner of one pass, their gain is 1 / (1 + (tan(pi f
T) / w_a)^4). Both ends are padded by the end values, for 10 ms and at least three periods of the cut-off frequency:
long enough for the filter to settle, so that the result is that of a signal which holds its end values for ever, and a
constant stays as it is. The mean is centred, and does not reach beyond the end. Values are uniform samples, each the
mean over its interval T; sample i stands for the instant (i + 1/2) T.

Sources: SAE J211-1, Instrumentation for impact test; its class CFC is 3 dB down at CFC / 0.6. Sample rate of at least
ten times the class, six times the cut-off frequency: as FlexPro's documentation of its CFC filter has it.

The duration follows Chuong and Malla (2025), section 3: on a curve of force over time the second sharp peak is the
tail-slap; it begins and ends where the force is lowest just before its rise and just after its decline. They read it by
eye, off 50 ms means and SAE-filtered curves; here, a valley is the first bottom on the way down that lies no more than
5 % of the peak above the lowest force between this strike and the next. A mean over w widens a strike that stands
free by w.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from postprocess.units import FOOT, KIP

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


def moving_mean(values: Floats, interval: float, width: float) -> Floats:
    """Return the centred mean over `width` [s] at the instant of each sample.

    Before the start the first value holds, and near the end the last mean that does not reach beyond it.

    values: shape (n,), any unit; interval: T [s]. From the cumulated integral, interpolated: any width will do.
    ValueError if the history is shorter than the width.
    """
    check_samples(values, interval, width)
    added = math.ceil(0.5 * width / interval) + 1
    held = np.pad(values, added, mode="edge")
    edges = interval * (np.arange(held.size + 1) - added)
    integral = np.concatenate(([0.0], np.cumsum(held))) * interval
    centres = interval * np.minimum(np.arange(values.size) + 0.5, values.size - 0.5 * width / interval)
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


def settling_rows(cutoff: float, interval: float) -> int:
    """Samples in which a filter of this cut-off frequency [Hz] settles."""
    return math.ceil(max(PAD, PERIODS / cutoff) / interval)


def _both_ways(values: Floats, interval: float, cutoff: float, corner: float) -> Floats:
    """Forward and backward through the second-order filter with this w_a, from the steady state at both ends."""
    from scipy.linalg.blas import dtbsv  # scipy.signal takes longer to import than a run to compute

    added = settling_rows(cutoff, interval)
    held = np.pad(values, added, mode="edge")
    entering, leaving = _coefficients(corner)
    band = np.tile(leaving[:, None], held.size)
    for _ in ("forward", "backward"):
        change = np.convolve(held - held[0], entering)[: held.size]
        held = (held[0] + dtbsv(leaving.size - 1, band, change, lower=1))[::-1]
    return np.asarray(held[added:-added])


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
    "cutoff_60hz": lambda force, interval: low_pass(force, interval, 60.0),
}
"""Curves of a force [N] with this interval [s]. "SAE filter, 60 Hz cut-off" says `low_pass` at 60 Hz: CFC 60 is 3 dB
down at 100 Hz."""

CUTOFFS = {"cfc60": 100.0, "cfc180": 300.0, "cutoff_60hz": 60.0}
"""Cut-off frequencies of these curves [Hz]."""


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

    force: shape (n,), each sample the mean over its interval [s]. It starts at first touch: before there is none. Where
    it ends in a strike, what later forces would change of a filter's curve is replaced by the last value before.
    names: of `FILTERS`.
    ValueError for samples too rare for CFC 180 (1800 Hz), and for a history shorter than 50 ms.
    """
    touched = np.concatenate(([0.0], force))
    curves = {name: FILTERS[name](touched, interval)[1:] for name in names}
    for name in CUTOFFS.keys() & curves.keys() if touched[-1] != 0.0 else ():
        last = max(0, force.size - 1 - settling_rows(CUTOFFS[name], interval))
        curves[name][last:] = curves[name][last]
    return curves


def force_peaks(curves: Mapping[str, Floats]) -> dict[str, float]:
    """The largest value of each curve, by its name."""
    return {name: float(values.max()) for name, values in curves.items()}


def second_strike(curve: Floats, interval: float) -> StrikeDuration:
    """The second strike of a curve of `force_curves`, by the paper's rule. ValueError if it has no second peak.

    curve: force on the wall [N], shape (n,), pressing positive; interval [s].
    """
    ends = np.concatenate(([0.0], curve, [0.0]))
    peaks = [place - 1 for place in _turning_points(ends, PROMINENCE * ends.max())[1::2]]
    if len(peaks) < 2:
        raise ValueError(f"a curve with {len(peaks)} peaks has no second strike: must have at least 2")
    first, second, last = (int(place) for place in (*peaks, curve.size - 1)[:3])
    start = second - _valley(curve[first : second + 1][::-1])
    end = second + _valley(curve[second : last + 1])
    return StrikeDuration(
        start=(start + 0.5) * interval,
        end=(end + 0.5) * interval,
        peak=float(curve[second]),
        impulse=float(0.5 * interval * np.sum(curve[start:end] + curve[start + 1 : end + 1])),
    )


def _turning_points(values: Floats, change: float) -> list[int]:
    """Valleys and peaks in turn, from a valley, between which values change by at least so much, if it is positive: the
    peaks have at least this prominence."""
    found, at, sign = list[int](), 0, -1.0
    while change > 0.0:
        rest = sign * values[at:]
        turned = np.maximum.accumulate(rest) - rest >= change
        if not turned.any():
            break
        later = int(np.argmax(turned))
        found.append(at + int(np.argmax(rest[:later])))
        at, sign = at + later, -sign
    return found


def _valley(falling: Floats) -> int:
    """Samples from the first one, the peak, to the first low bottom of the force."""
    low = int(np.argmax(falling <= falling.min() + LOWEST * falling[0]))
    rising = np.diff(falling[low:]) >= 0.0
    return low + (int(np.argmax(rising)) if rising.any() else rising.size)


@dataclass(frozen=True)
class DesignForce:
    """A transverse force on a railing [kip], as given, and its source.

    longitudinal: force along the rail [kip]; length: of rail over which both are spread [ft]; None: not given.
    """

    name: str
    kip: float
    source: str
    longitudinal: float | None = None
    length: float | None = None

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


AASHTO = "AASHTO LRFD Bridge Design Specifications, Table A13.2-1; later editions not checked"
LRFD = {
    "TL-1": (13.5, 4.5, 4.0),
    "TL-2": (27.0, 9.0, 4.0),
    "TL-3": (54.0, 18.0, 4.0),
    "TL-4": (54.0, 18.0, 3.5),
    "TL-5": (124.0, 41.0, 8.0),
    "TL-6": (175.0, 58.0, 8.0),
}
"""AASHTO's transverse and longitudinal forces [kip], and their length [ft], by test level."""

TTI = (
    "Sheikh, Bligh and Menges, Determination of minimum height and lateral design load for MASH test level 4 "
    "bridge rails, Texas Transportation Institute, Report 9-1002-5 (2011)"
)
MASH_TL_4 = (
    DesignForce("MASH, TTI", 80.0, TTI),  # for rails of 36 in. or higher
    DesignForce("MASH, 4.5 g", 22.05 * 4.5, "NCHRP Web-Only Document 326, Eq. 3-4: 22 050 lb times 4.5 g"),
)
UNCONFIRMED = "attributed to NCHRP Project 22-20(2); not verified against the project report"
TALLER = {
    "TL-4": MASH_TL_4,
    "TL-5": (
        DesignForce("42 in wall", 160.0, UNCONFIRMED),
        DesignForce("Manitoba, 1250 mm wall", 845e3 / KIP, "Design of the Manitoba tall wall, tac-atc.ca"),
        DesignForce("taller wall", 262.0, UNCONFIRMED),
    ),
    "TL-6": (
        DesignForce("MwRSF, 62 in wall", 300.0, "MASH TL-6 evaluation, rosap.ntl.bts.gov/view/dot/77847"),
    ),
}
"""Forces beside AASHTO's, by test level."""


def design_forces(test_level: str) -> Sequence[DesignForce]:
    """Forces for "TL-1" to "TL-6", AASHTO's first. ValueError for another level."""
    if test_level not in LRFD:
        raise ValueError(f"test level {test_level!r}: must be one of {', '.join(LRFD)}")
    transverse, *along = LRFD[test_level]
    first = DesignForce("AASHTO LRFD", transverse, AASHTO, *along)
    return (first, *TALLER.get(test_level, ()))
