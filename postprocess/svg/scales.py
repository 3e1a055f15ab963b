"""Scales of axes with ticks at round values, and scales of colours.

A scale maps values to places along an axis, or to colours of the map viridis.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from postprocess.units import SUPERSCRIPTS, measure

Floats = NDArray[np.float64]
Range = tuple[float, float]

NOTHING: Range = (np.inf, -np.inf)
"""Range of no values."""

SMALLEST, LARGEST = 1e-4, 1e6
"""Linear axes write values outside these limits as powers of ten."""

KNOTS = """
    440154 46075a 470d60 471365 48186a 481d6f 482374 482878 472d7b 46327e 453781 443b84 424086
    404588 3e4989 3d4e8a 3b528b 39568c 375b8d 355f8d 33638d 31678e 2f6b8e 2e6f8e 2c728e 2a768e
    297a8e 277e8e 26828e 25858e 23898e 228d8d 21918c 1f948c 1f988b 1e9c89 1fa088 20a386 22a785
    25ab82 28ae80 2db27d 32b67a 38b977 3fbc73 46c06f 4ec36b 56c667 5ec962 67cc5c 70cf57 7ad151
    84d44b 8ed645 98d83e a2da37 addc30 b8de29 c2df23 cde11d d8e219 e2e418 ece51b f6e620 fde725
"""
"""Every fourth of the 256 colours of viridis, and the last.

Source: van der Walt and Smith (2015), dedicated to the public domain.
"""

COUNT = 65
"""Colours of a scale."""

UNIFORM = 1e-3
"""Smallest range of a scale of colours, over the size of the values; a smaller one would exaggerate differences."""


def extent(values: Floats) -> Range:
    """Return the smallest and largest finite value.

    It is `NOTHING` without any.
    """
    finite = values[np.isfinite(values)]
    return (float(finite.min()), float(finite.max())) if finite.size else NOTHING


def even_rows(t: Floats, most: int) -> NDArray[np.intp]:
    """Return at most so many rows at even steps with both ends."""
    return np.unique(np.linspace(0, len(t) - 1, most).astype(int))


@dataclass(frozen=True)
class Scale:
    """Map from values to places.

    Values lie between `low` and `high`, places between `start` and `end`. A logarithmic scale, is_log, requires low >
    0.
    """

    low: float
    high: float
    start: float = 0.0
    end: float = 1.0
    is_log: bool = False

    def at(self, values: ArrayLike) -> Floats:
        """Return the places of values."""
        low, high, sizes = (self._measure(end) for end in (self.low, self.high, values))
        return self.start + (sizes - low) * ((self.end - self.start) / (high - low))

    def _measure(self, values: ArrayLike) -> Floats:
        numbers = np.asarray(values, float)
        return np.log10(numbers) if self.is_log else numbers

    def ticks(self, most: int) -> list[float]:
        """Return about `most` round values within the range.

        On a logarithmic axis they are powers of ten, and 2 and 5 times these where there are few.
        """
        find = log_ticks if self.is_log else round_ticks
        low, high = sorted((self.low, self.high))
        tried = (find(low, high, most + more) for more in range(4))
        return next((ticks for ticks in tried if len(ticks) > 1), find(low, high, most))


def round_step(span: float, most: int) -> float:
    """Return the smallest round step of a scale.

    It divides the span into at most `most` steps, and is 1, 2 or 5 times a power of ten.
    """
    size = 10.0 ** math.floor(math.log10(span / most))
    return next(
        factor * size for factor in (1.0, 2.0, 5.0, 10.0) if span / (factor * size) <= most * (1.0 + 1e-9)
    )


def round_ticks(low: float, high: float, most: int) -> list[float]:
    """Return the multiples of a round step between low and high."""
    step = round_step(high - low, most)
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return [float(f"{number * step:.12g}") for number in range(first, last + 1)]


def log_ticks(low: float, high: float, most: int) -> list[float]:
    """Return powers of ten between low and high.

    Values of 2 and 5 times these are added where they are not too many, or a single power lies in the range. Ranges
    without two of all these have ticks at round steps.
    """
    first, last = math.floor(math.log10(low) + 1e-9), math.ceil(math.log10(high) - 1e-9)
    stride = max(1, math.ceil((last - first) / most))
    powers = [10.0**power for power in range(first // stride * stride, last + 1, stride)]
    multiples = [factor * ten for ten in powers for factor in (1.0, 2.0, 5.0)]
    for candidates in [multiples] if 3 * (last - first) <= most else [powers, multiples]:
        inside = [value for value in candidates if low * (1.0 - 1e-9) <= value <= high * (1.0 + 1e-9)]
        if len(inside) > 1:
            return inside
    return round_ticks(low, high, most)


def tick_texts(ticks: list[float], is_log: bool = False) -> list[str]:
    """Format ticks with equal decimals.

    The minus sign is a true one; very large and very small ticks are powers of ten.
    """
    sizes = [abs(tick) for tick in ticks if tick]
    if is_log or (sizes and (max(sizes) >= LARGEST or max(sizes) < SMALLEST)):
        return [power_text(tick) for tick in ticks]
    step = min((b - a for a, b in pairwise(ticks)), default=max(sizes, default=1.0))
    decimals = max(0, -math.floor(math.log10(step) + 1e-9))
    return [f"{tick:.{decimals}f}".replace("-", "−") for tick in ticks]


def power_text(value: float) -> str:
    """Format a value as a power of ten, like 10⁻³ or 2×10⁵.

    Values from a thousandth to ten thousand are written plainly.
    """
    if value == 0.0 or not math.isfinite(value) or SMALLEST * 9.99 < abs(value) < 1e4:
        return f"{value:g}".replace("-", "−")
    digits, power = f"{value:.3g}".split("e") if "e" in f"{value:.3g}" else f"{value:.2e}".split("e")
    factor = f"{float(digits):g}".replace("-", "−")
    ten = "10" + str(int(power)).translate(SUPERSCRIPTS)
    return ten if factor == "1" else f"−{ten}" if factor == "−1" else f"{factor}×{ten}"


def fitted(low: float, high: float, margin: float = 0.05, is_log: bool = False) -> tuple[float, float]:
    """Return a range slightly wider than the values.

    A single value is widened on both sides.
    """
    if not (math.isfinite(low) and math.isfinite(high)):
        return (0.1, 1.0) if is_log else (0.0, 1.0)
    if is_log:
        added = max((high / low) ** margin, 1.1)
        return low / added, high * added
    size = max(abs(low), abs(high))
    added = margin * (high - low) if high - low > 1e-9 * size else 0.1 * size or 1.0
    return low - added, high + added


def viridis(count: int) -> Floats:
    """Return equally spaced colours of viridis.

    Shape (count, 3): red, green and blue from 0 to 1.
    """
    knots = np.array([[int(knot[i : i + 2], 16) for i in (0, 2, 4)] for knot in KNOTS.split()]) / 255.0
    numbers = np.minimum(4 * np.arange(len(knots)), 255)
    places = np.minimum(np.floor(256.0 * np.linspace(0.0, 1.0, count)), 255.0)
    return np.column_stack([np.interp(places, numbers, part) for part in knots.T])


@dataclass(frozen=True)
class Shades:
    """Colours of values between two ends, with is_log by their logarithms."""

    low: float
    high: float
    is_log: bool = False

    @classmethod
    def of(cls, values: Floats, is_log: bool = False) -> Shades:
        """Return the shades of values.

        At least one must be finite.
        """
        low, high = extent(values)
        if is_log:
            return cls(low, high if high > low else 10.0 * low, True)
        added = 0.5 * max(0.0, UNIFORM * max(abs(low), abs(high), 1e-300) - (high - low))
        return cls(low - added, high + added)

    def colours(self, values: Floats) -> list[str]:
        """Return the colours of finite values as "#rrggbb"."""
        fraction = np.clip(Scale(self.low, self.high, 0.0, 1.0, self.is_log).at(values), 0.0, 1.0)
        table = [f"#{bytes(colour).hex()}" for colour in np.rint(255.0 * viridis(COUNT)).astype(np.uint8)]
        return [table[number] for number in np.rint((COUNT - 1) * fraction).astype(int)]

    def keys(self, unit: str) -> list[tuple[str, str]]:
        """Return round values and colours for the legend."""
        ticks = Scale(self.low, self.high, is_log=self.is_log).ticks(6)
        texts = [measure(tick, unit, "g") for tick in ticks] if unit else tick_texts(ticks, self.is_log)
        return list(zip(texts, self.colours(np.array(ticks)), strict=True))


def cells_about(values: Floats, is_log: bool) -> Floats:
    """Return the ends of cells about values.

    values: shape (n,), at least two of them different; ends: shape (n, 2). A cell ends midway between neighbours,
    with is_log at their geometric mean. No cell extends below zero unless a value does.
    """
    centres, place = np.unique(np.log(values) if is_log else values, return_inverse=True)
    middle = 0.5 * (centres[1:] + centres[:-1])
    edges = np.concatenate([[2.0 * centres[0] - middle[0]], middle, [2.0 * centres[-1] - middle[-1]]])
    edges = np.exp(edges) if is_log else np.maximum(edges, 0.0) if centres[0] >= 0.0 else edges
    return np.stack([edges[:-1], edges[1:]], axis=-1)[place]
