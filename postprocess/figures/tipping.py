"""Charts of vehicles that roll over a wall.

Largest rolls over heights of wall and centre of mass; fraction upright, force and height of the resultant over the
height of the wall.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from postprocess.figures.studies import row_heights, row_plot
from postprocess.svg import chart
from postprocess.svg.areas import Boxes, Layer, Span
from postprocess.svg.chart import Chart
from postprocess.svg.marks import Level, Line, Mark, Swatch
from postprocess.svg.scales import Floats, Shades, cells_about
from postprocess.units import INCH

MAP, RED = 620.0, "#d8453a"

INCHES = (27, 32, 36, 42, 54)
"""Heights of common walls on the map [in]."""

OUTCOMES = (("on its side", "rigid", 0.45), ("over the wall", "red", 0.45))
"""Outcomes besides upright with colour and opacity."""


class Lines(NamedTuple):
    """Walls that keep 5, 50 and 95 % of the samples upright.

    centres: heights of the centre of mass, shape (n,); walls: heights, shape (3, n) [m]; NaN above all walls.
    """

    centres: Floats
    walls: Floats


def draw_map(
    centres: Floats, walls: Floats, rolls: Floats, lines: Lines, nominal: tuple[float, float]
) -> Chart:
    """Draw the largest rolls over heights of wall and centre of mass.

    rolls [rad], shape (walls, centres), 90 deg where the vehicle does not remain upright; nominal: centre and wall of
    the scene [m].
    """
    degrees, tips = np.degrees(rolls).ravel(), rolls.ravel() >= 0.5 * np.pi
    shades = Shades(0.0, float(degrees[~tips].max(initial=1.0)))
    colours = np.where(tips, RED, shades.colours(np.where(tips, 0.0, degrees)))
    row, column = np.divmod(np.arange(rolls.size), centres.size)
    x, y = cells_about(centres, False)[column], cells_about(walls, False)[row]
    texts = [f"{roll:.1f} deg" if roll < 90.0 else "rolls over" for roll in degrees]
    at = [f"wall {walls[i]:.3f} m; centre {centres[j]:.3f} m" for i, j in zip(row, column, strict=True)]
    start, end, bottom, top = (float(edge) for edge in (x.min(), x.max(), y.min(), y.max()))
    styles = (("5 % upright", "2 3", 1.4), ("50 % upright", "7 3", 1.8), ("95 % upright", "", 2.6))
    drawn = zip(styles, np.clip(lines.walls, bottom, top), strict=True)
    marks: list[Mark] = [
        Boxes("largest roll", x, y, colours.tolist(), texts, at),
        *(Swatch(*colour_key) for colour_key in shades.keys("deg")),
        Swatch("rolls over", RED),
        *(
            Line(name, lines.centres, heights, "ink", width, dashes)
            for (name, dashes, width), heights in drawn
        ),
        Line("the scene", np.array(nominal[:1]), np.array(nominal[1:]), "ink", 0.0, dots=4.5),
        *(Line("", np.array([start, end]), np.full(2, INCH * inches), "#ffffff", 1.0) for inches in INCHES),
        *(Level(f"{inches} in =", INCH * inches, "ink") for inches in INCHES),
    ]
    across = chart.Axis("height of the centre of mass [m]", start, end, margin=0.0)
    plot = chart.Plot(tuple(marks), chart.Axis("height of the wall [m]", bottom, top), 380.0, "xy", False)
    caption = "Largest roll of the nominal vehicle, and walls that keep 5, 50 and 95 % of the samples upright (lines)"
    return chart.Chart("map", caption, (plot,), across, "Roll", MAP)


def draw_upright(walls: Floats, fractions: Floats, interval: Floats, wall: float, level: float) -> Chart:
    """Draw the fractions of each outcome over the height of the wall.

    fractions: upright, on its side, over the wall, shape (3, n); interval: of the first, shape (2, n); wall: of the
    scene [m]; level: fraction that the wall is to keep upright.
    """
    upright, side, _ = 100.0 * fractions
    ends = (upright, upright + side, np.full_like(side, 100.0))
    layers = zip(OUTCOMES, ends, ends[1:], strict=False)
    marks: list[Mark] = [
        *(Layer(name, walls, low, high, colour, fill) for (name, colour, fill), low, high in layers),
        Layer("95 % interval", walls, 100.0 * interval[0], 100.0 * interval[1], "ink", 0.2),
        Line("upright", walls, upright, "ink", 2.2),
        Level("", 100.0 * level, "ink"),
        Span("the scene", wall, wall, "ink"),
    ]
    caption = "Outcome of the samples over the height of the wall"
    return _over_walls("upright", caption, "fraction of the samples [%]", walls, marks, 100.0)


def draw_force(walls: Floats, band: Floats, loads: Mapping[str, float], wall: float) -> Chart:
    """Draw the 50 ms mean of the lateral force over walls.

    band: 5, 50 and 95 %, shape (3, n) [N]; loads: published ones by name [N]; wall: of the scene [m].
    """
    caption = "Lateral force over the height of the wall, and published design loads (lines across)"
    levels = {name: force / 1e3 for name, force in loads.items()}
    marks = [*_band(walls, band / 1e3), *_published(levels, wall)]
    return _over_walls("force-over-height", caption, "largest 50 ms mean [kN]", walls, marks)


def draw_resultant(walls: Floats, band: Floats, heights: Mapping[str, float], wall: float) -> Chart:
    """Draw the height of the resultant over the height of the wall.

    band: 5, 50 and 95 %, shape (3, n) [m]; heights: published ones by name [m]; wall: of the scene [m].
    """
    caption = "Height of the resultant at the largest 50 ms mean, and published heights (lines across)"
    top = Line("top of the wall", walls, walls, "grey", 1.2, "2 3")
    marks = [*_band(walls, band), top, *_published(heights, wall)]
    return _over_walls("resultant", caption, "height of the resultant [m]", walls, marks)


def _published(levels: Mapping[str, float], wall: float) -> list[Mark]:
    """Return published values as levels, and the wall of the scene."""
    return [
        *(Level(name, level, "rigid") for name, level in levels.items()),
        Span("the scene", wall, wall, "ink"),
    ]


def _over_walls(
    name: str, caption: str, label: str, walls: Floats, marks: Sequence[Mark], high: float | None = None
) -> Chart:
    """Draw marks over the height of the wall."""
    across = chart.Axis("height of the wall [m]", float(walls[0]), float(walls[-1]), margin=0.0)
    plot = chart.Plot(tuple(marks), chart.Axis(label, 0.0, high), 220.0)
    return chart.Chart(name, caption, (plot,), across, "Walls", chart.HALF)


def _band(walls: Floats, band: Floats) -> Sequence[Mark]:
    """Return a band with its median."""
    low, middle, high = band
    return Layer("5 to 95 %", walls, low, high, "steel", 0.4), Line("median", walls, middle, "fe", 2.2)


def draw_outcomes(
    labels: Sequence[str], parts: Sequence[Sequence[float]], published: Sequence[Sequence[bool]]
) -> Chart:
    """Draw the probabilities of outcomes with the published one marked.

    parts: probabilities of each test, upright, on its side, over the wall; published: whether each one is the
    published outcome.
    """
    rows = row_heights(labels)
    ends = np.concatenate([np.zeros((len(labels), 1)), np.cumsum(parts, axis=1)], axis=1)
    marks = list[Mark]()
    across = rows[:, None] + 0.2 * np.array([-1.0, 1.0])
    for number, (name, colour, strength) in enumerate((("upright", "green", 0.45), *OUTCOMES)):
        texts = [f"{probabilities[number]:.2f}" for probabilities in parts]
        marks.append(Boxes(name, ends[:, number : number + 2], across, colour, texts, labels, strength))
    x, y = list[float](), list[float]()
    for row, edges, is_published in zip(rows.tolist(), ends.tolist(), published, strict=True):
        numbers = np.flatnonzero(is_published)
        x += [edges[numbers[0]], edges[numbers[-1] + 1], np.nan]
        y += [row - 0.33, row - 0.33, np.nan]
    marks.append(Line("published outcome", np.array(x), np.array(y), "ink", 2.4, dots=3.4))
    plot = row_plot(labels, marks, 34.0)
    caption = "Probabilities of the outcomes of crash tests, and the published outcome (line below)"
    return chart.Chart("outcomes", caption, (plot,), chart.Axis("probability", 0.0, 1.0), width=chart.FULL)
