"""What the command says: the tables, the findings and the numbers, whichever way they are shown."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from postprocess.pages.paper_page import Section
from tailslap.paper.answer import Answer, numbers
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

FIGURES = "Figures 10 to 14. The course of the motion"
FIGURES_NOTE = (
    "drag: exact motion with friction μ_k |N|, from the printed start; none: the same without friction. Marked are "
    "the printed values: paper, the start and the analytical column of Table 3 (in Figure 10, t = 0.38 s of Section "
    "3.1.1); ABAQUS, its column of Table 3."
)


def all_numbers(result: Answer) -> dict[str, Any]:
    """What `--json` and `summary.json` hold: the numbers, SI, and the findings in words."""
    return {
        **numbers(result),
        "headline": headline(result),
        "findings": [asdict(finding) for finding in findings(result)],
    }


def sections(result: Answer) -> tuple[Section, ...]:
    """The parts of the answer in the order of the paper, without plots; the earlier methods last."""
    known_4, known_5 = result.row_b
    table_4, table_5 = (result.table_4, known_4), (result.table_5, known_5)
    return (
        Section(
            "Table 1. MASH TL-4 (SUT) impact requirements",
            (table_1_inputs(result.table_1), table_1_start(result.table_1)),
        ),
        Section(
            "Table 3. Comparison of FEA and analytical results",
            (table_3_analytical(result.table_3), table_3_abaqus(result.table_3)),
        ),
        Section(FIGURES, (figure_readings(result.figures), figure_course(result.figures)), note=FIGURES_NOTE),
        Section(
            "Table 4. TL-4 peak lateral impact force, 50 ms average",
            (force_table(*table_4), factor_table(*table_4)),
        ),
        Section(
            "Table 5. TL-4 peak lateral impact force, SAE-filtered data",
            (force_table(*table_5, repeated=True), factor_table(*table_5)),
        ),
        Section("Earlier methods. Olson, Hirsch and Ritter (Section 2.1)", (earlier_table(result.earlier),)),
    )
