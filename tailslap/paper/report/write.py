"""Fills the result folder of the command `paper`."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import tailslap
from postprocess.files.histories import write_history
from postprocess.files.summary import write_summary
from postprocess.pages.paper_page import PaperPage, draw_figures, write_paper_page
from tailslap.paper.answer import Answer
from tailslap.paper.figures import FIGURES, marks
from tailslap.paper.printed import PAPER
from tailslap.paper.report.content import FIGURES as PLOTTED
from tailslap.paper.report.content import all_numbers, sections
from tailslap.paper.report.findings import findings, headline

PAGE = "paper.html"
CAPTIONS = {
    "theta": "Dynamic rotation angle θ",
    "v_gy": "Linear velocity v_GY, negative towards the wall",
    "v_gx": "Linear velocity v_GX",
    "omega": "Angular velocity ω",
    "slide": "Distance s",
}


def write_paper(result: Answer, folder: Path) -> None:
    """Fill the folder: page, numbers, and the curves of Figures 10 to 14 for both motions."""
    captions = {name: f"Figure {number}. {CAPTIONS[name]}." for number, name in FIGURES.items()}
    courses = result.figures.courses
    curves = draw_figures(captions, courses, {name: marks(name) for name in captions})
    page = PaperPage(
        tailslap.__version__,
        PAPER,
        headline(result),
        findings(result),
        tuple(replace(part, figures=curves) if part.title == PLOTTED else part for part in sections(result)),
    )
    write_paper_page(folder / PAGE, page)
    for reaction, columns in courses.items():
        write_history(folder / f"figures_10_to_14_{reaction}.csv", columns)
    write_summary(folder / "summary.json", all_numbers(result))
