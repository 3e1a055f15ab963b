"""What is compared: a result folder, or a file with named columns, by this program's names and in SI."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from postprocess.files.foreign import ForeignTable, read_foreign
from tailslap.api.result import Result
from tailslap.api.saved import load
from tailslap.errors import InputError, Verbatim
from tailslap.results.columns import column_units
from tailslap.scene.units import converted

TIME = "t"
TIMES = ("t", "time")
"""What a column of instants is called, in small or capital letters."""

THEIRS = re.compile(r"(?P<minus>-?)\s*(?P<name>[^\[]+?)\s*(?:\[(?P<unit>[^\]]+)\])?")


@dataclass(frozen=True)
class Item:
    """One of those compared: its label, columns in SI, their units, its summary where it is a result, and notes."""

    label: str
    columns: Mapping[str, np.ndarray]
    units: Mapping[str, str]
    summary: Mapping[str, Any] | None = None
    notes: tuple[str, ...] = ()


def parse_mapping(text: str) -> dict[str, str]:
    """This program's names and the file's, from "time=t,v_gy=VY [mph]". Raises InputError."""
    pairs = [part.partition("=") for part in text.split(",") if part.strip()]
    wrong = [key for key, equals, value in pairs if not equals or not key.strip() or not value.strip()]
    if wrong or not pairs:
        raise InputError("--columns", text, "allowed is NAME=THEIRS,..., like time=t,v_gy=VY")
    return {key.strip(): value.strip() for key, _, value in pairs}


def read_item(given: object, mapping: Mapping[str, str]) -> Item:
    """A result, its folder, or a file. Raises InputError."""
    found = given if isinstance(given, Result) else None
    path = Path(str(given))
    if found is None and path.is_dir():
        found = load(path)
    if found is None:
        return _item(path, _table(path), mapping)
    if not found.histories:
        raise InputError(str(given), Verbatim(found.command), "it has no history; allowed is a run")
    label = found.scene if isinstance(given, Result) else path.resolve().name
    return Item(label, dict(found.history), found.history.units, found.summary)


def _table(path: Path) -> ForeignTable:
    try:
        return read_foreign(path)
    except OSError:
        allowed = "there is no such file or folder; allowed are result folders and files with named columns"
        raise InputError("RESULT", str(path), allowed) from None
    except ValueError as error:
        raise InputError("RESULT", str(path), f"{error}; allowed is a file with named columns") from None


def _item(path: Path, table: ForeignTable, mapping: Mapping[str, str]) -> Item:
    """The file's columns by this program's names: those of the mapping, and those that are called so already.

    A name of the mapping that the file has not, where it has this program's own, is another file's.
    """
    given = {TIME if name.lower() == "time" else name: theirs for name, theirs in mapping.items()}
    wanted = {
        ours: theirs
        for ours, theirs in given.items()
        if ours not in table.columns or _parts(theirs, table)[1] in table.columns
    }
    known = column_units([*wanted, *table.columns])
    for name in table.columns:
        ours = TIME if name.lower() in TIMES else name
        if ours in known or ours == TIME:
            wanted.setdefault(ours, name)
    known = column_units(wanted)
    found = {ours: _column(ours, theirs, table, known, path) for ours, theirs in wanted.items()}
    _demand_rising(found, path)
    mapped = {TIME if name.lower() == "time" else name for name in mapping}
    assumed = [ours for ours, (_, unit) in found.items() if ours in mapped and not unit]
    notes = (f"{path.name}: no unit given for {', '.join(assumed)}; SI is assumed.",) if assumed else ()
    return Item(path.stem, {ours: values for ours, (values, _) in found.items()}, known, None, notes)


def _column(
    ours: str, theirs: str, table: ForeignTable, known: Mapping[str, str], path: Path
) -> tuple[np.ndarray, str]:
    """Values in SI, and the unit that the file or the mapping gives."""
    minus, name, given = _parts(theirs, table)
    if name not in table.columns:
        allowed = f"{path.name} has no such column; allowed are {', '.join(table.columns)}"
        raise InputError("--columns", theirs, allowed)
    unit, sign = given or table.units.get(name, ""), -1.0 if minus else 1.0
    return sign * _factor(ours, unit, known.get(ours, "")) * table.columns[name], unit


def _parts(theirs: str, table: ForeignTable) -> tuple[str, str, str]:
    """A minus, the column's name, and a unit, of what a mapping says."""
    match = THEIRS.fullmatch(theirs)
    if match is None or theirs in table.columns:
        return "", theirs, ""
    return match["minus"], match["name"], match["unit"] or ""


def _factor(ours: str, unit: str, si: str) -> float:
    """From the file's unit to SI; 1 where either is not known. Raises InputError for another dimension."""
    if not unit or not si:
        return 1.0
    try:
        return converted(1.0, unit, si)
    except ValueError:
        raise InputError(f"unit of {ours}", unit, f"allowed is a unit that fits {si}") from None


def _demand_rising(found: Mapping[str, tuple[np.ndarray, str]], path: Path) -> None:
    if TIME not in found:
        allowed = "it has no column of instants; allowed is one called t or time, or --columns time=THEIRS"
        raise InputError("RESULT", str(path), allowed)
    t = found[TIME][0]
    if not (np.diff(t[np.isfinite(t)]) > 0.0).all():
        raise InputError("RESULT", str(path), "its instants do not rise; allowed are rows in order of time")
