"""Force on the wall over time, raw and filtered, with design forces; force over crush of each contact point."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from postprocess.figures.curves import TIME, thinned
from postprocess.figures.impact.strikes import StrikeMark, corner_colour, shaded
from postprocess.svg.chart import Axis, Chart, Plot, draw_chart
from postprocess.svg.marks import Level, Line

Floats = NDArray[np.float64]

START = replace(TIME, low=0.0)
WIDE = 540.0
"""Time from first touch on; width of the plots over time [pixels]."""

LINES: Mapping[str, tuple[str, dict[str, Any]]] = {
    "raw": ("raw", {"colour": "grey", "width": 2.4}),
    "cfc180": ("CFC 180", {"colour": "green", "width": 1.0}),
    "cfc60": ("CFC 60", {"colour": "fe"}),
    "cutoff_60hz": ("60 Hz cut-off", {"colour": "violet", "dashes": "5 2"}),
    "mean_50ms": ("50 ms mean", {"colour": "rigid", "width": 2.2}),
}
"""Label and look of each curve, in the order in which they are drawn."""


def draw_forces(
    name: str,
    caption: str,
    t: Floats,
    curves: Mapping[str, Floats],
    strikes: Sequence[StrikeMark] = (),
    levels: Mapping[str, float] | None = None,
) -> Chart:
    """Curves of one force by the names of `force_curves`, shape (n,) [N], over t [s]; drawn in kN.

    levels: what a design force is called -> force [N], drawn as a line.
    """
    lines = [
        Line(label, *thinned(t, curves[key] / 1e3), **look)
        for key, (label, look) in LINES.items()
        if key in curves
    ]
    across = [Level(label, round(force / 1e3, 1)) for label, force in (levels or {}).items()]
    plot = Plot((*shaded(strikes), *across, *lines), Axis("force on the wall [kN]"), 230.0)
    return draw_chart(name, caption, (plot,), START, "Force", WIDE)


def draw_loops(contacts: Mapping[str, tuple[Floats, Floats]]) -> Chart:
    """Force [N] over crush [m] of each contact point by its name, shape (n,) each; drawn in kN and mm."""
    caption = "Force over crush of each contact point: what a loop encloses is lost"
    lines = tuple(
        Line(label, *_cornered(crush * 1e3, force / 1e3), corner_colour(label))
        for label, (crush, force) in contacts.items()
    )
    plot = Plot(lines, Axis("force [kN]", low=0.0), 230.0, nearest="xy")
    return draw_chart("loops", caption, (plot,), Axis("crush [mm]", low=0.0), "Force")


def _cornered(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """The points of a line without those that lie on the straight line between their neighbours, shape (k,)."""
    moved = np.append(True, (np.diff(x) != 0.0) | (np.diff(y) != 0.0))
    x, y = x[moved], y[moved]
    steps = np.diff(x) / (np.ptp(x) or 1.0) + 1j * np.diff(y) / (np.ptp(y) or 1.0)
    kept = np.concatenate([[True], np.abs(np.angle(steps[1:] / steps[:-1])) > 1e-6, [True]])
    return x[kept], y[kept]
