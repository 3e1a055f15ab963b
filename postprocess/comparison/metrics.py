"""Metrics of a history against its reference.

Those of Sprague and Geers, and the residuals of an analysis of variance.

Inner products are taken over time by the trapezoidal rule, (f, g) = integral of f g dt, of a history f and its
reference g at common instants:

    magnitude      M = sqrt((f, f) / (g, g)) - 1, blind to phase
    phase          P = arccos((f, g) / sqrt((f, f) (g, g))) / pi, blind to magnitude
    combined       C = sqrt(M^2 + P^2)
    residuals      r = (f - g) / max |g|; their mean over time, and their standard deviation about it

Sources: Sprague and Geers, A spectral-element method for modelling cavitation in transient fluid-structure
interaction, Int. J. Numer. Meth. Engng 60 (2004); the integrals also in Schwer, Validation metrics for response
histories, Engineering with Computers 23 (2007). Residuals: Ray, Repeatability of full-scale crash tests and criteria
for validating simulation results, Transportation Research Record 1528 (1996), as in the program RSVVP of NCHRP
Web-Only Document 179. Limits: Ray, Mongiardini, Plaxico and Anghileri, NCHRP Web-Only Document 179 (2010): 40 % for
Sprague and Geers' metrics, 5 % and 35 % for the mean and the standard deviation of the residuals over the reference's
peak.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

LIMITS = {"magnitude": 0.40, "phase": 0.40, "combined": 0.40, "mean_residual": 0.05, "deviation": 0.35}
"""Customary limits of the sizes of the metrics."""

GAP, LEAST_GAP = 5.0, 0.05
"""Shortest gap between two values that is not interpolated.

It is relative to the median of such intervals, and to the duration of all values; both must be exceeded.
"""

COVERED = 0.5
"""Smallest part of the reference's duration that must be compared."""


@dataclass(frozen=True)
class Metrics:
    """Distances of a history from its reference.

    They are dimensionless, and 0 where both are equal.
    """

    magnitude: float
    phase: float
    combined: float
    mean_residual: float
    deviation: float

    @property
    def within(self) -> bool:
        """True if all are within their customary limits."""
        return all(abs(value) <= LIMITS[name] for name, value in vars(self).items())


def compare_histories(
    instants: Floats, history: Floats, reference: Floats, is_known: NDArray[np.bool_] | bool = True
) -> Metrics:
    """Return metrics of a history against its reference.

    Both have shape (instants,) and any common unit. Instants [s] rise, and need not be evenly spaced; is_known, shape
    (instants - 1,): intervals that count. Numbers that are not finite, less than two instants, and a reference that
    is zero throughout result in NaN; two histories that are zero throughout agree.
    """
    if instants.size < 2:
        return Metrics(*(5 * (math.nan,)))
    if not (history.any() or reference.any()):
        return Metrics(*(5 * (0.0,)))
    steps = np.diff(instants) * is_known
    weights = 0.5 * (np.append(steps, 0.0) + np.append(0.0, steps))  # [s], of the trapezoidal rule
    with np.errstate(all="ignore"):
        size, reference_size = _norm(weights, history), _norm(weights, reference)
        magnitude = float(size / reference_size - 1.0)
        phase = _angle(weights, history / size, reference / reference_size) / math.pi
        residual = (history - reference) / np.abs(reference).max(initial=0.0)
        mean = np.sum(weights * residual) / weights.sum()
        deviation = np.sqrt(np.sum(weights * (residual - mean) ** 2) / weights.sum())
    values = (magnitude, phase, math.hypot(magnitude, phase), float(mean), float(deviation))
    return Metrics(*(value if math.isfinite(value) else math.nan for value in values))


def weighted_metrics(channels: Sequence[Metrics], momenta: Sequence[float]) -> Metrics:
    """Return the mean metrics of several channels, weighted by momentum.

    After NCHRP Web-Only Document 179.

    Parameters
    ----------
    channels : sequence of Metrics
        Of each channel.
    momenta : sequence of float
        Of each channel, in one unit; weights are their fractions of the sum.

    Returns
    -------
    Metrics
        No sign: channels that differ in opposite directions do not cancel each other.
    """
    sizes = np.abs([list(vars(metrics).values()) for metrics in channels])
    return Metrics(*(float(mean) for mean in np.asarray(momenta) @ sizes / np.sum(momenta)))


def _norm(weights: Floats, values: Floats) -> np.float64:
    return np.sqrt(np.sum(weights * values**2))


def _angle(weights: Floats, unit: Floats, other: Floats) -> float:
    """Return the angle between two functions of norm 1 [rad].

    Unlike the arccosine, the form keeps its digits for small angles.
    """
    return 2.0 * math.atan2(_norm(weights, unit - other), _norm(weights, unit + other))


@dataclass(frozen=True)
class Beside:
    """Column compared with that of the reference, while both exist.

    Attributes
    ----------
    name : str
        Of the column.
    t, value, reference : ndarray, shape (instants,)
        Instants of both [s], and both histories there.
    metrics : Metrics
        Of the one against the other.
    covered : float
        Time compared over that of the reference [-].
    gaps : tuple of pairs
        Ends [s] of the times between that are not compared.
    """

    name: str
    t: Floats
    value: Floats
    reference: Floats
    metrics: Metrics
    covered: float = 1.0
    gaps: tuple[tuple[float, float], ...] = ()

    @property
    def difference(self) -> Floats:
        """Value minus reference."""
        return self.value - self.reference

    @property
    def largest(self) -> tuple[float, float]:
        """Largest difference over the reference's peak, and its instant [s]."""
        k = int(np.argmax(np.abs(self.difference)))
        return _relative(float(self.difference[k]), float(np.abs(self.reference).max())), float(self.t[k])

    @property
    def at_end(self) -> float:
        """Value over reference - 1 at the last common instant."""
        return _relative(float(self.difference[-1]), float(self.reference[-1]))

    @property
    def within(self) -> bool:
        """True if all metrics and the compared duration are within limits."""
        return self.metrics.within and self.covered >= COVERED


def _relative(difference: float, reference: float) -> float:
    """Return a relative difference.

    It is 0 for two zeros, and NaN for another difference from 0.
    """
    return difference / reference if reference else math.nan if difference else 0.0


def beside(name: str, history: Mapping[str, Floats], reference: Mapping[str, Floats]) -> Beside | None:
    """Compare two columns of this name at the instants of both.

    Columns "t" [s] rise. Values are interpolated; those that are not finite, and long gaps in either column, are
    excluded. The result is None with less than two common instants.
    """
    records = [_finite(columns["t"], columns[name]) for columns in (history, reference)]
    if min(t.size for t, _ in records) < 2:
        return None
    first, last = max(t[0] for t, _ in records), min(t[-1] for t, _ in records)
    within = [t[(t >= first) & (t <= last)] for t, _ in records]
    if min(t.size for t in within) < 2:
        return None
    gaps = [gap for t, _ in records for gap in _gaps(t) if gap[0] < last and gap[1] > first]
    t = np.union1d(*within)
    t = t[~_inside(t, gaps)]
    is_known = ~_inside(0.5 * (t[1:] + t[:-1]), gaps)
    compared = float(np.sum(np.diff(t)[is_known]))
    if not compared:
        return None
    value, expected = (np.interp(t, *record) for record in records)
    metrics = compare_histories(t, value, expected, is_known)
    covered = min(1.0, compared / float(reference["t"][-1] - reference["t"][0]))
    ends = tuple(sorted((max(begin, first), min(end, last)) for begin, end in gaps))
    return Beside(name, t, value, expected, metrics, covered, ends)


def _finite(t: Floats, values: Floats) -> tuple[Floats, Floats]:
    finite = np.isfinite(t) & np.isfinite(values)
    return t[finite], values[finite]


def _gaps(t: Floats) -> list[tuple[float, float]]:
    """Return the ends of the gaps between instants that are not interpolated."""
    steps = np.diff(t)
    is_gap = (steps > GAP * np.median(steps)) & (steps > LEAST_GAP * (t[-1] - t[0]))
    return [(float(t[k]), float(t[k + 1])) for k in np.flatnonzero(is_gap)]


def _inside(t: Floats, gaps: Sequence[tuple[float, float]]) -> NDArray[np.bool_]:
    """Return True at instants between the ends of a gap."""
    inside = np.zeros(t.shape, bool)
    for begin, end in gaps:
        inside |= (t > begin) & (t < end)
    return inside
