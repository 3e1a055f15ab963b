"""Marks of a plot that cover areas."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import compress

import numpy as np

from postprocess.svg.marks import READ, SMALL, Mark, Name, coloured, patch, path, text_width
from postprocess.svg.scales import Floats, Scale

SMALL_BOX = 9.0
"""Size below which boxes are drawn without gaps [pixels]."""


@dataclass(frozen=True)
class Layer(Mark):
    """Area between two lines over the same x, shape (n,).

    Pages show the distance of the lines.
    """

    UP = ("low", "high")
    label: str
    x: Floats
    low: Floats
    high: Floats
    colour: str = "steel"
    strength: float = 0.7

    def draw(self, x: Scale, y: Scale) -> str:
        """Return a closed path along both lines."""
        along = x.at(self.x)
        forth = np.stack([along, y.at(self.high)], axis=-1)
        back = np.stack([along, y.at(self.low)], axis=-1)[::-1]
        edge = path(np.concatenate([forth, back]), READ)
        return coloured(
            f'<path {self.attributes}class="layer" d="{edge}Z" fill-opacity="{self.strength:g}"/>',
            self.colour,
        )

    def key(self) -> str:
        """Return a patch of its colour."""
        return patch(self.colour, self.strength)


@dataclass(frozen=True)
class Boxes(Mark):
    """Bars or cells between two values of x and of y.

    x, y: shape (n, 2). Boxes have one colour, or one each. Pages show `values` at `at`, by default the middle.
    strength: opacity.
    """

    label: str
    x: Floats
    y: Floats
    colour: str | Sequence[str] = "steel"
    values: Sequence[str] | Sequence[float] = ()
    at: Sequence[str] = ()
    strength: float = 1.0

    def draw(self, x: Scale, y: Scale) -> str:
        """Return one path for each colour.

        Boxes that are not small have gaps. Values require an invisible path through the centres.
        """
        start, end = np.sort(x.at(self.x)).T
        top, bottom = np.sort(y.at(self.y)).T
        is_small = bool((np.minimum(end - start, bottom - top) < SMALL_BOX).any())
        gap = 0.0 if is_small else 0.4
        edges = zip(start + gap, top + gap, end - gap, bottom - gap, strict=True)
        style = f' fill-opacity="{self.strength:g}"' + is_small * ' shape-rendering="crispEdges"'
        drawn = ["M{0:.2f} {1:.2f}H{2:.2f}V{3:.2f}H{0:.2f}Z".format(*edge) for edge in edges]
        colours = [self.colour] * len(drawn) if isinstance(self.colour, str) else self.colour
        elements = ""
        for colour in dict.fromkeys(colours):
            path = "".join(compress(drawn, [own_colour == colour for own_colour in colours]))
            elements += coloured(f'<path d="{path}"{style}/>', colour)
        if not self.values:
            return elements
        centres = zip(0.5 * (start + end), 0.5 * (top + bottom), strict=True)
        invisible = "".join(f"M{a:.2f} {b:.2f}Z" for a, b in centres)
        return f'<g>{elements}<path {self.attributes}d="{invisible}"/></g>'

    def key(self) -> str:
        """Return a patch if boxes have one colour."""
        return patch(self.colour, self.strength) if isinstance(self.colour, str) else ""


@dataclass(frozen=True)
class Span(Mark):
    """Shaded range of x, a dashed line if its width is zero.

    Its name stands at the top of the plot; row: of the name.
    """

    ACROSS = ("start", "end")
    UP = ()
    label: str
    start: float
    end: float
    colour: str = "soft"
    row: int = 0

    def draw(self, x: Scale, y: Scale) -> str:
        """Return the band or line with its name."""
        start, end = self._ends(x)
        shape = (
            f'<path d="M{start:.2f} {y.end:.2f}V{y.start:.2f}" stroke="currentColor" stroke-dasharray="2 2"/>'
        )
        if start != end:
            box = f"M{start:.2f} {y.end:.2f}H{end:.2f}V{y.start:.2f}H{start:.2f}Z"
            shape = f'<path d="{box}" fill-opacity="0.1"/>'
        return coloured(shape + "".join(name.draw() for name in self.names(x, y)), self.colour)

    def names(self, x: Scale, y: Scale) -> list[Name]:
        """Return the name, centred on a band or beside a line."""
        start, end = self._ends(x)
        is_last = start + text_width(self.label, SMALL) + 6.0 > x.end
        beside = (start - 3.0, "end") if is_last else (start + 3.0, "start")
        across, anchor = beside if start == end else (0.5 * (start + end), "middle")
        return [Name(self.label, across, y.end + SMALL * (1 + self.row), anchor)] if self.label else []

    def _ends(self, x: Scale) -> Floats:
        """Return the ends within the plot [pixels]."""
        return np.sort(np.clip(x.at([self.start, self.end]), x.start, x.end))


@dataclass(frozen=True)
class Outline(Mark):
    """Closed polygon, faintly filled.

    x, y: shape (n,). Its label is in the table, not in the legend.
    """

    x: Floats
    y: Floats
    colour: str = "fe"
    strength: float = 1.0
    fill: float = 0.04
    label: str = ""

    def draw(self, x: Scale, y: Scale) -> str:
        """Return a closed path."""
        edge = self.attributes + f'd="{path(np.stack([x.at(self.x), y.at(self.y)], axis=-1))}Z"'
        style = f'fill-opacity="{self.fill:g}" stroke="currentColor" stroke-opacity="{self.strength:.3g}"'
        return coloured(f"<path {edge} {style}/>", self.colour)


def area(points: Floats, colour: str, fill: float = 0.04) -> Outline:
    """Return the polygon through points, shape (n, 2)."""
    return Outline(points[:, 0], points[:, 1], colour, fill=fill)
