"""CSV and JSON files of a report."""

import csv
import json
import math
import re
from collections.abc import Mapping
from dataclasses import is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from postprocess.report.tables import Table
from postprocess.units import SI

FORMULA = ("=", "+", "-", "@", "\t", "\r")
"""First characters that a spreadsheet takes for a formula."""


def write_history(path: Path, columns: Mapping[str, ArrayLike]) -> Path:
    """Write columns by name, shape (n,), as CSV in their order.

    Values that are not finite are empty.
    """
    table = np.column_stack([_column(name, values) for name, values in columns.items()])
    with path.open("w", encoding="utf-8", newline="") as file:
        file.write(",".join(columns) + "\n")
        form = ",".join(["%.17g"] * len(columns)) + "\n"
        for row in table.tolist():
            line = form % tuple(row)
            file.write(re.sub("nan|-?inf", "", line) if "n" in line else line)
    return path


def _column(name: str, values: ArrayLike) -> NDArray[np.float64]:
    column = np.asarray(values, dtype=np.float64)
    if column.ndim != 1:
        raise ValueError(f"history column {name!r} must have one dimension, it has {column.ndim}")
    if re.search(r"[,\n]", name) or not name or name != name.strip():
        raise ValueError(f"history column name {name!r} does not fit a CSV header")
    return column


def write_summary(path: Path, summary: Mapping[str, Any]) -> Path:
    """Write a nested mapping as JSON.

    Its order is preserved, with an indentation of two.
    """
    path.write_text(summary_text(summary) + "\n", encoding="utf-8")
    return path


def summary_text(summary: Mapping[str, Any]) -> str:
    """Return a mapping as strict JSON."""
    return json.dumps(plain(summary), indent=2, allow_nan=False, ensure_ascii=False)


def plain(value: Any) -> Any:
    """Return a value in the types of JSON.

    Records become mappings, NumPy scalars and arrays are unwrapped, and numbers that are not finite become None.
    """
    if value is None or isinstance(value, int):
        return value
    if isinstance(value, str):
        return SI.rendered(value)
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, Path):
        return str(value)
    if is_dataclass(value):
        value = vars(value)
    if isinstance(value, Mapping):  # takes ten milliseconds for the types above
        return {str(key): plain(item) for key, item in value.items()}
    return value


def write_table(path: Path, table: Table) -> Path:
    """Write a table as CSV.

    A header of keys precedes one line for each record. Values are unformatted, and empty where they are not finite.
    An apostrophe precedes text that a spreadsheet would take for a formula.
    """
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(column.key for column in table.columns)
        writer.writerows(map(_literal, plain(list(record.values()))) for record in table.records())
    return path


def _literal(value: object) -> object:
    return f"'{value}" if isinstance(value, str) and value.startswith(FORMULA) else value
