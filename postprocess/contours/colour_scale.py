"""Which range a picture's colours span, and how its tick labels are printed so that neighbours differ."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from postprocess.figures.svg.scale import round_step

STEPS = 7
"""Steps between labels, at most."""

UNIFORM, WIDENING = 1e-4, 1e-2
"""Variation, over a field's size, up to which it is drawn as uniform, and the range that it is then shown in."""


@dataclass(frozen=True)
class ColourScale:
    """Ends of the colour range, how many labels it has, their printf format, and whether the field is as good as
    uniform."""

    low: float
    high: float
    labels: int
    format: str
    uniform: bool

    @property
    def ticks(self) -> list[str]:
        """The tick labels, low to high, as they are printed."""
        return [self.text(float(value)) for value in np.linspace(self.low, self.high, self.labels)]

    @property
    def bands(self) -> int:
        """Number of colours: two between labels; one about the value of a uniform field."""
        return 5 if self.uniform else 2 * (self.labels - 1)

    def text(self, value: float) -> str:
        """The value as the tick labels print it, with a true minus, and without the sign of a zero."""
        text = self.format % value
        return text.replace("-", "−", 1) if float(text) else text.lstrip("-")


def colour_scale(values: NDArray[np.float64]) -> ColourScale:
    """The scale for nodal values of shape (n,), with labels at round values.

    A field that varies by less than 1e-4 of its size would make a drama of next to nothing. Its range is widened to
    1e-2 of its size about the mean (1e-2 of the unit for zero), so that it is drawn in one colour.
    """
    if not np.all(np.isfinite(values)):
        raise ValueError("a contour field has values that are not finite")
    low, high = float(np.min(values)), float(np.max(values))
    size = max(abs(low), abs(high))
    if high - low <= UNIFORM * size or size == 0.0:
        middle, half = 0.5 * (low + high), 0.5 * WIDENING * (size or 1.0)
        return ColourScale(
            middle - half, middle + half, 3, tick_format(middle - half, middle + half, 2), True
        )
    step = round_step(high - low, STEPS)
    first, last = math.floor(low / step + 1e-6), math.ceil(high / step - 1e-6)
    low, high, count = first * step, last * step, last - first
    return ColourScale(low, high, count + 1, tick_format(low, high, count), False)


def tick_format(low: float, high: float, steps: int) -> str:
    """Printf format that tells neighbouring labels apart and gives the largest value at least two digits."""
    size = max(abs(low), abs(high))
    decimals = max(-_exponent((high - low) / steps * (1.0 + 1e-9)), 1 - _exponent(size))
    if 1e-3 <= size < 1e6:
        return f"%.{max(decimals, 0)}f"
    return f"%.{decimals + _exponent(size)}e"


def _exponent(value: float) -> int:
    return math.floor(math.log10(value))
