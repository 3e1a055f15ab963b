"""`paper.html`: published tables and figures, computed beside printed, in one file that fetches nothing.

The records hold finished text, so that a terminal and the page show the same digits.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from postprocess.figures import curves
from postprocess.figures.curves import LEFT, History, thinned
from postprocess.figures.panels import COMPARED, Panel
from postprocess.figures.style import DIFFERENCE, FE, RIGID, STYLE, Curve
from postprocess.pages.pages import write_page

TEMPLATE = "paper.html.j2"
NO_BREAK = "\N{NO-BREAK SPACE}"
GLUED = re.compile(r"(?<=\d) (?=[a-z%])|(?<==) | (?==)|(?<=row) ")
SYMBOL = re.compile(r"\b([^\W\d_])_([A-Za-z0-9]+)")
PRINTED, COMPUTED, DIFFERENT = "printed", "computed", "difference"
"""Kinds of a column, which decide how the page shows it."""
LINES: dict[str, dict[str, Any]] = {
    "━": {"color": RIGID, "linewidth": 3.2},
    "╌": {"color": FE, "linewidth": 1.4, "dashes": (3.0, 2.0)},
}
MARKS: dict[str, dict[str, Any]] = {
    "●": {"color": "#1b1f24", "marker": "o", "markersize": 5.5},
    "◆": {"color": DIFFERENCE, "marker": "D", "markersize": 5.0},
}
"""How the first and the second motion, or kind of mark, is drawn, by the sign that stands for it in the legend."""


@dataclass(frozen=True)
class Column:
    """Heading and kind of a column; group: a heading over several neighbours."""

    name: str
    kind: str = COMPUTED
    group: str = ""


@dataclass(frozen=True)
class Row:
    """head: a symbol ("v_GY") or a letter; unit; cells: one a column; title: the head in words."""

    head: str
    cells: tuple[str, ...]
    unit: str = ""
    title: str = ""


@dataclass(frozen=True)
class Table:
    """A table: title, heading of the row heads, columns, rows, and notes that stand below it.

    spelled: a terminal shows the titles of the rows as well, which the page always does; symbols: the heads
    of the rows are symbols of quantities.
    """

    title: str
    head: str
    columns: tuple[Column, ...]
    rows: tuple[Row, ...]
    notes: tuple[str, ...] = ()
    spelled: bool = False
    symbols: bool = False

    @property
    def groups(self) -> tuple[tuple[str, int], ...]:
        """The headings above the columns and how many columns each spans; none if no column has one."""
        spans: list[tuple[str, int]] = []
        for column in self.columns:
            if spans and spans[-1][0] == column.group:
                spans[-1] = (column.group, spans[-1][1] + 1)
            else:
                spans.append((column.group, 1))
        return tuple(spans) if any(column.group for column in self.columns) else ()


@dataclass(frozen=True)
class Finding:
    """A finding of the review: what was checked and seen, the commands that repeat it, and what is inferred."""

    title: str
    checked: str
    seen: tuple[str, ...]
    repeat: tuple[str, ...]
    inferred: tuple[str, ...] = ()


@dataclass(frozen=True)
class Section:
    """A part of the page: its heading, "Table 1. What it is"; a note; plots, and tables below them."""

    title: str
    tables: tuple[Table, ...]
    figures: tuple[Curve, ...] = ()
    note: str = ""


@dataclass(frozen=True)
class PaperPage:
    """All that the page says; paper: what it is about, in full."""

    version: str
    paper: str
    headline: str
    findings: tuple[Finding, ...]
    sections: tuple[Section, ...]


def write_paper_page(path: Path, page: PaperPage) -> Path:
    """Writes the page and returns its path."""
    return write_page(path, TEMPLATE, {f.name: getattr(page, f.name) for f in fields(page)}, {"prose": prose})


def prose(words: str) -> Any:
    """The words as HTML, in which a letter with a subscript, like v_GY, is shown as one."""
    from markupsafe import Markup, escape

    return Markup(SYMBOL.sub(r"<i>\1</i><sub>\2</sub>", glued(str(escape(words)))))


def glued(words: str) -> str:
    """The words with no line break between a number and its unit, nor at an equals sign."""
    return GLUED.sub(NO_BREAK, words)


def draw_figures(
    captions: Mapping[str, str],
    courses: Mapping[str, History],
    marks: Mapping[str, Mapping[str, tuple[tuple[float, float], ...]]],
) -> tuple[Curve, ...]:
    """One plot for each quantity of `captions` (name of a column -> caption), in that order.

    courses: name of a motion, two at most -> its columns, SI, with the instants "t" [s]; marks: quantity ->
    what they are called, two kinds at most -> printed points (t, value).
    """
    from matplotlib import rc_context, rcdefaults, rcParams

    panels = {panel.name: panel for panel in COMPARED}
    with rc_context():
        rcdefaults()
        rcParams.update(STYLE)
        sheet = curves.make_sheet((0.16, 0.74))
        return tuple(
            _draw(sheet, replace(panels[name], caption=caption), courses, marks[name])
            for name, caption in captions.items()
        )


def _draw(
    sheet: curves.Sheet,
    panel: Panel,
    courses: Mapping[str, History],
    marks: Mapping[str, tuple[tuple[float, float], ...]],
) -> Curve:
    curves.clear_sheet(sheet)
    (axes,) = sheet.axes
    axes.set_ylabel(f"{panel.symbol} [{panel.unit}]")
    legend = []
    for (label, columns), (sign, style) in zip(courses.items(), LINES.items(), strict=False):
        axes.plot(*thinned(columns["t"], columns[panel.name]), **style)
        legend.append((f"{sign} {label}", style["color"]))
    for (label, points), (sign, style) in zip(marks.items(), MARKS.items(), strict=False):
        if points:
            axes.plot(*np.transpose(points), linestyle="none", clip_on=False, zorder=4, **style)
            legend.append((f"{sign} {label}", style["color"]))
    x = LEFT
    for words, colour in legend:
        sheet.figure.text(x, 0.93, words, color=colour, fontweight="bold")
        x += 0.02 + 0.0195 * len(words)
    return curves.finish_curve(sheet, panel, ())
