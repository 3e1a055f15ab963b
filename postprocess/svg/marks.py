"""Marks that a plot shows, each a record that draws itself and the SVG text of marks and charts.

A colour is a name of `PALETTE`, which a page may give another colour (`page.css`, where it is dark), or "#rrggbb".

Scales of a plot's axes lead from values to places, with ticks at round values.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from html import escape
from itertools import compress, pairwise
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from postprocess.units import SI, measure

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


HALO = ' class="halo" stroke="#fff" stroke-width="3" paint-order="stroke"'


class Mark:
    """Something drawn in a plot. Its label stands in the legend, if it has a key; ranges are of its finite values."""

    label: str
    ACROSS: ClassVar[tuple[str, ...]] = ()
    UP: ClassVar[tuple[str, ...]] = ()

    def ranges(self) -> tuple[Range, Range]:
        """Smallest and largest x and y, of the entries that ACROSS and UP name."""
        along, up = ([np.ravel(getattr(self, name)) for name in names] for names in (self.ACROSS, self.UP))
        x, y = (extent(np.concatenate([np.zeros(0), *each])) for each in (along, up))
        return x, y

    def scaled(self, along: float, up: float) -> Mark:
        """Return the mark with x and y times these factors."""
        changed = {name: along * np.asarray(getattr(self, name)) for name in self.ACROSS}
        changed |= {name: up * np.asarray(getattr(self, name)) for name in self.UP}
        return replace(self, **changed)  # type: ignore[type-var]

    def draw(self, x: Scale, y: Scale) -> str:
        """SVG elements."""
        return ""

    def key(self) -> str:
        """SVG of 18 by 10 that shows its look in the legend; empty for what is not in it."""
        return ""


@dataclass(frozen=True)
class Line(Mark):
    """A line through points, shape (n,), with gaps where they are not finite. Pages show y of each, or `values`, and
    where it is, or `at`. width: 0 for points alone; dots: their radius."""

    ACROSS = ("x",)
    UP = ("y",)
    label: str
    x: Floats
    y: Floats
    colour: str = "fe"
    width: float = 1.4
    dashes: str = ""
    dots: float = 0.0
    values: Sequence[Any] = ()
    at: Sequence[str] = ()

    def draw(self, x: Scale, y: Scale) -> str:
        """A path, and dots at its points where it has any; of dots alone each is a stroke of no length."""
        places = np.stack([x.at(self.x), y.at(self.y)], axis=-1)
        sound = np.isfinite(places).all(axis=-1)
        edge = path(places) if self.width else "".join(f"M{a:.2f} {b:.2f}Z" for a, b in places[sound])
        values, at = (list(compress(of, sound)) for of in (self.values or self.y, self.at))
        shown = f'<path {named(self.label, values, at)}d="{edge}" fill="none"{self._look()}/>'
        dotted = places[sound] if self.dots and self.width else places[:0]
        dots = "".join(f'<circle cx="{a:.2f}" cy="{b:.2f}" r="{self.dots:g}"/>' for a, b in dotted)
        return coloured(shown + dots, self.colour)

    def key(self) -> str:
        """A piece of the line."""
        dot = f'<circle cx="9" cy="5" r="{self.dots:g}"/>' if self.dots else ""
        line = f'<path d="M0 5H18"{self._look()}/>' if self.width else ""
        return coloured(line + dot, self.colour)

    def _look(self) -> str:
        dashes = f' stroke-dasharray="{self.dashes}"' if self.dashes else ""
        round_ends = ' stroke-linecap="round"' if not self.width else ""
        width = self.width or 2.0 * self.dots
        return f' stroke="currentColor" stroke-width="{width:g}" stroke-linejoin="round"{dashes}{round_ends}'


@dataclass(frozen=True)
class Level(Mark):
    """A line across the plot at a value of y, its name beside the plot."""

    UP = ("value",)
    label: str
    value: float
    colour: str = "difference"

    def draw(self, x: Scale, y: Scale) -> str:
        """The line; charts set the name, which may have to make room for others."""
        height = float(y.at(self.value))
        line = f'<path d="M{x.start:.2f} {height:.2f}H{x.end:.2f}" stroke-dasharray="5 2" '
        return coloured(line + 'stroke="currentColor"/>', self.colour)


@dataclass(frozen=True)
class Words(Mark):
    """A text at a point, shifted by pixels, y downwards; anchor: "start", "middle" or "end"."""

    ACROSS = ("x",)
    UP = ("y",)
    label: str
    x: float
    y: float
    shift: tuple[float, float] = (0.0, 0.0)
    anchor: str = "start"
    colour: str = "ink"

    def draw(self, x: Scale, y: Scale) -> str:
        """The text, with an edge that sets it off from lines."""
        across, down = float(x.at(self.x)) + self.shift[0], float(y.at(self.y)) + self.shift[1]
        return coloured(words(self.label, across, down, self.anchor, 10.0, HALO), self.colour)


@dataclass(frozen=True)
class Swatch(Mark):
    """An entry of the legend alone: a colour, and what it stands for."""

    label: str
    colour: str

    def key(self) -> str:
        """A patch of the colour."""
        return patch(self.colour)


def key(label: str, colour: str, width: float, dashes: str = "", dots: float = 0.0) -> Line:
    """A line of no points: an entry of the legend alone."""
    return Line(label, np.zeros(0), np.zeros(0), colour, width, dashes, dots)


def patch(colour: str, strength: float = 1.0) -> str:
    """A filled key of the legend."""
    return coloured(f'<rect width="18" height="10" fill-opacity="{strength:g}"/>', colour)


def found_ranges(marks: Sequence[Mark]) -> tuple[Range, Range]:
    """Ranges of all marks together."""
    each = np.array([mark.ranges() for mark in marks])
    (low_x, low_y), (high_x, high_y) = each[:, :, 0].min(axis=0), each[:, :, 1].max(axis=0)
    return (float(low_x), float(high_x)), (float(low_y), float(high_y))


SMALL_BOX = 4.0
"""Pixels of a box."""


@dataclass(frozen=True)
class Layer(Mark):
    """Area between two lines over the same x, shape (n,); the value shown on pages is their distance."""

    ACROSS = ("x",)
    UP = ("low", "high")
    label: str
    x: Floats
    low: Floats
    high: Floats
    colour: str = "steel"
    strength: float = 0.7

    def draw(self, x: Scale, y: Scale) -> str:
        """The upper line forth, the lower line back."""
        along = x.at(self.x)
        forth = np.stack([along, y.at(self.high)], axis=-1)
        back = np.stack([along, y.at(self.low)], axis=-1)[::-1]
        name, edge = (named(self.label, self.high - self.low), path(np.concatenate([forth, back])))
        return coloured(f'<path {name}d="{edge}Z" fill-opacity="{self.strength:g}"/>', self.colour)

    def key(self) -> str:
        """A patch of it."""
        return patch(self.colour, self.strength)


@dataclass(frozen=True)
class Boxes(Mark):
    """Bars and cells: boxes between two values of x and two of y, shape (n, 2) each, all of one colour or each of its
    own. Pages show the value of each, and where it is; strength: how much covers what is behind."""

    ACROSS = ("x",)
    UP = ("y",)
    label: str
    x: Floats
    y: Floats
    colour: str | Sequence[str] = "steel"
    values: Sequence[Any] = ()
    at: Sequence[str] = ()
    strength: float = 1.0

    def draw(self, x: Scale, y: Scale) -> str:
        """A path a colour, with a gap between boxes that are not small, and an unseen one through the centres."""
        left, right = np.sort(x.at(self.x)).T
        top, bottom = np.sort(y.at(self.y)).T
        is_small = bool((np.minimum(right - left, bottom - top) < SMALL_BOX).any())
        gap = 0.0 if is_small else 0.4
        edges = zip(left + gap, top + gap, right - gap, bottom - gap, strict=True)
        look = f' fill-opacity="{self.strength:g}"' + is_small * ' shape-rendering="crispEdges"'
        drawn = ["M{0:.2f} {1:.2f}H{2:.2f}V{3:.2f}H{0:.2f}Z".format(*edge) for edge in edges]
        colours = [self.colour] * len(drawn) if isinstance(self.colour, str) else self.colour
        shown = ""
        for colour in dict.fromkeys(colours):
            path = "".join(compress(drawn, [each == colour for each in colours]))
            shown += coloured(f'<path d="{path}"{look}/>', colour)
        if not self.values:
            return shown
        centres = zip(0.5 * (left + right), 0.5 * (top + bottom), strict=True)
        unseen = "".join(f"M{a:.2f} {b:.2f}Z" for a, b in centres)
        return f'{shown}<path {named(self.label, self.values, self.at)}d="{unseen}"/>'

    def key(self) -> str:
        """A patch, if it has one colour."""
        return patch(self.colour, self.strength) if isinstance(self.colour, str) else ""


@dataclass(frozen=True)
class Span(Mark):
    """A range of x shaded from top to bottom, or a dashed line where it has no width; named at its top."""

    ACROSS = ("start", "end")
    label: str
    start: float
    end: float
    colour: str = "soft"

    def draw(self, x: Scale, y: Scale) -> str:
        """The band, and the name at its top."""
        left, right = sorted(np.clip(x.at([self.start, self.end]), x.start, x.end))
        if self.start == self.end:
            line = f'<path d="M{left:.2f} {y.end:.2f}V{y.start:.2f}" stroke="currentColor" stroke-dasharray="2 2"/>'
            name = words(self.label, left + 3.0, y.end + 11.0, size=10.0)
            return coloured(line + name, self.colour)
        box = f'x="{left:.2f}" y="{y.end:.2f}" width="{right - left:.2f}" height="{y.start - y.end:.2f}"'
        name = words(self.label, 0.5 * (left + right), y.end + 11.0, "middle", 10.0)
        return coloured(f'<rect {box} fill-opacity="0.1"/>{name}', self.colour)


@dataclass(frozen=True)
class Outline(Mark):
    """A closed polygon through points, shape (n,), its area faintly filled."""

    ACROSS = ("x",)
    UP = ("y",)
    x: Floats
    y: Floats
    colour: str = "fe"
    strength: float = 1.0
    fill: float = 0.04
    label: str = ""

    def draw(self, x: Scale, y: Scale) -> str:
        """A closed path."""
        edge = path(np.stack([x.at(self.x), y.at(self.y)], axis=-1))
        look = f'fill-opacity="{self.fill:g}" stroke="currentColor" stroke-opacity="{self.strength:.3g}"'
        return coloured(f'<path d="{edge}Z" {look}/>', self.colour)


COUNT = 65
"""Colours of a scale."""

UNIFORM = 1e-3
"""Range of values, over their size, that has all colours at least: less would make much of next to nothing."""


@dataclass(frozen=True)
class Shades:
    """Colours of values between two ends; is_log: by their logarithms."""

    low: float
    high: float
    is_log: bool = False

    @classmethod
    def of(cls, values: Floats, is_log: bool = False) -> Shades:
        """Shades of the finite values, one at least."""
        low, high = extent(values)
        if is_log:
            return cls(low, high if high > low else 10.0 * low, True)
        more = 0.5 * max(0.0, UNIFORM * max(abs(low), abs(high), 1e-300) - (high - low))
        return cls(low - more, high + more)

    def colours(self, values: Floats) -> list[str]:
        """Colours of finite values, as "#rrggbb"."""
        fraction = np.clip(Scale(self.low, self.high, 0.0, 1.0, self.is_log).at(values), 0.0, 1.0)
        table = [f"#{bytes(each).hex()}" for each in np.rint(255.0 * viridis(COUNT)).astype(np.uint8)]
        return [table[number] for number in np.rint((COUNT - 1) * fraction).astype(int)]

    def keys(self, unit: str) -> list[Swatch]:
        """Round values for the legend, in this unit."""
        ticks = Scale(self.low, self.high, is_log=self.is_log).ticks(6)
        texts = tick_texts(ticks, self.is_log)
        texts = [measure(tick, unit, "g") for tick in ticks] if unit else texts
        return [Swatch(*pair) for pair in zip(texts, self.colours(np.array(ticks)), strict=True)]


def cells_about(values: Floats, is_log: bool) -> Floats:
    """Ends of the cell about each value, half-way to its neighbours, by ratios if is_log: shape (n, 2) for values of
    shape (n,), two different ones at least. No cell reaches below zero where no value does."""
    centres, place = np.unique(np.log(values) if is_log else values, return_inverse=True)
    middle = 0.5 * (centres[1:] + centres[:-1])
    edges = np.concatenate([[2.0 * centres[0] - middle[0]], middle, [2.0 * centres[-1] - middle[-1]]])
    edges = np.exp(edges) if is_log else np.maximum(edges, 0.0) if centres[0] >= 0.0 else edges
    return np.stack([edges[:-1], edges[1:]], axis=-1)[place]
