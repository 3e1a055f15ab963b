"""Marks that a plot shows, each a record that draws itself in a colour of `drawing`, and colours of numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import compress
from typing import Any, ClassVar

import numpy as np

from postprocess.svg import drawing
from postprocess.units import measure

HALO = ' class="halo" stroke="#fff" stroke-width="3" paint-order="stroke"'


class Mark:
    """Something drawn in a plot. Its label stands in the legend, if it has a key; ranges are of its finite values."""

    label: str
    ACROSS: ClassVar[tuple[str, ...]] = ()
    UP: ClassVar[tuple[str, ...]] = ()

    def ranges(self) -> tuple[drawing.Range, drawing.Range]:
        """Smallest and largest x and y, of the entries that ACROSS and UP name."""
        along, up = ([np.ravel(getattr(self, name)) for name in names] for names in (self.ACROSS, self.UP))
        x, y = (drawing.extent(np.concatenate([np.zeros(0), *each])) for each in (along, up))
        return x, y

    def scaled(self, along: float, up: float) -> Mark:
        """Return the mark with x and y times these factors."""
        changed = {name: along * np.asarray(getattr(self, name)) for name in self.ACROSS}
        changed |= {name: up * np.asarray(getattr(self, name)) for name in self.UP}
        return replace(self, **changed)  # type: ignore[type-var]

    def draw(self, x: drawing.Scale, y: drawing.Scale) -> str:
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
    x: drawing.Floats
    y: drawing.Floats
    colour: str = "fe"
    width: float = 1.4
    dashes: str = ""
    dots: float = 0.0
    values: Sequence[Any] = ()
    at: Sequence[str] = ()

    def draw(self, x: drawing.Scale, y: drawing.Scale) -> str:
        """A path, and dots at its points where it has any; of dots alone each is a stroke of no length."""
        places = np.stack([x.at(self.x), y.at(self.y)], axis=-1)
        sound = np.isfinite(places).all(axis=-1)
        edge = drawing.path(places) if self.width else "".join(f"M{a:.2f} {b:.2f}Z" for a, b in places[sound])
        values, at = (list(compress(of, sound)) for of in (self.values or self.y, self.at))
        shown = f'<path {drawing.named(self.label, values, at)}d="{edge}" fill="none"{self._look()}/>'
        dotted = places[sound] if self.dots and self.width else places[:0]
        dots = "".join(f'<circle cx="{a:.2f}" cy="{b:.2f}" r="{self.dots:g}"/>' for a, b in dotted)
        return drawing.coloured(shown + dots, self.colour)

    def key(self) -> str:
        """A piece of the line."""
        dot = f'<circle cx="9" cy="5" r="{self.dots:g}"/>' if self.dots else ""
        line = f'<path d="M0 5H18"{self._look()}/>' if self.width else ""
        return drawing.coloured(line + dot, self.colour)

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

    def draw(self, x: drawing.Scale, y: drawing.Scale) -> str:
        """The line; charts set the name, which may have to make room for others."""
        height = float(y.at(self.value))
        line = f'<path d="M{x.start:.2f} {height:.2f}H{x.end:.2f}" stroke-dasharray="5 2" '
        return drawing.coloured(line + 'stroke="currentColor"/>', self.colour)


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

    def draw(self, x: drawing.Scale, y: drawing.Scale) -> str:
        """The text, with an edge that sets it off from lines."""
        across, down = float(x.at(self.x)) + self.shift[0], float(y.at(self.y)) + self.shift[1]
        return drawing.coloured(drawing.words(self.label, across, down, self.anchor, 10.0, HALO), self.colour)


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
    return drawing.coloured(f'<rect width="18" height="10" fill-opacity="{strength:g}"/>', colour)


def found_ranges(marks: Sequence[Mark]) -> tuple[drawing.Range, drawing.Range]:
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
    x: drawing.Floats
    low: drawing.Floats
    high: drawing.Floats
    colour: str = "steel"
    strength: float = 0.7

    def draw(self, x: drawing.Scale, y: drawing.Scale) -> str:
        """The upper line forth, the lower line back."""
        along = x.at(self.x)
        forth = np.stack([along, y.at(self.high)], axis=-1)
        back = np.stack([along, y.at(self.low)], axis=-1)[::-1]
        name, edge = (
            drawing.named(self.label, self.high - self.low),
            drawing.path(np.concatenate([forth, back])),
        )
        return drawing.coloured(f'<path {name}d="{edge}Z" fill-opacity="{self.strength:g}"/>', self.colour)

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
    x: drawing.Floats
    y: drawing.Floats
    colour: str | Sequence[str] = "steel"
    values: Sequence[Any] = ()
    at: Sequence[str] = ()
    strength: float = 1.0

    def draw(self, x: drawing.Scale, y: drawing.Scale) -> str:
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
            shown += drawing.coloured(f'<path d="{path}"{look}/>', colour)
        if not self.values:
            return shown
        centres = zip(0.5 * (left + right), 0.5 * (top + bottom), strict=True)
        unseen = "".join(f"M{a:.2f} {b:.2f}Z" for a, b in centres)
        return f'{shown}<path {drawing.named(self.label, self.values, self.at)}d="{unseen}"/>'

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

    def draw(self, x: drawing.Scale, y: drawing.Scale) -> str:
        """The band, and the name at its top."""
        left, right = sorted(np.clip(x.at([self.start, self.end]), x.start, x.end))
        if self.start == self.end:
            line = f'<path d="M{left:.2f} {y.end:.2f}V{y.start:.2f}" stroke="currentColor" stroke-dasharray="2 2"/>'
            name = drawing.words(self.label, left + 3.0, y.end + 11.0, size=10.0)
            return drawing.coloured(line + name, self.colour)
        box = f'x="{left:.2f}" y="{y.end:.2f}" width="{right - left:.2f}" height="{y.start - y.end:.2f}"'
        name = drawing.words(self.label, 0.5 * (left + right), y.end + 11.0, "middle", 10.0)
        return drawing.coloured(f'<rect {box} fill-opacity="0.1"/>{name}', self.colour)


@dataclass(frozen=True)
class Outline(Mark):
    """A closed polygon through points, shape (n,), its area faintly filled."""

    ACROSS = ("x",)
    UP = ("y",)
    x: drawing.Floats
    y: drawing.Floats
    colour: str = "fe"
    strength: float = 1.0
    fill: float = 0.04
    label: str = ""

    def draw(self, x: drawing.Scale, y: drawing.Scale) -> str:
        """A closed path."""
        edge = drawing.path(np.stack([x.at(self.x), y.at(self.y)], axis=-1))
        look = f'fill-opacity="{self.fill:g}" stroke="currentColor" stroke-opacity="{self.strength:.3g}"'
        return drawing.coloured(f'<path d="{edge}Z" {look}/>', self.colour)


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
    def of(cls, values: drawing.Floats, is_log: bool = False) -> Shades:
        """Shades of the finite values, one at least."""
        low, high = drawing.extent(values)
        if is_log:
            return cls(low, high if high > low else 10.0 * low, True)
        more = 0.5 * max(0.0, UNIFORM * max(abs(low), abs(high), 1e-300) - (high - low))
        return cls(low - more, high + more)

    def colours(self, values: drawing.Floats) -> list[str]:
        """Colours of finite values, as "#rrggbb"."""
        fraction = np.clip(drawing.Scale(self.low, self.high, 0.0, 1.0, self.is_log).at(values), 0.0, 1.0)
        table = [f"#{bytes(each).hex()}" for each in np.rint(255.0 * drawing.viridis(COUNT)).astype(np.uint8)]
        return [table[number] for number in np.rint((COUNT - 1) * fraction).astype(int)]

    def keys(self, unit: str) -> list[Swatch]:
        """Round values for the legend, in this unit."""
        ticks = drawing.Scale(self.low, self.high, is_log=self.is_log).ticks(6)
        texts = drawing.tick_texts(ticks, self.is_log)
        texts = [measure(tick, unit, "g") for tick in ticks] if unit else texts
        return [Swatch(*pair) for pair in zip(texts, self.colours(np.array(ticks)), strict=True)]


def cells_about(values: drawing.Floats, is_log: bool) -> drawing.Floats:
    """Ends of the cell about each value, half-way to its neighbours, by ratios if is_log: shape (n, 2) for values of
    shape (n,), two different ones at least. No cell reaches below zero where no value does."""
    centres, place = np.unique(np.log(values) if is_log else values, return_inverse=True)
    middle = 0.5 * (centres[1:] + centres[:-1])
    edges = np.concatenate([[2.0 * centres[0] - middle[0]], middle, [2.0 * centres[-1] - middle[-1]]])
    edges = np.exp(edges) if is_log else np.maximum(edges, 0.0) if centres[0] >= 0.0 else edges
    return np.stack([edges[:-1], edges[1:]], axis=-1)[place]
