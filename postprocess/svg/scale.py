"""Scales of a plot's axes: from values to places, and ticks at round values."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
SMALLEST, LARGEST = 1e-4, 1e6
"""Values of a linear axis outside these are written as powers of ten."""


@dataclass(frozen=True)
class Scale:
    """Values from `low` to `high` on places from `start` to `end`; is_log: by their logarithms, low > 0."""

    low: float
    high: float
    start: float = 0.0
    end: float = 1.0
    is_log: bool = False

    def at(self, values: ArrayLike) -> Any:
        """Places of values, of their shape."""
        low, high, given = (self._measure(each) for each in (self.low, self.high, values))
        return self.start + (given - low) * ((self.end - self.start) / (high - low))

    def _measure(self, values: ArrayLike) -> Floats:
        given = np.asarray(values, float)
        return np.log10(given) if self.is_log else given

    def ticks(self, most: int) -> list[float]:
        """Round values in range, about `most`; of a logarithmic axis powers of ten, between few also 2 and 5."""
        find = log_ticks if self.is_log else round_ticks
        low, high = sorted((self.low, self.high))
        tried = (find(low, high, most + more) for more in range(4))
        return next((ticks for ticks in tried if len(ticks) > 1), find(low, high, most))


def round_step(span: float, most: int) -> float:
    """The smallest of 1, 2 and 5 times a power of ten that parts a span into at most `most` steps."""
    size = 10.0 ** math.floor(math.log10(span / most))
    return next(
        factor * size for factor in (1.0, 2.0, 5.0, 10.0) if span / (factor * size) <= most * (1.0 + 1e-9)
    )


def round_ticks(low: float, high: float, most: int) -> list[float]:
    """Multiples of a round step between low and high."""
    step = round_step(high - low, most)
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return [float(f"{number * step:.12g}") for number in range(first, last + 1)]


def log_ticks(low: float, high: float, most: int) -> list[float]:
    """Powers of ten between low and high; with 2 and 5 times these where that is not too many, or leaves one; else
    round values."""
    first, last = math.floor(math.log10(low) + 1e-9), math.ceil(math.log10(high) - 1e-9)
    every = max(1, math.ceil((last - first) / most))
    tens = [10.0**power for power in range(first // every * every, last + 1, every)]
    more = [factor * ten for ten in tens for factor in (1.0, 2.0, 5.0)]
    for found in [more] if 3 * (last - first) <= most else [tens, more]:
        inside = [value for value in found if low * (1.0 - 1e-9) <= value <= high * (1.0 + 1e-9)]
        if len(inside) > 1:
            return inside
    return round_ticks(low, high, most)


def tick_texts(ticks: list[float], is_log: bool = False) -> list[str]:
    """Ticks as people read them: alike in decimals, with a true minus, and powers of ten as such."""
    sizes = [abs(tick) for tick in ticks if tick]
    if is_log or (sizes and (max(sizes) >= LARGEST or max(sizes) < SMALLEST)):
        return [power_text(tick) for tick in ticks]
    step = min((b - a for a, b in pairwise(ticks)), default=max(sizes, default=1.0))
    decimals = max(0, -math.floor(math.log10(step) + 1e-9))
    return [f"{tick:.{decimals}f}".replace("-", "−") for tick in ticks]


def power_text(value: float) -> str:
    """A value with a power of ten: 10⁻³, 2×10⁵; plain between a thousandth and a thousand."""
    if value == 0.0 or SMALLEST * 9.99 < abs(value) < 1e4:
        return f"{value:g}".replace("-", "−")
    digits, power = f"{value:.3g}".split("e") if "e" in f"{value:.3g}" else f"{value:.2e}".split("e")
    factor = f"{float(digits):g}".replace("-", "−")
    ten = "10" + str(int(power)).translate(SUPERSCRIPTS)
    return ten if factor == "1" else f"−{ten}" if factor == "−1" else f"{factor}×{ten}"


def fitted(low: float, high: float, margin: float = 0.05, is_log: bool = False) -> tuple[float, float]:
    """A range a little wider than that of the values; one of a single value is widened about it."""
    if not (math.isfinite(low) and math.isfinite(high)):
        return (0.1, 1.0) if is_log else (0.0, 1.0)
    if is_log:
        more = max((high / low) ** margin, 1.1)
        return low / more, high * more
    size = max(abs(low), abs(high))
    more = margin * (high - low) if high - low > 1e-9 * size else 0.1 * size or 1.0
    return low - more, high + more
