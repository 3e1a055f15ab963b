"""Files of numbers: histories as CSV, summaries as JSON."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from dataclasses import is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from postprocess.units import SI

FORMAT = "%.17g"
NOT_FINITE = re.compile(r"-?(nan|inf)")


def write_history(path: Path, columns: Mapping[str, ArrayLike]) -> Path:
    """Writes the columns, name -> values of shape (n,), in the mapping's order."""
    table = np.column_stack([_column(name, values) for name, values in columns.items()])
    line = ",".join([FORMAT] * table.shape[1])
    with path.open("w", encoding="utf-8", newline="") as file:
        file.write(",".join(columns) + "\n")
        for row in table:
            text = line % tuple(row)
            file.write((text if np.isfinite(row).all() else NOT_FINITE.sub("", text)) + "\n")
    return path


def read_history(path: Path) -> dict[str, NDArray[np.float64]]:
    """The columns of a file that `write_history` wrote, in its order: name -> values of shape (n,)."""
    header, _, body = path.read_text(encoding="utf-8").partition("\n")
    names = header.split(",")
    rows = [line.split(",") for line in body.splitlines()]
    table = np.array([[entry or "nan" for entry in row] for row in rows], dtype=np.float64)
    table = table.reshape(-1, len(names))
    return {name: np.ascontiguousarray(table[:, column]) for column, name in enumerate(names)}


def _column(name: str, values: ArrayLike) -> NDArray[np.float64]:
    column = np.asarray(values, dtype=np.float64)
    if column.ndim != 1:
        raise ValueError(f"history column {name!r} must have one dimension, it has {column.ndim}")
    if "," in name or "\n" in name or name != name.strip() or not name:
        raise ValueError(f"history column name {name!r} does not fit a CSV header")
    return column


def write_summary(path: Path, summary: Mapping[str, Any]) -> Path:
    """Writes the mapping, nested as wished, with its own key order, indented by two."""
    path.write_text(summary_text(summary) + "\n", encoding="utf-8")
    return path


def summary_text(summary: Mapping[str, Any]) -> str:
    """The mapping as strict JSON."""
    return json.dumps(plain(summary), indent=2, allow_nan=False, ensure_ascii=False)


def plain(value: Any) -> Any:
    """The value in the types that JSON has: records as mappings, NumPy scalars and arrays unwrapped, non-finite numbers
    None."""
    if is_dataclass(value):
        value = vars(value)
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, str):
        return SI.rendered(value)
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value
