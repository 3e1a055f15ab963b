"""Which range a picture's colours span, and how its tick labels are printed so that neighbours differ."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

BANDS = 12
LABELS = 7
DIGITS = 4
UNIFORM = 1e-9
WIDENING = 1e-3


@dataclass(frozen=True)
class ColourScale:
    """Ends of the colour range, printf format of the labels, and whether the field is uniform to rounding."""

    low: float
    high: float
    format: str
    uniform: bool

    @property
    def ticks(self) -> list[str]:
        """The tick labels, low to high, as they are printed."""
        return [self.text(float(value)) for value in np.linspace(self.low, self.high, LABELS)]

    @property
    def bands(self) -> int:
        """Number of colours; odd for a uniform field, whose value then lies inside a band."""
        return BANDS + 1 if self.uniform else BANDS

    def text(self, value: float) -> str:
        """The value as the tick labels print it, without the sign of a zero."""
        text = self.format % value
        return text if float(text) else text.lstrip("-")


def colour_scale(values: NDArray[np.float64]) -> ColourScale:
    """The scale for nodal values of shape (n,).

    A field that varies by less than 1e-9 of its size shows rounding, nothing else. Its range is widened to
    1e-3 of its size about the mean (1e-3 of the unit for zero), so that it is drawn in one colour.
    """
    if not np.all(np.isfinite(values)):
        raise ValueError("a contour field has values that are not finite")
    low, high = float(np.min(values)), float(np.max(values))
    size = max(abs(low), abs(high))
    uniform = high - low <= UNIFORM * size
    if uniform:
        middle, half = 0.5 * (low + high), 0.5 * WIDENING * (size or 1.0)
        low, high = middle - half, middle + half
    form = tick_format(low, high)
    low, high = (value if float(form % value) else 0.0 for value in (low, high))
    return ColourScale(low, high, form, uniform)


def tick_format(low: float, high: float) -> str:
    """Printf format that gives the step between ticks two digits and the largest value at least four."""
    size = max(abs(low), abs(high))
    step = (high - low) / (LABELS - 1)
    decimals = max(1 - _exponent(step), DIGITS - 1 - _exponent(size))
    if 1e-3 <= size < 1e6:
        return f"%.{max(decimals, 0)}f"
    return f"%.{decimals + _exponent(size)}e"


def _exponent(value: float) -> int:
    return math.floor(math.log10(value))
