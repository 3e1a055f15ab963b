"""Charts of a vehicle that rolls over a wall: roll and loads of its wheels over time, and how far it leans."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from postprocess.figures import histories
from postprocess.svg import chart
from postprocess.svg.chart import Chart
from postprocess.svg.marks import Line, Mark, Outline, Words, key
from postprocess.svg.scales import Floats

WIDE, NARROW = 540.0, 360.0
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
    caption = "Vehicle from behind, at rest and at its largest roll, or as far as it is followed; "
    caption += "a box twice as high as its centre of mass (dot)"
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
