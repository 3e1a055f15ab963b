"""Read histories to compare, by this program's names and in SI.

They are those of a result, or of a file with named columns. Files of other programs and of tests are text with a line
of names, separated by commas, semicolons, tabs or blanks. Units follow a name in brackets, "VY [m/s]" or "VY (m/s)", or
are in a separate line below the names. Columns that are compared contain numbers; an empty cell or NaN is a missing
value.
"""

import csv
import os
import re
import stat
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import count
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from postprocess.comparison import nodal
from tailslap.errors import MACHINE_FAULTS, InputError, Verbatim, one_of, place_error, shortened
from tailslap.result.columns import column_units
from tailslap.result.load import demand_listed, load
from tailslap.result.result import FE, Result
from tailslap.scene.read import read_text
from tailslap.scene.units import COMMA, converted

TIME = "t"
TIMES = ("t", "time")
"""Names of a column of instants, in small or capital letters."""

COMMENTS = ("#", "%", "*", "$")
NAME_AND_UNIT = re.compile(r"(.*?)\s*[\[(]\s*([^\])]*?)\s*[\])]")
THEIRS = re.compile(r"(?P<minus>-?)\s*(?P<name>[^\[]+?)\s*(?:\[(?P<unit>[^\]]+)\])?")
DECIMAL_COMMA = re.compile(r"[-+]?[0-9.]*,[0-9.,]+([eE][-+]?[0-9]+)?")
MISSING = ("", "nan", "-nan", "na", "n/a", "null")
"""Cells without a value, in small or capital letters."""

MAX_BYTES, MAX_COLUMNS = 500_000_000, 1000

"""Limits of a file."""

Floats = NDArray[np.float64]
Read = TypeVar("Read")


@dataclass(frozen=True)
class Item:
    """History that is compared.

    Attributes
    ----------
    label : str
        Name of the scene, folder or file.
    columns : dict of ndarray, shape (rows,)
        In SI; NaN is a missing value.
    units : dict of str
        Of the columns.
    summary : dict, optional
        Of a result.
    notes : tuple of str
        Assumptions.
    time_name : str
        Name of the column of instants in the file.
    unit_of_time : str
        Source of the unit of time: "file", "columns" for the option, or "assumed".
    """

    label: str
    columns: Mapping[str, Floats]
    units: Mapping[str, str]
    summary: Mapping[str, Any] | None = None
    notes: tuple[str, ...] = ()
    time_name: str = TIME
    unit_of_time: str = "file"


@dataclass(frozen=True)
class Cells:
    """Cells of a file with named columns.

    Attributes
    ----------
    names : list of str
        Of the columns, as in the file.
    units : dict of str
        By name; "" without a unit.
    rows : list of list of str
        Cells of each row, at least to the last column with a name.
    lines : list of int
        Line of each row in the file, from 1.
    """

    names: list[str]
    units: dict[str, str]
    rows: list[list[str]]
    lines: list[int]

    def numbers(self, name: str) -> Floats:
        """Return the numbers of a column.

        Missing ones are NaN. Raises ValueError with the line of a cell without number.
        """
        k, numbers = self.names.index(name), np.empty(len(self.rows))
        for place, (row, line) in enumerate(zip(self.rows, self.lines, strict=True)):
            try:
                numbers[place] = np.nan if row[k].lower() in MISSING else nodal.number(row[k])
            except ValueError as error:
                allowed = f"{error}, and an empty cell where there is no value"
                raise ValueError(f"line {line}, column {shortened(name)}: {allowed}") from None
        return numbers


def parse_mapping(text: str) -> dict[str, str]:
    """Return column names of a file by those of this program.

    The text is like "time=t,v_gy=VY [mph]". Raises InputError.
    """
    pairs = [part.partition("=") for part in text.split(",") if part.strip()]
    if not pairs or not all(key.strip() and value.strip() for key, _, value in pairs):
        raise InputError("--columns", text, "allowed is NAME=THEIRS,..., e.g. time=t,v_gy=VY")
    return {key.strip(): value.strip() for key, _, value in pairs}


def read_item(source: object, mapping: Mapping[str, str], force: bool = False) -> Item:
    """Read a history from a result, its folder, or a file.

    force: also damaged ones. Raises InputError.
    """
    if isinstance(source, Item):
        _demand_sound(source.columns, source.label)
        return source
    path = Path(str(source))
    if isinstance(source, Result):
        result, label = source, source.scene
    elif _is_folder(path):
        result, label = load(path, force=force), path.resolve().name
    else:
        is_listed = demand_listed(path, force)
        return _read_file(path, {_time_as_t(name): theirs for name, theirs in mapping.items()}, is_listed)
    if not result.histories:
        raise InputError(str(source), Verbatim(result.command), "it has no history; allowed is a run")
    columns = result.histories.get(FE) or next(iter(result.histories.values()))
    _demand_sound(columns, str(path))
    return Item(label, dict(columns), columns.units, result.summary)


def _is_folder(path: Path) -> bool:
    """Return True for a folder.

    Raises InputError, or OSError of the machine, where that cannot be determined.
    """
    try:
        return stat.S_ISDIR(os.stat(path).st_mode)
    except (FileNotFoundError, NotADirectoryError, ValueError):
        return False
    except OSError as error:
        raise place_error(path, "it cannot be read", error, "RESULT") from None


def _time_as_t(name: str) -> str:
    """Return "t" for a name of time."""
    return TIME if name.lower() in TIMES else name


def _read_file(path: Path, mapping: Mapping[str, str], is_listed: bool) -> Item:
    """Read the columns of a file.

    They are those of the mapping, and those that have names of this program already. A name of the mapping that the
    file does not have, where it has the name of this program, belongs to another file; so does a unit of the mapping
    where the file has one, as the files of this program do.
    """
    names, units, lines, numbers = _read(path)
    units = {**units, **column_units(names)} if is_listed else units
    present = {ours for ours, theirs in mapping.items() if _parts(theirs, names)[1] in names}
    wanted = {name: theirs for name, theirs in mapping.items() if name not in names or name in present}
    standard = {TIME, *column_units(names)}
    for name in names:
        if (ours := _time_as_t(name)) in standard:
            wanted.setdefault(ours, name)
    si_units = column_units(wanted)
    columns, sources, notes = {}, {}, []
    for ours, theirs in wanted.items():
        minus, name, mapped = _parts(theirs, names)
        if name not in names:
            allowed = one_of(name, names, f"{path.name} does not have this column; allowed are")
            raise InputError("--columns", theirs, allowed)
        unit = units.get(name) or mapped
        sources[ours] = name, "file" if units.get(name) else "columns" if mapped else "assumed"
        factor = (-1.0 if minus else 1.0) * _factor(ours, unit, si_units.get(ours, ""))
        columns[ours] = factor * _readable(path, partial(numbers, name))
        if mapped and mapped != unit:
            notes.append(f"{path.name}: {name} is in {unit} by the file, not in {mapped}.")
    _demand_sound(columns, str(path), lines)
    assumed = ", ".join(
        name for name, (_, source) in sources.items() if source == "assumed" and name in mapping
    )
    notes += [f"{path.name}: {assumed} without a unit, assumed in SI."] if assumed else []
    return Item(path.stem, columns, si_units, None, tuple(notes), *sources[TIME])


def _read(path: Path) -> tuple[list[str], dict[str, str], Sequence[int], Callable[[str], Floats]]:
    """Read columns of numbers and their names.

    Returns names, units by name, lines of the rows, if any, and a function from a name to its numbers.
    """
    motion = _readable(path, partial(_read_nodal, path))
    if motion is None:
        cells = _readable(path, partial(read_table, path))
        return [*filter(None, cells.names)], cells.units, cells.lines, cells.numbers
    return [*motion], {}, (), motion.__getitem__


def _readable(path: Path, read: Callable[[], Read]) -> Read:
    """Return the outcome of reading a file.

    Raises InputError for a file that cannot be read.
    """
    try:
        return read()
    except FileNotFoundError:
        allowed = "the file or folder does not exist; allowed are result folders and files with named columns"
        raise InputError("RESULT", str(path), allowed) from None
    except (OSError, ValueError, csv.Error) as error:
        if isinstance(error, OSError) and error.errno in MACHINE_FAULTS:
            raise
        why = getattr(error, "strerror", None) or error
        advice = "" if "allowed" in str(why) else "; allowed is a file with named columns"
        raise InputError("RESULT", str(path), f"{why}{advice}") from None


def _parts(theirs: str, names: Sequence[str]) -> tuple[str, str, str]:
    """Split a text of a mapping into minus, column name and unit."""
    match = THEIRS.fullmatch(theirs)
    if match is None or theirs in names:
        return "", theirs, ""
    return match["minus"], match["name"], match["unit"] or ""


def _factor(ours: str, unit: str, si: str) -> float:
    """Return the factor from the file's unit to SI.

    It is 1 where either is unknown. Raises InputError for another dimension.
    """
    if not unit or not si:
        return 1.0
    try:
        return converted(1.0, unit, si)
    except ValueError:
        raise InputError(f"unit of {ours}", unit, f"allowed is a unit of the dimension of {si}") from None


def _demand_sound(columns: Mapping[str, Floats], place: str, lines: Sequence[int] = ()) -> None:
    """Demand increasing instants and moderate numbers.

    Numbers must have finite squares. Raises InputError with line or row.
    """
    if TIME not in columns:
        allowed = "it has no time column; allowed is a column t or time, or --columns time=THEIRS"
        raise InputError("RESULT", place, allowed)
    where = lambda k: f"line {lines[k]}" if lines else f"row {k + 1}"  # noqa: E731
    t = columns[TIME]
    for k in np.flatnonzero(~np.isfinite(t))[:1]:
        raise InputError("RESULT", place, f"{where(k)}: the instant is missing; allowed is a number")
    for k in np.flatnonzero(np.diff(t) <= 0.0)[:1] + 1:
        after = f"{t[k]:.7g} s after {t[k - 1]:.7g} s"
        raise InputError("RESULT", place, f"{where(k)}: time does not increase from row to row, {after}")
    for name, values in columns.items():
        for k in np.flatnonzero(np.abs(values) > nodal.LARGEST)[:1]:  # NaN, a missing value, is not larger
            allowed = f"{where(k)}, column {shortened(name)}: {values[k]:g} in SI; {nodal.ALLOWED}"
            raise InputError("RESULT", place, allowed)


def _read_nodal(path: Path) -> dict[str, Floats] | None:
    """Read the mean motion of nodes.

    None where the file has no nodes. Raises OSError and ValueError.
    """
    if nodal.reader_of(path) is None:
        return None
    if path.is_file() and path.stat().st_size > MAX_BYTES:
        raise ValueError(f"it is too large; the limit is {MAX_BYTES} bytes")
    return nodal.read_centre_of_mass(path)


def read_table(path: Path) -> Cells:
    """Read the cells of named columns.

    Raises OSError, and ValueError or csv.Error with the reason for a file without named columns of numbers.
    """
    numbered = enumerate(read_text(path, MAX_BYTES, "replace").splitlines(), 1)
    rows = [(n, line) for n, line in numbered if line.strip() and not line.lstrip().startswith(COMMENTS)]
    if len(rows) < 3:
        raise ValueError("it has fewer than two rows below the line of names")
    lines, texts = zip(*rows, strict=True)
    separator = next((mark for mark in ("\t", ";", ",") if mark in texts[0]), None)
    if (width := len(texts[0].split(separator))) > MAX_COLUMNS:
        raise ValueError(f"it has {width} columns; allowed are at most {MAX_COLUMNS}")
    reader = csv.reader(texts, delimiter=separator or " ")
    split = ((row, reader.line_num) for row in reader) if separator else zip(map(str.split, texts), count(1))
    heads, *numbered_rows = [([cell.strip() for cell in row], lines[k - 1]) for row, k in split]
    names, units = _names_and_units(heads[0])
    if not any(map(_is_number, numbered_rows[0][0])):
        units, numbered_rows = [cell.strip("[]() ") for cell in numbered_rows[0][0]], numbered_rows[1:]
    width = max((k for k, name in enumerate(names, 1) if name), default=0)
    _demand_whole(numbered_rows, width, len(names))
    by_name = {name: unit for name, unit in zip(names, units, strict=False) if name}
    return Cells(names, by_name, [row for row, _ in numbered_rows], [line for _, line in numbered_rows])


def _names_and_units(heads: Sequence[str]) -> tuple[list[str], list[str]]:
    """Split a line of names into names and units.

    Raises ValueError for a line of numbers, or a repeated name.
    """
    if all(_is_number(cell) for cell in heads if cell):
        raise ValueError("its first line has no column names")
    matches = [NAME_AND_UNIT.fullmatch(cell) for cell in heads]
    names = [match[1] if match else cell for cell, match in zip(heads, matches, strict=True)]
    for name, times in Counter(filter(None, names)).items():
        if times > 1:
            raise ValueError(f"it has two columns {shortened(name)}")
    return names, [match[2] if match else "" for match in matches]


def _demand_whole(rows: Sequence[tuple[list[str], int]], least: int, most: int) -> None:
    """Demand decimal points and a cell for each column with a name.

    Raises ValueError with the line.
    """
    for row, line in rows:
        if comma := next(filter(DECIMAL_COMMA.fullmatch, row), None):
            raise ValueError(f'line {line} has "{shortened(comma)}"; {COMMA}')
        if any(row[most:]):
            raise ValueError(f"line {line} has {len(row)} entries for {most} names; {COMMA}")
        if len(row) < least:
            raise ValueError(f"line {line} is cut short: {len(row)} entries for {least} names")


def _is_number(cell: str) -> bool:
    """Return True for the text of a number."""
    try:
        float(cell)
    except ValueError:
        return False
    return True
