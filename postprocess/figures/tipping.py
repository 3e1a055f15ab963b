"""Charts of vehicles that roll over a wall.

Roll and wheel loads over time, the largest roll, and rolls over heights of centre and wall.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from postprocess.figures import histories
from postprocess.svg import chart
from postprocess.svg.chart import Chart
from postprocess.svg.marks import Boxes, Layer, Level, Line, Mark, Swatch, Words, area, dot, key
from postprocess.svg.scales import Floats, Shades, cells_about

WIDE, NARROW, MAP, RED = 540.0, 360.0, 620.0, "#d8453a"
EDGE, WALL = 0.3, 1.2
"""Margin about the drawing, and depth of the wall [m]."""

LOOKS = (("fe", 1.6, ""), ("rigid", 1.2, "5 3"))
"""Colour, width and dashes of each model's line."""

INCHES = (27, 32, 36, 42, 54)
"""Heights of common walls on the map [in]."""


class Roll(NamedTuple):
    """Roll and wheel loads over time.

    t [s], roll [rad], loads of the near and the far side of the wall [N]; shape (n,).
    """

    t: Floats
    roll: Floats
    near: Floats
    far: Floats


class Leaning(NamedTuple):
    """Vehicle from behind beside the wall.

    Width, track, heights of centre of mass and wall [m].
    """

    width: float
    track: float
    centre: float
    wall: float


def draw_roll(rolls: Mapping[str, Roll]) -> Chart:
    """Draw roll and wheel loads of each model over time.

    The first model is drawn bold, and loads are its own.
    """
    lines = []
    for (name, model), (colour, width, dashes) in zip(rolls.items(), LOOKS, strict=False):
        t, roll = histories.thinned(model.t, np.degrees(model.roll))
        lines.append(Line(f"roll, {name}", t, roll, colour, width, dashes))
    first, loads = next(iter(rolls.values())), []
    sides = (("wheels of the wall's side", first.near, "red"), ("of the far side", first.far, "steel"))
    for label, load, colour in sides:
        t, loads_kn = histories.thinned(first.t, load / 1e3)
        loads.append(Line(label, t, loads_kn, colour))
    keys = [key(label, colour, 1.4) for label, _, colour in sides]
    roll_plot = chart.Plot((*lines, *keys), chart.Axis("roll towards the wall [deg]"), 150.0)
    load_plot = chart.Plot(tuple(loads), chart.Axis("load [kN]", low=0.0), 110.0)
    caption = "Roll towards the wall, and loads of the wheels"
    return chart.draw_chart("roll", caption, (roll_plot, load_plot), histories.TIME, "Tipping", WIDE)


def draw_leaning(vehicle: Leaning, height: float, roll: float) -> Chart:
    """Draw the vehicle at rest and at its largest roll, from behind.

    height: of the rolled centre of mass [m]; roll [rad]. The side lies on the top of the wall; the box is twice as
    high as its centre of mass.
    """
    caption = "Vehicle from behind, at rest and at its largest computed roll; box twice as high as its centre of mass "
    caption += "(dot)"
    half, marks, top = 0.5 * vehicle.width, list[Mark](), 2.0 * vehicle.centre
    box = np.array([(-half, 0.0), (half, 0.0), (half, top), (-half, top)])
    wheels = 0.5 * vehicle.track * np.array([(-1.0, 0.0), (1.0, 0.0)])
    for at, angle, colour in ((vehicle.centre, 0.0, "soft"), (height, roll, "fe")):
        s, c = np.sin(angle), np.cos(angle)
        turn, away = np.array([(c, s), (-s, c)]), (half - (at - vehicle.wall) * s) / c
        corners, feet = ((points - (0.0, vehicle.centre)) @ turn + (away, at) for points in (box, wheels))
        marks.append(area(corners, colour))
        marks.append(Line("", feet[:, 0], feet[:, 1], colour, 0.0, dots=4.0))
        marks.append(dot(np.array([away, at]), colour, 3.0))
    low, high, top = -WALL, vehicle.width + 2.0 * EDGE, top + 3.0 * EDGE
    wall = np.array([(low, 0.0), (0.0, 0.0), (0.0, vehicle.wall), (low, vehicle.wall)])
    marks.append(area(wall, "grey", 0.25))
    marks.append(Words(f"{np.degrees(roll):.1f} deg", 0.5 * high, top - EDGE, anchor="middle", colour="fe"))
    x, y = chart.Axis("across the wall [m]", low, high), chart.Axis("height [m]", -EDGE, top)
    plot = chart.Plot(tuple(marks), y, None, has_grid=False)
    return chart.draw_chart("leaning", caption, (plot,), x, "Tipping", NARROW)


class Boundary(NamedTuple):
    """Lowest walls that prevent rollover [m].

    centres: heights of the centre of mass; line: walls, shape (k,); band: 5, 50 and 95 % of samples, shape (3, n),
    over band_centres.
    """

    centres: Floats
    line: Floats
    band_centres: Floats
    band: Floats


def draw_map(
    centres: Floats, walls: Floats, rolls: Floats, boundary: Boundary, nominal: tuple[float, float]
) -> Chart:
    """Draw the largest rolls over heights of wall and centre of mass.

    rolls [rad], shape (walls, centres), red where the vehicle tips; nominal: centre and wall of the scene [m].
    """
    degrees, tips = np.degrees(rolls).ravel(), rolls.ravel() >= 0.5 * np.pi
    shades = Shades(0.0, float(degrees[~tips].max(initial=1.0)))
    colours = np.where(tips, RED, shades.colours(np.where(tips, 0.0, degrees)))
    row, column = np.divmod(np.arange(rolls.size), centres.size)
    x, y = cells_about(centres, False)[column], cells_about(walls, False)[row]
    said = [f"{roll:.1f} deg" if roll < 90.0 else "tips" for roll in degrees]
    at = [f"wall {walls[i]:.3f} m; centre {centres[j]:.3f} m" for i, j in zip(row, column, strict=True)]
    start, end, bottom, top = (float(edge) for edge in (x.min(), x.max(), y.min(), y.max()))
    line, (low, middle, high) = (np.clip(heights, bottom, top) for heights in (boundary.line, boundary.band))
    marks: list[Mark] = [
        Boxes("largest roll", x, y, colours.tolist(), said, at),
        *(Swatch(*colour_key) for colour_key in shades.keys("deg")),
        Swatch("tips", RED),
        Layer("5 to 95 %", boundary.band_centres, low, high, "ink", 0.25),
        Line("median", boundary.band_centres, middle, "ink", 1.0, "4 3"),
        Line("lowest wall without rollover", boundary.centres, line, "ink", 2.2),
        Line("the scene", np.array(nominal[:1]), np.array(nominal[1:]), "ink", 0.0, dots=4.5),
        *(Line("", np.array([start, end]), np.full(2, 0.0254 * inches), "#ffffff", 1.0) for inches in INCHES),
        *(Level(f"{inches} in", 0.0254 * inches, "rigid") for inches in INCHES),
    ]
    across = chart.Axis("height of the centre of mass [m]", start, end, margin=0.0)
    plot = chart.Plot(tuple(marks), chart.Axis("height of the wall [m]", bottom, top), 380.0, "xy", False)
    caption = (
        "Largest roll and lowest wall without rollover, nominal (line) and in 90 % of the samples (band)"
    )
    return chart.draw_chart("map", caption, (plot,), across, "Tipping", MAP)
