"""Writes a mesh to a file that other programs read."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import meshio

FORMATS = {".msh": "gmsh", ".vtu": "vtu"}
"""File endings that can be written, with the name meshio gives the format."""


def write_mesh(mesh: meshio.Mesh, path: Path) -> None:
    """Write a mesh with its groups: as physical tags with names (.msh), or as the integer cell array `group` (.vtu).

    Parameters
    ----------
    mesh : meshio.Mesh
        Of `plate_mesh` or `wall_mesh`.
    path : Path
        Ending in .msh (Gmsh 4.1) or .vtu.

    Raises
    ------
    ValueError
        For another ending.
    """
    import meshio

    if path.suffix not in FORMATS:
        raise ValueError(f"{path.name}: a mesh is written as {' or '.join(FORMATS)}")
    tags = [np.full(len(block.data), number) for number, block in enumerate(mesh.cells, start=1)]
    if path.suffix == ".vtu":
        tagged = meshio.Mesh(mesh.points, mesh.cells, cell_data={"group": tags})
    else:
        tagged = meshio.Mesh(
            mesh.points,
            mesh.cells,
            cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags},
            field_data={
                name: np.array([number, mesh.cells[number - 1].dim])
                for number, name in enumerate(mesh.cell_sets, start=1)
            },
            point_data={"gmsh:dim_tags": _dimension_and_tag(mesh)},
        )
    tagged.write(path, file_format=FORMATS[path.suffix])


def _dimension_and_tag(mesh: meshio.Mesh) -> np.ndarray:
    """Entity that owns each node, the one of lowest dimension, as Gmsh 4.1 wants it; shape (nodes, 2)."""
    owner = np.zeros((len(mesh.points), 2), dtype=np.int64)
    for number, block in sorted(enumerate(mesh.cells, start=1), key=lambda item: -item[1].dim):
        owner[np.unique(block.data)] = block.dim, number
    return owner
