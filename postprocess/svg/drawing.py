"""SVG text of marks and charts: colours by name, paths, words; and the ranges of numbers.

A colour is a name of `PALETTE`, which a page may give another colour (`page.css`, where it is dark), or "#rrggbb".

Scales of a plot's axes: from values to places, and ticks at round values.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from postprocess.units import SI

Floats = NDArray[np.float64]
Range = tuple[float, float]

PALETTE = {
    "fe": "#14467c",
    "rigid": "#c8720a",
    "difference": "#8a1c3b",
    "red": "#d8453a",
    "green": "#1f8a54",
    "violet": "#7d57a8",
    "steel": "#6d89a8",
    "grey": "#7b858f",
    "soft": "#5b6570",
    "ink": "#1b1f24",
    "grid": "#e3e6ea",
}
NOTHING: Range = (np.inf, -np.inf)
SUBSCRIPT = re.compile(r"\b([^\W\d_])_([A-Za-z0-9]+)")
NO_BREAK = "\N{NO-BREAK SPACE}"

MEAN_WIDTH = 0.6
"""Width of a letter, over the size of the font."""

_WIDTHS = {
    **dict.fromkeys("0123456789", 0.64),
    **dict.fromkeys("−+=<>mwMW%", 0.85),
    **dict.fromkeys("ijlI.,:;'|![]()ft ", 0.37),
    **dict.fromkeys("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", 0.42),
}


def extent(values: Floats) -> Range:
    """Smallest and largest finite value; `NOTHING` without any."""
    finite = values[np.isfinite(values)]
    return (float(finite.min()), float(finite.max())) if finite.size else NOTHING


def path(places: Floats) -> str:
    """Path through places, shape (n, 2), broken where they are not finite."""
    sound = np.isfinite(places).all(axis=-1)
    ends = np.flatnonzero(np.diff(np.concatenate([[False], sound, [False]]).astype(int)))
    pieces = []
    for first, last in list(pairwise(ends))[::2]:
        points = places[first:last].ravel().tolist()
        pieces.append("M" + "L".join(["%.2f %.2f"] * (last - first)) % tuple(points))
    return "".join(pieces)


def named(label: str, values: Sequence[Any] | Floats, at: Sequence[str] = ()) -> str:
    """Attributes for pages that show values, and where these are, if `at` tells it; nothing without label or values."""
    if not (label and len(values)):
        return ""
    place = f' data-at="{_listed(at)}"' if len(at) else ""
    return f'data-label="{escape(label)}" data-values="{_listed(values)}"{place} '


def _listed(items: Iterable[Any]) -> str:
    """Numbers and words with spaces between, and none within."""
    texts = (item.replace(" ", NO_BREAK) if isinstance(item, str) else f"{item:.5g}" for item in items)
    return escape(" ".join(texts))


def coloured(elements: str, colour: str) -> str:
    """Elements in a colour."""
    name = f'class="{colour}" ' if colour in PALETTE else ""
    return f'<g {name}color="{PALETTE.get(colour, colour)}" fill="currentColor">{elements}</g>'


def words(text: str, x: float, y: float, anchor: str = "start", size: float = 12.0, more: str = "") -> str:
    """A text element; a letter with a subscript, like v_GY, is set as one. No element for no text."""
    if not text:
        return ""
    small = f'\\1<tspan dy="0.25em" font-size="{0.75 * size:g}">\\2</tspan><tspan dy="-0.19em">\u200b</tspan>'
    shown = SUBSCRIPT.sub(small, escape(text, quote=False))
    place = f'x="{x:.2f}" y="{y:.2f}"' + (f' text-anchor="{anchor}"' if anchor != "start" else "")
    return f'<text {place} font-size="{size:g}"{more}>{shown}</text>'


def text_width(text: str, size: float = 12.0) -> float:
    """Estimate how long a text is, in a wide font such as DejaVu Sans."""
    return size * sum(_WIDTHS.get(letter, MEAN_WIDTH) for letter in SI.rendered(text))


KNOTS = """
    440154 46075a 470d60 471365 48186a 481d6f 482374 482878 472d7b 46327e 453781 443b84 424086
    404588 3e4989 3d4e8a 3b528b 39568c 375b8d 355f8d 33638d 31678e 2f6b8e 2e6f8e 2c728e 2a768e
    297a8e 277e8e 26828e 25858e 23898e 228d8d 21918c 1f948c 1f988b 1e9c89 1fa088 20a386 22a785
    25ab82 28ae80 2db27d 32b67a 38b977 3fbc73 46c06f 4ec36b 56c667 5ec962 67cc5c 70cf57 7ad151
    84d44b 8ed645 98d83e a2da37 addc30 b8de29 c2df23 cde11d d8e219 e2e418 ece51b f6e620 fde725
"""
"""Every fourth of its 256 colours and the last, by van der Walt and Smith (2015), dedicated to the public domain."""


def viridis(count: int) -> Floats:
    """So many colours of the map viridis from end to end, red, green and blue from 0 to 1, shape (count, 3)."""
    knots = np.array([[int(knot[i : i + 2], 16) for i in (0, 2, 4)] for knot in KNOTS.split()]) / 255.0
    numbers = np.minimum(4 * np.arange(len(knots)), 255)
    asked = np.minimum(np.floor(256.0 * np.linspace(0.0, 1.0, count)), 255.0)
    return np.column_stack([np.interp(asked, numbers, part) for part in knots.T])


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
