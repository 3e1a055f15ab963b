"""Picture of the error over the time of the whole process.

A dashed line leads to the point of a code whose loop was ended early: its time is estimated, its error the model's.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from comparison.entries import ALIKE, ANGLE, COMMAND, EXACT, EXUDYN, RIGID, SAME_MODEL, Entry
from postprocess.svg.chart import Axis, Chart, Plot
from postprocess.svg.marks import Line, Mark, Words

COLOURS = {COMMAND: "fe", EXACT: "steel", ALIKE: "difference", "Akantu": "rigid"}
COLOURS |= {"Kratos": "violet", "Warp loop": "green", RIGID: "ink", EXUDYN: "red"}
FLOOR = 1e-10
"""Where exact values are shown."""
NUMBERED = (120, 7680)
"""Numbers of elements that are written beside their points."""
BELOW = (EXACT, "Akantu")
"""Codes whose numbers stand below their points, where others are above."""
WIDTH = 620.0


class Point(NamedTuple):
    """Code on a mesh.

    elements: 0 for a rigid body; time in seconds, error, and whether the time is estimated.
    """

    code: str
    elements: int
    time: float
    error: float
    is_reckoned: bool


def points(entries: Sequence[Entry], is_distorted: bool) -> list[Point]:
    """Points of one kind of mesh, rigid bodies among even ones."""
    chart_points = []
    for entry in entries:
        mesh, is_reckoned = entry.mesh, entry.values is None
        if (mesh is not None and mesh.distortion > 0.0) != is_distorted or not entry.turns:
            continue
        error = _error_of_model(entry, entries) if is_reckoned else entry.error
        if math.isfinite(error) and (mesh is None or mesh.plate.angle == ANGLE):
            count = mesh.plate.count if mesh else 0
            chart_points.append(
                Point(entry.code, count, entry.median("whole"), max(error, FLOOR), is_reckoned)
            )
    return chart_points


def _error_of_model(entry: Entry, entries: Sequence[Entry]) -> float:
    """Error of the other codes on this mesh, for one without."""
    same = [other.error for other in entries if other.mesh is entry.mesh and other.code in SAME_MODEL]
    return next((error for error in same if math.isfinite(error)), math.nan)


def draw(entries: Sequence[Entry]) -> Chart:
    """Equal rectangles above, distorted elements below."""
    plots = []
    for is_distorted, shape in ((False, "equal rectangles"), (True, "distorted elements")):
        shown_points = points(entries, is_distorted)
        if shown_points:
            axis = _axis(f"largest error of five, {shape}", [point.error for point in shown_points])
            plots.append(Plot(tuple(_marks(shown_points)), axis, 240.0, nearest="xy"))
    caption = "Error at the tail-slap against the time of the whole process; numbers are elements"
    return Chart("peers", caption, plots, Axis("whole process [s]", is_log=True), width=WIDTH)


def _axis(label: str, errors: Sequence[float]) -> Axis:
    """Range of the axis in half powers of ten."""
    low, high = math.floor(math.log10(min(errors))), math.ceil(math.log10(max(errors)))
    return Axis(label, 10.0 ** (low - 0.5), 10.0**high, is_log=True)


def _marks(chart_points: Sequence[Point]) -> list[Mark]:
    marks: list[Mark] = []
    for code, colour in COLOURS.items():
        members = [point for point in chart_points if point.code == code]
        ended = [point for point in members if not point.is_reckoned]
        if ended:
            marks.append(_line(code, ended, colour, ""))
        if len(ended) < len(members):
            marks.append(_line("" if ended else code, members[-2:], colour, "4 3"))
        marks += [_name(point, colour) for point in members if code != ALIKE]
    return marks


def _line(label: str, members: Sequence[Point], colour: str, dashes: str) -> Line:
    times, errors = (np.array([getattr(point, part) for point in members]) for part in ("time", "error"))
    return Line(label, times, errors, colour, 1.2, dashes, 0.0 if dashes else 2.6)


def _name(point: Point, colour: str) -> Words:
    text = str(point.elements) if point.elements in NUMBERED else ""
    if not point.elements:
        text = f"{point.code}, exact" if point.error == FLOOR else point.code
    shift = (5.0, 11.0 if point.code in BELOW else -4.0)
    return Words(text, point.time, point.error, shift, colour=colour)


def write(entries: Sequence[Entry], path: Path) -> None:
    """Draw into a file."""
    path.write_text(draw(entries).svg, encoding="utf-8")
