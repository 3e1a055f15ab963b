"""Histories on disk: `history.csv` and `rigid.csv`, a header row of names and one row a recorded instant, SI.

Seventeen significant digits are written, so every double comes back bit for bit. What is no finite number is an empty
entry.
"""

import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

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
