"""Charts of a whole impact: positions along the wall, forces, energies, crush, contact along the side.

The impact as an animated GIF: the vehicle along the wall, and the force below it.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from postprocess.figures import histories
from postprocess.svg import chart
from postprocess.svg.chart import Chart
from postprocess.svg.marks import (
    HOLD,
    Boxes,
    Layer,
    Level,
    Line,
    Mark,
    Moving,
    Outline,
    Span,
    Swatch,
    Words,
    look,
)
from postprocess.svg.scales import Floats, Shades
from postprocess.units import SI, Units, measure

CORNERS = {"front": "red", "rear": "fe"}


@dataclass(frozen=True)
class StrikeMark:
    """A strike: its corner, "front" or "rear", instants [s], and where along the wall it begins and ends [m]."""

    corner: str
    start: float
    end: float
    places: tuple[float, float] = (0.0, 0.0)


Strikes = Sequence[StrikeMark]


def corner_colour(corner: str) -> str:
    """One colour for each of the two corners, grey for what is none."""
    return CORNERS.get(corner.split()[-1], "soft")


CLOSE = 0.25
"""Distance of strikes, over the time of all, whose names may overlap."""


def shaded(strikes: Sequence[StrikeMark]) -> tuple[Span, ...]:
    """Their times as bands behind the plot, each with its corner's name on top, close ones in rows."""
    row, middle, found = 0, -np.inf, list[Span]()
    for each in strikes:
        last, middle = middle, 0.5 * (each.start + each.end)
        row = (row + 1) % 3 if middle - last < CLOSE * strikes[-1].end else 0
        found.append(Span(each.corner, each.start, each.end, corner_colour(each.corner), row))
    return tuple(found)


EDGE = 0.4
"""Free space about what is drawn [m]."""

SLOWER, MAX_POSES = 10.0, 61
"""Time that an animation takes over that of the motion, and its keyframes."""

NAME = 0.04
"""Width of the name of an instant, over that of the chart; closer ones stand in two rows, a third has none."""

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
    strikes: Strikes = (),
    motion: tuple[Floats, Floats] | None = None,
) -> Chart:
    """Outlines at these instants [s], later ones more opaque, over the wall Y = 0; strikes as bars below its face.

    outlines: shape (k, points, 2) [m]; motion: even instants [s] and outlines at them, which are shown one after the
    other, `SLOWER` times slower.
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
    wall = np.array([(low[0], low[1]), (high[0], low[1]), (high[0], 0.0), (low[0], 0.0)])
    marks: list[Mark] = [Outline(wall[:, 0], wall[:, 1], "grey", fill=0.25)]
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
    x, y = chart.Axis("X along the wall [m]", low[0], high[0]), chart.Axis("Y [m]", low[1], high[1])
    return chart.draw_chart(
        "positions",
        caption,
        (chart.Plot(tuple(marks), y, None, "xy", has_grid=False),),
        x,
        "Motion",
        chart.FULL,
    )


def _position(outline: Floats, instant: float, shade: float, top: float, row: int | None) -> list[Mark]:
    """One outline; its instant on top, over the point that lies farthest along the wall, in this row if any."""
    x, y = outline[outline[:, 0].argmax()]
    foot, text = top - 0.5 * TOP, f"{instant:.2f} s"
    name = [] if row is None else [Words(text, x, foot, (0.0, -3.0 - 10.0 * row), "middle", "fe")]
    return [
        Outline(outline[:, 0], outline[:, 1], "fe", 0.25 + 0.75 * shade, label=text),
        Line("", np.array([x, x]), np.array([y, foot]), "steel", 0.7, "1 2"),
        *name,
    ]


def _strike(strike: StrikeMark, height: float, end: float) -> list[Mark]:
    """A bar where it is, named behind it or, near the end of the strip, before it."""
    (first, last), near = sorted(strike.places), max(strike.places) > end - 3.5
    place, shift, anchor = (first, -6.0, "end") if near else (last, 6.0, "start")
    text = f"{strike.corner} {strike.start:.3f} to {strike.end:.3f} s"
    colour = corner_colour(strike.corner)
    bar = Line("", np.array(strike.places), np.full(2, height), colour, 4.0)
    return [bar, Words(text, place, height, (shift, 3.5), anchor, colour)]


START = replace(histories.TIME, low=0.0)
"""Time from first touch on."""

LINES: Mapping[str, tuple[str, dict[str, Any]]] = {
    "raw": ("raw", {"colour": "grey", **look(0)}),
    "cfc180": ("CFC 180", {"colour": "green", **look(1)}),
    "cfc60": ("CFC 60", {"colour": "fe", **look(2)}),
    "cutoff_60hz": ("60 Hz cut-off", {"colour": "violet", **look(3)}),
    "mean_50ms": ("50 ms mean", {"colour": "rigid", **look(4), "width": 2.2}),
}
"""Label and look of each curve, in the order in which they are drawn."""


def draw_forces(
    name: str,
    caption: str,
    t: Floats,
    curves: Mapping[str, Floats],
    strikes: Strikes = (),
    levels: Mapping[str, float] | None = None,
    width: float = chart.HALF,
) -> Chart:
    """Curves of one force by the names of `force_curves`, shape (n,) [N], over t [s]; drawn in kN.

    levels: what a design force is called -> force [N], drawn as a line; width: of the chart [pixels].
    """
    shown = [(look, curves[key] / 1e3) for key, look in LINES.items() if key in curves]
    stretches = histories.STRETCHES if width == chart.FULL else histories.FEW
    lines = [Line(label, *histories.thinned(t, force, stretches), **look) for (label, look), force in shown]
    across = [Level(label, round(force / 1e3, 1)) for label, force in (levels or {}).items()]
    plot = chart.Plot((*shaded(strikes), *across, *lines), chart.Axis("force on the wall [kN]"), 270.0)
    return chart.draw_chart(name, caption, (plot,), START, "Force", width)


def draw_curves(
    name: str, caption: str, axis: str, t: Floats, curves: Mapping[str, Floats], strikes: Strikes = ()
) -> Chart:
    """Curves by their names, shape (n,) in the unit of the axis, over t [s]."""
    lines = [
        Line(label, *histories.thinned(t, values), colour, **look(k))
        for k, ((label, values), colour) in enumerate(zip(curves.items(), LAYERS, strict=False))
    ]
    plot = chart.Plot((*shaded(strikes), *lines), chart.Axis(axis), 230.0)
    return chart.draw_chart(name, caption, (plot,), START, "Train")


def draw_loops(contacts: Mapping[str, tuple[Floats, Floats]]) -> Chart:
    """Force [N] over crush [m] of each contact point by its name, shape (n,) each; drawn in kN and mm."""
    caption = "Force over crush of each contact point; the area of a loop is the dissipated energy"
    places = {label: _cornered(crush * 1e3, force / 1e3) for label, (crush, force) in contacts.items()}
    lines = tuple(Line(label, *its, corner_colour(label)) for label, its in places.items())
    plot = chart.Plot(lines, chart.Axis("force [kN]", low=0.0), 230.0, nearest="xy")
    return chart.draw_chart("loops", caption, (plot,), chart.Axis("crush [mm]", low=0.0), "Force")


def _cornered(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """The points of a line without those that lie on the straight line between their neighbours, shape (k,)."""
    moved = np.append(True, (np.diff(x) != 0.0) | (np.diff(y) != 0.0))
    x, y = x[moved], y[moved]
    steps = np.diff(x) / (np.ptp(x) or 1.0) + 1j * np.diff(y) / (np.ptp(y) or 1.0)
    kept = np.concatenate([[True], np.abs(np.angle(steps[1:] / steps[:-1])) > 1e-6, [True]])
    return x[kept], y[kept]


LAYERS = ("difference", "rigid", "steel", "green", "violet", "soft", "red")


def draw_energies(t: Floats, kinetic: Floats, parts: Mapping[str, Floats], strikes: Strikes = ()) -> Chart:
    """Draw the energy that the motion lost, as a line, and below it the parts that it went into, in layers [kJ].

    t [s], kinetic and each of `parts` [J], shape (n,): crush lost, friction, damping, crush stored, strain and so on,
    the first at the bottom. Where layers and line part, the balance is open.
    """
    caption = "Decrease of the kinetic energy (line), and energies into which it is converted (layers)"
    shown = np.unique(np.linspace(0, t.size - 1, 2 * histories.STRETCHES).astype(int))
    kept = {label: values[shown] / 1e3 for label, values in parts.items() if np.any(values)}
    tops = np.cumsum([np.zeros(shown.size), *kept.values()], axis=0)
    bands = zip(kept, tops, tops[1:], LAYERS, strict=False)
    layers = tuple(Layer(label, t[shown], below, above, colour) for label, below, above, colour in bands)
    line = Line("given up", t[shown], (kinetic[0] - kinetic[shown]) / 1e3, "ink", 1.3)
    plot = chart.Plot((*shaded(strikes), *layers, line), chart.Axis("energy [kJ]"), 220.0)
    return chart.draw_chart("energies", caption, (plot,), START, "Energy", chart.HALF)


COLUMNS = 240
"""Columns of cells at most; each is the largest force of its time."""


def draw_side_force(t: Floats, distances: Floats, force: Floats, unit: str, strikes: Strikes = ()) -> Chart:
    """Force at each distance from the front and instant, the largest darkest; nothing where there is none.

    t [s], shape (n,), even; distances of the nodes [m], rising from 0, shape (k,); force, shape (n, k), in `unit`, for
    example "kN" of each node or "kN/m".
    """
    caption = "Contact force along the side that faces the wall, over time"
    edges = np.concatenate([distances[:1], 0.5 * (distances[1:] + distances[:-1]), distances[-1:]])
    starts = np.unique(np.linspace(0, t.size, min(COLUMNS, t.size), endpoint=False).astype(int))
    table, times = np.maximum.reduceat(force, starts, axis=0), np.append(t[starts], t[-1])
    column, row = np.nonzero(table > 0.0)
    pressed, shades = table[column, row], Shades(float(table.max()) or 1.0, 0.0)
    along, across = (np.stack([ends[k], ends[k + 1]], -1) for ends, k in ((times, column), (edges, row)))
    said, places = (
        [measure(value, unit, ".4g") for value in pressed],
        zip(times[column], distances[row], strict=True),
    )
    at = [f"{time:.4g} s; {measure(place, 'm', '.4g')}" for time, place in places]
    cells = Boxes("force", along, across, shades.colours(pressed), said, at)
    x = replace(START, high=float(t[-1]))
    y = chart.Axis("distance from the front [m]", low=float(edges[-1]), high=float(edges[0]))
    keys = [Swatch(*each) for each in shades.keys(unit)]
    plot = chart.Plot((*keys, cells, *shaded(strikes)), y, 200.0, nearest="xy", has_grid=False)
    return chart.draw_chart("side-force", caption, (plot,), x, "Force", chart.HALF)


BODY, WALL = "#14467c", "#8a929b"
SIZE, DPI = (720, 378), 90
"""Pixels of the animation; in one of another size letters and lines are in proportion."""

MAX_FRAMES = 120
"""More instants are thinned to as many. A frame of a GIF lasts whole hundredths of a second, from two on."""


def write_animation(
    path: Path,
    t: Floats,
    outlines: Floats,
    force: Floats,
    units: Units = SI,
    size: tuple[int, int] = SIZE,
) -> Path:
    """Write the GIF and return its path; it runs about `SLOWER` times slower than the impact.

    t [s], shape (n,), even, n >= 2; outlines [m], shape (n, points, 2); force on the wall [N], shape (n,); units: of
    its axes; size: [pixels].
    """
    chosen = np.unique(np.linspace(0, t.size - 1, min(t.size, MAX_FRAMES)).astype(int))
    pause = 10 * max(2, round(100.0 * SLOWER * (t[-1] - t[0]) / (chosen.size - 1)))
    with histories.style():
        first, *others = _frames(chosen, t, outlines, force, units, size)
    first.save(path, save_all=True, append_images=others, duration=pause, loop=0)
    return path


def _frames(
    chosen: np.ndarray, t: Floats, outlines: Floats, force: Floats, units: Units, size: tuple[int, int]
) -> list[Any]:
    """Pillow images of the chosen instants; all but body, force so far and time is drawn once."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.patches import Polygon
    from PIL import Image

    (length, length_unit), (load, load_unit) = units.of("m"), units.of("N")
    outlines, force, edge = length * outlines, load * force, length * EDGE
    low, high = outlines.min(axis=(0, 1)) - edge, outlines.max(axis=(0, 1)) + edge
    dpi = DPI * min(size[0] / SIZE[0], size[1] / SIZE[1])
    figure = Figure(figsize=(size[0] / dpi, size[1] / dpi), dpi=dpi)
    canvas: Any = FigureCanvasAgg(figure)
    upper, lower = figure.add_axes((0.08, 0.46, 0.89, 0.46)), figure.add_axes((0.08, 0.12, 0.89, 0.26))
    upper.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    upper.set_ylabel(f"Y [{length_unit}]")
    upper.axhspan(low[1], 0.0, color=WALL, alpha=0.6, linewidth=0)
    upper.grid(visible=False)
    lower.plot(t, force, color=WALL, linewidth=0.8)
    lower.set(xlim=(t[0], t[-1]), xlabel="t [s]")
    lower.set_ylabel(f"force [{load_unit}]")
    body = Polygon(outlines[0], facecolor=BODY, edgecolor=BODY, alpha=0.35, animated=True)
    upper.add_patch(body)
    (so_far,) = lower.plot([], [], color=BODY, linewidth=1.4, animated=True)
    clock = upper.set_title("", fontsize=9, loc="left", animated=True)
    canvas.draw()
    still, found = canvas.copy_from_bbox(figure.bbox), []
    for number in chosen:
        canvas.restore_region(still)
        body.set_xy(outlines[number])
        so_far.set_data(t[: number + 1], force[: number + 1])
        clock.set_text(f"{t[number]:.3f} s")
        upper.draw_artist(body)
        lower.draw_artist(so_far)
        upper.draw_artist(clock)
        found.append(Image.fromarray(np.array(canvas.buffer_rgba())).convert("P", dither=Image.Dither.NONE))
    return found
