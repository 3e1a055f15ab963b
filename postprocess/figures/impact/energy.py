"""What becomes of the kinetic energy, as layers over time."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from postprocess.figures.curves import STRETCHES
from postprocess.figures.impact.forces import START, WIDE
from postprocess.figures.impact.strikes import StrikeMark, shaded
from postprocess.svg.chart import Axis, Chart, Plot, draw_chart
from postprocess.svg.marks import Layer, Line

Floats = NDArray[np.float64]

COLOURS = ("difference", "rigid", "steel", "green", "violet", "soft", "red")


def draw_energies(
    t: Floats, kinetic: Floats, parts: Mapping[str, Floats], strikes: Sequence[StrikeMark] = ()
) -> Chart:
    """What the motion gave up, as a line, and below it what it went into, layer upon layer; in kJ.

    t [s], kinetic and each of `parts` [J], shape (n,): crush lost, friction, damping, crush stored, strain and so on,
    the first at the bottom. Where layers and line part, the balance is open.
    """
    caption = "Energy that the motion gave up (line), and what it went into (layers)"
    shown = np.unique(np.linspace(0, t.size - 1, 2 * STRETCHES).astype(int))
    kept = {label: values[shown] / 1e3 for label, values in parts.items() if np.any(values)}
    tops = np.cumsum([np.zeros(shown.size), *kept.values()], axis=0)
    layers = tuple(
        Layer(label, t[shown], tops[number], tops[number + 1], colour)
        for number, (label, colour) in enumerate(zip(kept, COLOURS, strict=False))
    )
    line = Line("given up", t[shown], (kinetic[0] - kinetic[shown]) / 1e3, "ink", 1.3)
    plot = Plot((*shaded(strikes), *layers, line), Axis("energy [kJ]"), 220.0)
    return draw_chart("energies", caption, (plot,), START, "Energy", WIDE)
