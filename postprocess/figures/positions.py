"""Positions of a vehicle beside the wall, seen from above.

They are drawn over one another, and one of them may be animated.
"""

import math
from collections.abc import Sequence

import numpy as np

from postprocess.figures.impact import StrikeMark, Strikes, corner_colour
from postprocess.svg import chart
from postprocess.svg.chart import Chart
from postprocess.svg.marks import HOLD, Line, Mark, Moving, Outline, Words, area
from postprocess.svg.scales import Floats

EDGE = 0.4
"""Margin about the drawing [m]."""

SLOWER, MAX_POSES = 10.0, 61
"""Duration of an animation over that of the motion, and number of its keyframes."""

NAME = 0.04
"""Distance of the names of two instants that stand in one row, over the width of the chart.

Closer ones take a second row, and further ones have no name.
"""

TOP, ROW = 0.9, 0.5
"""Height of the row of instants above the vehicle, and of a strike's row below the wall's face [m]."""


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
    even instants [s] and outlines there, which are animated `SLOWER` times slower.
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
        t, moved = (of[np.unique(np.linspace(0, len(of) - 1, MAX_POSES).astype(int))] for of in motion)
        marks.append(Moving("", moved[..., 0], moved[..., 1], SLOWER * float(np.ptp(t)) / (1.0 - HOLD)))
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
) -> Chart:
    """Draw marks beside the wall Y <= 0, seen from above.

    frame: its lower and upper corner, shape (2, 2) [m]; labels: of both axes, which without them have no ticks.
    """
    low, high = frame
    wall = np.array([(low[0], low[1]), (high[0], low[1]), (high[0], 0.0), (low[0], 0.0)])
    ends = zip(labels, frame.T.tolist(), strict=True)
    x, y = (chart.Axis(label, a, b, named=None if label else ()) for label, (a, b) in ends)
    plot = chart.Plot((area(wall, "grey", 0.25), *marks), y, None, "xy", has_grid=False)
    return chart.draw_chart(name, caption, (plot,), x, group, chart.FULL)


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
    text = f"{strike.corner} {strike.start:.3f} to {strike.end:.3f} s"
    colour = corner_colour(strike.corner)
    bar = Line("", np.array(strike.places), np.full(2, height), colour, 4.0)
    return [bar, Words(text, place, height, (shift, 3.5), anchor, colour)]
