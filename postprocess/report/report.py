"""A report: a page, a summary, tables and histories beside it, and its text on the terminal.

Tables and sentences on a terminal, within its width; where standard output is none, within 80 columns.
"""

import csv
import shutil
import textwrap
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import chain, zip_longest
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from postprocess.report import page
from postprocess.report.page import (
    Headline,
    Page,
    Section,
    Table,
    plain,
    write_history,
    write_page,
    write_summary,
)
from postprocess.report.provenance import files_digest, write_crate
from postprocess.svg.chart import Chart
from postprocess.units import SI, Units

WIDEST, NARROWEST, LEAST = 100, 40, 12
"""Columns that lines have at most and at least, and that a column of words keeps."""

GAP = "  "

Part = Table | page.Section | str
Lines = list[list[str]]


def printed(parts: Iterable[Part]) -> str:
    """Tables, sentences and whole sections as text, one below the other; a table without rows is left out."""
    shown = chain.from_iterable(map(_single, parts))
    return "\n".join(chain.from_iterable(map(_lines, shown))).rstrip("\n")


def line_width() -> int:
    """Largest length of a line."""
    return max(NARROWEST, min(shutil.get_terminal_size().columns, WIDEST))


def wrapped(text: str, before: str = "") -> list[str]:
    """Lines of the terminal's width, no word broken; `before` stands in front of the first."""
    wrapper = textwrap.TextWrapper(
        line_width(), before, " " * len(before), break_long_words=False, break_on_hyphens=False
    )
    return [line.replace(page.NO_BREAK, " ") for line in wrapper.wrap(page.glued(SI.rendered(text)))]


def place_line(label: str, place: object) -> str:
    """A label and a path, which is not broken however long it is."""
    return f"{label} {place}".replace(" ", page.NO_BREAK)


def labelled(text: str, indent: int) -> list[str]:
    """A label and its text, the further lines below the text; a line without a label is indented as it begins."""
    if text[indent - 1 : indent] != " ":
        indent = len(text) - len(text.lstrip())
    return wrapped(text[indent:].strip(), text[:indent]) or [text]


def labelled_text(lines: Iterable[str], indent: int) -> str:
    """Such lines as one text."""
    return "\n".join(part for line in lines for part in labelled(line, indent))


def _single(part: Part) -> Iterator[Table | str]:
    """A section's title, tables and sentences; other parts as they are."""
    if not isinstance(part, page.Section):
        yield part
        return
    yield f"{part.title}\n{'=' * len(part.title)}"
    for table in part.tables:
        yield from (table, "")
    for sentence in part.sentences:
        yield from (sentence, "")


def _lines(part: Table | str) -> Iterator[str]:
    if isinstance(part, str):
        yield from (line for text in part.split("\n") for line in wrapped(text) or [""])
    elif part.rows:
        yield from table_lines(part, line_width())
        yield from (line for note in part.notes for line in wrapped(note))
        yield ""


def table_lines(table: Table, width: int) -> list[str]:
    """The table within so many columns: words wrap; where numbers take too many, further columns stand below, beside
    the first column again."""
    roomy, columns = ([_laid(table, n, least) for n in range(len(table.columns))] for least in (LEAST, 0))
    if len(list(_blocks(roomy, width))) == 1:
        columns = roomy
    lines = wrapped(table.title) if table.title else []
    for block in _blocks(columns, width):
        lines += [*_block_lines(block, width), ""]
    return lines[:-1]


@dataclass(frozen=True)
class Laid:
    """A column as text: lines of its heading, cells, whether these are words, and the narrowest that it can be."""

    heading: list[str]
    cells: list[str]
    is_words: bool
    least: int

    @property
    def widest(self) -> int:
        """Columns that it takes without a break."""
        return max(map(len, (*self.heading, *self.cells)), default=0)


def _laid(table: Table, number: int, least: int) -> Laid:
    """A column; its heading is no wider than its cells or `least`, if words allow that."""
    column = table.columns[number]
    cells = [column.text(row) for row in table.rows]
    words = [word for text in (column.label, *(cells if not column.form else ())) for word in text.split()]
    longest = max(map(len, words), default=0)
    numbers = max(map(len, cells), default=0) if column.form else 0
    wide = max(longest, numbers, least if column.form else LEAST)
    heading = textwrap.wrap(column.label, wide, break_long_words=False) + (
        [f"[{column.shown_unit}]"] if column.unit else []
    )
    first = not number or table.columns[number - 1].group != column.group
    groups = [column.group if first else ""] if table.groups else []
    narrowest = max([longest, numbers, *map(len, (*heading, *groups))])
    return Laid([*groups, *heading], cells, not column.form, narrowest)


def _blocks(columns: list[Laid], width: int) -> Iterator[list[Laid]]:
    """Columns that fit side by side, each time with the first one."""
    block = columns[:1]
    for column in columns[1:]:
        if len(block) > 1 and sum(each.least + len(GAP) for each in block) + column.least > width:
            yield block
            block = columns[:1]
        block = [*block, column]
    yield block


def _block_lines(block: list[Laid], width: int) -> Iterator[str]:
    """Heading, a rule, and the rows."""
    widths = _widths(block, width)
    deep = max(len(column.heading) for column in block)
    if any(any(column.heading) for column in block):
        yield from _row([[""] * (deep - len(c.heading)) + c.heading for c in block], block, widths)
        yield "─" * (sum(widths) + len(GAP) * (len(block) - 1))
    for number in range(len(block[0].cells)):
        cells = [
            textwrap.wrap(column.cells[number], wide, break_long_words=False, break_on_hyphens=False) or [""]
            for column, wide in zip(block, widths, strict=True)
        ]
        yield from _row(cells, block, widths)


def _widths(block: list[Laid], width: int) -> list[int]:
    """Widths of columns: words are narrowed, the widest first."""
    widths = [column.widest for column in block]
    while sum(widths) + len(GAP) * (len(block) - 1) > width:
        narrowed = [number for number, column in enumerate(block) if column.least < widths[number]]
        if not narrowed:
            break
        widths[max(narrowed, key=lambda number: widths[number])] -= 1
    return widths


def _row(cells: Lines, block: list[Laid], widths: list[int]) -> Iterator[str]:
    """Lines of a row; words to the left, numbers to the right."""
    for texts in zip_longest(*cells, fillvalue=""):
        cells_of = zip(texts, block, widths, strict=True)
        yield GAP.join(
            f"{text:{'<' if column.is_words else '>'}{wide}}" for text, column, wide in cells_of
        ).rstrip()


PAGE, SUMMARY = "report.html", "summary.json"
SHOWN = ("figures", "tables", "sentences")
"""Parts of a section that have units."""


@dataclass(frozen=True)
class Report:
    """Files and terminal text of a command.

    tables, histories, texts: by the names of their files, which are .csv for the first two. terminal: printed between
    the answer of the page and the place of the page. passed: None where nothing is judged.
    """

    page: Page
    summary: Mapping[str, Any]
    terminal: tuple[Part, ...]
    tables: Mapping[str, Table] = field(default_factory=dict)
    histories: Mapping[str, Mapping[str, ArrayLike]] = field(default_factory=dict)
    texts: Mapping[str, str] = field(default_factory=dict)

    @property
    def numbers(self) -> dict[str, Any]:
        """The summary behind the headline."""
        return {**vars(self.page.headline), **self.summary}

    @property
    def passed(self) -> bool:
        """True if nothing failed."""
        return self.page.passed is not False


def in_units(report: Report, units: Units) -> Report:
    """The report as people who think in other units read it; its files stay in SI."""
    terminal = tuple(shown_in(part, units) for part in report.terminal)
    page = page_in_units(report.page, units)
    return replace(report, page=page, summary=report.numbers, terminal=terminal)


def page_in_units(page: Page, units: Units) -> Page:
    """Return the page in these units."""
    sections = [shown_in(section, units) for section in page.sections]
    name = "SI units" if units is SI else f"{units.name.upper()} units, files in SI"
    footer = page.footer.replace("SI units", name)
    return replace(page, headline=page.headline.in_units(units), sections=sections, footer=footer)


def shown_in(part: Any, units: Units) -> Any:
    """Return a text, table, chart or section in these units; other objects as they are."""
    if isinstance(part, str):
        return units.rendered(part)
    if isinstance(part, Table | Chart):
        return part.in_units(units)
    if isinstance(part, Section):
        parts: dict[str, Any]
        parts = {name: [shown_in(each, units) for each in getattr(part, name)] for name in SHOWN}
        return replace(part, title=units.rendered(part.title), lead=units.rendered(part.lead), **parts)
    return part


def write_report(report: Report, folder: Path, page: str = PAGE) -> None:
    """Fill a folder: page, summary, tables, histories, texts, the figures as SVG, and the description of all files."""
    write_summary(folder / SUMMARY, report.numbers)
    for name, table in report.tables.items():
        write_table(folder / name, table)
    for name, columns in report.histories.items():
        write_history(folder / name, columns)
    for name, text in report.texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    for chart in report.page.charts:
        (folder / f"{chart.name}.svg").write_text(chart.svg, encoding="utf-8")
    made = report.page.footer
    seal = f"SHA-256 of the list of the other files: `{files_digest(folder, page)}`."
    write_page(folder / page, replace(report.page, footer=f"{made} {seal}".strip()))
    write_crate(folder, page, report.page.headline, made, str(report.numbers.get("version", "")))


FORMULA = ("=", "+", "-", "@", "\t", "\r")
"""Beginnings of what a spreadsheet takes for a formula."""


def write_table(path: Path, table: Table) -> Path:
    """Write a table as CSV: a header of keys, a line a record; the values as they are, not as they are shown;
    empty where they are no finite numbers. An apostrophe keeps text from being a formula of a spreadsheet."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(column.key for column in table.columns)
        writer.writerows(map(_literal, plain(list(record.values()))) for record in table.records())
    return path


def _literal(value: Any) -> Any:
    return f"'{value}" if isinstance(value, str) and value.startswith(FORMULA) else value


def opened(headline: Headline, *parts: Part) -> str:
    """A headline and what follows it, as text."""
    return printed((*headline.lines, "", *parts))


def report_text(report: Report, place: Path, page: str = PAGE) -> str:
    """Text for the terminal, with the place of the page."""
    return opened(report.page.headline, *report.terminal, place_line("Report:", place / page))
