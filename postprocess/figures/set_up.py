"""Set-up from above, to scale.

The wall, and the vehicle at first touch and at the strike.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from postprocess.figures.positions import plan_view, vehicle_outlines
from postprocess.svg.chart import Chart
from postprocess.svg.marks import Line, Mark, Swatch, Words, area, dot
from postprocess.svg.scales import Floats
from postprocess.units import measure

COLOURS = ("steel", "fe")
"""Colours of first touch and strike."""

SYMBOLS = {"length": "L", "width": "B", "angle": "θ", "speed": "v_0", "slide": "s"}
SYMBOLS |= {"first": "first touch", "second": "tail-slap"}
SCHEME = "Vehicle of length L and width B from above, at first touch and at the tail-slap"
"""Texts of a drawing without numbers, and its caption."""


class Unit(NamedTuple):
    """Rigid rectangle at both instants.

    x_g, y_g [m] and theta [rad], shape (2,); length, width and distance of the centre of mass behind the front [m].
    """

    x_g: Floats
    y_g: Floats
    theta: Floats
    length: float
    width: float
    centre: float


def draw_set_up(units: Sequence[Unit], words: Mapping[str, str], caption: str) -> Chart:
    """Draw the wall Y = 0 and the units of a vehicle.

    Parameters
    ----------
    units : sequence of Unit
        Of a vehicle one, of a train several, the foremost first.
    words : mapping of str
        Texts by the keys of `SYMBOLS`: dimensions of the foremost unit, angle, speed, names of both positions, and
        the distance between them along the wall, which is measured if it has no text.
    caption : str
        Also the alternative text of the drawing.

    Returns
    -------
    Chart
        With equal scales.
    """
    outlines = [vehicle_outlines(*unit) for unit in units]
    front, size = outlines[0], units[0].length
    points = np.concatenate(outlines).reshape(-1, 2)
    (start_x, low), (end_x, high) = points.min(axis=0), points.max(axis=0)
    start_x, end_x, high = start_x - 0.22 * size, end_x + 0.05 * size, high + 0.1 * size
    low = min(low, 0.0) - 0.05 * (end_x - start_x)
    marks: list[Mark] = [_words("wall", np.array([start_x, low]), (4.0, -4.0))]
    for outline in outlines:
        marks += [area(place, colour, 0.12) for place, colour in zip(outline, COLOURS, strict=True)]
    marks += [Swatch(words[key], colour) for key, colour in zip(("first", "second"), COLOURS, strict=True)]
    for k, colour in enumerate(COLOURS):
        centre = np.array([units[0].x_g[k], units[0].y_g[k]])
        for name, at, across in (("P", front[k, 0], 4.0), ("E", front[k, 1], -10.0), ("G", centre, 5.0)):
            marks += [dot(at, colour, 2.5), _words(name, at, (across, 12.0))]
    marks += _angle(front[0], float(units[0].theta[0]), size, words["angle"])
    marks += _dimensions(front[0], size, words)
    marks += _speed(units[0], size, words["speed"])
    from_point, to_point = (np.array([front[k, 0, 0], 0.5 * low]) for k in (0, 1))
    slide = words.get("slide") or measure(to_point[0] - from_point[0], "m", ".3g")
    marks += [
        *_arrow(from_point, to_point, size),
        _words(slide, 0.5 * (from_point + to_point), (0.0, -3.0), "middle"),
    ]
    return plan_view("set-up", caption, marks, np.array([(start_x, low), (end_x, high)]), "Set-up")


def _line(points: Floats, colour: str = "ink", width: float = 0.8) -> Line:
    return Line("", points[:, 0], points[:, 1], colour, width)


def _words(text: str, at: Floats, shift: tuple[float, float], anchor: str = "start") -> Words:
    return Words(text, float(at[0]), float(at[1]), shift, anchor)


def _angle(place: Floats, theta: float, size: float, text: str) -> list[Mark]:
    """Return the arc of the angle at the corner P."""
    turned = np.linspace(0.0, theta, 20)
    arc = place[0] + 0.45 * size * np.stack([-np.cos(turned), np.sin(turned)], axis=1)
    return [_line(arc), _words(text, arc[10], (-5.0, 4.0), "end")]


def _dimensions(place: Floats, size: float, words: Mapping[str, str]) -> list[Mark]:
    """Return the dimension lines of length and width."""
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
    """Return the arrow of the speed at first touch."""
    start, theta = np.array([unit.x_g[0], unit.y_g[0]]), float(unit.theta[0])
    end = start + 0.3 * size * np.array([np.cos(theta), -np.sin(theta)])
    return [*_arrow(start, end, size), _words(text, end, (0.0, -8.0), "middle")]


def _arrow(start: Floats, end: Floats, size: float) -> list[Mark]:
    """Return a line with a filled head at its end."""
    along = (end - start) / (float(np.linalg.norm(end - start)) or 1.0) * 0.03 * size
    across = 0.3 * np.array([-along[1], along[0]])
    head = np.stack([end, end - along + across, end - along - across])
    return [_line(np.stack([start, end]), width=1.2), area(head, "ink", 1.0)]
