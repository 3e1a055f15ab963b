"""Histories as line plots, FE over rigid, in SVG text that goes into a page as it is.

Text stays text in the SVG, so it can be searched and copied and takes the font of the page around it. A
history is thinned to the smallest and the largest value of each of 200 stretches of it: peaks survive.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from postprocess.figures.panels import COMPARED, LEDGER, Panel
from postprocess.figures.style import DIFFERENCE, FE, RIGID, SUPERSCRIPTS, Curve, drawn, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]
History = Mapping[str, Floats]

STRETCHES = 200
WIDTH, HEIGHT, LEFT = 4.1, 2.9, 0.2
COLOURS = (FE, "#e2574c", "#2a9d63", "#8d6bb5")
THICK, THIN = 2.8, 1.2


@dataclass(frozen=True)
class Sheet:
    """A figure and its axes, top to bottom; used again for each panel, because making axes costs time."""

    figure: "Figure"
    axes: tuple["Axes", ...]


def draw_histories(fe: History, rigid: History, more: tuple[Panel, ...] = ()) -> tuple[Curve, ...]:
    """The plots of all known columns that the FE history has: motion first, then reaction, then energy.

    fe, rigid: column name -> values of shape (n,), SI, each with its instants "t" [s]; the rigid ones are
    interpolated to the instants of the FE run. A compared column that `rigid` lacks is not drawn.
    more: plots beside those of `panels`.
    """
    both = {*fe} & {*rigid}
    with style(), np.errstate(all="ignore"):
        double, single = make_sheet((0.42, 0.48), (0.16, 0.2)), make_sheet((0.16, 0.74))
        compared = [_draw_compared(double, panel, fe, rigid) for panel in COMPARED if panel.name in both]
        ledger = [
            _draw_ledger(single, panel, fe) for panel in (*LEDGER, *more) if {*fe} & {*dict(panel.columns)}
        ]
    return (*compared, *ledger)


def thinned(t: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Times and values, shape (k,), k <= 402: both ends, smallest and largest value of each stretch."""
    if len(t) <= 2 * STRETCHES:
        return t, values
    edges = np.linspace(0, len(t), STRETCHES + 1).astype(int)
    kept = [
        low + np.array([f(values[low:high]) for f in (np.argmin, np.argmax)]) for low, high in pairwise(edges)
    ]
    index = np.unique(np.concatenate([[0, len(t) - 1], *kept]))
    return t[index], values[index]


def power_of_ten(values: Floats) -> int:
    """Exponent, a multiple of three, that leaves the largest magnitude between 1 and 1000; 0 for zeros."""
    size = float(np.max(np.abs(values), initial=0.0))
    return 3 * math.floor(math.log10(size) / 3) if 1e-250 < size < math.inf else 0


def _draw_compared(sheet: Sheet, panel: Panel, fe: History, rigid: History) -> Curve:
    t, values = fe["t"], fe[panel.name]
    exact = np.interp(t, rigid["t"], rigid[panel.name])
    power = power_of_ten(values - exact)
    clear_sheet(sheet)
    upper, lower = sheet.axes
    upper.plot(*thinned(t, exact), color=RIGID, linewidth=4.0, solid_capstyle="round")
    upper.plot(*thinned(t, values), color=FE, linewidth=1.2)
    upper.set_ylabel(f"{panel.symbol} [{panel.unit}]")
    lower.plot(*thinned(t, (values - exact) * 10.0**-power), color=DIFFERENCE, linewidth=0.9)
    lower.set_ylabel(f"FE − rigid\n[{_factor(power)}{panel.unit}]", fontsize=8)
    return finish_curve(sheet, panel, (("rigid, exact", RIGID), ("FE", FE)))


def _draw_ledger(sheet: Sheet, panel: Panel, fe: History) -> Curve:
    found = [(fe[name], label) for name, label in panel.columns if name in fe]
    histories = [values - values[0] if panel.from_start else values for values, _ in found]
    power = power_of_ten(np.concatenate(histories))
    clear_sheet(sheet)
    (axes,) = sheet.axes
    for values, colour in zip(histories, COLOURS, strict=False):
        width = THICK if panel.from_start and colour == FE else THIN
        axes.plot(*thinned(fe["t"], values * 10.0**-power), color=colour, linewidth=width)
    axes.set_ylabel(f"{panel.symbol} [{_factor(power)}{panel.unit}]")
    return finish_curve(
        sheet, panel, tuple((label, c) for (_, label), c in zip(found, COLOURS, strict=False))
    )


def _factor(power: int) -> str:
    return f"10{str(power).translate(SUPERSCRIPTS)} " if power else ""


def make_sheet(*spans: tuple[float, float]) -> Sheet:
    """A figure with axes one below the other; each by its lower edge and height, parts of the figure."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH, HEIGHT))
    last = figure.add_axes((LEFT, spans[-1][0], 0.97 - LEFT, spans[-1][1]))
    others = [figure.add_axes((LEFT, low, 0.97 - LEFT, height), sharex=last) for low, height in spans[:-1]]
    last.set_xlabel("t [s]")
    for axes in (*others, last):
        axes.tick_params(labelbottom=axes is last, length=2.5)
        axes.yaxis.set_label_coords(-0.15 if others and axes is last else -0.185, 0.5)
    return Sheet(figure, (*others, last))


def clear_sheet(sheet: Sheet) -> None:
    for artist in (*sheet.figure.texts, *(line for axes in sheet.axes for line in axes.lines)):
        artist.remove()


def finish_curve(sheet: Sheet, panel: Panel, legend: tuple[tuple[str, str], ...]) -> Curve:
    """Fits the axes to their lines, and names these in their own colours above the plot."""
    for axes in sheet.axes:
        axes.relim()
        axes.autoscale_view()
    x = LEFT
    for label, colour in legend:
        sheet.figure.text(x, 0.93, f"━ {label}", color=colour, fontweight="bold")
        x += 0.06 + 0.0195 * len(label)
    return drawn(sheet.figure, panel.name, panel.caption, panel.group)
