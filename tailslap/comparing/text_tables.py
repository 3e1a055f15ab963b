"""Read columns of text.

Tables have a line of names, also behind a mark of comments, or none, and are separated by commas, semicolons, tabs or
blanks. Units follow a name in brackets, "VY [m/s]" or "VY (m/s)", or are in a separate line below the names. An empty
cell or NaN is a missing value. A channel of ISO-MME (ISO/TS 13499) has one column and the interval of its samples.
"""

import csv
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import takewhile, zip_longest
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from postprocess.comparison import nodal
from tailslap.comparing.units import DIMENSIONLESS, is_unit
from tailslap.errors import shortened
from tailslap.scene.read import read_text
from tailslap.scene.units import COMMA

COMMENTS, MARKS = ("#", "%", "*", "$"), "\t;,"
BRACKETS = re.compile(r"\[[^\]]*\]|\([^)]*\)")
BLANK_NAMES = re.compile(r'"[^"]*"|\S+?(?:\s*[\[(][^\])]*[\])])+|\S+')
"""Names that are separated by blanks, with their units in brackets."""

EXCEL = re.compile(r'"?sep=([,;\t|])"?\s*', re.IGNORECASE)
"""First line of a file of a spreadsheet, which states the separator."""

NUMBER = re.compile(r"[-+]?[.,]?[0-9][0-9.,]*([eEdD][-+]?[0-9]+|[-+][0-9]+)?|[-+]?(nan|inf|infinity)", re.I)
DECIMAL_COMMA = re.compile(r"[-+]?[0-9.]*,[0-9.,]+([eEdD][-+]?[0-9]+)?")
MISSING = ("", "nan", "-nan", "na", "n/a", "null")
"""Cells without a value, in small or capital letters."""

MAX_BYTES, MAX_COLUMNS, MAX_NAME, MAX_NAMES = 500_000_000, 1000, 1000, 20_000
"""Limits of a file, and characters of a name and of a line of names that are apart by blanks."""

ISO_TIME = ("time of first sample", "sampling interval", "number of samples")
"""Lines of an ISO-MME channel, in small letters."""

FEW = "it has fewer than two rows of numbers"

Floats = NDArray[np.float64]
Lines = Sequence[tuple[int, str]]
"""Lines of a file and their numbers, from 1."""


@dataclass(frozen=True)
class Source:
    """Opened history with columns by the names in its file.

    Attributes
    ----------
    units : dict of str
        By the names of the columns; "" without a unit. Columns without a name have their number, from 1.
    numbers : callable
        Function from a name to its numbers. Raises ValueError with the line of another cell.
    lines : sequence of int
        Of the rows, if any.
    is_named : bool
        False without a line of names, or with one that is a comment.
    remarks : dict of str
        On missing entries, by name.
    number : int
        Of the result in the command, from 1.
    label, place : str
        Name for pages, and for messages.
    is_result : bool
        True for results of this program, which take mappings of their own alone.
    summary : dict, optional
        Of a result.
    """

    units: Mapping[str, str]
    numbers: Callable[[str], Floats]
    lines: Sequence[int] = ()
    is_named: bool = True
    remarks: Mapping[str, str] = field(default_factory=dict)
    number: int = 0
    label: str = ""
    place: str = ""
    is_result: bool = False
    summary: Mapping[str, Any] | None = None

    @property
    def names(self) -> list[str]:
        """Names of the columns, in their order."""
        return [*self.units]

    @property
    def file(self) -> str:
        """Name of the file."""
        return Path(self.place).name


def read_table(path: Path, decimal_comma: bool = False) -> Source:
    """Read a table or an ISO-MME channel.

    Raises OSError, and ValueError or csv.Error with the reason for a file without columns of numbers.
    """
    lines = enumerate(read_text(path, MAX_BYTES, "replace").splitlines(), 1)
    filled = [(number, line) for number, line in lines if line.strip()]
    if {"channel code", ISO_TIME[1]} <= {line.partition(":")[0].strip().lower() for _, line in filled[:100]}:
        return _read_iso_mme(filled)
    comments = [line for _, line in takewhile(_is_comment, filled)]
    rows = [row for row in filled if not _is_comment(row)]
    separator = ""
    if rows and (match := EXCEL.fullmatch(rows[0][1])):
        separator, rows = match[1], rows[1:]
    unquoted = re.sub(r'"[^"]*"', "", rows[0][1]) if rows else ""
    marks = [mark for mark in MARKS if mark in unquoted and not (decimal_comma and mark == ",")]
    return _read_rows(rows, comments, separator or next(iter(marks), ""), decimal_comma)


def _is_comment(row: tuple[int, str]) -> bool:
    return row[1].lstrip().startswith(COMMENTS)


def _read_rows(rows: Lines, comments: Sequence[str], separator: str, decimal_comma: bool) -> Source:
    """Read rows and the names above them.

    Raises ValueError or csv.Error.
    """
    split = _split(rows, separator)
    if len(split) < 2:
        raise ValueError(FEW)
    (first, _), (second, _) = split[:2]
    width = max((k for k, cell in enumerate(first, 1) if cell), default=0)
    if is_named := not NUMBER.fullmatch(next(filter(None, first), "")):
        above = [first if separator else _names(rows[0][1], "", len(second)) or first, second]
    else:
        above = [_names(line.lstrip("".join(COMMENTS) + " \t"), separator, width) for line in comments[-2:]]
    unit_row = above[1] if len(above) == 2 and all(above) and _is_unit_row(above[1]) else []
    heads = above[0 if is_named or unit_row else -1] if above else []
    split = split[1 + bool(unit_row) :] if is_named else split
    units = _units(heads or width * [""], unit_row)
    _demand_whole(split, max((k for k, head in enumerate(heads, 1) if head), default=width), len(units))
    cells, lines = map(list, zip(*split, strict=True))
    columns = {name: column for name, *column in zip_longest(units, *cells, fillvalue="") if name}
    numbers = lambda name: _numbers(name, columns[name], lines, decimal_comma)  # noqa: E731
    remarks = {name: _missing(column, lines) for name, column in columns.items()}
    return Source(units, numbers, lines, is_named, remarks)


def _split(rows: Lines, separator: str) -> list[tuple[list[str], int]]:
    """Return the cells of rows with their lines. Raises csv.Error."""
    texts = (line if separator else "\t".join(line.split()) for _, line in rows)
    reader = csv.reader(texts, delimiter=separator or "\t")
    return [([cell.strip() for cell in row], rows[reader.line_num - 1][0]) for row in reader]


def _names(line: str, separator: str, width: int) -> list[str]:
    """Return the names of a line for as many columns, else none.

    Names apart by blanks may have brackets, or are two blanks apart. Names in a comment are always split by blanks,
    too.
    """
    if len(line) > MAX_NAMES:
        return []
    choices = [[cell.strip() for cell in next(csv.reader([line], delimiter=separator))]] if separator else []
    choices += [BLANK_NAMES.findall(line), re.split(r"\s{2,}", line.strip())]
    return next(([cell.strip('"') for cell in cells] for cells in choices if len(cells) == width), [])


def _is_unit_row(cells: Sequence[str]) -> bool:
    """Return True for units below the names.

    None of its cells is a number except 1, the unit of a number, beside units.
    """
    filled = [cell.strip("[]() ") for cell in cells if cell]
    words = [cell for cell in filled if cell not in DIMENSIONLESS]
    if not words or any(map(NUMBER.fullmatch, words)):
        return False
    return len(words) == len(filled) or all(map(is_unit, words))


def _units(heads: Sequence[str], unit_row: Sequence[str]) -> dict[str, str]:
    """Return the units of headings by name.

    Raises ValueError for many, long or repeated names, or two units of one column.
    """
    if len(heads) > MAX_COLUMNS:
        raise ValueError(f"it has {len(heads)} columns; allowed are at most {MAX_COLUMNS}")
    units = dict[str, str]()
    for k, (head, below) in enumerate(zip(heads, (*unit_row, *len(heads) * [""]), strict=False), 1):
        name, unit = name_and_unit(head) if head else (str(k), "")
        if len(head) > MAX_NAME:
            raise ValueError(
                f'it has the name "{shortened(head)}"; allowed are at most {MAX_NAME} characters'
            )
        other = below.strip("[]() ")
        if name in units:
            raise ValueError(f"it has two columns {shortened(name)}")
        if unit and other and unit != other:
            both = f"{shortened(unit)} and {shortened(other)}"
            raise ValueError(f"column {shortened(name)} has two units, {both}")
        units[name] = unit or other
    return units


def name_and_unit(head: str) -> tuple[str, str]:
    """Split a heading into name and unit.

    The unit is the first text in brackets that is one, else that in square brackets; other brackets belong to the name.
    """
    squares, rounds = (
        [match for match in BRACKETS.finditer(head[:MAX_NAME]) if match[0][0] == mark] for mark in "[("
    )
    units = [match for match in (*squares, *rounds) if match[0] != "(1)" and is_unit(match[0][1:-1])]
    for match in (units or squares)[:1]:
        if name := " ".join((head[: match.start()] + head[match.end() :]).split()):
            return name, match[0][1:-1].strip()
    return " ".join(head.split()), ""


def _demand_whole(rows: Sequence[tuple[list[str], int]], least: int, most: int) -> None:
    """Demand two rows with a cell for each name, and none beyond.

    Raises ValueError with the line.
    """
    if len(rows) < 2:
        raise ValueError(FEW)
    for row, line in rows:
        if any(row[most:]) or len(row) < least:
            what = "is cut short:" if len(row) < least else "has"
            raise ValueError(f"line {line} {what} {len(row)} entries for {least} names")
    if not any(row[least - 1] for row, _ in rows):
        why = f"neither line {rows[0][1]} nor another has an entry under the last of {least} names"
        raise ValueError(f"{why}, as in rows without one of the columns; allowed are names of filled columns")


def _read_iso_mme(filled: Lines) -> Source:
    """Read an ISO-MME channel, with its instants.

    Raises ValueError for a channel over another one, or with another number of samples than stated.
    """
    first = next((k for k, (_, line) in enumerate(filled) if ":" not in line), len(filled))
    split = [(number, *line.partition(":")) for number, line in filled[:first]]
    heads = {key.strip().lower(): (f"line {number}", entry.strip()) for number, key, _, entry in split}
    where, entry = heads.get("reference channel", ("", "implicit"))
    if entry.lower() not in ("implicit", "novalue", ""):
        raise ValueError(f'{where}: reference channel "{shortened(entry)}"; allowed is implicit')
    start, interval, samples = (_iso_number(key, *heads.get(key, ("its head", ""))) for key in ISO_TIME)
    if samples != len(filled) - first:
        why = f"it has {len(filled) - first} lines of samples, by {heads[ISO_TIME[2]][0]} {samples:g}"
        raise ValueError(f"{why}; allowed is a whole channel")
    stated = {key: entry for key, (_, entry) in heads.items() if entry.upper() != "NOVALUE"}
    name = stated.get("channel code") or stated.get("name of the channel") or "2"
    instants = ((k, repr(start + k * interval)) for k in range(len(filled) - first))
    rows = [(filled[first + k][0], f"{t}\t{filled[first + k][1].strip()}") for k, t in instants]
    return _read_rows(rows, [f"t [s]\t{name} [{stated.get('unit', '')}]"], "\t", False)


def _iso_number(key: str, where: str, entry: str) -> float:
    """Return the number in a line of an ISO-MME channel. Raises ValueError."""
    try:
        return nodal.number(entry)
    except ValueError as error:
        raise ValueError(f"{where}, {key}: {error}") from None


def _missing(cells: Sequence[str], lines: Sequence[int]) -> str:
    """Return a remark on missing entries, if any."""
    empty = [line for cell, line in zip(cells, lines, strict=True) if not cell]
    return f"without an entry in {len(empty)} of {len(cells)} rows, first in line {empty[0]}" if empty else ""


def _numbers(name: str, cells: Sequence[str], lines: Sequence[int], decimal_comma: bool) -> Floats:
    """Return the numbers of a column.

    Missing ones are NaN. Raises ValueError with the line of a cell without number.
    """
    numbers = np.empty(len(cells))
    for k, (cell, line) in enumerate(zip(cells, lines, strict=True)):
        try:
            numbers[k] = np.nan if cell.lower() in MISSING else _number(cell, decimal_comma)
        except ValueError as error:
            why = f"{error}, and an empty cell where there is no value"
            raise ValueError(f"line {line}, column {shortened(name)}: {why}") from None
    return numbers


def _number(cell: str, decimal_comma: bool) -> float:
    """Return the number in a cell. Raises ValueError."""
    if "." in cell if decimal_comma else DECIMAL_COMMA.fullmatch(cell):
        why = "" if decimal_comma else f"{COMMA}; "
        raise ValueError(f'given "{shortened(cell)}"; {why}allowed are decimal commas, by --decimal-comma')
    return nodal.number(cell.replace(",", ".") if decimal_comma else cell)
