"""Vehicle beside the wall, seen from above and to scale.

Positions at several instants are drawn over one another, and one of them may be animated. The set-up has the vehicle
at first touch and at the strike, with its dimensions.
"""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from postprocess.figures.impact import StrikeMark, Strikes, corner_colour
from postprocess.svg import chart
from postprocess.svg.areas import Outline, area
from postprocess.svg.chart import Chart
from postprocess.svg.marks import Line, Mark, Swatch, Words, dot
from postprocess.svg.motion import SLOWER, Moving
from postprocess.svg.scales import Floats
from postprocess.units import measure

EDGE = 0.4
"""Margin about the drawing [m]."""

NAME = 0.04
"""Distance of the names of two instants that stand in one row, over the width of the chart.

Closer ones take a second row, and further ones have no name.
"""

TOP, ROW = 0.9, 0.5
"""Height of the row of instants above the vehicle, and of a strike's row below the wall's face [m]."""

COLOURS = ("steel", "fe")
"""Colours of first touch and strike."""


def vehicle_outlines(
    x: Floats, y: Floats, theta: Floats, length: float, width: float, centre: float
) -> Floats:
    """Return the corners of a rigid vehicle, shape (n, 4, 2) [m].

    The front and rear corners of the side at the wall come first. x, y: centre of mass [m], theta: angle between side
    and wall [rad], shape (n,); centre: distance of the centre of mass behind the front [m].
    """
    heading = np.stack([np.cos(theta), -np.sin(theta)], axis=-1)
    lateral = np.stack([np.sin(theta), np.cos(theta)], axis=-1)
    ends = [centre * heading - 0.5 * width * lateral, (centre - length) * heading - 0.5 * width * lateral]
    across = [ends[1] + width * lateral, ends[0] + width * lateral]
    return np.asarray(np.stack([x, y], axis=-1)[:, None] + np.stack([*ends, *across], axis=1))


def draw_positions(
    outlines: Floats,
    instants: Sequence[float],
    strikes: Strikes = (),
    motion: tuple[Floats, Floats] | None = None,
) -> Chart:
    """Draw outlines at instants, later ones more opaque.

    outlines: shape (k, points, 2) [m]; instants [s]; strikes: drawn as bars below the face of the wall Y = 0; motion:
    even instants [s] and outlines there, which are animated.
    """
    caption = "Positions of the vehicle, later ones more opaque"
    if strikes:
        caption += "; below the wall's face what is crushed, and the strikes"
    if motion is not None:
        caption += f"; the filled one is animated, {SLOWER:g} times slower than the vehicle"
    points = outlines.reshape(-1, 2)
    low, high = points.min(axis=0) - EDGE, points.max(axis=0) + np.array([2.0 * EDGE, TOP])
    rows = low[1] - ROW * np.arange(len(strikes))
    low[1] -= ROW * len(strikes)
    marks: list[Mark] = []
    ends, least = [-math.inf, -math.inf], NAME * (high[0] - low[0])
    for number, (outline, instant) in enumerate(zip(outlines, instants, strict=True)):
        x = outline[:, 0].max()
        row = next((row for row, end in enumerate(ends) if abs(x - end) >= least), None)
        if row is not None:
            ends[row] = x
        marks += _position(outline, instant, (number + 1) / len(outlines), high[1], row)
    if motion is not None:
        t, moved = motion
        marks.append(Moving("", t, moved[..., 0], moved[..., 1]))
    for strike, row in zip(strikes, rows, strict=True):
        marks += _strike(strike, row, high[0])
    return plan_view(
        "positions", caption, marks, np.array([low, high]), "Motion", ("X along the wall [m]", "Y [m]")
    )


def plan_view(
    name: str,
    caption: str,
    marks: Sequence[Mark],
    frame: Floats,
    group: str,
    labels: tuple[str, str] = ("", ""),
    width: float = chart.FULL,
) -> Chart:
    """Draw marks beside the wall Y <= 0, seen from above.

    frame: its lower and upper corner, shape (2, 2) [m]; labels: of both axes, which without them have no ticks; width:
    of the chart [pixels].
    """
    low, high = frame
    wall = np.array([(low[0], low[1]), (high[0], low[1]), (high[0], 0.0), (low[0], 0.0)])
    ends = zip(labels, frame.T.tolist(), strict=True)
    x, y = (chart.Axis(label, a, b, named=None if label else ()) for label, (a, b) in ends)
    plot = chart.Plot((area(wall, "grey", 0.25), *marks), y, None, "xy", has_grid=False)
    return chart.Chart(name, caption, (plot,), x, group, width)


def _position(outline: Floats, instant: float, shade: float, top: float, row: int | None) -> list[Mark]:
    """Return one outline and its instant.

    The instant stands in this row on top, above the point farthest along the wall.
    """
    x, y = outline[outline[:, 0].argmax()]
    foot, text = top - 0.5 * TOP, f"{instant:.2f} s"
    name = [] if row is None else [Words(text, x, foot, (0.0, -3.0 - 10.0 * row), "middle", "fe")]
    return [
        Outline(outline[:, 0], outline[:, 1], "fe", 0.25 + 0.75 * shade, label=text),
        Line("", np.array([x, x]), np.array([y, foot]), "steel", 0.7, "1 2"),
        *name,
    ]


def _strike(strike: StrikeMark, height: float, end: float) -> list[Mark]:
    """Return a bar at the place of a strike, with its name.

    The name stands behind it, near the end of the strip before it.
    """
    (first, last), near = sorted(strike.places), max(strike.places) > end - 3.5
    place, shift, anchor = (first, -6.0, "end") if near else (last, 6.0, "start")
    text = f"{strike.corner} {strike.start:.2f} s"
    colour = corner_colour(strike.corner)
    bar = Line("", np.array(strike.places), np.full(2, height), colour, 4.0)
    return [bar, Words(text, place, height, (shift, 3.5), anchor, colour)]


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
    """Draw the wall Y = 0 and a vehicle's units to scale.

    units: the foremost first; words: texts by "length" and "width" of the foremost unit, "angle", "speed", "first" and
    "second" position, and "slide" between them, which is measured if it has no text; caption: also
    the alternative text of the drawing.
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
        *arrow(from_point, to_point, size),
        _words(slide, 0.5 * (from_point + to_point), (0.0, -3.0), "middle"),
    ]
    return plan_view("set-up", caption, marks, np.array([(start_x, low), (end_x, high)]), "Set-up")


def _line(points: Floats, colour: str = "ink", width: float = 0.8) -> Line:
    return Line("", points[:, 0], points[:, 1], colour, width)


def _words(text: str, at: Floats, shift: tuple[float, float], anchor: str = "start") -> Words:
    return Words(text, float(at[0]), float(at[1]), shift, anchor)


def _angle(place: Floats, theta: float, size: float, text: str) -> list[Mark]:
    """Return the arc of the angle at P."""
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
    """Return the speed arrow at first touch."""
    start, theta = np.array([unit.x_g[0], unit.y_g[0]]), float(unit.theta[0])
    end = start + 0.3 * size * np.array([np.cos(theta), -np.sin(theta)])
    return [*arrow(start, end, size), _words(text, end, (0.0, -8.0), "middle")]


def arrow(start: Floats, end: Floats, size: float, colour: str = "ink") -> list[Mark]:
    """Return an arrow with a head in proportion to a size."""
    along = (end - start) / (float(np.linalg.norm(end - start)) or 1.0) * 0.03 * size
    across = 0.3 * np.array([-along[1], along[0]])
    head = np.stack([end, end - along + across, end - along - across])
    return [_line(np.stack([start, end]), colour, 1.2), area(head, colour, 1.0)]
