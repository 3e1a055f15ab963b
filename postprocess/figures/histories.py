"""Histories as line plots.

FE over rigid body on the page of a run, several origins over one another on pages and in Python. Pages show the
smallest and the largest value in each of 160 parts of a history, which preserves peaks.
"""

from __future__ import annotations

import io
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import cycle
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from postprocess.svg import chart, marks, scales
from postprocess.units import SUPERSCRIPTS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

History = Mapping[str, scales.Floats]

STRETCHES, FEW = 160, 100
"""Parts of the main chart of a page, and of one of half its width or less."""

COLOURS = ("fe", "red", "green", "violet")
TIME = chart.Axis("t [s]", margin=0.0)
MAIN = "v_gy"
"""Column whose chart has the width of the page; it determines the force of the tail-slap."""


ORIGINS = ("fe", "rigid", "green", "difference", "violet", "red", "steel", "grey")
"""Colours of curves of several origins in order."""

DASHES: tuple[str | tuple[int, tuple[float, ...]], ...] = ("-", (0, (5, 2)), (0, (1, 1.5)), (0, (6, 2, 1, 2)))

WIDTH, HEIGHT = 6.4, 2.5
"""Size of a panel that matplotlib draws [inches]."""

STYLE: dict[Any, object] = {
    "svg.fonttype": "none",
    "font.family": ["DejaVu Sans"],
    "font.size": 9.0,
    "axes.formatter.useoffset": False,
    "axes.formatter.limits": (-6, 9),
    "axes.unicode_minus": True,
    "axes.grid": True,
    "grid.color": "#e3e6ea",
    "grid.linewidth": 0.6,
    "axes.edgecolor": "#8a929b",
    "axes.axisbelow": True,
    "axes.xmargin": 0.0,
}


class Panel(NamedTuple):
    """Plot of one or more columns.

    name: of its file; columns: with their labels; symbol, unit: of the axis; from_start: whether changes since the
    start are drawn.
    """

    name: str
    columns: tuple[tuple[str, str], ...]
    symbol: str
    unit: str
    group: str
    caption: str
    from_start: bool = False


COMPARED = tuple(
    Panel(name, ((name, "FE"),), symbol, unit, group, caption)
    for name, symbol, unit, group, caption in (
        ("v_gy", "v_GY", "m/s", "Motion", "Velocity of G across the wall, negative towards it"),
        ("v_gx", "v_GX", "m/s", "Motion", "Velocity of G along the wall"),
        ("theta", "θ", "rad", "Motion", "Angle θ between the side PE and the wall"),
        (
            "omega",
            "ω",
            "rad/s",
            "Motion",
            "Angular velocity ω, positive as the rear rotates towards the wall",
        ),
        ("slide", "s", "m", "Motion", "Slide of the corner P along the wall"),
        ("reaction_normal", "N", "N", "Reaction", "Wall reaction on the vehicle, below zero a pull"),
        ("reaction_tangential", "R", "N", "Reaction", "Friction force on the vehicle along the wall"),
    )
)
"""Plots of columns that are compared with the rigid body."""

ENERGIES = tuple(
    Panel(name, tuple(columns.items()), "energy", "J", "Energy", caption, name == "energy_exchanged")
    for name, columns, caption in (
        (
            "energy_exchanged",
            {"kinetic_energy": "kinetic, change", "friction_work": "work of friction"},
            "Change of kinetic energy, and work of friction",
        ),
        (
            "energy_stored",
            {"strain_energy": "strain", "contact_energy": "spring", "vibration_energy": "vibration"}
            | {"damping_work": "damping"},
            "Strain, contact spring and vibration of the plate, and the work of damping",
        ),
        ("energy_error", {"energy_error": "error"}, "Energy-balance error"),
    )
)
"""Plots of energies."""


def draw_histories(fe: History, rigid: History, more: tuple[Panel, ...] = ()) -> tuple[chart.Chart, ...]:
    """Draw the columns of an FE history over the rigid body.

    Motion comes first, then reaction, then energy. fe, rigid: values of shape (n,) by column, SI, each with its
    instants "t" [s]; the rigid ones are interpolated. Columns that one of them does not have are omitted. more:
    further plots.
    """
    shared = {*fe} & {*rigid}
    compared = [_draw_compared(panel, fe, rigid) for panel in COMPARED if panel.name in shared]
    plots = [_draw_columns(panel, fe) for panel in (*ENERGIES, *more) if {*fe} & {*dict(panel.columns)}]
    return (*compared, *plots)


def _draw_compared(panel: Panel, fe: History, rigid: History) -> chart.Chart:
    t, values = fe["t"], fe[panel.name]
    with np.errstate(all="ignore"):
        exact = np.interp(t, rigid["t"], rigid[panel.name])
        apart = values - exact
    unit_power, is_main = 3 if panel.unit == "N" else 0, panel.name == MAIN
    power = power_of_ten(np.degrees(apart) if panel.unit == "rad" else apart)  # readable in degrees as well
    rows = extremes(apart, STRETCHES if is_main else FEW)  # the exact motion is smooth
    rigid_line = marks.Line("rigid, exact", t[rows], exact[rows] * 10.0**-unit_power, "rigid", 4.0)
    lines = rigid_line, marks.Line("FE", t[rows], values[rows] * 10.0**-unit_power)
    difference = marks.Line("FE − rigid", t[rows], apart[rows] * 10.0**-power, "difference", 1.1)
    high, wide = (220.0, chart.FULL) if is_main else (130.0, chart.HALF)
    plots = (
        chart.Plot(lines, chart.Axis(f"{panel.symbol} [{unit_with_power(panel.unit, unit_power)}]"), high),
        chart.Plot((difference,), chart.Axis(f"FE − rigid [{unit_with_power(panel.unit, power)}]"), 66.0),
    )
    return chart.Chart(panel.name, panel.caption, plots, TIME, panel.group, wide)


def _draw_columns(panel: Panel, fe: History) -> chart.Chart:
    curves = {label: fe[name] for name, label in panel.columns if name in fe}
    if panel.from_start:
        curves = {label: values - values[0] for label, values in curves.items()}
    power = power_of_ten(np.concatenate([*curves.values()]))
    drawn = [Curve(label, fe["t"], values * 10.0**-power) for label, values in curves.items()]
    lines = thin_lines(drawn, COLOURS, FEW)
    axis = chart.Axis(f"{panel.symbol} [{unit_with_power(panel.unit, power)}]")
    height = 216.0 - (18.0 if len(lines) > 1 else 0.0)
    return chart.Chart(panel.name, panel.caption, (chart.Plot(lines, axis, height),), TIME, panel.group)


class Curve(NamedTuple):
    """History of one origin.

    t [s] and values, shape (instants,) each.
    """

    label: str
    t: scales.Floats
    values: scales.Floats


def thin_lines(
    curves: Sequence[Curve], colours: Sequence[str], stretches: int = STRETCHES
) -> tuple[marks.Line, ...]:
    """Return thinned curves as lines of different style."""
    return tuple(
        marks.Line(label, *thinned(t, values, stretches), colour, **marks.line_style(number))
        for number, ((label, t, values), colour) in enumerate(zip(curves, cycle(colours), strict=False))
    )


def thinned(
    t: scales.Floats, values: scales.Floats, stretches: int = STRETCHES
) -> tuple[scales.Floats, scales.Floats]:
    """Return times and values of the rows of `extremes`, shape (k,)."""
    rows = extremes(values, stretches)
    return t[rows], values[rows]


def extremes(values: scales.Floats, stretches: int = STRETCHES) -> NDArray[np.intp]:
    """Return the rows of smallest and largest values in each part.

    With both ends they are 2 * stretches + 2 at most.
    """
    count = len(values)
    if count <= 2 * stretches:
        return np.arange(count)
    stretch = np.arange(count) * stretches // count
    rising = np.lexsort((values, stretch))
    first = np.flatnonzero(np.diff(stretch, prepend=-1))
    last = np.append(first[1:], count) - 1
    return np.unique(np.concatenate([[0, count - 1], rising[first], rising[last]]))


def power_of_ten(values: scales.Floats) -> int:
    """Return the exponent of a unit that suits the values.

    A multiple of three with which the largest magnitude lies between 1 and 1000; 0 for zeros.
    """
    size = float(np.max(np.abs(values), initial=0.0))
    return 3 * math.floor(math.log10(size) / 3) if 1e-250 < size < math.inf else 0


def unit_with_power(unit: str, power: int) -> str:
    """Return a unit with a power of ten or a prefix."""
    if power == 3 and unit in ("N", "J"):
        return "k" + unit
    return f"10{str(power).translate(SUPERSCRIPTS)} {unit}" if power else unit


def draw_overlay(name: str, heading: str, curves: Sequence[Curve], caption: str, width: float) -> chart.Chart:
    """Draw overlaid curves as SVG for a page.

    name: of its file, heading: of their axis, with unit; width: of the chart [pixels].
    """
    lines = thin_lines(curves, ORIGINS)
    return chart.Chart(name, caption, (chart.Plot(lines, chart.Axis(heading)),), TIME, width=width)


@dataclass(frozen=True)
class HistoryPlot:
    """Panels of curves, drawn by matplotlib.

    Attributes
    ----------
    figure : matplotlib.figure.Figure
        For further changes.
    """

    figure: Figure

    def save(self, path: str | Path) -> Path:
        """Write the plot.

        Parameters
        ----------
        path : str or Path
            The ending selects the format, .png, .svg or .pdf.

        Returns
        -------
        Path
            The file.
        """
        self.figure.savefig(path)
        return Path(path)

    def _repr_svg_(self) -> str:
        buffer = io.StringIO()
        self.figure.savefig(buffer, format="svg")
        return buffer.getvalue()

    def __repr__(self) -> str:
        return f"<Plot of {', '.join(axes.get_ylabel() for axes in self.figure.axes)}>"


def plot_overlays(panels: Mapping[str, Sequence[Curve]], over: str = TIME.label) -> HistoryPlot:
    """Plot stacked panels over a common axis.

    panels: curves by heading, with unit; over: label of the axis; over anything but time the rows are points in any
    order.
    """
    points = {"marker": "o", "ms": 4.0, "ls": "none"} if over != TIME.label else {}
    with style():
        from matplotlib.figure import Figure

        figure = Figure(figsize=(WIDTH, HEIGHT * len(panels)), layout="tight")
        grid = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
        for axes, (heading, curves) in zip(grid, panels.items(), strict=True):
            for number, (label, t, values) in enumerate(curves):
                dashes = DASHES[(number // len(ORIGINS) + number) % len(DASHES)]
                colour = marks.PALETTE[ORIGINS[number % len(ORIGINS)]]
                axes.plot(t, values, label=label, color=colour, **(points or {"ls": dashes, "lw": 1.4}))
            axes.margins(x=0.05 if points else 0.0)
            axes.set_ylabel(heading)
        grid[-1].set_xlabel(over)
        if any(len(curves) > 1 for curves in panels.values()):
            grid[0].legend(loc="best", frameon=False, fontsize="small")
    return HistoryPlot(figure)


@contextmanager
def style() -> Iterator[None]:
    """Set the style of all figures of matplotlib, whatever the user's settings."""
    from matplotlib import rc_context, rcdefaults, rcParams

    with rc_context():
        rcdefaults()
        rcParams.update(STYLE)
        yield
