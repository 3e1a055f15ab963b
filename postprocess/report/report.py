"""A report: a page, a summary, tables and histories beside it, and what is said on the terminal."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from postprocess.report import files
from postprocess.report.page import Page, Section, write_page
from postprocess.report.table import Table
from postprocess.report.terminal import Part, place_line, printed
from postprocess.svg.chart import Chart
from postprocess.units import SI, Units

PAGE, SUMMARY = "report.html", "summary.json"
SHOWN = ("figures", "tables", "sentences")
"""Parts of a section that have units."""


@dataclass(frozen=True)
class Report:
    """Files and terminal text of a command.

    tables, histories, texts: by the names of their files, which are .csv for the first two. terminal: what is printed
    before the place of the page. passed: None where nothing is judged.
    """

    page: Page
    summary: Mapping[str, Any]
    terminal: tuple[Part, ...]
    tables: Mapping[str, Table] = field(default_factory=dict)
    histories: Mapping[str, Mapping[str, ArrayLike]] = field(default_factory=dict)
    texts: Mapping[str, str] = field(default_factory=dict)

    @property
    def passed(self) -> bool:
        """True if nothing failed."""
        return self.page.passed is not False


def in_units(report: Report, units: Units) -> Report:
    """The report as people who think in other units read it; its files stay in SI."""
    terminal = tuple(shown_in(part, units) for part in report.terminal)
    return replace(report, page=page_in_units(report.page, units), terminal=terminal)


def page_in_units(page: Page, units: Units) -> Page:
    """Return the page in these units."""
    sections = [shown_in(section, units) for section in page.sections]
    said = "SI units" if units is SI else f"{units.name.upper()} units, files in SI"
    footer = page.footer.replace("SI units", said)
    return replace(page, headline=units.rendered(page.headline), sections=sections, footer=footer)


def shown_in(part: Any, units: Units) -> Any:
    """Return a text, table, chart or section in these units; other objects as they are."""
    if isinstance(part, str):
        return units.rendered(part)
    if isinstance(part, Table | Chart):
        return part.in_units(units)
    if isinstance(part, Section):
        parts: dict[str, Any] = {
            name: [shown_in(each, units) for each in getattr(part, name)] for name in SHOWN
        }
        return replace(part, title=units.rendered(part.title), lead=units.rendered(part.lead), **parts)
    return part


def write_report(report: Report, folder: Path, page: str = PAGE) -> None:
    """Fill a folder: page, summary, tables, histories, texts, and the figures as SVG."""
    write_page(folder / page, report.page)
    files.write_summary(folder / SUMMARY, report.summary)
    for name, table in report.tables.items():
        write_table(folder / name, table)
    for name, columns in report.histories.items():
        files.write_history(folder / name, columns)
    for name, text in report.texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    for chart in report.page.charts:
        (folder / f"{chart.name}.svg").write_text(chart.svg, encoding="utf-8")


FORMULA = ("=", "+", "-", "@", "\t", "\r")
"""Beginnings of what a spreadsheet takes for a formula."""


def write_table(path: Path, table: Table) -> Path:
    """Write a table as CSV: a header of keys, a line a record; the values as they are, not as they are shown;
    empty where they are no finite numbers. An apostrophe keeps text from being a formula of a spreadsheet."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(column.key for column in table.columns)
        writer.writerows(map(_literal, files.plain(list(record.values()))) for record in table.records())
    return path


def _literal(value: Any) -> Any:
    return f"'{value}" if isinstance(value, str) and value.startswith(FORMULA) else value


def report_text(report: Report, place: Path, page: str = PAGE) -> str:
    """Text for the terminal, with the place of the page."""
    return printed((*report.terminal, place_line("Report:", place / page)))
