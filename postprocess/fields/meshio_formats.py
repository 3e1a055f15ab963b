"""Formats that meshio writes: XDMF with all instants, VTU with a file an instant and a collection, Gmsh's MSH."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from postprocess.fields.series import UNITS, FieldSeries, padded


def labelled(name: str) -> str:
    """Name of a field with its unit."""
    return f"{name} [{UNITS[name]}]"


def write_xdmf(path: Path, series: FieldSeries) -> Path:
    """One XML file with all numbers in it."""
    import meshio

    cells = [(series.cell_type, series.cells)]
    with meshio.xdmf.TimeSeriesWriter(str(path), data_format="XML") as writer:
        writer.write_points_cells(series.points_3d, cells)
        for t, nodal, elemental in _instants(series):
            writer.write_data(float(t), point_data=nodal, cell_data={k: [v] for k, v in elemental.items()})
    return path


def write_vtu(path: Path, series: FieldSeries) -> Path:
    """The collection, a .pvd file, and beside it a .vtu file an instant."""
    entries = []
    for number, (t, nodal, elemental) in enumerate(_instants(series)):
        name = f"{path.stem}_{number:04d}.vtu"
        _mesh(series, nodal, elemental).write(path.with_name(name), binary=True)
        entries.append(f'    <DataSet timestep="{t!r}" file="{name}"/>')
    path.write_text(
        '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n  <Collection>\n'
        + "\n".join(entries)
        + "\n  </Collection>\n</VTKFile>\n",
        encoding="utf-8",
    )
    return path


def write_msh(path: Path, series: FieldSeries) -> Path:
    """The mesh, and after it a view of each field with all its instants (MSH 2.2, text)."""
    import meshio

    mesh = _mesh(series, {}, {})
    mesh.cell_data = {"gmsh:physical": [np.ones(len(series.cells), int)]}
    mesh.cell_data["gmsh:geometrical"] = [np.ones(len(series.cells), int)]
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
        nodal = {labelled(name): padded(values[k]) for name, values in series.nodal.items()}
        yield float(t), nodal, {labelled(name): values[k] for name, values in series.elemental.items()}


def _mesh(series: FieldSeries, nodal: dict[str, Any], elemental: dict[str, Any]) -> Any:
    import meshio

    cells = [(series.cell_type, series.cells)]
    return meshio.Mesh(series.points_3d, cells, nodal, {name: [values] for name, values in elemental.items()})
