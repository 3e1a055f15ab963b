"""Histories of several origins over one another: panels of curves, as a plot of its own or for a page."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

from postprocess.figures.curves import TIME, thinned
from postprocess.figures.style import style
from postprocess.svg import chart, marks
from postprocess.svg.chart import Chart, draw_chart
from postprocess.svg.drawing import PALETTE

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SHADES = ("fe", "rigid", "green", "difference", "violet", "red", "steel", "grey")
"""Colours of the lines, in order: names of the palette of pages."""

COLOURS = tuple(PALETTE[name] for name in SHADES)
DASHES: tuple[Any, ...] = ("-", (0, (5, 2)), (0, (1, 1.5)), (0, (6, 2, 1, 2)))
WIDTH, HEIGHT = 6.4, 2.5
"""Size of a panel [inches]."""


@dataclass(frozen=True)
class Line:
    """A history: its label, instants [s] and values, shape (instants,) each."""

    label: str
    t: NDArray[Any]
    values: NDArray[Any]


@dataclass(frozen=True)
class Overlay:
    """A panel: name of what is drawn, its unit, and the lines."""

    name: str
    unit: str
    lines: Sequence[Line]

    @property
    def heading(self) -> str:
        """Name with unit."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name


@dataclass(frozen=True)
class Plot:
    """Panels of curves, drawn.

    Attributes
    ----------
    figure : matplotlib.figure.Figure
        To be changed at will.
    """

    figure: Any

    def save(self, path: str | Path) -> Path:
        """Write the plot.

        Parameters
        ----------
        path : str or Path
            Its ending is the format: .png, .svg or .pdf.

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


def overlay_plot(panels: Sequence[Overlay]) -> Plot:
    """All panels in one figure, one below the other, with a common axis of time."""
    with style():
        return Plot(_figure(panels))


def overlay_curve(name: str, panel: Overlay, caption: str) -> Chart:
    """One panel as SVG for a page; name: of its file."""
    lines = tuple(
        marks.Line(line.label, *thinned(line.t, line.values), SHADES[number % len(SHADES)])
        for number, line in enumerate(panel.lines)
    )
    return draw_chart(name, caption, (chart.Plot(lines, chart.Axis(panel.heading)),), TIME)


def _figure(panels: Sequence[Overlay]) -> Figure:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH, HEIGHT * len(panels)), layout="tight")
    grid = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for axes, panel in zip(grid, panels, strict=True):
        for number, line in enumerate(panel.lines):
            dashes = DASHES[(number // len(COLOURS) + number) % len(DASHES)]
            axes.plot(
                line.t, line.values, label=line.label, color=COLOURS[number % len(COLOURS)], ls=dashes, lw=1.4
            )
        axes.set_ylabel(panel.heading)
    grid[-1].set_xlabel("t [s]")
    if any(len(panel.lines) > 1 for panel in panels):
        grid[0].legend(loc="best", frameon=False, fontsize="small")
    return figure
