"""Fields and histories in formats of other programs.

VTKHDF, one HDF5 file that ParaView opens as a time series; XDMF, VTU and Gmsh's MSH by meshio; CSV and Parquet tables
with units in the headings, or in the metadata of each column.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from postprocess.fields.series import COMPONENTS, UNITS, VTK_TYPES, FieldSeries, padded
from postprocess.report.data_files import write_history, write_table
from postprocess.report.tables import listed

if TYPE_CHECKING:
    import meshio

Table = tuple[Mapping[str, np.ndarray], Mapping[str, str]]
"""Columns and their units."""


def field_tables(series: FieldSeries) -> dict[str, Table]:
    """Return the fields of nodes and of elements as tables.

    They have a row for each instant and node or element.
    """
    count, nodes, elements = len(series.t), len(series.points), len(series.cells)
    x, y = (np.tile(series.points[:, k], count) for k in (0, 1))
    of_nodes = {"t": np.repeat(series.t, nodes), "node": np.tile(np.arange(nodes), count), "x": x, "y": y}
    of_elements = {"t": np.repeat(series.t, elements), "element": np.tile(np.arange(elements), count)}
    of_nodes |= {name: series.scalar(name).ravel() for name in COMPONENTS}
    of_elements |= {name: values.ravel() for name, values in series.elemental.items()}
    return {"nodes": (of_nodes, UNITS | {"x": "m", "y": "m"}), "elements": (of_elements, UNITS)}


def write_vtkhdf(path: Path, series: FieldSeries) -> Path:
    """Write fields in VTK's "VTKHDF File Format" 2.0.

    An UnstructuredGrid with `Steps`: the mesh once, the fields of all instants one after the other.
    """
    import h5py

    (elements, corners), count = series.cells.shape, len(series.t)
    buffer = io.BytesIO()  # HDF5 states no error of the disk when it closes a data set
    with h5py.File(buffer, "w") as file:
        root = file.create_group("VTKHDF", track_order=True)
        root.attrs["Version"] = (2, 0)
        root.attrs.create("Type", b"UnstructuredGrid", dtype=h5py.string_dtype("ascii", 16))
        root["NumberOfPoints"], root["NumberOfCells"] = [len(series.points)], [elements]
        root["NumberOfConnectivityIds"] = [series.cells.size]
        root["Points"] = series.points_3d
        root["Connectivity"] = series.cells.astype(np.int64).ravel()
        root["Offsets"] = corners * np.arange(elements + 1, dtype=np.int64)
        root["Types"] = np.full(elements, VTK_TYPES[series.cell_type], np.uint8)
        steps = root.create_group("Steps")
        steps.attrs["NSteps"] = count
        steps["Values"] = series.t
        for name in ("PartOffsets", "PointOffsets"):
            steps[name] = np.zeros(count, np.int64)
        for name in ("CellOffsets", "ConnectivityIdOffsets"):
            steps[name] = np.zeros((count, 1), np.int64)
        steps["NumberOfParts"] = np.ones(count, np.int64)
        for group, fields in (("PointData", series.nodal), ("CellData", series.elemental)):
            for name, values in fields.items():
                stored = padded(values) if group == "PointData" else values
                data = root.create_dataset(f"{group}/{name}", data=stored.reshape(-1, *stored.shape[2:]))
                data.attrs["units"] = UNITS[name]
                steps[f"{group}Offsets/{name}"] = stored.shape[1] * np.arange(count, dtype=np.int64)
    path.write_bytes(buffer.getbuffer())
    return path


def write_xdmf(path: Path, series: FieldSeries) -> Path:
    """Write fields as one XML file."""
    import meshio

    with meshio.xdmf.TimeSeriesWriter(str(path), data_format="XML") as writer:
        writer.write_points_cells(series.points_3d, [(series.cell_type, series.cells)])
        for t, nodal, elemental in _instants(series):
            writer.write_data(t, point_data=nodal, cell_data={k: [v] for k, v in elemental.items()})
    return path


def write_vtu(path: Path, series: FieldSeries) -> Path:
    """Write a collection, .pvd, with a .vtu file for each instant."""
    entries = []
    for number, (t, nodal, elemental) in enumerate(_instants(series)):
        name = f"{path.stem}_{number:04d}.vtu"
        cell_data = {label: [values] for label, values in elemental.items()}
        _mesh(series, point_data=nodal, cell_data=cell_data).write(path.with_name(name), binary=True)
        entries.append(f'    <DataSet timestep="{t!r}" file="{name}"/>\n')
    path.write_text(
        '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n  <Collection>\n'
        + "".join(entries)
        + "  </Collection>\n</VTKFile>\n",
        encoding="utf-8",
    )
    return path


def write_msh(path: Path, series: FieldSeries) -> Path:
    """Write a mesh followed by views of all fields and instants.

    MSH 2.2, text.
    """
    import meshio

    tags = [np.ones(len(series.cells), int)]
    mesh = _mesh(series, cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags})
    meshio.gmsh.write(str(path), mesh, fmt_version="2.2", binary=False)
    with path.open("a", encoding="utf-8") as file:
        for number, (t, nodal, elemental) in enumerate(_instants(series)):
            for name, values in nodal.items():
                file.write(_msh_view("NodeData", name, t, number, values))
            for name, values in elemental.items():
                file.write(_msh_view("ElementData", name, t, number, values[:, None]))
    return path


def _msh_view(kind: str, name: str, t: float, step: int, values: np.ndarray) -> str:
    """Return a section of a file of Gmsh.

    Tags of text, real and whole numbers precede a line for each node or element. The name of the view is that of the
    field with its unit.
    """
    count, components = values.shape
    head = f'${kind}\n1\n"{name} [{UNITS[name]}]"\n1\n{t!r}\n3\n{step}\n{components}\n{count}\n'
    lines = (f"{i} {' '.join(map(repr, row))}" for i, row in enumerate(values.tolist(), 1))
    return head + "\n".join(lines) + f"\n$End{kind}\n"


def _instants(series: FieldSeries) -> Iterator[tuple[float, dict[str, np.ndarray], dict[str, np.ndarray]]]:
    """Yield instant [s], nodal and elemental fields by their names.

    Nodal fields have three components.
    """
    for k, t in enumerate(series.t):
        nodal = {name: padded(values[k]) for name, values in series.nodal.items()}
        yield float(t), nodal, {name: values[k] for name, values in series.elemental.items()}


def _mesh(series: FieldSeries, **data: object) -> meshio.Mesh:
    import meshio

    return meshio.Mesh(series.points_3d, [(series.cell_type, series.cells)], **data)


def write_csv(path: Path, table: Table) -> Path:
    """Write columns with units in the headings, in full precision."""
    columns, units = table
    named = {f"{name} [{units[name]}]" if units.get(name) else name: v for name, v in columns.items()}
    if all(np.asarray(values).dtype.kind in "biuf" for values in named.values()):
        return write_history(path, named)
    rows = [dict(zip(named, row, strict=True)) for row in zip(*named.values(), strict=True)]
    return write_table(path, listed(rows))


def write_parquet(path: Path, table: Table) -> Path:
    """Write a Parquet file of columns, with units as metadata."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    columns, units = table
    arrays = [pa.array(np.ascontiguousarray(values)) for values in columns.values()]
    fields = [
        pa.field(name, array.type, metadata={"unit": units[name]} if units.get(name) else None)
        for name, array in zip(columns, arrays, strict=True)
    ]
    with path.open("wb") as file:  # whose errors have a number
        pq.write_table(pa.Table.from_arrays(arrays, schema=pa.schema(fields)), file)
    return path
