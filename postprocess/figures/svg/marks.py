"""What a plot shows: lines, levels, words, and `areas`; each a record that draws itself in a colour of `drawing`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import compress
from typing import Any, ClassVar

import numpy as np

from postprocess.figures.svg.drawing import Floats, Range, coloured, extent, named, path, words
from postprocess.figures.svg.scale import Scale

HALO = ' class="halo" stroke="#fff" stroke-width="3" paint-order="stroke"'


class Mark:
    """Something drawn in a plot. Its label stands in the legend, if it has a key; ranges are of its finite values."""

    label: str
    ACROSS: ClassVar[tuple[str, ...]] = ()
    UP: ClassVar[tuple[str, ...]] = ()

    def ranges(self) -> tuple[Range, Range]:
        """Smallest and largest x and y, of the entries that ACROSS and UP name."""
        along, up = ([np.ravel(getattr(self, name)) for name in names] for names in (self.ACROSS, self.UP))
        return extent(np.concatenate([np.zeros(0), *along])), extent(np.concatenate([np.zeros(0), *up]))

    def scaled(self, along: float, up: float) -> Mark:
        """The same with x and y so many times as large."""
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
    size: float = 10.0

    def draw(self, x: Scale, y: Scale) -> str:
        """The text, with an edge that sets it off from lines."""
        across, down = float(x.at(self.x)) + self.shift[0], float(y.at(self.y)) + self.shift[1]
        return coloured(words(self.label, across, down, self.anchor, self.size, HALO), self.colour)


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
