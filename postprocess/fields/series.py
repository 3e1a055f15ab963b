"""Fields over the plate, and their file in a result folder."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

if TYPE_CHECKING:
    import pyvista


FILE = "fields.npz"
"""Name of the file in a result folder."""

NODES = {"displacement": "m", "elastic_displacement": "m", "velocity": "m/s"}
"""Fields of the nodes, with components along and across the wall, and their units."""

STRESSES = ("stress_von_mises", "stress_principal_1", "stress_principal_2")
ELEMENTS = {**dict.fromkeys(STRESSES, "Pa"), "strain_energy_density": "J/m^3"}
"""Fields of the elements and their units."""

COMPONENTS = {f"{name}_{axis}": unit for name, unit in NODES.items() for axis in "xy"}
UNITS = {"t": "s", "points": "m", **NODES, **ELEMENTS, **COMPONENTS}
SCALARS = (*COMPONENTS, *NODES, *ELEMENTS)
"""Scalars by node or element: components, sizes of vectors, fields of elements."""

VTK_TYPES = {"triangle": 5, "quad": 9, "triangle6": 22, "quad8": 23, "quad9": 28}
"""Cell types of VTK by their names in meshio."""


@dataclass(frozen=True)
class FieldSeries:
    """Fields at several instants, SI.

    Attributes
    ----------
    cell_type : str
        Of all elements, as named by meshio.
    points : ndarray, shape (nodes, 2)
        The unstrained plate at the start of the run, in the wall's frame [m].
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
        """Points with Z = 0, shape (nodes, 3) [m]."""
        return padded(self.points)

    @property
    def corners(self) -> np.ndarray:
        """Nodes at the corners of each element, shape (elements, 3 or 4)."""
        return self.cells[:, : 3 if self.cell_type.startswith("triangle") else 4]

    def places(self, magnify: float = 1.0) -> np.ndarray:
        """Return the places of the nodes, shape (instants, nodes, 2) [m].

        The elastic deformation is multiplied by `magnify`.
        """
        elastic = self.nodal["elastic_displacement"]
        return np.asarray(self.points + self.nodal["displacement"] + (magnify - 1.0) * elastic)

    def at(self, k: int) -> FieldSeries:
        """Return the fields at instant number k alone."""
        nodal, elemental = ({name: f[[k]] for name, f in of.items()} for of in (self.nodal, self.elemental))
        return replace(self, t=self.t[[k]], nodal=nodal, elemental=elemental)

    def scalar(self, name: str) -> np.ndarray:
        """Return one of `SCALARS`, shape (instants, nodes or elements).

        Raises KeyError for another name.
        """
        if name in ELEMENTS:
            return self.elemental[name]
        if name in NODES:
            return np.asarray(np.linalg.norm(self.nodal[name], axis=-1))
        if name not in COMPONENTS:
            raise KeyError(name)
        return self.nodal[name[:-2]][:, :, "xy".index(name[-1])]

    def grid(self, k: int = -1) -> pyvista.UnstructuredGrid:
        """Return mesh and fields at instant number k.

        Returns
        -------
        pyvista.UnstructuredGrid
            The unstrained plate at the start of the run; `grid.warp_by_vector("displacement")` is the plate at this
            instant. Points have vectors and their components along and across the wall, cells the fields of
            elements; `field_data["t"]` is the instant [s].
        """
        import pyvista

        mesh = pyvista.UnstructuredGrid({VTK_TYPES[self.cell_type]: self.cells}, self.points_3d)
        for name in SCALARS:
            data = mesh.cell_data if name in ELEMENTS else mesh.point_data
            data[name] = padded(self.nodal[name][k]) if name in NODES else self.scalar(name)[k].copy()
        mesh.field_data["t"] = self.t[[k]]
        return mesh


def padded(vectors: np.ndarray) -> np.ndarray:
    """Return planar vectors with a third component, 0."""
    return np.concatenate([vectors, np.zeros_like(vectors[..., :1])], axis=-1)


def write_fields(path: Path, series: FieldSeries) -> Path:
    """Write mesh and fields in double precision."""
    fixed = {"cell_type": np.array(series.cell_type), "points": series.points, "cells": series.cells}
    arrays: dict[str, Any] = {**fixed, "t": series.t, **series.nodal, **series.elemental}
    with path.open("wb") as file:
        np.savez(file, **arrays)
    return path


def read_fields(source: Path | BinaryIO) -> FieldSeries:
    """Read fields from a file of `write_fields`.

    Raises OSError, KeyError or ValueError for other files.
    """
    with np.load(source, allow_pickle=False) as arrays:
        points, cells, t = (arrays[name] for name in ("points", "cells", "t"))
        nodal, elemental = ({name: arrays[name] for name in names} for names in (NODES, ELEMENTS))
        return FieldSeries(str(arrays["cell_type"]), points, cells, t, nodal, elemental)
