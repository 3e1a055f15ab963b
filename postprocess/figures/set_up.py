"""Drawing of a set-up from above, to scale: the wall, and the vehicle at first touch and at the strike."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from postprocess.figures.impact import vehicle_outlines
from postprocess.svg import chart
from postprocess.svg.chart import Chart
from postprocess.svg.marks import Line, Mark, Outline, Swatch, Words
from postprocess.svg.scales import Floats
from postprocess.units import measure

COLOURS = ("steel", "fe")
"""Colours of first touch and strike."""

SYMBOLS = {"length": "L", "width": "B", "angle": "θ", "speed": "v_0", "slide": "s"}
SYMBOLS |= {"first": "first touch", "second": "tail-slap"}
SCHEME = "Vehicle of length L and width B from above, at first touch and at the tail-slap"
"""Words of a drawing without numbers, and its caption."""


class Unit(NamedTuple):
    """A rigid rectangle at both instants: x_g, y_g [m] and theta [rad], shape (2,); length, width and distance of the
    centre of mass behind the front [m]."""

    x_g: Floats
    y_g: Floats
    theta: Floats
    length: float
    width: float
    centre: float


def draw_set_up(units: Sequence[Unit], words: Mapping[str, str], caption: str) -> Chart:
    """Draw the wall Y = 0 and the units of a vehicle, the foremost first.

    Parameters
    ----------
    units : sequence of Unit
        One for a vehicle, more for a train.
    words : mapping of str
        Texts by the keys of `SYMBOLS`: dimensions of the foremost unit, angle, speed, names of both positions, and
        the distance between them along the wall, which is measured if it has no text.
    caption : str
        Also the text for readers who do not see the drawing.

    Returns
    -------
    Chart
        With equal scales.
    """
    outlines = [vehicle_outlines(*unit) for unit in units]
    front, size = outlines[0], units[0].length
    points = np.concatenate(outlines).reshape(-1, 2)
    (left, low), (right, high) = points.min(axis=0), points.max(axis=0)
    left, right, high = left - 0.22 * size, right + 0.05 * size, high + 0.1 * size
    low = min(low, 0.0) - 0.05 * (right - left)
    wall = np.array([(left, low), (right, low), (right, 0.0), (left, 0.0)])
    marks: list[Mark] = [_area(wall, "grey", 0.25), _words("wall", wall[0], (4.0, -4.0))]
    for each in outlines:
        marks += [_area(place, colour, 0.12) for place, colour in zip(each, COLOURS, strict=True)]
    marks += [Swatch(words[key], colour) for key, colour in zip(("first", "second"), COLOURS, strict=True)]
    for k, colour in enumerate(COLOURS):
        centre = np.array([units[0].x_g[k], units[0].y_g[k]])
        for name, at, across in (("P", front[k, 0], 4.0), ("E", front[k, 1], -10.0), ("G", centre, 5.0)):
            marks += [Line("", at[:1], at[1:], colour, 0.0, dots=2.5), _words(name, at, (across, 12.0))]
    marks += _angle(front[0], float(units[0].theta[0]), size, words["angle"])
    marks += _dimensions(front[0], size, words)
    marks += _speed(units[0], size, words["speed"])
    start, end = (np.array([front[k, 0, 0], 0.5 * low]) for k in (0, 1))
    slide = words.get("slide") or measure(end[0] - start[0], "m", ".3g")
    marks += [*_arrow(start, end, size), _words(slide, 0.5 * (start + end), (0.0, -3.0), "middle")]
    plot = chart.Plot(tuple(marks), chart.Axis("", low, high, named=()), None, has_grid=False)
    x = chart.Axis("", left, right, named=())
    return chart.draw_chart("set-up", caption, (plot,), x, "Set-up", chart.FULL)


def _line(points: Floats, colour: str = "ink", width: float = 0.8) -> Line:
    return Line("", points[:, 0], points[:, 1], colour, width)


def _area(points: Floats, colour: str, fill: float) -> Outline:
    return Outline(points[:, 0], points[:, 1], colour, fill=fill)


def _words(text: str, at: Floats, shift: tuple[float, float], anchor: str = "start") -> Words:
    return Words(text, float(at[0]), float(at[1]), shift, anchor)


def _angle(place: Floats, theta: float, size: float, text: str) -> list[Mark]:
    """Arc between the wall and the side, at the corner P, and its angle."""
    turned = np.linspace(0.0, theta, 20)
    arc = place[0] + 0.45 * size * np.stack([-np.cos(turned), np.sin(turned)], axis=1)
    return [_line(arc), _words(text, arc[10], (-5.0, 4.0), "end")]


def _dimensions(place: Floats, size: float, words: Mapping[str, str]) -> list[Mark]:
    """Lines of length and width beside the sides away from the wall and at the rear."""
    front, rear, far_rear, far_front = place
    out, back = (v / np.hypot(v[0], v[1]) * 0.04 * size for v in (far_rear - rear, rear - front))
    length, width = np.stack([far_front, far_rear]) + out, np.stack([rear, far_rear]) + back
    return [
        _line(length, "soft"),
        _words(words["length"], length.mean(axis=0), (0.0, -5.0), "middle"),
        _line(width, "soft"),
        _words(words["width"], width.mean(axis=0), (-5.0, 4.0), "end"),
    ]


def _speed(unit: Unit, size: float, text: str) -> list[Mark]:
    """Arrow of the speed at first touch, from the centre of mass."""
    start, theta = np.array([unit.x_g[0], unit.y_g[0]]), float(unit.theta[0])
    end = start + 0.3 * size * np.array([np.cos(theta), -np.sin(theta)])
    return [*_arrow(start, end, size), _words(text, end, (0.0, -8.0), "middle")]


def _arrow(start: Floats, end: Floats, size: float) -> list[Mark]:
    """A line with a filled head at its end."""
    along = (end - start) / (float(np.linalg.norm(end - start)) or 1.0) * 0.03 * size
    across = 0.3 * np.array([-along[1], along[0]])
    head = np.stack([end, end - along + across, end - along - across])
    return [_line(np.stack([start, end]), width=1.2), _area(head, "ink", 1.0)]
