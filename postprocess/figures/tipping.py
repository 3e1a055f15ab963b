"""Chart of rolls over heights of centre and wall."""

from typing import NamedTuple

import numpy as np

from postprocess.svg import chart
from postprocess.svg.chart import Chart
from postprocess.svg.marks import Boxes, Layer, Level, Line, Mark, Swatch
from postprocess.svg.scales import Floats, Shades, cells_about

MAP, RED = 620.0, "#d8453a"

INCHES = (27, 32, 36, 42, 54)
"""Heights of common walls on the map [in]."""


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
