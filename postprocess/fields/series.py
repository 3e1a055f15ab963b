"""Fields over the plate at some instants, and the file of a result folder that holds them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

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

UNITS = {"t": "s", "points": "m", **NODES, **ELEMENTS}


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


def padded(vectors: np.ndarray) -> np.ndarray:
    """Vectors in the plane with a third component, 0."""
    return np.concatenate([vectors, np.zeros_like(vectors[..., :1])], axis=-1)


def write_fields(path: Path, series: FieldSeries) -> Path:
    """Write all of it, in double precision."""
    fixed = {"cell_type": np.array(series.cell_type), "points": series.points, "cells": series.cells}
    with path.open("wb") as file:
        np.savez(file, **fixed, t=series.t, **series.nodal, **series.elemental)  # type: ignore[arg-type]
    return path


def read_fields(path: Path) -> FieldSeries:
    """What `write_fields` wrote. Raises OSError, KeyError or ValueError for anything else."""
    with np.load(path, allow_pickle=False) as found:
        return FieldSeries(
            str(found["cell_type"]),
            found["points"],
            found["cells"],
            found["t"],
            {name: found[name] for name in NODES},
            {name: found[name] for name in ELEMENTS},
        )
