"""The picture of peers.py: error against the time of the whole process, a line for each code."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from comparison.entries import ANGLE, COMMAND, EXACT, EXUDYN, RIGID, Entry
from postprocess.figures.svg.chart import Axis, Chart, Plot, draw_chart
from postprocess.figures.svg.marks import Line, Mark, Words

COLOURS = {
    COMMAND: "fe",
    EXACT: "steel",
    "tailslap run, as the others": "grey",
    "Akantu": "rigid",
    "Kratos": "violet",
    "Warp loop": "green",
    RIGID: "ink",
    EXUDYN: "red",
}
FLOOR = 1e-10
"""Where exact values are shown."""

WIDTH = 620.0


def draw(entries: Sequence[Entry]) -> Chart:
    """Equal rectangles above, distorted elements below, of the whole event."""
    whole = [entry for entry in entries if entry.mesh is None or entry.mesh.plate.angle == ANGLE]
    ended = [entry for entry in whole if entry.values is not None]
    even = [entry for entry in ended if entry.mesh is None or not entry.mesh.distortion]
    uneven = [entry for entry in ended if entry.mesh is not None and entry.mesh.distortion]
    plots = [
        Plot(
            tuple(_marks(members)), Axis(f"largest error of five, {shape}", is_log=True), 260.0, nearest=True
        )
        for members, shape in ((even, "equal rectangles"), (uneven, "distorted elements"))
        if members
    ]
    caption = "Error at the tail-slap against the time of the whole process; numbers are elements"
    return draw_chart("peers", caption, plots, Axis("whole process [s]", is_log=True), width=WIDTH)


def _marks(entries: Sequence[Entry]) -> list[Mark]:
    marks: list[Mark] = []
    for code, colour in COLOURS.items():
        members = [entry for entry in entries if entry.code == code]
        if members:
            times = np.array([entry.median("whole") for entry in members])
            errors = np.array([max(entry.error, FLOOR) for entry in members])
            marks.append(Line(code, times, errors, colour, 1.2, dots=2.6))
            marks += [_number(*place, colour) for place in zip(members, times, errors, strict=True)]
    return marks


def _number(entry: Entry, time: float, error: float, colour: str) -> Words:
    text = (
        str(entry.mesh.plate.count) if entry.mesh else entry.code if error > FLOOR else f"{entry.code}: exact"
    )
    return Words(text, time, error, (5.0, -4.0), colour=colour, size=9.0)


def write(entries: Sequence[Entry], path: Path) -> None:
    """Draw into a file."""
    path.write_text(draw(entries).svg, encoding="utf-8")
