"""Peaks of a force history by the filters in use, and how long its second strike lasts.

The duration follows Chuong and Malla (2025), section 3: on a curve of force over time the second sharp peak is the
tail-slap; it begins and ends where the force is lowest just before its rise and just after its decline. They read it by
eye, off 50 ms means and SAE-filtered curves; here, a valley is the first bottom on the way down that lies no more than
5 % of the peak above the lowest force between this strike and the next. A mean over w widens a strike that stands
free by w.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from postprocess.signals.filters import cfc_filter, cutoff_60hz, moving_mean

Floats = NDArray[np.float64]

PROMINENCE = 0.25
"""How far a peak must stand above the valleys beside it, over the largest value of the curve, to count as a strike."""

LOWEST = 0.05
"""How far above the lowest force a valley may lie, over the peak: undershoot of filters elsewhere is no valley."""


FILTERS: Mapping[str, Callable[[Floats, float], Floats]] = {
    "raw": lambda force, interval: force,
    "mean_50ms": lambda force, interval: moving_mean(force, interval, 0.05),
    "cfc60": lambda force, interval: cfc_filter(force, interval, 60),
    "cfc180": lambda force, interval: cfc_filter(force, interval, 180),
    "cutoff_60hz": cutoff_60hz,
}
"""Of a force [N] with this interval [s]."""


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
    """How many samples after its first, the peak, the force has its first low bottom."""
    low = int(np.argmax(falling <= falling.min() + LOWEST * falling[0]))
    rising = np.diff(falling[low:]) >= 0.0
    return low + (int(np.argmax(rising)) if rising.any() else rising.size)
