"""Text of reports on a terminal.

Tables and sentences keep within its width; without a terminal within 80 columns.
"""

import io
import math
import shutil
import textwrap
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import chain, takewhile

from postprocess.report.page import Headline, Section
from postprocess.report.prose import NO_BREAK, glued
from postprocess.report.tables import Table
from postprocess.units import SI, Units

WIDEST, NARROWEST, LEAST = 100, 40, 12
"""Largest and smallest length of lines, and smallest width of a column of words."""

GAP = 2
"""Blanks between columns."""

SCREEN = 40
"""Most lines of a run."""

MORE = "More by --full, and in the report."
"""Line in place of omitted parts."""

Part = Table | Section | str


def printed(parts: Iterable[Part]) -> str:
    """Return tables, sentences and sections as text, one below the other.

    Tables without rows are omitted.
    """
    single = chain.from_iterable(map(_single, parts))
    return "\n".join(chain.from_iterable(map(_lines, single))).rstrip("\n")


def line_width() -> int:
    """Return the largest length of a line."""
    return max(NARROWEST, min(shutil.get_terminal_size().columns, WIDEST))


def wrapped(text: str, before: str = "") -> list[str]:
    """Wrap a text to the terminal's width.

    before: text in front of the first line.
    """
    wrapper = textwrap.TextWrapper(
        line_width(), before, " " * len(before), break_long_words=False, break_on_hyphens=False
    )
    return [line.replace(NO_BREAK, " ") for line in wrapper.wrap(glued(SI.rendered(text)))]


def place_line(label: str, place: object) -> str:
    """Return a label and a path that is never broken."""
    return f"{label} {place}".replace(" ", NO_BREAK)


def labelled(text: str, indent: int) -> list[str]:
    """Wrap a text beside its label, which blanks fill up.

    A line without a label is indented as it begins.
    """
    if text[indent - 2 : indent] != "  ":
        indent = len(text) - len(text.lstrip())
    return wrapped(text[indent:].strip(), text[:indent]) or [text]


def labelled_text(lines: Iterable[str], indent: int) -> str:
    """Return labelled lines as one text."""
    return "\n".join(part for line in lines for part in labelled(line, indent))


def _single(part: Part) -> Iterator[Table | str]:
    """Yield the parts of a section, and other parts unchanged."""
    if not isinstance(part, Section):
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


@dataclass(frozen=True)
class Laid:
    """Column of text with its narrowest width."""

    heading: str
    cells: list[str]
    is_words: bool
    narrowest: int


def table_lines(table: Table, width: int) -> list[str]:
    """Return a table as lines of this width.

    Words wrap. Where numbers require more, further columns stand below, beside the first ones again.
    """
    for least in (LEAST, 0):
        columns = [_laid(table, number, least) for number in range(len(table.columns))]
        blocks = list(_blocks(columns, width))
        if len(blocks) == 1:
            break
    lines = wrapped(table.title) if table.title else []
    for block in blocks:
        lines += [*_grid(block, width), ""]
    return lines[:-1]


def _laid(table: Table, number: int, least: int) -> Laid:
    """Return a column as text.

    Its heading is wrapped to `least` or the width of its cells.
    """
    column = table.columns[number]
    cells, is_words = [column.text(row) for row in table.rows], not column.form
    pieces = [column.label.split(), *(text.split() if is_words else [text] for text in cells)]
    widest = max(map(len, chain.from_iterable(pieces)), default=0)
    heading = textwrap.wrap(column.label, max(widest, LEAST if is_words else least), break_long_words=False)
    heading += [f"[{column.shown_unit}]"] if column.unit else []
    if table.groups:
        is_first = not number or table.columns[number - 1].group != column.group
        heading.insert(0, column.group if is_first else "")
    return Laid("\n".join(heading), cells, is_words, max([widest, *map(len, heading)]))


def _blocks(columns: list[Laid], width: int) -> Iterator[list[Laid]]:
    """Yield columns that fit side by side.

    Each block begins with the first columns of words, which identify a row, or with the first column alone where
    these take half of the width.
    """
    first = list(takewhile(lambda column: column.is_words, columns))
    narrow = len(first) < len(columns) and sum(part.narrowest + GAP for part in first) < 0.5 * width
    block = first = first if first and narrow else columns[:1]
    for column in columns[len(first) :]:
        if len(block) > len(first) and sum(part.narrowest + GAP for part in block) + column.narrowest > width:
            yield block
            block = first
        block = [*block, column]
    yield block


def _widths(block: list[Laid], width: int) -> list[int]:
    """Return the column widths, where words divide the free space equally."""
    longest = [max([column.narrowest, *map(len, column.cells)]) for column in block]
    widths = [column.narrowest for column in block]
    for _ in range(width - sum(widths) - GAP * (len(block) - 1)):
        growing = [i for i, most in enumerate(longest) if widths[i] < most]
        if not growing:
            break
        widths[min(growing, key=widths.__getitem__)] += 1
    return widths


def _grid(block: list[Laid], width: int) -> list[str]:
    """Return columns side by side as lines.

    Words are aligned left and wrap, numbers right and whole.
    """
    from rich import box
    from rich.console import Console
    from rich.table import Table as Grid
    from rich.text import Text

    grid = Grid(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, show_edge=False, header_style="")
    grid.show_header = any(column.heading for column in block)
    widths = _widths(block, width)  # Rich makes columns narrower than their minimum, and cuts the last ones
    for column, size in zip(block, widths, strict=True):
        grid.add_column(Text(column.heading), justify="left" if column.is_words else "right", width=size)
    for cells in zip(*(column.cells for column in block), strict=True):
        grid.add_row(*map(Text, cells))
    console = Console(file=io.StringIO(), width=sum(widths) + GAP * len(widths), color_system=None)
    with console.capture() as capture:
        console.print(grid)
    return [line.rstrip() for line in capture.get().splitlines()]


def concluded(headline: Headline, *parts: Part, places: Iterable[str] = (), most: float = math.inf) -> str:
    """Return parts and a headline as text that ends with the answer.

    places: lines with paths above the answer; most: number of lines of the text. Parts that exceed it are omitted, the
    last ones first.
    """
    above = printed(filter(None, (headline.set_up, headline.certainty, *places, headline.band)))
    ending = "\n\n".join(filter(None, (above, printed((headline.answer,)))))
    blocks = [list(chain.from_iterable(map(_lines, _single(part)))) for part in parts]
    room = most - ending.count("\n") - 1
    if _text(blocks).count("\n") + 1 >= room:
        ending, room = f"{MORE}\n{ending}", room - 1
    body: list[list[str]] = []
    for block in blocks:
        if _text([*body, block]).count("\n") + 1 < room:
            body.append(block)
    return "\n\n".join(filter(None, (_text(body), ending)))


def _text(blocks: Iterable[list[str]]) -> str:
    """Return lines as text without empty lines at its end."""
    return "\n".join(chain.from_iterable(blocks)).rstrip("\n")


def part_in_units(part: Part, units: Units) -> Part:
    """Return a part of the terminal's text in other units."""
    return units.rendered(part) if isinstance(part, str) else part.in_units(units)
