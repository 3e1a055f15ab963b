"""Strength of a parapet over height, length and place of the load."""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from postprocess.report.command_report import Report
from postprocess.report.page import Headline, Section
from postprocess.report.tables import Column, Table, columns
from postprocess.svg import chart
from postprocess.svg.marks import Level, Line
from postprocess.units import measure
from tailslap.campaign.records import Record
from tailslap.case.case import Case
from tailslap.case.report_parts import study_page, study_summary
from tailslap.scene.parapet_keys import load_length_of, parapet_of, strengths_of
from tailslap.wall_strength.report import MEANING, nominal_force
from tailslap.wall_strength.strength import Load, bounds_of

TOLERANCE, MOST = 0.03, 700
"""Difference of the bounds that is aimed at [-], and size of mesh from which on none is refined."""

HEIGHTS = (0.5, 0.625, 0.75, 0.875, 1.0)
LENGTHS = (0.1, 0.25, 0.5, 1.0, 1.5, 2.0)
DISTANCES = (0.0, 0.25, 0.5, 1.0, 1.5, 2.0, 3.0)
"""Heights of the load, its lengths and distances from an end, all in heights of the wall [-]."""

SWEPT = {
    "height": "height of the load [m]",
    "length": "length of the load [m]",
    "distance": "distance from the end [m]",
}
COLUMNS = (
    Column("varied", "Varied"),
    *columns({"height": "Height", "length": "Length", "distance": "From the end"}, unit="m", form=".2f"),
    *columns({"lower": "Lower bound", "upper": "Upper bound", "aashto": "A13.3.1"}, unit="N", form="#.4g"),
    Column("ratio", "Force over lower bound", form=".2f", style="strong"),
)


@dataclass(frozen=True)
class ParapetResult:
    """Result of the study.

    rows: records of `COLUMNS`; demand: force of the impact [N].
    """

    case: Case
    rows: list[Record]
    demand: float

    def column(self, varied: str, name: str) -> np.ndarray:
        """Return a column of the rows with one varied quantity."""
        return np.array([row[name] for row in self.rows if row["varied"] == varied], dtype=float)


def compute(case: Case, place: Path) -> ParapetResult:
    """Compute bounds over each quantity, the others as in the scene.

    Raises InputError for a scene without [parapet].
    """
    table = parapet_of(case.scene)
    strengths, longest = strengths_of(table), table.length or math.inf
    height, length = table.load_height or table.height, load_length_of(case.scene, table)
    size = table.height
    loads = {
        "height": [Load(length, factor * size, None) for factor in HEIGHTS],
        "length": [Load(factor * size, height, None) for factor in LENGTHS],
        "distance": [Load(length, height, factor * size) for factor in DISTANCES],
    }
    rows: list[Record] = []
    demand = nominal_force(case)
    for varied, load in ((varied, load) for varied, of_one in loads.items() for load in of_one):
        if load.length + 2.0 * (load.end_distance or 0.0) > longest:
            continue
        bounds = bounds_of(strengths, load, longest, TOLERANCE, MOST)
        formula = strengths.resistance(load.length, "end" if load.end_distance == 0.0 else "interior").force
        lower = bounds.lower.value or math.nan
        upper = bounds.upper.value if math.isfinite(bounds.upper.value) else math.nan
        row = {"varied": varied, "height": load.height, "length": load.length, "distance": load.end_distance}
        rows.append(row | {"lower": lower, "upper": upper, "aashto": formula, "ratio": demand / lower})
    return ParapetResult(case, rows, demand)


def interior_from(result: ParapetResult) -> float:
    """Return the distance from an end whence the interior value holds [m].

    It is the first one whose upper bound reaches the largest lower bound of all distances; NaN without one.
    """
    distances, upper = result.column("distance", "distance"), result.column("distance", "upper")
    reached = distances[
        upper >= result.column("distance", "lower").max(initial=math.inf if not upper.size else 0.0)
    ]
    return float(reached[0]) if reached.size else math.nan


def report(result: ParapetResult) -> Report:
    """Return the report with one chart of each quantity."""
    charts = [_chart(result, varied, label) for varied, label in SWEPT.items()]
    table = Table(COLUMNS, result.rows, notes=(MEANING,))
    place = interior_from(result)
    holds = (
        f" From about {measure(place, 'm', '.2f')} from an end the interior value holds."
        if place == place
        else ""
    )
    answer = f"Force over the lower bound of the flexural strength: {_range(result)}.{holds}"
    headline = Headline(
        f"Strength of the parapet: {result.case.subject}",
        answer,
        result.case.set_up,
        "All bounds are proven.",
    )
    section = Section("Strength and force", "", charts, (table,), layout="narrow")
    page = study_page(
        result.case, "Strength over height, length and place", headline, [section], "summary.json (SI)"
    )
    summary = study_summary("parapet", result.case) | {"rows": result.rows, "interior_from": place}
    return Report(page, summary, (table,))


def _range(result: ParapetResult) -> str:
    """Return the least and largest ratio in words."""
    ratios = [row["ratio"] for row in result.rows if math.isfinite(row["ratio"])]
    return f"{min(ratios):.2f} to {max(ratios):.2f}" if ratios else "not proven"


def _chart(result: ParapetResult, varied: str, label: str) -> chart.Chart:
    """Draw bounds, A13.3.1 and the force over one quantity."""
    x = result.column(varied, varied)
    styles = {
        "lower": ("lower bound", "fe", ""),
        "upper": ("upper bound", "red", ""),
        "aashto": ("A13.3.1", "grey", "5 3"),
    }
    marks = [
        Line(name, x, result.column(varied, key) / 1e3, colour, 1.8, dashes)
        for key, (name, colour, dashes) in styles.items()
    ]
    plot = chart.Plot(
        (*marks, Level("force", result.demand / 1e3, "ink")), chart.Axis("force [kN]", 0.0), 240.0
    )
    across = chart.Axis(label, float(x[0]), float(x[-1]), margin=0.0)
    return chart.Chart(
        f"strength-over-{varied}",
        f"Strength over the {label.removesuffix(' [m]')}",
        (plot,),
        across,
        "Strength",
        chart.PART,
    )
