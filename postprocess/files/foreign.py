"""Histories of other programs and of tests: text with named columns, separated by commas, semicolons, tabs or blanks.

Units stand behind a name in brackets, "VY [m/s]" or "VY (m/s)", or in a line of their own below the names.
"""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

COMMENTS = ("#", "%", "*", "$")
NAME_AND_UNIT = re.compile(r"(.*?)\s*[\[(]\s*([^\])]*?)\s*[\])]")
MAX_BYTES = 500_000_000


@dataclass(frozen=True)
class ForeignTable:
    """Columns by name, shape (rows,) each, and the units that the file gives; "" is what has none."""

    columns: dict[str, NDArray[np.float64]]
    units: dict[str, str]


def read_foreign(path: Path) -> ForeignTable:
    """Read the file. Raises OSError, and ValueError, saying why, for one that has no named columns of numbers."""
    if path.stat().st_size > MAX_BYTES:
        raise ValueError(f"it has more than {MAX_BYTES // 1_000_000} MB")
    lines = path.read_text(encoding="utf-8-sig", errors="replace").splitlines()
    lines = [line for line in lines if line.strip() and not line.lstrip().startswith(COMMENTS)]
    if len(lines) < 3:
        raise ValueError("it has less than two rows below a line of names")
    rows = _split(lines)
    named = [_name_and_unit(cell) for cell in rows[0]]
    names, units = [name for name, _ in named], [unit for _, unit in named]
    if all(map(_is_number, filter(None, rows[0]))):
        raise ValueError("its first line has no names of columns")
    first = 1
    if not any(map(_is_number, rows[1])):
        units, first = [cell.strip("[]() ") for cell in rows[1]], 2
    values = _numbers(rows[first:], len(names))
    columns = {name: values[:, k] for k, name in enumerate(names) if name}
    return ForeignTable(columns, {name: unit for name, unit in zip(names, units, strict=False) if name})


def _split(lines: list[str]) -> list[list[str]]:
    separator = next((mark for mark in ("\t", ";", ",") if mark in lines[0]), None)
    if separator is None:
        return [line.split() for line in lines]
    return [[cell.strip() for cell in row] for row in csv.reader(lines, delimiter=separator)]


def _name_and_unit(cell: str) -> tuple[str, str]:
    match = NAME_AND_UNIT.fullmatch(cell.strip())
    return (match[1], match[2]) if match else (cell.strip(), "")


def _numbers(rows: list[list[str]], width: int) -> NDArray[np.float64]:
    """The rows as numbers; an empty or missing cell, or a word, is NaN."""
    cells = ((row + [""] * width)[:width] for row in rows)
    return np.array([[float(cell) if _is_number(cell) else np.nan for cell in row] for row in cells])


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True
