"""Fields over the plate at some instants: the record, its file in a result folder, its meshes and its tables."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import pyvista

FILE = "fields.npz"
"""Name of the file in a result folder."""

NODES = {
    "displacement": "m",
    "elastic_displacement": "m",
    "velocity": "m/s",
}
"""Fields of the nodes, two components, along the wall and across it, and their units."""

ELEMENTS = {
    "stress_von_mises": "Pa",
    "stress_principal_1": "Pa",
    "stress_principal_2": "Pa",
    "strain_energy_density": "J/m^3",
}
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


def read_fields(path: Path) -> FieldSeries:
    """Fields that `write_fields` wrote. Raises OSError, KeyError or ValueError for anything else."""
    with np.load(path, allow_pickle=False) as found:
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
