"""Marks that a plot shows, each a record that draws itself and the SVG text of marks and charts.

A colour is a name of `PALETTE`, which a page may give another colour (`page.css`, where it is dark), or "#rrggbb".
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from html import escape
from itertools import compress, pairwise
from typing import Any, ClassVar

import numpy as np

from postprocess.svg.scales import Floats, Range, Scale, extent
from postprocess.units import SI

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


def labelled(label: str) -> str:
    """Attribute by which pages know the mark; nothing without a label."""
    return f'data-label="{escape(label)}" ' if label else ""


def path(places: Floats) -> str:
    """Path through places, shape (n, 2), broken where they are not finite."""
    sound = np.isfinite(places).all(axis=-1)
    ends = np.flatnonzero(np.diff(np.concatenate([[False], sound, [False]]).astype(int)))
    pieces = []
    for first, last in list(pairwise(ends))[::2]:
        points = places[first:last].ravel().tolist()
        pieces.append("M" + "L".join(["%.2f %.2f"] * (last - first)) % tuple(points))
    return "".join(pieces)


def coloured(elements: str, colour: str) -> str:
    """Elements in a colour."""
    name = f'class="{colour}" ' if colour in PALETTE else ""
    return f'<g {name}color="{PALETTE.get(colour, colour)}" fill="currentColor">{elements}</g>'


def words(text: str, x: float, y: float, anchor: str = "start", size: float = 12.0, more: str = "") -> str:
    """A text element; a letter with a subscript, like v_GY, is set as one. No element for no text."""
    if not text:
        return ""
    small = f'\\1<tspan dy="0.22em" font-size="{0.82 * size:g}">\\2</tspan><tspan dy="-0.18em">\u200b</tspan>'
    shown = SUBSCRIPT.sub(small, escape(text, quote=False))
    place = f'x="{x:.2f}" y="{y:.2f}"' + (f' text-anchor="{anchor}"' if anchor != "start" else "")
    return f'<text {place} font-size="{size:g}"{more}>{shown}</text>'


def text_width(text: str, size: float = 12.0) -> float:
    """Estimate how long a text is, in a wide font such as DejaVu Sans."""
    return size * sum(_WIDTHS.get(letter, MEAN_WIDTH) for letter in SI.rendered(text))


HALO = ' class="halo" stroke="#fff" stroke-width="3" paint-order="stroke"'


Samples = tuple[Sequence[Any] | Floats, Sequence[Any] | Floats]
"""Places and values of equal number: numbers, or words."""

KEY = 26.0
"""Width of a key in the legend: room for a dash and the gaps beside it."""

DASHES = ("", "7 3", "2 3", "9 3 2 3", "14 3", "5 2 1 2", "4 4", "1 5")
WIDTHS = (3.0, 2.2, 1.7, 1.4)


def look(number: int) -> dict[str, Any]:
    """Width and dashes of line `number` of a plot. One that is drawn later is thinner or has gaps, and hides none
    before it; each has dashes of its own, which tell lines apart where colours do not."""
    return {"width": WIDTHS[min(number, len(WIDTHS) - 1)], "dashes": DASHES[number % len(DASHES)]}


class Mark:
    """Something drawn in a plot. Its label stands in the legend, if it has a key; ranges are of its finite values."""

    label: str
    ACROSS: ClassVar[tuple[str, ...]] = ("x",)
    UP: ClassVar[tuple[str, ...]] = ("y",)

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

    def samples(self, x: Scale, y: Scale) -> Samples:
        """Places and values of its points, in the order of those of its first path; none for most marks."""
        return (), ()

    def key(self) -> str:
        """SVG of `KEY` by 10 that shows its look in the legend; empty for what is not in it."""
        return ""


@dataclass(frozen=True)
class Line(Mark):
    """A line through points, shape (n,), with gaps where they are not finite. Its samples are y of each, or `values`,
    at x, or `at`. width: 0 for points alone; dots: their diameter, over 2; those of points with `at` have it as their
    title."""

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
        """A path, and dots at its points where it has any; each dot is a stroke of no length."""
        places, sound = self._places(x, y)
        dots = [f"M{a:.2f} {b:.2f}Z" for a, b in places[sound]]
        label, edge = labelled(self.label), path(places) if self.width else "".join(dots)
        shown = f'<path {label}d="{edge}" fill="none"{self._look() if self.width else self._dots()}/>'
        if self.dots and self.at:
            named = zip(dots, compress(self.at, sound), strict=True)
            shown += "".join(
                f'<path d="{dot}"{self._dots()}><title>{escape(at)}</title></path>' for dot, at in named
            )
        elif self.dots and self.width:
            shown += f'<path d="{"".join(dots)}"{self._dots()}/>'
        return coloured(shown, self.colour)

    def samples(self, x: Scale, y: Scale) -> Samples:
        """Places and values of the points that are drawn."""
        _, sound = self._places(x, y)
        at, values = (list(compress(of, sound)) for of in (self.at or self.x, self.values or self.y))
        return at, values

    def key(self) -> str:
        """A piece of the line."""
        dot = f'<path d="M{0.5 * KEY:g} 5Z"{self._dots()}/>' if self.dots else ""
        line = f'<path d="M0 5H{KEY:g}"{self._look()}/>' if self.width else ""
        return coloured(line + dot, self.colour)

    def _places(self, x: Scale, y: Scale) -> tuple[Floats, list[bool]]:
        """Places of the points, shape (n, 2), and which of them are finite."""
        places = np.stack([x.at(self.x), y.at(self.y)], axis=-1)
        return places, list(np.isfinite(places).all(axis=-1))

    def _look(self) -> str:
        dashes = f' stroke-dasharray="{self.dashes}"' if self.dashes else ""
        return f' stroke="currentColor" stroke-width="{self.width:g}" stroke-linejoin="round"{dashes}'

    def _dots(self) -> str:
        return f' stroke="currentColor" stroke-width="{2.0 * self.dots:g}" stroke-linecap="round"'


@dataclass(frozen=True)
class Level(Mark):
    """A line across the plot at a value of y, its name beside the plot."""

    ACROSS = ()
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

    label: str
    x: float
    y: float
    shift: tuple[float, float] = (0.0, 0.0)
    anchor: str = "start"
    colour: str = "ink"

    def draw(self, x: Scale, y: Scale) -> str:
        """The text, with an edge that sets it off from lines."""
        across, down = float(x.at(self.x)) + self.shift[0], float(y.at(self.y)) + self.shift[1]
        return coloured(words(self.label, across, down, self.anchor, 11.0, HALO), self.colour)


@dataclass(frozen=True)
class Swatch(Mark):
    """An entry of the legend alone: a colour, and what it stands for."""

    ACROSS = ()
    UP = ()
    label: str
    colour: str

    def key(self) -> str:
        """A patch of the colour."""
        return patch(self.colour)


def key(label: str, colour: str, width: float, dashes: str = "") -> Line:
    """A line of no points: an entry of the legend alone."""
    return Line(label, np.zeros(0), np.zeros(0), colour, width, dashes)


def patch(colour: str, strength: float = 1.0) -> str:
    """A filled key of the legend."""
    return coloured(f'<rect width="{KEY:g}" height="10" fill-opacity="{strength:g}"/>', colour)


def found_ranges(marks: Sequence[Mark]) -> tuple[Range, Range]:
    """Ranges of all marks together."""
    each = np.array([mark.ranges() for mark in marks])
    (low_x, low_y), (high_x, high_y) = each[:, :, 0].min(axis=0), each[:, :, 1].max(axis=0)
    return (float(low_x), float(high_x)), (float(low_y), float(high_y))


HOLD = 0.12
"""Part of an animation in which what moved stays where it ends."""


@dataclass(frozen=True)
class Moving(Mark):
    """A closed polygon that moves as a rigid body, in a plot of equal scales: corners at even instants, shape
    (instants, points); seconds: of one run. By CSS alone: it stands still where its reader prefers that, and pages can
    pause it."""

    label: str
    x: Floats
    y: Floats
    seconds: float
    colour: str = "fe"

    def draw(self, x: Scale, y: Scale) -> str:
        """The polygon about its first corner, and keyframes of that corner's place and of the angle."""
        across, down = x.at(self.x), y.at(self.y)
        angle = np.unwrap(np.arctan2(down[:, 1] - down[:, 0], across[:, 1] - across[:, 0]))
        turns = [
            f"transform:translate({a:.1f}px,{b:.1f}px) rotate({turn:.4f}rad)"
            for a, b, turn in zip(across[:, 0], down[:, 0], angle - angle[0], strict=True)
        ]
        times = [*np.linspace(0.0, 100.0 * (1.0 - HOLD), len(turns)), 100.0]
        frames = "".join(f"{t:.2f}%{{{turn}}}" for t, turn in zip(times, [*turns, turns[-1]], strict=True))
        style = (
            f"@keyframes motion{{{frames}}}.moving{{{turns[-1]};animation:motion {self.seconds:.3g}s linear infinite}}"
            "@media (prefers-reduced-motion:reduce){.moving{animation:none}}"
        )
        edge = path(np.stack([across[0] - across[0, 0], down[0] - down[0, 0]], axis=-1))
        shape = (
            f'<path class="moving" d="{edge}Z" fill-opacity="0.45" stroke="currentColor" stroke-width="1.5"/>'
        )
        return f"<style>{style}</style>{coloured(shape, self.colour)}"


SMALL_BOX = 9.0
"""Pixels of a box."""


@dataclass(frozen=True)
class Layer(Mark):
    """Area between two lines over the same x, shape (n,); the value shown on pages is their distance."""

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
        edge = path(np.concatenate([forth, back]))
        return coloured(
            f'<path {labelled(self.label)}d="{edge}Z" fill-opacity="{self.strength:g}"/>', self.colour
        )

    def samples(self, x: Scale, y: Scale) -> Samples:
        """Distances of the two lines."""
        return self.x, self.high - self.low

    def key(self) -> str:
        """A patch of it."""
        return patch(self.colour, self.strength)


@dataclass(frozen=True)
class Boxes(Mark):
    """Bars and cells: boxes between two values of x and two of y, shape (n, 2) each, all of one colour or each of its
    own. Pages show the value of each, and where it is; strength: how much covers what is behind."""

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
        return f'<g>{shown}<path {labelled(self.label)}d="{unseen}"/></g>'

    def samples(self, x: Scale, y: Scale) -> Samples:
        """The values of the boxes, at `at` or their middle."""
        return self.at or np.mean(self.x, axis=-1), self.values

    def key(self) -> str:
        """A patch, if it has one colour."""
        return patch(self.colour, self.strength) if isinstance(self.colour, str) else ""


@dataclass(frozen=True)
class Span(Mark):
    """A range of x shaded from top to bottom, or a dashed line where it has no width; named at its top, in a row."""

    ACROSS = ("start", "end")
    UP = ()
    label: str
    start: float
    end: float
    colour: str = "soft"
    row: int = 0

    def draw(self, x: Scale, y: Scale) -> str:
        """The band, and the name at its top."""
        left, right = sorted(np.clip(x.at([self.start, self.end]), x.start, x.end))
        if self.start == self.end:
            line = f'<path d="M{left:.2f} {y.end:.2f}V{y.start:.2f}" stroke="currentColor" stroke-dasharray="2 2"/>'
            name = words(self.label, left + 3.0, y.end + 11.0, size=11.0)
            return coloured(line + name, self.colour)
        box = f"M{left:.2f} {y.end:.2f}H{right:.2f}V{y.start:.2f}H{left:.2f}Z"
        name = words(self.label, 0.5 * (left + right), y.end + 11.0 * (1 + self.row), "middle", 11.0)
        return coloured(f'<path d="{box}" fill-opacity="0.1"/>{name}', self.colour)


@dataclass(frozen=True)
class Outline(Mark):
    """A closed polygon through points, shape (n,), its area faintly filled; a label is in the table, not the legend."""

    x: Floats
    y: Floats
    colour: str = "fe"
    strength: float = 1.0
    fill: float = 0.04
    label: str = ""

    def draw(self, x: Scale, y: Scale) -> str:
        """A closed path."""
        edge = labelled(self.label) + f'd="{path(np.stack([x.at(self.x), y.at(self.y)], axis=-1))}Z"'
        look = f'fill-opacity="{self.fill:g}" stroke="currentColor" stroke-opacity="{self.strength:.3g}"'
        return coloured(f"<path {edge} {look}/>", self.colour)

    def samples(self, x: Scale, y: Scale) -> Samples:
        """Its corners."""
        return self.x, self.y
