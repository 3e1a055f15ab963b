"""Tables and sentences on a terminal."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import chain
from typing import TYPE_CHECKING

from postprocess.report.page import NO_BREAK, Finding, Section, glued
from postprocess.report.table import Column, Table

if TYPE_CHECKING:
    from rich.table import Table as RichTable

NARROW = 96
"""Columns where standard output is no terminal."""


Part = Table | Finding | Section | str


def printed(parts: Iterable[Part]) -> str:
    """Tables, findings, sentences and whole sections as text, one below the other."""
    from rich.console import Console

    console = Console(highlight=False, soft_wrap=True, markup=False)
    console.width = max(console.width if console.is_terminal else 0, NARROW)
    with console.capture() as shown:  # rich would end the program itself when the reader of a pipe leaves
        for part in chain.from_iterable(map(_single, parts)):
            if isinstance(part, Table):
                console.print(_rich(part))
            for line in _lines(part):
                console.print(line)
    return shown.get().rstrip("\n")


def wrapped(text: str, before: str = "") -> list[str]:
    """Lines of the width of a page; `before` stands in front of the first."""
    indent = " " * len(before)
    lines = textwrap.wrap(glued(text), NARROW, initial_indent=before, subsequent_indent=indent)
    return [line.replace(NO_BREAK, " ") for line in lines]


def _single(part: Part) -> Iterator[Table | Finding | str]:
    """A section's title, tables, sentences and findings, each of these with its number; other parts as they are."""
    if not isinstance(part, Section):
        yield part
        return
    yield f"{part.title}\n{'=' * len(part.title)}"
    numbered = (
        replace(finding, title=f"{number}. {finding.title}")
        for number, finding in enumerate(part.findings, 1)
    )
    items: tuple[Table | Finding | str, ...] = (*part.tables, *part.sentences, *numbered)
    for item in items:
        yield item
        yield ""


def _lines(part: Table | Finding | str) -> Iterator[str]:
    if isinstance(part, str):
        yield from (line for text in part.split("\n") for line in wrapped(text) or [""])
    elif isinstance(part, Finding):
        yield part.title
        yield from wrapped(part.checked, "  checked  ")
        yield from (line for sentence in part.seen for line in wrapped(sentence, "  seen     "))
        yield from (line for sentence in part.inferred for line in wrapped(sentence, "  inferred "))
        yield from (f"  repeat   {command}" for command in part.repeat)
    else:
        yield from (line for note in part.notes for line in wrapped(note))


def _rich(table: Table) -> RichTable:
    from rich import box
    from rich.table import Table as RichTable
    from rich.text import Text

    headed = any(column.label for column in table.columns)
    made = RichTable(
        title=table.title or None,
        title_justify="left",
        box=box.SIMPLE_HEAD if headed else None,
        show_header=headed,
        pad_edge=False,
        collapse_padding=True,
    )
    for column, heading in zip(table.columns, _headings(table), strict=True):
        made.add_column(Text(heading), justify="right" if column.form else "left", no_wrap=bool(column.form))
    for row in table.rows:
        made.add_row(*(Text(_cell(column, row)) for column in table.columns))
    return made


def _cell(column: Column, row: object) -> str:
    return column.text(row)


def _headings(table: Table) -> Iterator[str]:
    """Headings of the columns; where there are groups, below the group's, which its first column carries."""
    last = ""
    for column in table.columns:
        group = column.group if column.group != last else ""
        yield f"{group}\n{column.heading}" if table.groups else column.heading
        last = column.group
