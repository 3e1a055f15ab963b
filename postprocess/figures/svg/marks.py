"""What a plot shows: lines, layers, shaded times, levels, outlines, words, images; each a record that draws itself.

A colour is a name of `PALETTE`; a page may give the names other colours (`page.css`, where it is dark).
"""

from __future__ import annotations

import base64
import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Protocol
from xml.sax.saxutils import escape

import numpy as np
from numpy.typing import NDArray

from postprocess.figures.svg.scale import Scale

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
SUBSCRIPT = re.compile(r"([^\W\d_])_([A-Za-z0-9]+)")


class Mark(Protocol):
    """Something drawn in a plot. Its label stands in the legend, if it has a key; ranges are of its finite values."""

    @property
    def label(self) -> str:
        """Its name."""

    def ranges(self) -> tuple[Range, Range]:
        """Smallest and largest x and y."""

    def scaled(self, along: float, up: float) -> Mark:
        """The same with x and y so many times as large."""

    def draw(self, x: Scale, y: Scale) -> str:
        """SVG elements."""

    def key(self) -> str:
        """SVG of 18 by 10 that shows its look in the legend; empty for what is not in it."""


@dataclass(frozen=True)
class Line:
    """A line through points, shape (n,); it has gaps where they are not finite, and its values are shown on pages."""

    label: str
    x: Floats
    y: Floats
    colour: str = "fe"
    width: float = 1.4
    dashes: str = ""
    dots: float = 0.0

    def ranges(self) -> tuple[Range, Range]:
        """Of its points."""
        return extent(self.x), extent(self.y)

    def scaled(self, along: float, up: float) -> Line:
        """With all x and y so many times as large."""
        return replace(self, x=along * self.x, y=up * self.y)

    def draw(self, x: Scale, y: Scale) -> str:
        """A path, and dots at its points where it has any; of dots alone each is a stroke of no length."""
        places = np.stack([x.at(self.x), y.at(self.y)], axis=-1)
        sound = np.isfinite(places).all(axis=-1)
        edge = path(places) if self.width else "".join(f"M{a:.2f} {b:.2f}Z" for a, b in places[sound])
        shown = f'<path {named(self.label, self.y[sound])} d="{edge}" fill="none"{self._look()}/>'
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
class Layer:
    """What lies between two lines over the same x, shape (n,); the value shown on pages is their distance."""

    label: str
    x: Floats
    low: Floats
    high: Floats
    colour: str = "steel"
    strength: float = 0.7

    def ranges(self) -> tuple[Range, Range]:
        """Of both lines."""
        return extent(self.x), extent(np.concatenate([self.low, self.high]))

    def scaled(self, along: float, up: float) -> Layer:
        """With all x and y so many times as large."""
        return replace(self, x=along * self.x, low=up * self.low, high=up * self.high)

    def draw(self, x: Scale, y: Scale) -> str:
        """The upper line forth, the lower line back."""
        along = x.at(self.x)
        forth = np.stack([along, y.at(self.high)], axis=-1)
        back = np.stack([along, y.at(self.low)], axis=-1)[::-1]
        name = named(self.label, self.high - self.low)
        edge = path(np.concatenate([forth, back]))
        return coloured(
            f'<path {name} d="{edge}Z" fill="currentColor" fill-opacity="{self.strength:g}"/>', self.colour
        )

    def key(self) -> str:
        """A patch of it."""
        patch = f'<rect width="18" height="10" fill="currentColor" fill-opacity="{self.strength:g}"/>'
        return coloured(patch, self.colour)


@dataclass(frozen=True)
class Span:
    """A range of x shaded from top to bottom, named at its top."""

    label: str
    start: float
    end: float
    colour: str = "soft"

    def ranges(self) -> tuple[Range, Range]:
        """None of its own."""
        return NOTHING, NOTHING

    def scaled(self, along: float, up: float) -> Span:
        """With its ends so many times as large."""
        return replace(self, start=along * self.start, end=along * self.end)

    def draw(self, x: Scale, y: Scale) -> str:
        """The band, and the name at its top."""
        left, right = sorted(np.clip(x.at([self.start, self.end]), x.start, x.end))
        box = f'x="{left:.2f}" y="{y.end:.2f}" width="{right - left:.2f}" height="{y.start - y.end:.2f}"'
        name = words(self.label, 0.5 * (left + right), y.end + 11.0, "middle", 10.0)
        return coloured(f'<rect {box} fill="currentColor" fill-opacity="0.1"/>{name}', self.colour)

    def key(self) -> str:
        """Named in the plot."""
        return ""


@dataclass(frozen=True)
class Level:
    """A line across the plot at a value of y, its name beside the plot."""

    label: str
    value: float
    colour: str = "difference"

    def ranges(self) -> tuple[Range, Range]:
        """Its value."""
        return NOTHING, (self.value, self.value)

    def scaled(self, along: float, up: float) -> Level:
        """With a value so many times as large."""
        return replace(self, value=up * self.value)

    def draw(self, x: Scale, y: Scale) -> str:
        """The line; charts set the name, which may have to make room for others."""
        height = float(y.at(self.value))
        line = f'<path d="M{x.start:.2f} {height:.2f}H{x.end:.2f}" stroke-dasharray="5 2" '
        return coloured(line + 'stroke="currentColor"/>', self.colour)

    def key(self) -> str:
        """Named beside the plot."""
        return ""


@dataclass(frozen=True)
class Outline:
    """A closed polygon, shape (n, 2), its area faintly filled."""

    points: Floats
    colour: str = "fe"
    strength: float = 1.0
    fill: float = 0.04
    label: str = ""

    def ranges(self) -> tuple[Range, Range]:
        """Of its corners."""
        return extent(self.points[:, 0]), extent(self.points[:, 1])

    def scaled(self, along: float, up: float) -> Outline:
        """With all x and y so many times as large."""
        return replace(self, points=self.points * (along, up))

    def draw(self, x: Scale, y: Scale) -> str:
        """A closed path."""
        edge = path(np.stack([x.at(self.points[:, 0]), y.at(self.points[:, 1])], axis=-1))
        look = f'fill="currentColor" fill-opacity="{self.fill:g}" stroke="currentColor" '
        return coloured(f'<path d="{edge}Z" {look}stroke-opacity="{self.strength:.3g}"/>', self.colour)

    def key(self) -> str:
        """Not in the legend."""
        return ""


@dataclass(frozen=True)
class Words:
    """A text at a point, shifted by pixels, y downwards; anchor: "start", "middle" or "end"."""

    label: str
    x: float
    y: float
    shift: tuple[float, float] = (0.0, 0.0)
    anchor: str = "start"
    colour: str = "ink"
    size: float = 10.0

    def ranges(self) -> tuple[Range, Range]:
        """Those of its point."""
        return (self.x, self.x), (self.y, self.y)

    def scaled(self, along: float, up: float) -> Words:
        """With x and y so many times as large."""
        return replace(self, x=along * self.x, y=up * self.y)

    def draw(self, x: Scale, y: Scale) -> str:
        """The text."""
        across, down = float(x.at(self.x)) + self.shift[0], float(y.at(self.y)) + self.shift[1]
        return coloured(words(self.label, across, down, self.anchor, self.size), self.colour)

    def key(self) -> str:
        """Not in the legend."""
        return ""


@dataclass(frozen=True)
class Image:
    """A PNG image between two values of x and of y, its rows from the first y to the last."""

    png: bytes = field(repr=False)
    x: Range
    y: Range
    label: str = ""

    def ranges(self) -> tuple[Range, Range]:
        """Its own."""
        return self.x, (min(self.y), max(self.y))

    def scaled(self, along: float, up: float) -> Image:
        """With its ends so many times as large."""
        (left, right), (first, last) = self.x, self.y
        return replace(self, x=(along * left, along * right), y=(up * first, up * last))

    def draw(self, x: Scale, y: Scale) -> str:
        """The image, stretched."""
        left, right = x.at(self.x)
        top, bottom = sorted(y.at(self.y))
        box = f'x="{left:.2f}" y="{top:.2f}" width="{right - left:.2f}" height="{bottom - top:.2f}"'
        data = "data:image/png;base64," + base64.b64encode(self.png).decode("ascii")
        return f'<image {box} preserveAspectRatio="none" style="image-rendering:pixelated" href="{data}"/>'

    def key(self) -> str:
        """Not in the legend."""
        return ""


@dataclass(frozen=True)
class Swatch:
    """An entry of the legend alone: a colour as "#rrggbb", and what it stands for."""

    label: str
    colour: str

    def ranges(self) -> tuple[Range, Range]:
        """None."""
        return NOTHING, NOTHING

    def scaled(self, along: float, up: float) -> Swatch:
        """As it is."""
        return self

    def draw(self, x: Scale, y: Scale) -> str:
        """Nothing in the plot."""
        return ""

    def key(self) -> str:
        """A patch of the colour."""
        return f'<rect width="18" height="10" fill="{self.colour}"/>'


QUOTE = {'"': "&quot;"}


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


def named(label: str, values: Floats) -> str:
    """Attributes for pages that show values."""
    texts = " ".join(["%.5g"] * values.size) % tuple(values.tolist())
    return f'data-label="{escape(label, QUOTE)}" data-values="{texts}"'


def coloured(elements: str, colour: str) -> str:
    """Elements in a colour of the palette."""
    return f'<g class="{colour}" color="{PALETTE[colour]}" fill="currentColor">{elements}</g>'


def words(text: str, x: float, y: float, anchor: str = "start", size: float = 12.0, more: str = "") -> str:
    """A text element; a letter with a subscript, like v_GY, is set as one."""
    small = f'\\1<tspan dy="0.25em" font-size="{0.75 * size:g}">\\2</tspan><tspan dy="-0.19em">\u200b</tspan>'
    shown = SUBSCRIPT.sub(small, escape(text))
    place = f'x="{x:.2f}" y="{y:.2f}"' + (f' text-anchor="{anchor}"' if anchor != "start" else "")
    return f'<text {place} font-size="{size:g}"{more}>{shown}</text>'


def text_width(text: str, size: float = 12.0) -> float:
    """About how long a text is."""
    return 0.6 * size * len(text)


def found_ranges(marks: Sequence[Mark]) -> tuple[Range, Range]:
    """Ranges of all marks together."""
    each = np.array([mark.ranges() for mark in marks])
    (low_x, low_y), (high_x, high_y) = each[:, :, 0].min(axis=0), each[:, :, 1].max(axis=0)
    return (float(low_x), float(high_x)), (float(low_y), float(high_y))
