"""Charts of a whole impact over time.

Forces, energies, crush, and contact along the side.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from postprocess.figures import histories
from postprocess.svg import chart
from postprocess.svg.areas import Boxes, Layer, Span
from postprocess.svg.chart import Chart
from postprocess.svg.marks import Level, Line, Swatch, line_style
from postprocess.svg.motion import Cursor
from postprocess.svg.scales import Floats, Shades, even_rows
from postprocess.units import measure

CORNERS, OTHER = {"front": "red", "rear": "fe"}, "soft"
"""Colours of corners by the last word of their name, and of all other parts."""

STRIPS = ("soft", "green", "violet", "rigid", "steel")
"""Colours of other parts where each has a line."""

START = replace(histories.TIME, low=0.0)
"""Time from first touch on."""

LINES = {
    "raw": ("raw", "grey", line_style(0)),
    "cfc180": ("CFC 180", "green", line_style(1)),
    "cfc60": ("CFC 60", "fe", line_style(2)),
    "cutoff_60hz": ("60 Hz cut-off", "violet", line_style(3)),
    "mean_50ms": ("50 ms mean", "rigid", line_style(4) | {"width": 2.2}),
}
"""Label, colour and line style of each curve in the order of drawing."""

SHOWN = ("raw", "mean_50ms")
"""Curves that are shown at first."""

LAYERS = ("difference", "rigid", "steel", "green", "violet", "soft", "red")

INSTANTS = 160
"""Number of instants of energies."""

COLUMNS = 240
"""Largest number of columns of cells; each is the largest force of its time."""


@dataclass(frozen=True)
class StrikeMark:
    """Strike with its corner, instants and places.

    corner: "front", "rear" or the name of a strip; start, end [s]; places: along the wall at both [m].
    """

    corner: str
    start: float
    end: float
    places: tuple[float, float] = (0.0, 0.0)


Strikes = Sequence[StrikeMark]


def corner_colour(corner: str) -> str:
    """Return the colour of a corner, grey for other names."""
    return CORNERS.get(corner.split()[-1], OTHER)


def shaded(strikes: Sequence[StrikeMark]) -> tuple[Span, ...]:
    """Return strikes as bands behind a plot, with their corners."""
    return tuple(
        Span(strike.corner, strike.start, strike.end, corner_colour(strike.corner)) for strike in strikes
    )


class Forces(NamedTuple):
    """Filtered curves of one component of the force.

    axis: its name; t [s], curves: by the names of `force_curves`, shape (n,) [N]; model: after the labels of curves.
    """

    axis: str
    t: Floats
    curves: Mapping[str, Floats]
    model: str = ""

    @property
    def lines(self) -> list[Line]:
        """Curves of the forces [kN].

        Those outside of `SHOWN`, and those of a further model, are hidden at first.
        """
        lines, are_few = list[Line](), len(self.curves) <= len(SHOWN)
        for key, (label, colour, style) in LINES.items():
            if key in self.curves:
                places = histories.thinned(self.t, self.curves[key] / 1e3)
                is_shown = not self.model and (key in SHOWN or are_few)
                lines.append(Line(label + self.model, *places, colour, **style, is_shown=is_shown))
        return lines


def draw_forces(
    caption: str,
    components: Sequence[Forces],
    strikes: Strikes = (),
    levels: Mapping[str, float] | None = None,
    motion: Floats | None = None,
) -> Chart:
    """Draw filtered forces, components one below the other.

    Components with the same axis are in one plot. levels: design forces of the first by their names [N], as lines;
    motion: instants of an animation beside the chart [s].
    """
    across = [Level(label, round(force / 1e3, 1)) for label, force in (levels or {}).items()]
    plots = list[chart.Plot]()
    for axis in dict.fromkeys(component.axis for component in components):
        lines = [line for component in components if component.axis == axis for line in component.lines]
        front = [] if motion is None else [Cursor("", motion)]
        drawn = (*shaded(strikes), *([] if plots else across), *lines, *front)
        plots.append(chart.Plot(drawn, chart.Axis(f"{axis} [kN]"), 150.0 if plots else 270.0))
    return chart.Chart("force", caption, plots, START, "Force", chart.FULL)


def draw_curves(
    name: str, caption: str, axis: str, t: Floats, curves: Mapping[str, Floats], strikes: Strikes = ()
) -> Chart:
    """Draw curves by their names over time.

    Shape (n,), in the unit of the axis, over t [s].
    """
    lines = histories.thin_lines(
        [histories.Curve(name, t, values) for name, values in curves.items()], LAYERS
    )
    plot = chart.Plot((*shaded(strikes), *lines), chart.Axis(axis), 230.0)
    return chart.Chart(name, caption, (plot,), START, "Train")


def draw_loops(contacts: Mapping[str, tuple[Floats, Floats]]) -> Chart:
    """Draw force over crush of each contact point, in kN and mm.

    contacts: force [N] and crush [m], shape (n,), by name.
    """
    caption = "Force over crush of each contact point; the area of a loop is the dissipated energy"
    places = {label: _cornered(crush * 1e3, force / 1e3) for label, (crush, force) in contacts.items()}
    strip_labels = [label for label in places if corner_colour(label) == OTHER]
    colours = dict(zip(strip_labels, STRIPS * len(strip_labels), strict=False))
    lines = tuple(
        Line(label, *points, colours.get(label, corner_colour(label))) for label, points in places.items()
    )
    plot = chart.Plot(lines, chart.Axis("force [kN]", low=0.0), 230.0, nearest="xy")
    return chart.Chart("loops", caption, (plot,), chart.Axis("crush [mm]", low=0.0), "Force")


def _cornered(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Remove the points that lie on straight lines between their neighbours."""
    changed = np.append(True, (np.diff(x) != 0.0) | (np.diff(y) != 0.0))
    x, y = x[changed], y[changed]
    steps = np.diff(x) / (np.ptp(x) or 1.0) + 1j * np.diff(y) / (np.ptp(y) or 1.0)
    corners = np.concatenate([[True], np.abs(np.angle(steps[1:] / steps[:-1])) > 1e-6, [True]])
    return x[corners], y[corners]


def draw_energies(t: Floats, kinetic: Floats, parts: Mapping[str, Floats], strikes: Strikes = ()) -> Chart:
    """Draw the decrease of the kinetic energy as its parts [kJ].

    t [s], kinetic and each of `parts` [J], shape (n,): dissipated crush, friction, damping, stored crush, strain and
    so on, the first at the bottom. The distance between line and layers is the error of the balance.
    """
    caption = "Decrease of the kinetic energy (line), and energies into which it is converted (layers)"
    rows = even_rows(t, INSTANTS)
    used = {label: values[rows] / 1e3 for label, values in parts.items() if np.any(values)}
    tops = np.cumsum([np.zeros(rows.size), *used.values()], axis=0)
    bands = zip(used, tops, tops[1:], LAYERS, strict=False)
    layers = tuple(Layer(label, t[rows], below, above, colour) for label, below, above, colour in bands)
    line = Line("kinetic energy lost", t[rows], (kinetic[0] - kinetic[rows]) / 1e3, "ink", 1.3)
    plot = chart.Plot((*shaded(strikes), *layers, line), chart.Axis("energy [kJ]"), 220.0)
    return chart.Chart("energies", caption, (plot,), START, "Energy", chart.HALF)


def draw_side_force(t: Floats, distances: Floats, force: Floats, strikes: Strikes = ()) -> Chart:
    """Draw the contact force over the distance from the front and time.

    t [s], shape (n,), even; distances of the nodes [m], rising from 0, shape (k,); force of each, shape (n, k)
    [kN]. Cells without force are empty.
    """
    caption = "Contact force along the side that faces the wall, over time"
    edges = np.concatenate([distances[:1], 0.5 * (distances[1:] + distances[:-1]), distances[-1:]])
    starts = np.unique(np.linspace(0, t.size, min(COLUMNS, t.size), endpoint=False).astype(int))
    table, times = np.maximum.reduceat(force, starts, axis=0), np.append(t[starts], t[-1])
    column, row = np.nonzero(table > 0.0)
    pressed, shades = table[column, row], Shades(float(table.max()) or 1.0, 0.0)
    along, across = (np.stack([ends[k], ends[k + 1]], -1) for ends, k in ((times, column), (edges, row)))
    texts = [measure(value, "kN", ".4g") for value in pressed]
    places = zip(times[column], distances[row], strict=True)
    at = [f"{time:.4g} s; {measure(place, 'm', '.4g')}" for time, place in places]
    cells = Boxes("force", along, across, shades.colours(pressed), texts, at)
    x = replace(START, high=float(t[-1]))
    y = chart.Axis("distance from the front [m]", low=float(edges[-1]), high=float(edges[0]))
    keys = [Swatch(*colour_key) for colour_key in shades.keys("kN")]
    plot = chart.Plot((*keys, cells, *shaded(strikes)), y, 200.0, nearest="xy", has_grid=False)
    return chart.Chart("side-force", caption, (plot,), x, "Force", chart.HALF)
