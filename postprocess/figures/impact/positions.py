"""The strip of positions: outlines of the vehicle along the wall, and where the strikes are."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from postprocess.figures.impact.strikes import StrikeMark
from postprocess.svg.chart import Axis, Chart, Plot, draw_chart
from postprocess.svg.marks import Line, Mark, Outline, Words

Floats = NDArray[np.float64]

WIDTH, EDGE = 900.0, 0.4
"""Width of the figure [pixels]; free space about what is drawn [m]."""

TOP, ROW = 0.9, 0.5
"""Height of the row of instants above the vehicle, and of each strike's row below the wall's face [m]."""


def vehicle_outlines(
    x: Floats, y: Floats, theta: Floats, length: float, width: float, centre: float
) -> Floats:
    """Corners of a rigid vehicle, front and rear of the wall's side first: shape (n, 4, 2) [m].

    x, y: centre of mass [m], theta: angle between side and wall [rad], shape (n,); centre: how far behind the front the
    centre of mass lies [m].
    """
    heading = np.stack([np.cos(theta), -np.sin(theta)], axis=-1)
    left = np.stack([np.sin(theta), np.cos(theta)], axis=-1)
    ends = [centre * heading - 0.5 * width * left, (centre - length) * heading - 0.5 * width * left]
    across = [ends[1] + width * left, ends[0] + width * left]
    return np.asarray(np.stack([x, y], axis=-1)[:, None] + np.stack([*ends, *across], axis=1))


def draw_positions(
    outlines: Floats,
    instants: Sequence[float],
    strikes: Sequence[StrikeMark] = (),
    path: Floats | None = None,
) -> Chart:
    """Outlines at these instants [s], later ones darker, over the wall Y = 0; strikes as bars below its face.

    outlines: shape (k, points, 2) [m]; path: of the centre of mass, shape (n, 2) [m].
    """
    caption = (
        "Positions of the vehicle, later ones darker; below the wall's face what is crushed, and the strikes"
    )
    points = outlines.reshape(-1, 2)
    low, high = points.min(axis=0) - EDGE, points.max(axis=0) + np.array([2.0 * EDGE, TOP])
    rows = low[1] - ROW * np.arange(len(strikes))
    low[1] -= ROW * len(strikes)
    wall = np.array([(low[0], low[1]), (high[0], low[1]), (high[0], 0.0), (low[0], 0.0)])
    marks: list[Mark] = [Outline(wall[:, 0], wall[:, 1], "grey", fill=0.25)]
    marks += [] if path is None else [Line("", path[:, 0], path[:, 1], "soft", 0.8, "4 3")]
    for number, (outline, instant) in enumerate(zip(outlines, instants, strict=True)):
        marks += _position(outline, instant, (number + 1) / len(outlines), high[1])
    for strike, row in zip(strikes, rows, strict=True):
        marks += _strike(strike, row, high[0])
    x, y = Axis("X along the wall [m]", low[0], high[0]), Axis("Y [m]", low[1], high[1])
    return draw_chart(
        "positions", caption, (Plot(tuple(marks), y, None, has_grid=False),), x, "Motion", WIDTH
    )


def _position(outline: Floats, instant: float, shade: float, top: float) -> list[Mark]:
    """One outline; its instant on top, over the point that lies farthest along the wall."""
    x, y = outline[outline[:, 0].argmax()]
    foot = top - 0.5 * TOP
    return [
        Outline(outline[:, 0], outline[:, 1], "fe", 0.25 + 0.75 * shade),
        Line("", np.array([x, x]), np.array([y, foot]), "steel", 0.7, "1 2"),
        Words(f"{instant:.2f} s", x, foot, (0.0, -3.0), "middle", "fe"),
    ]


def _strike(strike: StrikeMark, height: float, end: float) -> list[Mark]:
    """A bar where it is, named behind it or, near the end of the strip, before it."""
    (first, last), near = sorted(strike.places), max(strike.places) > end - 3.5
    place, shift, anchor = (first, -6.0, "end") if near else (last, 6.0, "start")
    text = f"{strike.corner} {strike.start:.3f} to {strike.end:.3f} s"
    bar = Line("", np.array(strike.places), np.full(2, height), strike.colour, 4.0)
    return [bar, Words(text, place, height, (shift, 3.5), anchor, strike.colour)]
