"""Diagrams of errors over run time."""

import math
from typing import NamedTuple

import numpy as np

from postprocess.figures.studies import Series, draw_precision
from postprocess.svg.chart import Chart
from postprocess.svg.scales import power_text
from tailslap.campaign.records import Record
from tailslap.studies.cost import cost_settings
from tailslap.studies.cost.cost_study import front, own_error


class Diagram(NamedTuple):
    """Labels and lines of a diagram.

    Attributes
    ----------
    name, title, error : str
        Name and title, and label of the error.
    methods : tuple of str
        Kind and name of the methods beside finite elements.
    lines : dict of str
        Labels of the groups that are drawn as lines.
    front, truth : str
        Labels of front and reference.
    shows_order : bool
        True to label lines with their orders.
    """

    name: str
    title: str
    error: str
    methods: tuple[str, str]
    lines: dict[str, str]
    front: str = "Pareto front"
    truth: str = "limit"
    shows_order: bool = False


def charts(
    diagram: Diagram, rows: list[Record], uncertainty: float, mesh_uncertainty: float = math.nan
) -> list[Chart]:
    """Return the diagram.

    The uncertainties are those of the reference and of the mesh of choices.
    """
    series = []
    for line in lines(diagram, rows, uncertainty, mesh_uncertainty):
        ordered = diagram.shows_order and line["order"] > 0.5 and line["group"] != cost_settings.MODES
        order = f", order {line['order']:.1f}" if ordered else ""
        series.append(_series(line["label"] + order, line["rows"]))
    best = diagram.front, [(row["seconds"], row["error"]) for row in front(rows)]
    floor = f"uncertainty of the {diagram.truth}: {power_text(float(f'{uncertainty:.0e}'))}", uncertainty
    return draw_precision(diagram.name, diagram.title, series, diagram.error, best, floor)


def _series(label: str, rows: list[Record]) -> Series:
    """Return a line of the diagram, labelled for choices."""
    finite = [row for row in rows if math.isfinite(own_error(row))]
    numbers = [row["seconds"] for row in finite], [own_error(row) for row in finite]
    passed = [not row["failed"] for row in finite]
    added = " (added)" if any(row["choice"] for row in finite) else ""
    return Series(label + added, *numbers, passed, [row["label"] for row in finite])


def lines(diagram: Diagram, rows: list[Record], uncertainty: float, mesh_uncertainty: float) -> list[Record]:
    """Return the lines of a diagram.

    Each has its errors and observed order, that of errors well above the uncertainty, NaN without any.
    """
    drawn = []
    for group, label in diagram.lines.items():
        members = [row for row in rows if row["group"] == group and math.isfinite(own_error(row))]
        errors = np.array([own_error(row) for row in members])
        fineness = np.array([row["refinement"] for row in members])
        level = 3.0 * (mesh_uncertainty if any(row["choice"] for row in members) else uncertainty)
        certain = (errors > level) & (fineness > 0.0)
        x, y = np.log(fineness[certain]), np.log(errors[certain])
        order = -float(np.polyfit(x, y, 1)[0]) if len(x) > 1 and np.ptp(x) else math.nan
        coarsest, finest = (errors[0], errors[-1]) if members else (None, None)
        line = {"group": group, "label": label, "rows": members, "order": order}
        drawn.append({**line, "coarsest": coarsest, "finest": finest})
    return drawn
