"""Filters of crash-test practice.

Low-pass filters, by frequency class (CFC) or cut-off frequency, are Butterworth filters of second order, applied
forward and backward, so nothing is delayed. With w_a the tangent at the corner of one pass, their gain is 1 / (1 +
(tan(pi f T) / w_a)^4). Both ends are padded with the end values, for 10 ms and at least three periods of the cut-off
frequency, in which the filter settles: the result is that of a signal with constant continuation, and constants
remain unchanged. The mean is centred, and does not extend beyond the end. Values are uniform samples, each the mean
over its interval T; sample i belongs to the instant (i + 1/2) T. They have the shape (n,), or (histories, n) for
several histories at once.

Sources: SAE J211-1, Instrumentation for impact test; its class CFC is 3 dB down at CFC / 0.6. Sample rate of at least
ten times the class, six times the cut-off frequency: documentation of the CFC filter of FlexPro.
"""

import math
from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from postprocess.signals.compiled_filters import low_pass_of_all, means_of_all

Floats = NDArray[np.float64]

CLASSES = (60, 180, 600, 1000)
PAD = 0.01
"""Shortest padding of each end [s]."""

PERIODS = 3.0
SAMPLES_A_PERIOD = 6.0

FILTERS: Mapping[str, Callable[[Floats, float], Floats]] = {
    "raw": lambda force, interval: force,
    "mean_10ms": lambda force, interval: moving_mean(force, interval, 0.01),
    "mean_50ms": lambda force, interval: moving_mean(force, interval, 0.05),
    "cfc60": lambda force, interval: cfc_filter(force, interval, 60),
    "cfc180": lambda force, interval: cfc_filter(force, interval, 180),
    "cutoff_60hz": lambda force, interval: low_pass(force, interval, 60.0),
}
"""Filters of a force [N] with this interval [s].

A "SAE filter, 60 Hz cut-off" is `low_pass` at 60 Hz, whereas CFC 60 is 3 dB down at 100 Hz.
"""

LABELS = {
    "raw": "raw",
    "mean_10ms": "10 ms mean",
    "mean_50ms": "50 ms mean",
    "cfc60": "CFC 60",
    "cfc180": "CFC 180",
    "cutoff_60hz": "60 Hz cut-off",
}
"""Names of the filtered forces in tables and charts."""


class LowPass(NamedTuple):
    """Low-pass filter, whose w_a is tan(rate T) / divisor.

    cutoff: frequency [Hz] at which it is 3 dB down; rate [1/s].
    """

    cutoff: float
    rate: float
    divisor: float


def of_class(frequency_class: int) -> LowPass:
    """Return the filter of a channel frequency class."""
    return LowPass(frequency_class / 0.6, math.pi * frequency_class * 2.0775, 1.0)


def of_cutoff(cutoff: float) -> LowPass:
    """Return the filter of a cut-off frequency [Hz]."""
    return LowPass(cutoff, math.pi * cutoff, (math.sqrt(2.0) - 1.0) ** 0.25)


LOW_PASSES = {"cfc60": of_class(60), "cfc180": of_class(180), "cutoff_60hz": of_cutoff(60.0)}
"""Low-pass filters of forces."""


def cfc_filter(values: Floats, interval: float, frequency_class: int) -> Floats:
    """Filter values by a channel frequency class.

    The filter is 3 dB down at class / 0.6. values: any unit; interval: T [s]; class: 60, 180, 600 or 1000. ValueError
    for another class, too long an interval or too short a history.
    """
    if frequency_class not in CLASSES:
        raise ValueError(f"frequency class {frequency_class}: must be one of {', '.join(map(str, CLASSES))}")
    return _both_ways(values, interval, of_class(frequency_class))


def low_pass(values: Floats, interval: float, cutoff: float) -> Floats:
    """Filter values by a cut-off frequency [Hz].

    The gain of both passes together is there 1 / sqrt 2. values: any unit; interval: T [s]. ValueError as for
    `cfc_filter`.
    """
    return _both_ways(values, interval, of_cutoff(cutoff))


def moving_mean(values: Floats, interval: float, width: float) -> Floats:
    """Return the centred mean over `width` [s] at each sample.

    Before the start the first value is continued, and near the end the last mean that does not extend beyond it.
    values: any unit; interval: T [s]. The cumulated integral is interpolated, so any width is possible. ValueError if
    the history is shorter than the width.
    """
    check_samples(values, interval, width)
    rows = _rows(values)
    means = np.empty_like(rows)
    means_of_all(rows, 0.5 * width / interval, np.empty(rows.shape[1] + 1), means)
    return means.reshape(values.shape)


def _rows(values: Floats) -> Floats:
    """Return histories as rows, shape (histories, n)."""
    return np.ascontiguousarray(values, dtype=np.float64).reshape(-1, values.shape[-1])


def check_samples(values: Floats, interval: float, shortest: float, cutoff: float = 0.0) -> None:
    """Raise ValueError unless samples suffice for a filter.

    They must be finite, last `shortest` [s], and be frequent enough for the cut-off frequency [Hz].
    """
    if values.ndim not in (1, 2) or not np.isfinite(values).all():
        raise ValueError(f"values of shape {values.shape}: must be finite numbers in one or two dimensions")
    if not (0.0 < interval < math.inf and interval * SAMPLES_A_PERIOD * cutoff <= 1.0 + 1e-9):
        limit = 1.0 / (SAMPLES_A_PERIOD * cutoff) if cutoff else math.inf
        longest = f", at most {limit:.4g} s for a cut-off at {cutoff:.4g} Hz" if cutoff else ""
        raise ValueError(f"sample interval {interval:g} s: must be positive{longest}")
    if (duration := values.shape[-1] * interval) < shortest * (1.0 - 1e-9):
        raise ValueError(f"history of {duration:.4g} s: must last at least {shortest:.4g} s")


def settling_samples(cutoff: float, interval: float) -> int:
    """Return the samples in which a filter of this cut-off [Hz] settles."""
    return int(np.ceil(max(PAD, PERIODS / cutoff) / interval))


def _both_ways(values: Floats, interval: float, filter_: LowPass) -> Floats:
    """Filter forward and backward, from steady states."""
    check_samples(values, interval, 1.0 / filter_.cutoff, filter_.cutoff)
    rows, padding = _rows(values), settling_samples(filter_.cutoff, interval)
    corner, filtered = math.tan(filter_.rate * interval) / filter_.divisor, np.empty_like(rows)
    low_pass_of_all(rows, padding, corner, np.empty(rows.shape[1] + 2 * padding), filtered)
    return filtered.reshape(values.shape)


def force_curves(force: Floats, interval: float, names: Iterable[str] = tuple(FILTERS)) -> dict[str, Floats]:
    """Return the force [N] after each filter.

    force: each sample the mean over its interval [s]. It starts at first touch, and is zero before. If it ends during a
    strike, the part of a filtered curve that later forces would change repeats its last valid value. names: of
    `FILTERS`, which are those of `summary.json`. ValueError for samples too rare for CFC 180 (1800 Hz), and for a
    history shorter than 50 ms.
    """
    touched = np.concatenate((np.zeros_like(force[..., :1]), force), axis=-1)
    curves = {name: FILTERS[name](touched, interval)[..., 1:] for name in names}
    is_cut = force[..., -1:] != 0.0
    for name in LOW_PASSES.keys() & curves.keys() if is_cut.any() else ():
        last = max(0, force.shape[-1] - 1 - settling_samples(LOW_PASSES[name].cutoff, interval))
        curve = curves[name][..., last:]
        curve[...] = np.where(is_cut, curve[..., :1], curve)
    return curves


def force_peaks(curves: Mapping[str, Floats]) -> dict[str, float]:
    """Return the maxima of the curves by name."""
    return {name: float(values.max()) for name, values in curves.items()}
