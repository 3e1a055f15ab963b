"""Histories and fields as tables, CSV and Parquet: units in the headings, or in the metadata of each column."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from postprocess.fields.series import UNITS, FieldSeries
from postprocess.files.histories import write_history

Table = tuple[Mapping[str, np.ndarray], Mapping[str, str]]
"""Columns and their units."""


def field_tables(series: FieldSeries) -> dict[str, Table]:
    """A row an instant and node, and a row an instant and element."""
    count, nodes, elements = len(series.t), len(series.points), len(series.cells)
    x, y = (np.tile(series.points[:, k], count) for k in (0, 1))
    of_nodes = {"t": np.repeat(series.t, nodes), "node": np.tile(np.arange(nodes), count), "x": x, "y": y}
    units = {"t": "s", "x": "m", "y": "m"}
    for name, values in series.nodal.items():
        for k, axis in enumerate("xy"):
            of_nodes[f"{name}_{axis}"] = values[:, :, k].ravel()
            units[f"{name}_{axis}"] = UNITS[name]
    of_elements = {
        "t": np.repeat(series.t, elements),
        "element": np.tile(np.arange(elements), count),
        **{name: values.ravel() for name, values in series.elemental.items()},
    }
    return {"nodes": (of_nodes, units), "elements": (of_elements, {**UNITS})}


def write_csv(path: Path, table: Table) -> Path:
    """A heading of names with units, a line a row, 17 digits."""
    columns, units = table
    named = {f"{name} [{units[name]}]" if units.get(name) else name: v for name, v in columns.items()}
    return write_history(path, named)


def write_parquet(path: Path, table: Table) -> Path:
    """Columns by their names; the unit of each is in the metadata of its field."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    columns, units = table
    arrays = [pa.array(np.ascontiguousarray(values)) for values in columns.values()]
    fields = [
        pa.field(name, array.type, metadata={"unit": units[name]} if units.get(name) else None)
        for name, array in zip(columns, arrays, strict=True)
    ]
    pq.write_table(pa.Table.from_arrays(arrays, schema=pa.schema(fields)), path)
    return path
