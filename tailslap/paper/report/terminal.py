"""The tables and findings on standard output."""

from __future__ import annotations

import json
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from postprocess.files.summary import plain
from postprocess.pages.paper_page import NO_BREAK, Finding, Row, Table, glued
from postprocess.report.terminal import NARROW
from tailslap.paper.answer import Answer
from tailslap.paper.printed import PAPER
from tailslap.paper.report.content import all_numbers, sections
from tailslap.paper.report.findings import findings
from tailslap.paper.report.write import PAGE

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table as RichTable


def print_paper(result: Answer, place: Path, as_json: bool) -> None:
    """The numbers as JSON; or the tables with their notes, the findings, and where the page is."""
    if as_json:
        print(json.dumps(plain(all_numbers(result)), indent=2, allow_nan=False, ensure_ascii=False))
        return
    from rich.console import Console

    console = Console(highlight=False, soft_wrap=True, markup=False)
    console.width = max(console.width if console.is_terminal else 0, NARROW)
    with console.capture() as shown:  # rich would end the program itself when the reader of a pipe leaves
        _show(console, result, place)
    print(shown.get(), end="")


def _show(console: Console, result: Answer, place: Path) -> None:
    console.print(f"{PAPER}\ncomputed beside printed; diff. = computed/printed - 1\n")
    for section in sections(result):
        console.print(f"{section.title}\n{'=' * len(section.title)}")
        for table in section.tables:
            console.print(_rich(table))
            notes = (line for note in table.notes for line in _wrapped(note))
            console.print("\n".join((*_legend(table), *notes, "")))
    console.print("Findings\n========\n")
    for number, finding in enumerate(findings(result), 1):
        console.print("\n".join(_finding(number, finding)) + "\n")
    console.print(f"Page: {place / PAGE}")


def _rich(table: Table) -> RichTable:
    from rich import box
    from rich.table import Table as RichTable
    from rich.text import Text

    rich = RichTable(title=table.title, title_justify="left", box=box.SIMPLE_HEAD, collapse_padding=True)
    rich.add_column(Text(f"\n{table.head}" if table.groups else table.head), no_wrap=True)
    for heading in _headings(table):
        rich.add_column(Text(heading), justify="right", no_wrap=True)
    for row in table.rows:
        rich.add_row(Text(_head(table, row)), *map(Text, row.cells))
    return rich


def _headings(table: Table) -> Iterator[str]:
    """Names of the columns; where there are groups, below the group's, which its first column carries."""
    if not table.groups:
        yield from (column.name for column in table.columns)
        return
    last = ""
    for column in table.columns:
        yield f"{column.group if column.group != last else ''}\n{column.name}"
        last = column.group


def _head(table: Table, row: Row) -> str:
    words = f"{row.title}, {row.head}" if table.spelled else row.head
    return f"{words} [{row.unit}]" if row.unit else words


def _legend(table: Table) -> Iterator[str]:
    """The words behind the letters at the head of the rows, where the table shows the letters alone."""
    if not (table.symbols or table.spelled):
        yield from (f"{row.head + ':':<4}{row.title}" for row in table.rows if row.title)


def _finding(number: int, finding: Finding) -> Iterator[str]:
    yield f"{number}. {finding.title}"
    yield from _wrapped(finding.checked, "  checked  ")
    for sentence in finding.seen:
        yield from _wrapped(sentence, "  seen     ")
    for sentence in finding.inferred:
        yield from _wrapped(sentence, "  inferred ")
    for command in finding.repeat:
        yield f"  repeat   {command}"


def _wrapped(words: str, before: str = "") -> list[str]:
    indent = " " * len(before)
    lines = textwrap.wrap(glued(words), NARROW, initial_indent=before, subsequent_indent=indent)
    return [line.replace(NO_BREAK, " ") for line in lines]
