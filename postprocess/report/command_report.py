"""Report of a command.

A page, a summary, tables and histories as files, and text for the terminal.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from postprocess.report.data_files import write_history, write_summary, write_table
from postprocess.report.page import Page, write_page
from postprocess.report.provenance import files_digest, write_crate
from postprocess.report.tables import Table
from postprocess.report.terminal import Part, concluded, part_in_units, place_line
from postprocess.units import Units

PAGE, SUMMARY = "report.html", "summary.json"


@dataclass(frozen=True)
class Report:
    """Files and terminal text of a command.

    tables, histories, texts: by the names of their files, .csv for the first two; terminal: printed above set-up and
    answer, in order of importance.
    """

    page: Page
    summary: Mapping[str, Any]
    terminal: tuple[Part, ...]
    tables: Mapping[str, Table] = field(default_factory=dict)
    histories: Mapping[str, Mapping[str, ArrayLike]] = field(default_factory=dict)
    texts: Mapping[str, str] = field(default_factory=dict)

    @property
    def numbers(self) -> dict[str, Any]:
        """Headline and summary."""
        return {**vars(self.page.headline), **self.summary}

    @property
    def passed(self) -> bool:
        """True if no check failed."""
        return self.page.passed is not False

    def in_units(self, units: Units) -> Report:
        """Return the report in other units.

        Its files remain in SI.
        """
        terminal = tuple(part_in_units(part, units) for part in self.terminal)
        return replace(self, page=self.page.in_units(units), summary=self.numbers, terminal=terminal)


def write_report(report: Report, folder: Path, page: str = PAGE) -> None:
    """Write the report into a folder.

    Page, summary, tables, histories, texts, figures as SVG, and the description of all files.
    """
    write_summary(folder / SUMMARY, report.numbers)
    for name, table in report.tables.items():
        write_table(folder / name, table)
    for name, columns in report.histories.items():
        write_history(folder / name, columns)
    for name, text in report.texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    for chart in report.page.charts:
        (folder / f"{chart.name}.svg").write_text(chart.svg, encoding="utf-8")
    origin, digest = report.page.footer, files_digest(folder, page)
    seal = f"SHA-256 of the list of the other files: `{digest}`."
    original = report.page.original or report.page
    sealed = replace(original, footer=f"{original.footer} {seal}".strip())
    write_page(folder / page, sealed.in_units(report.page.units))
    write_crate(folder, page, digest, report.page.headline, origin, str(report.numbers.get("version", "")))


def report_text(report: Report, place: Path, page: str = PAGE, most: float = math.inf) -> str:
    """Return the text for the terminal, with the place of the page.

    most: number of lines, see `concluded`.
    """
    places = (place_line("Report:", place / page),)
    return concluded(report.page.headline, *report.terminal, places=places, most=most)
