"""Duration of the second strike on a curve of force.

After Chuong and Malla (2025), section 3: the second sharp peak is the tail-slap; it begins and ends where the force
is lowest just before its rise and just after its decline. They read it by eye from 50 ms means and SAE-filtered
curves. Here, a valley is the first minimum beside the peak that lies no more than 5 % of the peak above the lowest
force between this strike and the next. A mean over w widens an isolated strike by w.
"""

from dataclasses import dataclass

import numpy as np

from postprocess.signals.filters import Floats

PROMINENCE = 0.25
"""Smallest height of a strike's peak above the valleys beside it, over the largest value."""

LOWEST = 0.05
"""Largest height of a valley above the lowest force, over the peak, which excludes undershoot of filters."""


@dataclass(frozen=True)
class StrikeDuration:
    """Strike from valley to valley.

    Instants [s], peak [N], impulse [N s].
    """

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
        """Duration of the equal triangular pulse [s].

        Impulse and peak are equal, and it is 2 J / F.
        """
        return 2.0 * self.impulse / self.peak


def second_strike(curve: Floats, interval: float) -> StrikeDuration:
    """Return the second strike of a filtered force, by the paper's rule.

    curve: of `force_curves` [N], shape (n,), positive where the vehicle presses; interval [s]. ValueError without a
    second peak.
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
    """Return alternating valleys and peaks, from a valley.

    Values between two of them differ by at least `change`, which is the least prominence of the peaks.
    """
    places, at, sign = list[int](), 0, -1.0
    while change > 0.0:
        rest = sign * values[at:]
        turned = np.maximum.accumulate(rest) - rest >= change
        if not turned.any():
            break
        later = int(np.argmax(turned))
        places.append(at + int(np.argmax(rest[:later])))
        at, sign = at + later, -sign
    return places


def _valley(falling: Floats) -> int:
    """Return samples from a peak to its valley.

    falling: force from the peak on.
    """
    low = int(np.argmax(falling <= falling.min() + LOWEST * falling[0]))
    rising = np.diff(falling[low:]) >= 0.0
    return low + (int(np.argmax(rising)) if rising.any() else rising.size)
