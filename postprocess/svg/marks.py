"""Marks of a plot, and the SVG text of their elements.

A colour is a name of `PALETTE`, which pages may redefine (`dark.css` does), or "#rrggbb".
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from itertools import compress
from typing import Any, ClassVar, NamedTuple

import numpy as np

from postprocess.svg.scales import Floats, Range, Scale, extent
from postprocess.units import SI, SUBSCRIPT, US

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

MEAN_WIDTH = 0.6
"""Width of a letter relative to the size of the font."""

_WIDTHS = {
    **dict.fromkeys("0123456789", 0.64),
    **dict.fromkeys("−+=<>mwMW%", 0.85),
    **dict.fromkeys("ijlI.,:;'|![]()ft ", 0.37),
    **dict.fromkeys("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", 0.42),
}

HALO = ' class="halo" stroke="#fff" stroke-width="3" paint-order="stroke"'

SMALL = 11.0
"""Size of letters of names and ticks [pixels]."""

BESIDE = 4.0
"""Room between names in one row [pixels]."""

KEY = 26.0
"""Width of a key in the legend, gaps included [pixels]."""

DASHES = ("", "7 3", "2 3", "9 3 2 3", "14 3", "5 2 1 2", "4 4", "1 5")

WIDTHS = (3.0, 2.2, 1.7, 1.4)

DRAWN, READ = (1, 1), (2, 3)
"""Decimals of places that are drawn alone, and of those from which pages read values [pixels]."""


def labelled(label: str) -> str:
    """Return the attribute that names a mark, empty without a label."""
    return f'data-label="{escape(SI.rendered(label))}" ' if label else ""


def path(places: Floats, digits: tuple[int, int] = DRAWN, end: str = "") -> str:
    """Return the path through places, shape (n, 2).

    It consists of a start and steps, and has gaps where places are not finite. digits: decimals of x and y; their
    rounding errors do not add up, as each step ends at a rounded place. end: after each piece.
    """
    sound, size = np.isfinite(places).all(axis=-1), 10.0 ** np.array(digits)
    ends = np.flatnonzero(np.diff(np.concatenate([[False], sound, [False]]).astype(int)))
    rounded = np.rint(places * size)
    steps = np.diff(rounded, axis=0, prepend=0.0)
    steps[ends[::2]] = rounded[ends[::2]]
    texts = [f"{across:.10g} {down:.10g}" for across, down in (steps / size + 0.0).tolist()]
    pieces = []
    for first, last in ends.reshape(-1, 2).tolist():
        further = " ".join(texts[first + 1 : last])
        pieces.append(f"M{texts[first]}l{further}".removesuffix("l").replace(" -", "-") + end)
    return "".join(pieces)


def coloured(elements: str, colour: str, is_shown: bool = True) -> str:
    """Return a group of elements in this colour."""
    name = f'class="{colour}" ' if colour in PALETTE else ""
    hidden = "" if is_shown else ' style="display:none"'
    return f'<g {name}color="{PALETTE.get(colour, colour)}" fill="currentColor"{hidden}>{elements}</g>'


def words(text: str, x: float, y: float, anchor: str = "start", size: float = 12.0, more: str = "") -> str:
    """Return a text element with subscripts.

    Without text it is empty.
    """
    if not text:
        return ""
    small = f'\\1<tspan dy="0.22em" font-size="{0.82 * size:g}">\\2</tspan><tspan dy="-0.18em">\u200b</tspan>'
    content = SUBSCRIPT.sub(small, escape(text, quote=False))
    place = f'x="{x:.2f}" y="{y:.2f}"' + (f' text-anchor="{anchor}"' if anchor != "start" else "")
    return f'<text {place} font-size="{size:g}"{more}>{content}</text>'


def text_width(text: str, size: float = 12.0) -> float:
    """Estimate the length of a text in a wide font."""
    return size * math.fsum(_WIDTHS.get(letter, MEAN_WIDTH) for letter in SI.rendered(text))


class Name(NamedTuple):
    """Small text at a place of a drawing [pixels].

    anchor: "start", "middle" or "end".
    """

    text: str
    x: float
    y: float
    anchor: str = "start"

    def draw(self, more: str = "") -> str:
        """Return its text element."""
        return words(self.text, self.x, self.y, self.anchor, SMALL, more)

    @property
    def ends(self) -> Range:
        """Left and right end [pixels]."""
        wide = text_width(self.text, SMALL)
        start = self.x - {"start": 0.0, "middle": 0.5, "end": 1.0}[self.anchor] * wide
        return start, start + wide

    def overlaps(self, other: Name) -> bool:
        """Return True if it overlaps another name."""
        (start, end), (other_start, other_end) = self.ends, other.ends
        is_beside = start > other_end + BESIDE or other_start > end + BESIDE
        return not is_beside and abs(self.y - other.y) < SMALL


def line_style(number: int) -> dict[str, Any]:
    """Return width and dashes of line `number` of a plot.

    Later lines are thinner or dashed, so that they hide none drawn before. Dashes differ between lines, so that they
    can be distinguished without colours.
    """
    return {"width": WIDTHS[min(number, len(WIDTHS) - 1)], "dashes": DASHES[number % len(DASHES)]}


class Mark:
    """Element of a plot.

    Its label stands in the legend if it has a key. Its ranges are those of its finite values.
    """

    label: str
    ACROSS: ClassVar[tuple[str, ...]] = ("x",)
    UP: ClassVar[tuple[str, ...]] = ("y",)

    def ranges(self) -> tuple[Range, Range]:
        """Return the ranges of x and y.

        They are those of the fields in ACROSS and UP.
        """
        along, up = ([np.ravel(getattr(self, name)) for name in names] for names in (self.ACROSS, self.UP))
        x, y = (extent(np.concatenate([np.zeros(0), *values])) for values in (along, up))
        return x, y

    def draw(self, x: Scale, y: Scale) -> str:
        """Return the SVG elements."""
        return ""

    def names(self, x: Scale, y: Scale) -> list[Name]:
        """Return the texts that it draws."""
        return []

    @property
    def attributes(self) -> str:
        """Attributes of a path with label and samples."""
        label, texts = getattr(self, "label", ""), list[str]()
        for name in ("at", "values"):
            samples = getattr(self, name, ()) if label else ()
            words = "|".join(text if isinstance(text, str) else f"{text:.6g}" for text in samples)
            in_si, in_us = (escape(units.rendered(words)) for units in (SI, US))
            texts += [f'data-{name}="{in_si}" '] if words else []
            texts += [f'data-{name}-us="{in_us}" '] if in_us != in_si else []
        return "".join([labelled(label), *texts])

    def key(self) -> str:
        """Return its sample in the legend.

        The sample takes `KEY` by 10 pixels; marks outside the legend have none.
        """
        return ""


@dataclass(frozen=True)
class Line(Mark):
    """Line through points, shape (n,).

    It has gaps where they are not finite. Its samples are `values`, by default y, at `at`, by default x. A width of 0
    draws points alone; dots is their radius. Points with `at` have it as their title. is_shown: False if it is shown
    on request.
    """

    label: str
    x: Floats
    y: Floats
    colour: str = "fe"
    width: float = 1.4
    dashes: str = ""
    dots: float = 0.0
    values: Sequence[str] | Sequence[float] = ()
    at: Sequence[str] = ()
    is_shown: bool = True

    def draw(self, x: Scale, y: Scale) -> str:
        """Return a path and its points.

        Points are strokes of zero length.
        """
        places = np.stack([x.at(self.x), y.at(self.y)], axis=-1)
        sound = np.logical_and.reduce(np.isfinite(places), axis=-1)
        is_dotted = self.dots or not self.width
        dots = [f"M{a:.2f} {b:.2f}Z" for a, b in places[sound].tolist()] if is_dotted else []
        edge = path(places, READ if self.label else DRAWN) if self.width else "".join(dots)
        stroke = self._stroke() if self.width else self._round_stroke()
        elements = f'<path {self.attributes}d="{edge}" fill="none"{stroke}/>'
        if self.dots and self.at:
            named = zip(dots, compress(self.at, sound), strict=True)
            elements += "".join(
                f'<path d="{dot}"{self._round_stroke()}><title>{escape(at)}</title></path>'
                for dot, at in named
            )
        elif self.dots and self.width:
            elements += f'<path d="{"".join(dots)}"{self._round_stroke()}/>'
        return coloured(elements, self.colour, self.is_shown)

    def key(self) -> str:
        """Return a piece of the line."""
        dot = f'<path d="M{0.5 * KEY:g} 5Z"{self._round_stroke()}/>' if self.dots else ""
        line = f'<path d="M0 5H{KEY:g}"{self._stroke()}/>' if self.width else ""
        return coloured(line + dot, self.colour)

    def _stroke(self) -> str:
        dashes = f' stroke-dasharray="{self.dashes}"' if self.dashes else ""
        return f' stroke="currentColor" stroke-width="{self.width:g}" stroke-linejoin="round"{dashes}'

    def _round_stroke(self) -> str:
        return f' stroke="currentColor" stroke-width="{2.0 * self.dots:g}" stroke-linecap="round"'


@dataclass(frozen=True)
class Level(Mark):
    """Horizontal line with its name beside the plot."""

    ACROSS = ()
    UP = ("value",)
    label: str
    value: float
    colour: str = "difference"

    def draw(self, x: Scale, y: Scale) -> str:
        """Return the line without its name, which the chart places."""
        height = float(y.at(self.value))
        line = f'<path d="M{x.start:.2f} {height:.2f}H{x.end:.2f}" stroke-dasharray="5 2" '
        return coloured(line + 'stroke="currentColor"/>', self.colour)


@dataclass(frozen=True)
class Words(Mark):
    """Text at a point, shifted by pixels.

    anchor: "start", "middle" or "end".
    """

    label: str
    x: float
    y: float
    shift: tuple[float, float] = (0.0, 0.0)
    anchor: str = "start"
    colour: str = "ink"

    def draw(self, x: Scale, y: Scale) -> str:
        """Return the text with a white edge.

        The edge separates it from lines.
        """
        return coloured("".join(name.draw(HALO) for name in self.names(x, y)), self.colour)

    def names(self, x: Scale, y: Scale) -> list[Name]:
        """Return the text at its place."""
        across, down = float(x.at(self.x)) + self.shift[0], float(y.at(self.y)) + self.shift[1]
        return [Name(self.label, across, down, self.anchor)] if self.label else []


@dataclass(frozen=True)
class Swatch(Mark):
    """Entry of the legend alone.

    label: meaning of the colour.
    """

    ACROSS = ()
    UP = ()
    label: str
    colour: str

    def key(self) -> str:
        """Return a patch of the colour."""
        return patch(self.colour)


def key(label: str, colour: str, width: float, dashes: str = "") -> Line:
    """Return an entry of the legend alone, as a line."""
    return Line(label, np.zeros(0), np.zeros(0), colour, width, dashes)


def patch(colour: str, strength: float = 1.0) -> str:
    """Return a filled rectangle for the legend."""
    return coloured(f'<rect width="{KEY:g}" height="10" fill-opacity="{strength:g}"/>', colour)


def found_ranges(marks: Sequence[Mark]) -> tuple[Range, Range]:
    """Return the joint ranges of all marks."""
    ranges = np.array([mark.ranges() for mark in marks])
    (low_x, low_y), (high_x, high_y) = ranges[:, :, 0].min(axis=0), ranges[:, :, 1].max(axis=0)
    return (float(low_x), float(high_x)), (float(low_y), float(high_y))


def dot(point: Floats, colour: str, size: float) -> Line:
    """Return a point, shape (2,), as a dot of this radius [pixels]."""
    return Line("", point[:1], point[1:], colour, 0.0, dots=size)
