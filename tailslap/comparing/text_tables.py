"""Read columns of text.

Tables have a line of names, also behind a mark of comments, or none, and are separated by commas, semicolons, tabs or
blanks. Units follow a name in brackets, "VY [m/s]" or "VY (m/s)", or are in a separate line below the names. An empty
cell or NaN is a missing value. A channel of ISO-MME (ISO/TS 13499) has one column and the interval of its samples.
"""

import csv
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import count, takewhile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from postprocess.comparison import nodal
from tailslap.comparing.units import DIMENSIONLESS, is_unit
from tailslap.errors import shortened
from tailslap.scene.read import read_text
from tailslap.scene.units import COMMA

COMMENTS, MARKS = ("#", "%", "*", "$"), "\t;,"
BRACKETS = re.compile(r"\[([^\]]*)\]|\(([^)]*)\)")
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

ISO_CODE, ISO_NAME, ISO_UNIT = "channel code", "name of the channel", "unit"
ISO_TIME = ("time of first sample", "sampling interval", "number of samples")
"""Lines of an ISO-MME channel, in small letters."""

Floats = NDArray[np.float64]
Lines = Sequence[tuple[int, str]]
"""Lines of a file and their numbers, from 1."""


@dataclass(frozen=True)
class Cells:
    """Cells of a file with columns.

    Attributes
    ----------
    names : list of str
        Of the columns, as in the file; columns without a name have their number, from 1.
    units : dict of str
        By name; "" without a unit.
    rows : list of list of str
        Cells of each row, at least to the last column with a name.
    lines : list of int
        Line of each row in the file, from 1.
    is_named : bool
        False without a line of names, or with one that is a comment.
    decimal_comma : bool
        True if numbers have a decimal comma.
    """

    names: list[str]
    units: dict[str, str]
    rows: list[list[str]]
    lines: list[int]
    is_named: bool = True
    decimal_comma: bool = False

    def numbers(self, name: str) -> Floats:
        """Return the numbers of a column.

        Missing ones are NaN. Raises ValueError with the line of a cell without number.
        """
        k, numbers = self.names.index(name), np.empty(len(self.rows))
        for place, (row, line) in enumerate(zip(self.rows, self.lines, strict=True)):
            cell = row[k] if k < len(row) else ""
            try:
                numbers[place] = np.nan if cell.lower() in MISSING else self._number(cell)
            except ValueError as error:
                raise ValueError(f"line {line}, column {shortened(name)}: {error}") from None
        return numbers

    def missing(self) -> dict[str, str]:
        """Return remarks on columns without an entry in some rows, by name."""
        remarks = {}
        for k, name in enumerate(self.names):
            lines = [line for row, line in zip(self.rows, self.lines, strict=True) if not any(row[k : k + 1])]
            if lines:
                remarks[name] = (
                    f"without an entry in {len(lines)} of {len(self.rows)} rows, first in line {lines[0]}"
                )
        return remarks

    def _number(self, cell: str) -> float:
        """Return the number in a cell. Raises ValueError."""
        if self.decimal_comma and "." in cell:
            raise ValueError(f'given "{shortened(cell)}"; allowed are decimal commas, by --decimal-comma')
        if not self.decimal_comma and DECIMAL_COMMA.fullmatch(cell):
            raise ValueError(f'given "{shortened(cell)}"; {COMMA}; allowed are commas by --decimal-comma')
        try:
            return nodal.number(cell.replace(",", ".") if self.decimal_comma else cell)
        except ValueError as error:
            raise ValueError(f"{error}, and an empty cell where there is no value") from None


def read_table(path: Path, decimal_comma: bool = False) -> Cells:
    """Read the cells of a table or of an ISO-MME channel.

    Raises OSError, and ValueError or csv.Error with the reason for a file without columns of numbers.
    """
    lines = enumerate(read_text(path, MAX_BYTES, "replace").splitlines(), 1)
    filled = [(number, line) for number, line in lines if line.strip()]
    heads = [line.partition(":")[0].strip().lower() for _, line in filled[:100]]
    if ISO_CODE in heads and ISO_TIME[1] in heads:
        return _read_iso_mme(filled)
    above = takewhile(lambda row: row[1].lstrip().startswith(COMMENTS), filled)
    comments = [line.lstrip("".join(COMMENTS) + " \t").rstrip() for _, line in above]
    rows = [(number, line) for number, line in filled if not line.lstrip().startswith(COMMENTS)]
    separator = ""
    if rows and (match := EXCEL.fullmatch(rows[0][1])):
        separator, rows = match[1], rows[1:]
    if len(rows) < 2:
        raise ValueError("it has fewer than two rows of numbers")
    unquoted = re.sub(r'"[^"]*"', "", rows[0][1])
    marks = [mark for mark in MARKS if mark in unquoted and not (decimal_comma and mark == ",")]
    return _cells(rows, comments, separator or next(iter(marks), ""), decimal_comma)


def _cells(rows: Lines, comments: Sequence[str], separator: str, decimal_comma: bool) -> Cells:
    """Return the cells of rows and the names above them.

    Raises ValueError or csv.Error.
    """
    if (width := len(rows[0][1].split(separator or None))) > MAX_COLUMNS:
        raise ValueError(f"it has {width} columns; allowed are at most {MAX_COLUMNS}")
    split = _split(rows, separator)
    first = split[0][0]
    width = max((k for k, cell in enumerate(first, 1) if cell), default=0)
    is_named = not NUMBER.fullmatch(next(filter(None, first), ""))
    if is_named:
        heads = first if separator else _names(rows[0][1], "", len(split[1][0])) or first
        unit_row = split[1][0] if _is_unit_row(split[1][0]) else []
        split = split[2:] if unit_row else split[1:]
    else:
        above = [_names(line, separator, width) for line in comments[-2:]]
        unit_row = above.pop() if len(above) == 2 and all(above) and _is_unit_row(above[1]) else []
        heads = above[-1] if above else []
    if len(split) < 2:
        raise ValueError("it has fewer than two rows below the line of names")
    names, units = _names_and_units(heads or width * [""], unit_row)
    _demand_whole(split, max((k for k, head in enumerate(heads, 1) if head), default=width), len(names))
    cells, lines = zip(*split, strict=True)
    return Cells(names, units, [*cells], [*lines], is_named, decimal_comma)


def _split(rows: Lines, separator: str) -> list[tuple[list[str], int]]:
    """Return the cells of rows with their lines. Raises csv.Error."""
    lines, texts = zip(*rows, strict=True)
    reader = csv.reader(texts, delimiter=separator or " ")
    split = ((row, reader.line_num) for row in reader) if separator else zip(map(str.split, texts), count(1))
    return [([cell.strip() for cell in row], lines[k - 1]) for row, k in split]


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
    if any(NUMBER.fullmatch(cell) and cell not in DIMENSIONLESS for cell in filled):
        return False
    words = [cell for cell in filled if cell not in DIMENSIONLESS]
    return bool(words) and (len(words) == len(filled) or all(map(is_unit, words)))


def _names_and_units(heads: Sequence[str], unit_row: Sequence[str]) -> tuple[list[str], dict[str, str]]:
    """Split headings into names and units.

    Raises ValueError for a repeated name, or two units of one column.
    """
    split = [name_and_unit(head) if head else (str(k), "") for k, head in enumerate(heads, 1)]
    names, units = [name for name, _ in split], {}
    for name, times in Counter(names).items():
        if times > 1:
            raise ValueError(f"it has two columns {shortened(name)}")
    below = [cell.strip("[]() ") for cell in unit_row] + len(names) * [""]
    for (name, unit), other in zip(split, below, strict=False):
        if unit and other and unit != other:
            raise ValueError(
                f"column {shortened(name)} has two units, {shortened(unit)} and {shortened(other)}"
            )
        units[name] = unit or other
    return names, units


def name_and_unit(head: str) -> tuple[str, str]:
    """Split a heading into name and unit.

    The unit is the first text in brackets that is one, else that in square brackets; other brackets belong to the name.
    Raises ValueError for a long name.
    """
    if len(head) > MAX_NAME:
        raise ValueError(f'it has the name "{shortened(head)}"; allowed are at most {MAX_NAME} characters')
    squares = [match for match in BRACKETS.finditer(head) if match[1] is not None]
    rounds = [match for match in BRACKETS.finditer(head) if match[2] and match[2] not in DIMENSIONLESS[:1]]
    units = (match for match in (*squares, *rounds) if is_unit(match[1] or match[2] or ""))
    bracket = next(units, None) or next(iter(squares), None)
    if bracket is None or not (name := head[: bracket.start()] + head[bracket.end() :]).strip():
        return " ".join(head.split()), ""
    return " ".join(name.split()), (bracket[1] or bracket[2] or "").strip()


def _demand_whole(rows: Sequence[tuple[list[str], int]], least: int, most: int) -> None:
    """Demand a cell for each column with a name, and none beyond.

    Raises ValueError with the line.
    """
    for row, line in rows:
        if any(row[most:]):
            raise ValueError(f"line {line} has {len(row)} entries for {most} names")
        if len(row) < least:
            raise ValueError(f"line {line} is cut short: {len(row)} entries for {least} names")
    if not any(row[least - 1] for row, _ in rows):
        why = f"neither line {rows[0][1]} nor another has an entry under the last of {least} names"
        raise ValueError(f"{why}, as in rows without one of the columns; allowed are names of filled columns")


def _read_iso_mme(filled: Lines) -> Cells:
    """Return the cells of an ISO-MME channel, with its instants.

    Raises ValueError for a channel over another one, or with another number of samples than stated.
    """
    first = next((k for k, (_, line) in enumerate(filled) if ":" not in line), len(filled))
    heads = {}
    for number, line in filled[:first]:
        key, _, entry = line.partition(":")
        heads[key.strip().lower()] = (number, entry.strip())
    number, entry = heads.get("reference channel", (0, "implicit"))
    if entry.lower() not in ("implicit", "novalue", ""):
        raise ValueError(f'line {number}: reference channel "{shortened(entry)}"; allowed is implicit')
    start, interval, samples = (_iso_number(heads, key) for key in ISO_TIME)
    if samples != len(filled) - first:
        why = f"it has {len(filled) - first} lines of samples, by line {heads[ISO_TIME[2]][0]} {samples:g}"
        raise ValueError(f"{why}; allowed is a whole channel")
    stated = {key: entry for key, (_, entry) in heads.items() if entry.upper() != "NOVALUE"}
    name = stated.get(ISO_CODE) or stated.get(ISO_NAME) or "2"
    rows = [[repr(start + k * interval), line.strip()] for k, (_, line) in enumerate(filled[first:])]
    lines = [number for number, _ in filled[first:]]
    return Cells(["t", name], {"t": "s", name: stated.get(ISO_UNIT, "")}, rows, lines, False)


def _iso_number(heads: dict[str, tuple[int, str]], key: str) -> float:
    """Return the number in a line of an ISO-MME channel. Raises ValueError."""
    number, entry = heads.get(key, (0, ""))
    if not number:
        raise ValueError(f'it has no line "{key.capitalize()}", which an ISO-MME channel requires')
    try:
        return nodal.number(entry)
    except ValueError as error:
        raise ValueError(f"line {number}, {key}: {error}") from None
