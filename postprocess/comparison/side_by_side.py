"""A history beside a reference that was sampled at other instants: differences, and metrics of validation.

Limits: Ray, Mongiardini, Plaxico and Anghileri, NCHRP Web-Only Document 179 (2010): 40 % for Sprague and Geers'
metrics, 5 % and 35 % for the mean and the standard deviation of the residuals over the reference's peak.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from postprocess.comparison.metrics import Metrics, compare_histories

Floats = NDArray[np.float64]

LIMITS = Metrics(0.40, 0.40, 0.40, 0.05, 0.35)
"""Customary limits of the sizes of the metrics."""


@dataclass(frozen=True)
class Beside:
    """A column beside the reference's, while both are known.

    t, value, reference: common instants [s] and both histories there. metrics: of the one against the other.
    """

    name: str
    t: Floats
    value: Floats
    reference: Floats
    metrics: Metrics

    @property
    def difference(self) -> Floats:
        """Value less reference."""
        return self.value - self.reference

    @property
    def largest(self) -> tuple[float, float]:
        """The largest difference over the reference's peak, and when it is [s]."""
        k = int(np.argmax(np.abs(self.difference)))
        peak = float(np.abs(self.reference).max())
        return (float(self.difference[k]) / peak if peak else float("nan")), float(self.t[k])

    @property
    def at_end(self) -> float:
        """Value over reference - 1 at the last common instant."""
        last = float(self.reference[-1])
        return float(self.value[-1]) / last - 1.0 if last else float("nan")

    @property
    def within(self) -> bool:
        """Whether all metrics are within their customary limits."""
        limits = asdict(LIMITS)
        return all(abs(value) <= limits[name] for name, value in asdict(self.metrics).items())


def beside(name: str, history: Mapping[str, Floats], reference: Mapping[str, Floats]) -> Beside | None:
    """The column of this name at the reference's instants, interpolated; None where they have less than two in common.

    Columns "t" [s] rise; rows that are not finite are left out.
    """
    t, value = _finite(history["t"], history[name])
    at, expected = _finite(reference["t"], reference[name])
    if t.size < 2 or at.size < 2:
        return None
    common = (at >= t[0]) & (at <= t[-1])
    if common.sum() < 2:
        return None
    at, expected = at[common], expected[common]
    found = np.interp(at, t, value)
    return Beside(name, at, found, expected, compare_histories(at, found, expected))


def _finite(t: Floats, values: Floats) -> tuple[Floats, Floats]:
    known = np.isfinite(t) & np.isfinite(values)
    return t[known], values[known]
