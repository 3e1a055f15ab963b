"""The table of a sweep, `sweep.parquet`: a row a run, in the order of the runs."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from postprocess.files.summary import plain
from tailslap.files.manifest import listed_file
from tailslap.sweeps.definition import Definition
from tailslap.sweeps.folder import TABLE
from tailslap.sweeps.journal import Rows
from tailslap.sweeps.row import REUSED, TIMES, versions
from tailslap.sweeps.variation import Variation

if TYPE_CHECKING:
    import pyarrow as pa

CHUNK = 20_000
"""Rows that are in memory at a time."""


def write_table(folder: Path, definition: Definition, rows: Rows) -> Path:
    """Write the table of all rows that there are, whole or not at all."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    schema = _schema(definition, _checks(rows))
    path = folder / TABLE
    with listed_file(path) as partial, pq.ParquetWriter(partial, schema, compression="zstd") as writer:
        complete = (plain(row | definition.inputs_of(row["run"])) for row in rows.in_order())
        while chunk := list(itertools.islice(complete, CHUNK)):
            writer.write_table(pa.Table.from_pylist(chunk, schema=schema))
    return path


def read_columns(path: Path, names: Iterable[str]) -> dict[str, np.ndarray]:
    """Columns of the table; numbers that a row lacks are NaN."""
    import pyarrow.parquet as pq

    table = pq.read_table(path, columns=list(names))
    return {name: table[name].to_numpy(zero_copy_only=False) for name in table.column_names}


def _checks(rows: Rows) -> list[str]:
    """Columns of checks: which there are depends on the runs."""
    return sorted({name for row in rows.in_order() for name in row if name.startswith("check.")})


def _schema(definition: Definition, checks: list[str]) -> pa.Schema:
    import pyarrow as pa

    real, whole, text = pa.float64(), pa.int64(), pa.string()
    columns: dict[str, Any] = {"run": whole, "status": text, "reason": text}
    columns |= {item.key: _kind(item) for item in definition.variations}
    types = {name: {float: real, int: whole, str: text}[kind] for name, kind in definition.kinds.items()}
    columns |= {name: kind for name, kind in types.items() if not name.startswith("cost.")}
    columns |= dict.fromkeys(checks, real) | types
    columns |= dict.fromkeys(TIMES, real) | {REUSED: text} | dict.fromkeys(versions(), text)
    return pa.schema(list(columns.items()))


def _kind(item: Variation) -> Any:
    """The type of a column of inputs."""
    import pyarrow as pa

    if not item.numeric:
        return pa.string()
    return pa.int64() if all(isinstance(value, int) for value in item.values) else pa.float64()
