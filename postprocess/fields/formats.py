"""Fields and histories in the formats of other programs.

VTKHDF, one HDF5 file that ParaView opens as a time series; XDMF, VTU and Gmsh's MSH by meshio; CSV and Parquet tables
with units in the headings, or in the metadata of each column.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from postprocess.fields.series import UNITS, VTK_TYPES, FieldSeries, Table, padded
from postprocess.report import files


def write_vtkhdf(path: Path, series: FieldSeries) -> Path:
    """Write VTK's "VTKHDF File Format" 2.0, UnstructuredGrid with `Steps`: the mesh once, the fields of all instants
    one after the other. Raises ImportError where h5py is not installed."""
    try:
        import h5py
    except ImportError:
        raise ImportError("VTKHDF needs h5py: `pip install h5py`") from None
    (elements, corners), count = series.cells.shape, len(series.t)
    with h5py.File(path, "w") as file:
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
    return path


def write_xdmf(path: Path, series: FieldSeries) -> Path:
    """Write one XML file with all numbers in it."""
    import meshio

    with meshio.xdmf.TimeSeriesWriter(str(path), data_format="XML") as writer:
        writer.write_points_cells(series.points_3d, [(series.cell_type, series.cells)])
        for t, nodal, elemental in _instants(series):
            writer.write_data(t, point_data=nodal, cell_data={k: [v] for k, v in elemental.items()})
    return path


def write_vtu(path: Path, series: FieldSeries) -> Path:
    """Write the collection, a .pvd file, and beside it a .vtu file an instant."""
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
    """Write the mesh, and after it a view of each field with all its instants (MSH 2.2, text)."""
    import meshio

    ones = [np.ones(len(series.cells), int)]
    mesh = _mesh(series, cell_data={"gmsh:physical": ones, "gmsh:geometrical": ones})
    meshio.gmsh.write(str(path), mesh, fmt_version="2.2", binary=False)
    with path.open("a", encoding="utf-8") as file:
        for number, (t, nodal, elemental) in enumerate(_instants(series)):
            for name, values in nodal.items():
                file.write(_msh_view("NodeData", name, t, number, values))
            for name, values in elemental.items():
                file.write(_msh_view("ElementData", name, t, number, values[:, None]))
    return path


def _msh_view(kind: str, name: str, t: float, step: int, values: np.ndarray) -> str:
    """A section of Gmsh's file: tags of text, real and whole numbers, then a line a node or element."""
    count, components = values.shape
    head = f'${kind}\n1\n"{name}"\n1\n{t!r}\n3\n{step}\n{components}\n{count}\n'
    lines = (f"{i} {' '.join(map(repr, row))}" for i, row in enumerate(values.tolist(), 1))
    return head + "\n".join(lines) + f"\n$End{kind}\n"


def _instants(series: FieldSeries) -> Iterator[tuple[float, dict[str, np.ndarray], dict[str, np.ndarray]]]:
    """Instant [s], and fields of nodes, with three components, and of elements, by names with units."""
    for k, t in enumerate(series.t):
        nodal = {f"{name} [{UNITS[name]}]": padded(values[k]) for name, values in series.nodal.items()}
        yield float(t), nodal, {f"{name} [{UNITS[name]}]": v[k] for name, v in series.elemental.items()}


def _mesh(series: FieldSeries, **data: Any) -> Any:
    import meshio

    return meshio.Mesh(series.points_3d, [(series.cell_type, series.cells)], **data)


def write_csv(path: Path, table: Table) -> Path:
    """Write a heading of names with units, and a line a row, 17 digits."""
    columns, units = table
    named = {f"{name} [{units[name]}]" if units.get(name) else name: v for name, v in columns.items()}
    return files.write_history(path, named)


def write_parquet(path: Path, table: Table) -> Path:
    """Write columns by their names; the unit of each is in the metadata of its field."""
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
