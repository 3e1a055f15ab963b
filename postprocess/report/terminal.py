"""Tables and sentences on a terminal, within its width; where standard output is none, within 80 columns."""

from __future__ import annotations

import shutil
import textwrap
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import chain, zip_longest

from postprocess.report import page
from postprocess.report.table import Table
from postprocess.units import SI

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
    """A line of a label and what it says, the further lines below the latter; one without a label as it begins."""
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
    """Widths of columns: words give way, the widest first."""
    widths = [column.widest for column in block]
    while sum(widths) + len(GAP) * (len(block) - 1) > width:
        gives = [number for number, column in enumerate(block) if column.least < widths[number]]
        if not gives:
            break
        widths[max(gives, key=lambda number: widths[number])] -= 1
    return widths


def _row(cells: Lines, block: list[Laid], widths: list[int]) -> Iterator[str]:
    """Lines of a row; words to the left, numbers to the right."""
    for texts in zip_longest(*cells, fillvalue=""):
        sides = [
            text.ljust(wide) if column.is_words else text.rjust(wide)
            for text, column, wide in zip(texts, block, widths, strict=True)
        ]
        yield GAP.join(sides).rstrip()
