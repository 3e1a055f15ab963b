"""Charts of a vehicle that rolls over a wall: roll and loads of its wheels over time, and how far it leans."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from postprocess.figures import histories
from postprocess.svg import chart
from postprocess.svg.chart import Chart
from postprocess.svg.marks import Boxes, Layer, Level, Line, Mark, Outline, Swatch, Words, key
from postprocess.svg.scales import Floats, Shades, cells_about

WIDE, NARROW, MAP, RED = 540.0, 360.0, 620.0, "#d8453a"
EDGE, WALL = 0.3, 1.2
"""Free space about what is drawn, and depth of the wall [m]."""

LOOKS = (("fe", 1.6, ""), ("rigid", 1.2, "5 3"))
"""Colour, width and dashes of each model's line."""


class Roll(NamedTuple):
    """A roll over time t [s], shape (n,): roll [rad], loads of the wheels of the wall's and of the far side [N]."""

    t: Floats
    roll: Floats
    near: Floats
    far: Floats


class Leaning(NamedTuple):
    """A vehicle from behind, the wall on its left: its width and track, heights of its centre of mass and of the wall
    [m]."""

    width: float
    track: float
    centre: float
    wall: float


def draw_roll(rolls: Mapping[str, Roll]) -> Chart:
    """Roll and loads over time, of each model by its name; the first is drawn bold, loads of it alone."""
    lines = []
    for (name, own), (colour, width, dashes) in zip(rolls.items(), LOOKS, strict=False):
        t, roll = histories.thinned(own.t, np.degrees(own.roll))
        lines.append(Line(f"roll, {name}", t, roll, colour, width, dashes))
    first, loads = next(iter(rolls.values())), []
    sides = (("wheels of the wall's side", first.near, "red"), ("of the far side", first.far, "steel"))
    for label, load, colour in sides:
        t, shown = histories.thinned(first.t, load / 1e3)
        loads.append(Line(label, t, shown, colour))
    keys = [key(label, colour, 1.4) for label, _, colour in sides]
    roll_plot = chart.Plot((*lines, *keys), chart.Axis("roll towards the wall [deg]"), 150.0)
    load_plot = chart.Plot(tuple(loads), chart.Axis("load [kN]", low=0.0), 110.0)
    caption = "Roll towards the wall, and loads of the wheels"
    return chart.draw_chart("roll", caption, (roll_plot, load_plot), histories.TIME, "Tipping", WIDE)


def draw_leaning(vehicle: Leaning, height: float, roll: float) -> Chart:
    """The vehicle at rest, and with its centre of mass at another height [m] and rolled [rad], its side on the wall's
    top; a box twice as high as its centre of mass."""
    caption = "Vehicle from behind, at rest and at its largest computed roll; box twice as high as its centre of mass "
    caption += "(dot)"
    half, marks, top = 0.5 * vehicle.width, list[Mark](), 2.0 * vehicle.centre
    box = np.array([(-half, 0.0), (half, 0.0), (half, top), (-half, top)])
    wheels = 0.5 * vehicle.track * np.array([(-1.0, 0.0), (1.0, 0.0)])
    for at, angle, colour in ((vehicle.centre, 0.0, "soft"), (height, roll, "fe")):
        s, c = np.sin(angle), np.cos(angle)
        turn, away = np.array([(c, s), (-s, c)]), (half - (at - vehicle.wall) * s) / c
        corners, feet = ((points - (0.0, vehicle.centre)) @ turn + (away, at) for points in (box, wheels))
        marks.append(Outline(corners[:, 0], corners[:, 1], colour))
        marks.append(Line("", feet[:, 0], feet[:, 1], colour, 0.0, dots=4.0))
        marks.append(Line("", np.array([away]), np.array([at]), colour, 0.0, dots=3.0))
    low, high, top = -WALL, vehicle.width + 2.0 * EDGE, top + 3.0 * EDGE
    wall = np.array([(low, 0.0), (0.0, 0.0), (0.0, vehicle.wall), (low, vehicle.wall)])
    marks.append(Outline(wall[:, 0], wall[:, 1], "grey", fill=0.25))
    marks.append(Words(f"{np.degrees(roll):.1f} deg", 0.5 * high, top - EDGE, anchor="middle", colour="fe"))
    x, y = chart.Axis("across the wall [m]", low, high), chart.Axis("height [m]", -EDGE, top)
    plot = chart.Plot(tuple(marks), y, None, has_grid=False)
    return chart.draw_chart("leaning", caption, (plot,), x, "Tipping", NARROW)


INCHES = (27, 32, 36, 42, 54)
"""Heights of common walls that the map marks [in]."""


class Boundary(NamedTuple):
    """Lowest walls that hold over heights of the centre of mass, shape (k,), and their 5, 50 and 95 % over others,
    shape (3, n), all [m]."""

    centres: Floats
    line: Floats
    band_centres: Floats
    band: Floats


def draw_map(
    centres: Floats, walls: Floats, rolls: Floats, boundary: Boundary, own: tuple[float, float]
) -> Chart:
    """Largest rolls [rad] over walls and centres [m], shape (walls, centres), red where the vehicle tips; own: heights
    of the scene's centre and wall [m]."""
    degrees, tips = np.degrees(rolls).ravel(), rolls.ravel() >= 0.5 * np.pi
    shades = Shades(0.0, float(degrees[~tips].max(initial=1.0)))
    shown = np.where(tips, RED, shades.colours(np.where(tips, 0.0, degrees)))
    row, column = np.divmod(np.arange(rolls.size), centres.size)
    x, y = cells_about(centres, False)[column], cells_about(walls, False)[row]
    said = [f"{roll:.1f} deg" if roll < 90.0 else "tips" for roll in degrees]
    at = [f"wall {walls[i]:.3f} m; centre {centres[j]:.3f} m" for i, j in zip(row, column, strict=True)]
    left, right, bottom, top = (float(edge) for edge in (x.min(), x.max(), y.min(), y.max()))
    line, (low, middle, high) = (np.clip(heights, bottom, top) for heights in (boundary.line, boundary.band))
    marks: list[Mark] = [
        Boxes("largest roll", x, y, shown.tolist(), said, at),
        *(Swatch(*each) for each in shades.keys("deg")),
        Swatch("tips", RED),
        Layer("5 to 95 %", boundary.band_centres, low, high, "ink", 0.25),
        Line("median", boundary.band_centres, middle, "ink", 1.0, "4 3"),
        Line("lowest wall without rollover", boundary.centres, line, "ink", 2.2),
        Line("the scene", np.array(own[:1]), np.array(own[1:]), "ink", 0.0, dots=4.5),
        *(
            Line("", np.array([left, right]), np.full(2, 0.0254 * inches), "#ffffff", 1.0)
            for inches in INCHES
        ),
        *(Level(f"{inches} in", 0.0254 * inches, "rigid") for inches in INCHES),
    ]
    across = chart.Axis("height of the centre of mass [m]", left, right, margin=0.0)
    plot = chart.Plot(tuple(marks), chart.Axis("height of the wall [m]", bottom, top), 380.0, "xy", False)
    caption = (
        "Largest roll and lowest wall without rollover, nominal (line) and in 90 % of the samples (band)"
    )
    return chart.draw_chart("map", caption, (plot,), across, "Tipping", MAP)
