"""Histories to compare: of a result, or of a file with named columns, by this program's names and in SI.

Files of other programs and of tests are text with a line of names, separated by commas, semicolons, tabs or blanks.
Units stand behind a name in brackets, "VY [m/s]" or "VY (m/s)", or in a line of their own below the names.
"""

import csv
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tailslap.errors import InputError, Verbatim, one_of, shortened
from tailslap.files.load import column_units, demand_listed, load
from tailslap.result import FE, Result
from tailslap.scene.read import read_text
from tailslap.scene.units import COMMA, converted

TIME = "t"
TIMES = ("t", "time")
"""Names of a column of instants, in small or capital letters."""

COMMENTS = ("#", "%", "*", "$")
NAME_AND_UNIT = re.compile(r"(.*?)\s*[\[(]\s*([^\])]*?)\s*[\])]")
THEIRS = re.compile(r"(?P<minus>-?)\s*(?P<name>[^\[]+?)\s*(?:\[(?P<unit>[^\]]+)\])?")
DECIMAL_COMMA = re.compile(r"[-+]?[0-9.]*,[0-9.,]+([eE][-+]?[0-9]+)?")
MAX_BYTES = 500_000_000

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Item:
    """One of those compared: its label, columns in SI, their units, its summary where it is a result, and notes."""

    label: str
    columns: Mapping[str, Floats]
    units: Mapping[str, str]
    summary: Mapping[str, Any] | None = None
    notes: tuple[str, ...] = ()


def parse_mapping(text: str) -> dict[str, str]:
    """This program's names and the file's, from "time=t,v_gy=VY [mph]". Raises InputError."""
    pairs = [part.partition("=") for part in text.split(",") if part.strip()]
    if not pairs or not all(key.strip() and value.strip() for key, _, value in pairs):
        raise InputError("--columns", text, "allowed is NAME=THEIRS,..., e.g. time=t,v_gy=VY")
    return {key.strip(): value.strip() for key, _, value in pairs}


def read_item(given: object, mapping: Mapping[str, str], force: bool = False) -> Item:
    """A result, its folder, or a file; force: damaged ones too. Raises InputError."""
    if isinstance(given, Item):
        return given
    path = Path(str(given))
    if isinstance(given, Result):
        found, label = given, given.scene
    elif os.path.isdir(
        path
    ):  # where Path.is_dir raises an error for one below a folder that may not be searched
        found, label = load(path, force=force), path.resolve().name
    else:
        demand_listed(path, force)
        return _read_file(path, {_time_as_t(name): theirs for name, theirs in mapping.items()})
    if not found.histories:
        raise InputError(str(given), Verbatim(found.command), "it has no history; allowed is a run")
    columns = found.histories.get(FE) or next(iter(found.histories.values()))
    _demand_rising(columns, path)
    return Item(label, dict(columns), columns.units, found.summary)


def _time_as_t(name: str) -> str:
    return TIME if name.lower() in TIMES else name


def _read_file(path: Path, mapping: Mapping[str, str]) -> Item:
    """The file's columns by this program's names: those of the mapping, and those that are called so already.

    A name of the mapping that the file has not, where it has this program's own, is another file's.
    """
    try:
        columns, units = _read_nodal(path) or read_table(path)
    except FileNotFoundError:
        allowed = "the file or folder does not exist; allowed are result folders and files with named columns"
        raise InputError("RESULT", str(path), allowed) from None
    except (OSError, ValueError, csv.Error) as error:
        why = getattr(error, "strerror", None) or error
        raise InputError("RESULT", str(path), f"{why}; allowed is a file with named columns") from None
    there = {ours for ours, theirs in mapping.items() if _parts(theirs, columns)[1] in columns}
    wanted = {name: theirs for name, theirs in mapping.items() if name not in columns or name in there}
    own = {TIME, *column_units(columns)}
    for name in columns:
        if (ours := _time_as_t(name)) in own:
            wanted.setdefault(ours, name)
    known = column_units(wanted)
    found, assumed = {}, []
    for ours, theirs in wanted.items():
        minus, name, given = _parts(theirs, columns)
        if name not in columns:
            allowed = one_of(name, columns, f"{path.name} does not have this column; allowed are")
            raise InputError("--columns", theirs, allowed)
        unit = given or units.get(name, "")
        found[ours] = (-1.0 if minus else 1.0) * _factor(ours, unit, known.get(ours, "")) * columns[name]
        if ours in mapping and not unit:
            assumed.append(ours)
    _demand_rising(found, path)
    notes = (f"{path.name}: {', '.join(assumed)} without a unit, assumed in SI.",) if assumed else ()
    return Item(path.stem, found, known, None, notes)


def _parts(theirs: str, columns: Mapping[str, Floats]) -> tuple[str, str, str]:
    """A minus, the column's name, and a unit, that a mapping gives."""
    match = THEIRS.fullmatch(theirs)
    if match is None or theirs in columns:
        return "", theirs, ""
    return match["minus"], match["name"], match["unit"] or ""


def _factor(ours: str, unit: str, si: str) -> float:
    """From the file's unit to SI; 1 where either is not known. Raises InputError for another dimension."""
    if not unit or not si:
        return 1.0
    try:
        return converted(1.0, unit, si)
    except ValueError:
        raise InputError(f"unit of {ours}", unit, f"allowed is a unit of the dimension of {si}") from None


def _demand_rising(found: Mapping[str, Floats], path: Path) -> None:
    if TIME not in found:
        allowed = "it has no time column; allowed is a column t or time, or --columns time=THEIRS"
        raise InputError("RESULT", str(path), allowed)
    t = found[TIME]
    if not (np.diff(t[np.isfinite(t)]) > 0.0).all():
        raise InputError("RESULT", str(path), "time does not increase from row to row")


def _read_nodal(path: Path) -> tuple[dict[str, Floats], dict[str, str]] | None:
    """Motion of the centre of mass from nodes of another program, and its units; None where the file has no nodes.

    Raises OSError and ValueError.
    """
    from postprocess.comparison import nodal

    if nodal.reader_of(path) is None:
        return None
    columns = nodal.read_centre_of_mass(path)
    return columns, column_units(columns)


def read_table(path: Path) -> tuple[dict[str, Floats], dict[str, str]]:
    """Columns of a file by name, shape (rows,) each, and the units that it gives; "" is the unit of those without.

    An empty or missing cell, or a word, is NaN.

    Raises OSError, and ValueError or csv.Error, saying why, for a file that has no named columns of numbers.
    """
    lines = read_text(path, MAX_BYTES, "replace").splitlines()
    lines = [line for line in lines if line.strip() and not line.lstrip().startswith(COMMENTS)]
    if len(lines) < 3:
        raise ValueError("it has fewer than two rows below the line of names")
    separator = next((mark for mark in ("\t", ";", ",") if mark in lines[0]), None)
    cells = csv.reader(lines, delimiter=separator) if separator else map(str.split, lines)
    rows = [[cell.strip() for cell in row] for row in cells]
    if all(_is_number(cell) for cell in rows[0] if cell):
        raise ValueError("its first line has no column names")
    matches = [NAME_AND_UNIT.fullmatch(cell.strip()) for cell in rows[0]]
    names = [match[1] if match else cell.strip() for cell, match in zip(rows[0], matches, strict=True)]
    units = [match[2] if match else "" for match in matches]
    for name in filter(None, names):
        if names.count(name) > 1:
            raise ValueError(f"it has two columns {shortened(name)}")
    first = 1
    if not any(map(_is_number, rows[1])):
        units, first = [cell.strip("[]() ") for cell in rows[1]], 2
    _demand_points(rows[first:], len(names))
    padded = ((row + [""] * len(names))[: len(names)] for row in rows[first:])
    values = np.array([[float(cell) if _is_number(cell) else np.nan for cell in row] for row in padded])
    columns = {name: values[:, k] for k, name in enumerate(names) if name}
    return columns, {name: unit for name, unit in zip(names, units, strict=False) if name}


def _demand_points(rows: list[list[str]], columns: int) -> None:
    """Raise ValueError where numbers have decimal commas, as cells or as more cells than there are columns."""
    for row in rows:
        if comma := next(filter(DECIMAL_COMMA.fullmatch, row), None):
            raise ValueError(f'it has "{comma}"; {COMMA}')
        if any(row[columns:]):
            raise ValueError(f"a row has {len(row)} entries for {columns} names; {COMMA}")


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True
