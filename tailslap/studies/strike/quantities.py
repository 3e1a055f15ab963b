"""What the study measures of an impact: of each of its first two strikes peaks, impulse and duration."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from postprocess.signals.peaks import force_curves

Array = NDArray[np.float64]

STRIKES = (1, 2)
PEAKS = {"raw": "raw", "mean_50ms": "50 ms mean", "cfc60": "CFC 60"}
"""Peaks of a strike: of its corner's force; of the total force on the wall, filtered, in the strike."""


WINDOW = 0.05
"""Of the mean [s]."""


@dataclass(frozen=True)
class Quantity:
    """A measured quantity of a strike: name, words, the unit it is shown in and what of SI makes one of that."""

    name: str
    label: str
    unit: str
    scale: float


QUANTITIES = (
    *(Quantity(name, label, "kN", 1e3) for name, label in PEAKS.items()),
    Quantity("impulse", "impulse", "kN s", 1e3),
    Quantity("duration", "duration", "ms", 1e-3),
)


def column(strike: int, name: str) -> str:
    """Name of a strike's quantity in tables and files."""
    return f"strike_{strike}.{name}"


COLUMNS = tuple(column(strike, quantity.name) for strike in STRIKES for quantity in QUANTITIES)


def filtered(force: Array, interval: float) -> dict[str, Array]:
    """The force by the filters, shape (rows,) each."""
    return force_curves(force, interval, ("mean_50ms", "cfc60"))


def peaks_within(curves: dict[str, Array], interval: float, start: float, end: float) -> dict[str, float]:
    """The largest values of the filtered curves in a strike from start to end [s]; NaN where these are no instants.

    Of the means over 50 ms those that lie in the strike, or over its middle where it is shorter: the next strike may
    follow at once.
    """
    if not np.isfinite(start + end):
        return dict.fromkeys(curves, float("nan"))
    half = min(0.5 * WINDOW, 0.5 * (end - start))
    inside = {"mean_50ms": (start + half, end - half), "cfc60": (start, end)}
    return {name: _largest(values, interval, *inside[name]) for name, values in curves.items()}


def _largest(values: Array, interval: float, start: float, end: float) -> float:
    first = int(start / interval)
    return float(values[first : max(first + 1, int(np.ceil(end / interval)))].max())
