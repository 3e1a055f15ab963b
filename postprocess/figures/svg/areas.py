"""Areas that a plot shows: layers between lines, boxes, shaded ranges, outlines."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import compress
from typing import Any

import numpy as np

from postprocess.figures.svg.drawing import Floats, coloured, named, path, words
from postprocess.figures.svg.marks import Mark, patch
from postprocess.figures.svg.scale import Scale

SMALL = 4.0
"""Pixels of a box."""


@dataclass(frozen=True)
class Layer(Mark):
    """What lies between two lines over the same x, shape (n,); the value shown on pages is their distance."""

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
        name, edge = named(self.label, self.high - self.low), path(np.concatenate([forth, back]))
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
        is_small = bool((np.minimum(right - left, bottom - top) < SMALL).any())
        gap = 0.0 if is_small else 0.4
        edges = zip(left + gap, top + gap, right - gap, bottom - gap, strict=True)
        look = f' fill-opacity="{self.strength:g}"' + is_small * ' shape-rendering="crispEdges"'
        shown = self._shown(
            ["M{0:.2f} {1:.2f}H{2:.2f}V{3:.2f}H{0:.2f}Z".format(*edge) for edge in edges], look
        )
        if not self.values:
            return shown
        centres = zip(0.5 * (left + right), 0.5 * (top + bottom), strict=True)
        unseen = "".join(f"M{a:.2f} {b:.2f}Z" for a, b in centres)
        return f'{shown}<path {named(self.label, self.values, self.at)}d="{unseen}"/>'

    def _shown(self, drawn: list[str], look: str) -> str:
        """The boxes of each colour as one path."""
        colours = [self.colour] * len(drawn) if isinstance(self.colour, str) else self.colour
        paths = {
            one: "".join(compress(drawn, [each == one for each in colours])) for one in dict.fromkeys(colours)
        }
        return "".join(coloured(f'<path d="{edge}"{look}/>', one) for one, edge in paths.items())

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
            return coloured(line + words(self.label, left + 3.0, y.end + 11.0, size=10.0), self.colour)
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
        look = f'fill-opacity="{self.fill:g}" stroke="currentColor" '
        return coloured(f'<path d="{edge}Z" {look}stroke-opacity="{self.strength:.3g}"/>', self.colour)
