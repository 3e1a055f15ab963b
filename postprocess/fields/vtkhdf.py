"""VTKHDF: one HDF5 file with all instants, which ParaView opens as a time series.

The layout is that of VTK's "VTKHDF File Format", version 2, UnstructuredGrid with `Steps`: the mesh is there once, the
fields of all instants one after the other.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from postprocess.fields.series import UNITS, FieldSeries, padded

VTK_TYPES = {"triangle": 5, "quad": 9, "triangle6": 22, "quad8": 23, "quad9": 28}


def write_vtkhdf(path: Path, series: FieldSeries) -> Path:
    """Write the file. Raises ImportError where h5py is not installed."""
    try:
        import h5py
    except ImportError:
        raise ImportError("VTKHDF needs h5py: `pip install h5py`") from None
    with h5py.File(path, "w") as file:
        root = file.create_group("VTKHDF", track_order=True)
        root.attrs["Version"] = (2, 0)
        root.attrs.create("Type", b"UnstructuredGrid", dtype=h5py.string_dtype("ascii", 16))
        _write_mesh(root, series)
        _write_fields(root, series)
    return path


def _write_mesh(root: Any, series: FieldSeries) -> None:
    elements, nodes = series.cells.shape
    root["NumberOfPoints"], root["NumberOfCells"] = [len(series.points)], [elements]
    root["NumberOfConnectivityIds"] = [series.cells.size]
    root["Points"] = series.points_3d
    root["Connectivity"] = series.cells.astype(np.int64).ravel()
    root["Offsets"] = nodes * np.arange(elements + 1, dtype=np.int64)
    root["Types"] = np.full(elements, VTK_TYPES[series.cell_type], np.uint8)


def _write_fields(root: Any, series: FieldSeries) -> None:
    """Fields, and where those of each instant begin."""
    count, steps = len(series.t), root.create_group("Steps")
    steps.attrs["NSteps"] = count
    steps["Values"] = series.t
    for name in ("PartOffsets", "PointOffsets"):
        steps[name] = np.zeros(count, np.int64)
    for name in ("CellOffsets", "ConnectivityIdOffsets"):
        steps[name] = np.zeros((count, 1), np.int64)
    steps["NumberOfParts"] = np.ones(count, np.int64)
    for group, fields in (("PointData", series.nodal), ("CellData", series.elemental)):
        offsets = steps.create_group(f"{group}Offsets")
        root.create_group(group)
        for name, values in fields.items():
            stored = padded(values) if group == "PointData" else values
            data = root[group].create_dataset(name, data=stored.reshape(-1, *stored.shape[2:]))
            data.attrs["units"] = UNITS[name]
            offsets[name] = stored.shape[1] * np.arange(count, dtype=np.int64)
