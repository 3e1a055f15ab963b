"""Histories as line plots, FE over rigid.

A history is thinned to the smallest and the largest value of each of 200 stretches of it: peaks survive.
"""

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from postprocess.figures.panels import COMPARED, LEDGER, Panel
from postprocess.svg.chart import Axis, Chart, Plot, draw_chart
from postprocess.svg.marks import Line
from postprocess.svg.scale import SUPERSCRIPTS

Floats = NDArray[np.float64]
History = Mapping[str, Floats]

STRETCHES = 200
COLOURS = ("fe", "red", "green", "violet")
TIME = Axis("t [s]", margin=0.0)


def draw_histories(fe: History, rigid: History, more: tuple[Panel, ...] = ()) -> tuple[Chart, ...]:
    """The plots of all known columns that the FE history has: motion first, then reaction, then energy.

    fe, rigid: column name -> values of shape (n,), SI, each with its instants "t" [s]; the rigid ones are
    interpolated to the instants of the FE run. A compared column that `rigid` lacks is not drawn.
    more: plots beside those of `panels`.
    """
    both = {*fe} & {*rigid}
    compared = [_draw_compared(panel, fe, rigid) for panel in COMPARED if panel.name in both]
    ledger = [_draw_ledger(panel, fe) for panel in (*LEDGER, *more) if {*fe} & {*dict(panel.columns)}]
    return (*compared, *ledger)


def thinned(t: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Times and values, shape (k,), k <= 402: both ends, smallest and largest value of each stretch."""
    if len(t) <= 2 * STRETCHES:
        return t, values
    stretch = np.arange(len(t)) * STRETCHES // len(t)
    rising = np.lexsort((values, stretch))
    first = np.flatnonzero(np.diff(stretch, prepend=-1))
    last = np.append(first[1:], len(t)) - 1
    index = np.unique(np.concatenate([[0, len(t) - 1], rising[first], rising[last]]))
    return t[index], values[index]


def power_of_ten(values: Floats) -> int:
    """Exponent, a multiple of three, that leaves the largest magnitude between 1 and 1000; 0 for zeros."""
    size = float(np.max(np.abs(values), initial=0.0))
    return 3 * math.floor(math.log10(size) / 3) if 1e-250 < size < math.inf else 0


def unit_with_power(unit: str, power: int) -> str:
    """A unit with a power of ten before it, or where it has one, with its prefix."""
    if power == 3 and unit in ("N", "J"):
        return "k" + unit
    return f"10{str(power).translate(SUPERSCRIPTS)} {unit}" if power else unit


def _draw_compared(panel: Panel, fe: History, rigid: History) -> Chart:
    t, values = fe["t"], fe[panel.name]
    with np.errstate(all="ignore"):
        exact = np.interp(t, rigid["t"], rigid[panel.name])
        apart = values - exact
    own, power = (3 if panel.unit == "N" else 0), power_of_ten(apart)
    lines = (
        Line("rigid, exact", *thinned(t, exact * 10.0**-own), "rigid", 4.0),
        Line("FE", *thinned(t, values * 10.0**-own)),
    )
    difference = Line("FE − rigid", *thinned(t, apart * 10.0**-power), "difference", 1.1)
    plots = (
        Plot(lines, Axis(f"{panel.symbol} [{unit_with_power(panel.unit, own)}]"), 130.0),
        Plot((difference,), Axis(f"FE − rigid [{unit_with_power(panel.unit, power)}]"), 66.0),
    )
    return draw_chart(panel.name, panel.caption, plots, TIME, panel.group)


def _draw_ledger(panel: Panel, fe: History) -> Chart:
    found = [(fe[name], label) for name, label in panel.columns if name in fe]
    histories = [values - values[0] if panel.from_start else values for values, _ in found]
    power = power_of_ten(np.concatenate(histories))
    lines = tuple(
        Line(
            label,
            *thinned(fe["t"], values * 10.0**-power),
            colour,
            3.0 if panel.from_start and colour == "fe" else 1.3,
        )
        for (_, label), values, colour in zip(found, histories, COLOURS, strict=False)
    )
    axis = Axis(f"{panel.symbol} [{unit_with_power(panel.unit, power)}]")
    height = 216.0 - (18.0 if len(lines) > 1 else 0.0)
    return draw_chart(panel.name, panel.caption, (Plot(lines, axis, height),), TIME, panel.group)
