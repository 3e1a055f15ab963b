"""What the command `paper` reports: page, numbers, curves; and the tables and findings on the terminal."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import tailslap
from postprocess.figures.paper_plots import draw_figures
from postprocess.report.page import Page, Section
from postprocess.report.report import Report
from tailslap.paper.figures import FIGURES, marks
from tailslap.paper.printed import INPUTS, PAPER, START
from tailslap.paper.report.findings import findings, headline
from tailslap.paper.report.force_tables import earlier_table, factor_table, force_table
from tailslap.paper.report.kinematic_tables import (
    figure_course,
    figure_readings,
    table_1_inputs,
    table_1_start,
    table_3_abaqus,
    table_3_analytical,
)
from tailslap.paper.review import Review
from tailslap.report.common import footer

CAPTIONS = {
    "theta": "Dynamic rotation angle θ",
    "v_gy": "Linear velocity v_GY, negative towards the wall",
    "v_gx": "Linear velocity v_GX",
    "omega": "Angular velocity ω",
    "slide": "Distance s",
}
DIFFERENCE = "In every table, diff. is computed/printed - 1."
REPEATED = (
    "Every number was computed when this page was made. The commands repeat it, in the checkout with its virtual "
    "environment active."
)
PLOTTED = (
    "drag: exact motion with friction μ_k |N|, from the printed start; none: the same without friction. Marked are "
    "the printed values: paper, the start and the analytical column of Table 3 (in Figure 10, t = 0.38 s of Section "
    "3.1.1); ABAQUS, its column of Table 3."
)
AXES = " SI units; X along the wall in the driving direction, Y away from it; ω positive where it closes the angle."


def paper_report(result: Review) -> Report:
    """Page, summary, the curves of Figures 10 to 14 for both motions, and what the terminal says."""
    found = Section("Findings", REPEATED, findings=findings(result))
    parts = sections(result)
    page = Page(
        kicker=PAPER,
        title="The paper's tables and figures, computed beside printed",
        headline=f"{headline(result)} {DIFFERENCE}",
        sections=(found, *parts),
        footer=footer() + AXES,
        contents=True,
    )
    return Report(
        page,
        summary(result),
        (f"{PAPER}\nComputed beside printed. {DIFFERENCE}", "", *parts, found),
        histories={f"figures_10_to_14_{name}.csv": course for name, course in result.figures.courses.items()},
    )


def summary(result: Review) -> dict[str, Any]:
    """The numbers, SI, and the findings in words; a cell is {"printed", "computed", "difference"}.

    The curves of the figures are left out: they stand in files of their own.
    """
    record = asdict(result)
    del record["figures"]["courses"]
    return {
        "version": tailslap.__version__,
        "paper": PAPER,
        "inputs": {
            item.name: {"given": item.given, "value": item.value, "unit": item.unit} for item in INPUTS
        },
        "start": asdict(START),
        **record,
        "headline": headline(result),
        "findings": [asdict(finding) for finding in findings(result)],
    }


def sections(result: Review) -> tuple[Section, ...]:
    """The parts of the paper in its order; the earlier methods last."""
    figures, known = result.figures, result.row_b
    captions = {name: f"Figure {number}. {CAPTIONS[name]}." for number, name in FIGURES.items()}
    curves = draw_figures(captions, figures.courses, {name: marks(name) for name in captions})
    table_1 = (table_1_inputs(result.table_1), table_1_start(result.table_1))
    table_3 = (table_3_analytical(result.table_3), table_3_abaqus(result.table_3))
    table_4 = (force_table(result.table_4, known[0]), factor_table(result.table_4, known[0]))
    table_5 = (force_table(result.table_5, known[1], repeated=True), factor_table(result.table_5, known[1]))
    readings = (figure_readings(figures), figure_course(figures))
    return (
        Section("Table 1. MASH TL-4 (SUT) impact requirements", tables=table_1),
        Section("Table 3. Comparison of FEA and analytical results", tables=table_3),
        Section("Figures 10 to 14. The course of the motion", PLOTTED, curves, readings),
        Section("Table 4. TL-4 peak lateral impact force, 50 ms average", tables=table_4),
        Section("Table 5. TL-4 peak lateral impact force, SAE-filtered data", tables=table_5),
        Section(
            "Earlier methods. Olson, Hirsch and Ritter (Section 2.1)", tables=(earlier_table(result.earlier),)
        ),
    )
