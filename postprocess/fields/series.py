"""Fields over the plate at some instants: the record, its file in a result folder, its meshes and its tables.

Fields and histories in the formats of other programs.

VTKHDF, one HDF5 file that ParaView opens as a time series; XDMF, VTU and Gmsh's MSH by meshio; CSV and Parquet tables
with units in the headings, or in the metadata of each column.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

from postprocess.report import page, report

if TYPE_CHECKING:
    import pyvista


FILE = "fields.npz"
"""Name of the file in a result folder."""

NODES = {"displacement": "m", "elastic_displacement": "m", "velocity": "m/s"}
"""Fields of the nodes, two components, along the wall and across it, and their units."""

STRESSES = ("stress_von_mises", "stress_principal_1", "stress_principal_2")
ELEMENTS = {**dict.fromkeys(STRESSES, "Pa"), "strain_energy_density": "J/m^3"}
"""Fields of the elements and their units."""

COMPONENTS = {f"{name}_{axis}": unit for name, unit in NODES.items() for axis in "xy"}
UNITS = {"t": "s", "points": "m", **NODES, **ELEMENTS, **COMPONENTS}
SCALARS = (*COMPONENTS, *NODES, *ELEMENTS)
"""Scalars, one value a node or an element: components, sizes of vectors, fields of elements."""

VTK_TYPES = {"triangle": 5, "quad": 9, "triangle6": 22, "quad8": 23, "quad9": 28}
"""Numbers of the cells that meshio calls so."""

Table = tuple[Mapping[str, np.ndarray], Mapping[str, str]]
"""Columns and their units."""


@dataclass(frozen=True)
class FieldSeries:
    """Fields at some instants, SI.

    Attributes
    ----------
    cell_type : str
        Of all elements, as meshio calls it.
    points : ndarray, shape (nodes, 2)
        The unstrained plate where the run starts, in the wall's frame [m].
    cells : ndarray, shape (elements, nodes per element)
        Nodes of each element.
    t : ndarray, shape (instants,)
        Instants [s].
    nodal : mapping of ndarray, shape (instants, nodes, 2)
        Fields by the names of `NODES`.
    elemental : mapping of ndarray, shape (instants, elements)
        Fields by the names of `ELEMENTS`.
    """

    cell_type: str
    points: np.ndarray
    cells: np.ndarray
    t: np.ndarray
    nodal: Mapping[str, np.ndarray]
    elemental: Mapping[str, np.ndarray]

    @property
    def points_3d(self) -> np.ndarray:
        """The points with Z = 0, shape (nodes, 3) [m]."""
        return padded(self.points)

    @property
    def corners(self) -> np.ndarray:
        """Nodes at the corners of each element, shape (elements, 3 or 4)."""
        return self.cells[:, : 3 if self.cell_type.startswith("triangle") else 4]

    def places(self, magnify: float = 1.0) -> np.ndarray:
        """Places of the nodes, with the elastic deformation times `magnify`, shape (instants, nodes, 2) [m]."""
        elastic = self.nodal["elastic_displacement"]
        return np.asarray(self.points + self.nodal["displacement"] + (magnify - 1.0) * elastic)

    def at(self, k: int) -> FieldSeries:
        """Fields at instant number k alone."""
        nodal, elemental = ({name: f[[k]] for name, f in of.items()} for of in (self.nodal, self.elemental))
        return replace(self, t=self.t[[k]], nodal=nodal, elemental=elemental)

    def scalar(self, name: str) -> np.ndarray:
        """Values a node, or an element, of a name of `SCALARS`, shape (instants, nodes or elements); else KeyError."""
        if name in ELEMENTS:
            return self.elemental[name]
        if name in NODES:
            return np.asarray(np.linalg.norm(self.nodal[name], axis=-1))
        if name not in COMPONENTS:
            raise KeyError(name)
        return self.nodal[name[:-2]][:, :, "xy".index(name[-1])]

    def grid(self, k: int = -1) -> pyvista.UnstructuredGrid:
        """Mesh and fields at instant number k.

        Returns
        -------
        pyvista.UnstructuredGrid
            The unstrained plate where the run starts: `grid.warp_by_vector("displacement")` is where it is. At the
            points vectors, and their components along and across the wall; at the cells fields of elements; the
            instant [s] in `field_data["t"]`.
        """
        import pyvista

        found = pyvista.UnstructuredGrid({VTK_TYPES[self.cell_type]: self.cells}, self.points_3d)
        for name in SCALARS:
            data = found.cell_data if name in ELEMENTS else found.point_data
            data[name] = padded(self.nodal[name][k]) if name in NODES else self.scalar(name)[k].copy()
        found.field_data["t"] = self.t[[k]]
        return found


def padded(vectors: np.ndarray) -> np.ndarray:
    """Vectors in the plane with a third component, 0."""
    return np.concatenate([vectors, np.zeros_like(vectors[..., :1])], axis=-1)


def write_fields(path: Path, series: FieldSeries) -> Path:
    """Write all of it, in double precision."""
    fixed = {"cell_type": np.array(series.cell_type), "points": series.points, "cells": series.cells}
    arrays: dict[str, Any] = {**fixed, "t": series.t, **series.nodal, **series.elemental}
    with path.open("wb") as file:
        np.savez(file, **arrays)
    return path


def read_fields(source: Path | BinaryIO) -> FieldSeries:
    """Fields that `write_fields` wrote. Raises OSError, KeyError or ValueError for anything else."""
    with np.load(source, allow_pickle=False) as found:
        return FieldSeries(
            str(found["cell_type"]),
            found["points"],
            found["cells"],
            found["t"],
            {name: found[name] for name in NODES},
            {name: found[name] for name in ELEMENTS},
        )


def field_tables(series: FieldSeries) -> dict[str, Table]:
    """A row an instant and node, and a row an instant and element."""
    count, nodes, elements = len(series.t), len(series.points), len(series.cells)
    x, y = (np.tile(series.points[:, k], count) for k in (0, 1))
    of_nodes = {"t": np.repeat(series.t, nodes), "node": np.tile(np.arange(nodes), count), "x": x, "y": y}
    of_elements = {"t": np.repeat(series.t, elements), "element": np.tile(np.arange(elements), count)}
    of_nodes |= {name: series.scalar(name).ravel() for name in COMPONENTS}
    of_elements |= {name: values.ravel() for name, values in series.elemental.items()}
    return {"nodes": (of_nodes, UNITS | {"x": "m", "y": "m"}), "elements": (of_elements, UNITS)}


def write_vtkhdf(path: Path, series: FieldSeries) -> Path:
    """Write VTK's "VTKHDF File Format" 2.0, UnstructuredGrid with `Steps`: the mesh once, the fields of all instants
    one after the other."""
    import h5py

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
    """A section of Gmsh's file: tags of text, real and whole numbers, then a line a node or element.

    name: of the field; with its unit it is the view's.
    """
    count, components = values.shape
    head = f'${kind}\n1\n"{name} [{UNITS[name]}]"\n1\n{t!r}\n3\n{step}\n{components}\n{count}\n'
    lines = (f"{i} {' '.join(map(repr, row))}" for i, row in enumerate(values.tolist(), 1))
    return head + "\n".join(lines) + f"\n$End{kind}\n"


def _instants(series: FieldSeries) -> Iterator[tuple[float, dict[str, np.ndarray], dict[str, np.ndarray]]]:
    """Instant [s], and fields of nodes, with three components, and of elements, by their names."""
    for k, t in enumerate(series.t):
        nodal = {name: padded(values[k]) for name, values in series.nodal.items()}
        yield float(t), nodal, {name: values[k] for name, values in series.elemental.items()}


def _mesh(series: FieldSeries, **data: Any) -> Any:
    import meshio

    return meshio.Mesh(series.points_3d, [(series.cell_type, series.cells)], **data)


def write_csv(path: Path, table: Table) -> Path:
    """Write a heading of names with units, and a line a row, numbers with all their digits."""
    columns, units = table
    named = {f"{name} [{units[name]}]" if units.get(name) else name: v for name, v in columns.items()}
    if all(np.asarray(values).dtype.kind in "biuf" for values in named.values()):
        return page.write_history(path, named)
    rows = [dict(zip(named, row, strict=True)) for row in zip(*named.values(), strict=True)]
    return report.write_table(path, page.listed(rows))


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
