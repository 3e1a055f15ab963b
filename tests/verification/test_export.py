"""Verification: what is exported, read again by other libraries, has the run's values."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import tailslap
from postprocess.fields import FORMATS
from postprocess.fields.series import ELEMENTS, NODES, UNITS, FieldSeries
from tailslap import Result
from tailslap.command_line import main
from tailslap.errors import InputError

pytestmark = pytest.mark.verification

SINGLE = 2e-7
"""Relative rounding of float32."""


@pytest.fixture(scope="module")
def result() -> Result:
    return tailslap.run(
        "paper-table-3", {"output.fields": 4, "plate.element": "quad9", "plate.elements": [6, 2]}
    )


@pytest.fixture(scope="module")
def exported(result: Result, tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    made: dict[str, Path] = {}

    def write(to: str) -> Path:
        if to not in made:
            made[to] = tailslap.export(result, to, tmp_path_factory.mktemp("exported") / to)
        return made[to]

    return write


def same(found: Any, expected: np.ndarray) -> None:
    """To float32 of the field's size, or better."""
    np.testing.assert_allclose(found, expected, rtol=SINGLE, atol=SINGLE * np.abs(expected).max())


def check_mesh(mesh: Any, series: FieldSeries, k: int, suffix: bool) -> None:
    """A mesh of pyvista at one instant."""
    same(mesh.points[:, :2], series.points)
    for name, values in series.nodal.items():
        found = mesh.point_data[f"{name} [{UNITS[name]}]" if suffix else name]
        same(found[:, :2], values[k])
        assert not found[:, 2].any()
    for name, values in series.elemental.items():
        same(mesh.cell_data[f"{name} [{UNITS[name]}]" if suffix else name], values[k])


@pytest.mark.parametrize(("to", "suffix"), [("vtkhdf", False), ("vtu", True), ("xdmf", True)])
def test_vtk_reads_the_time_series(
    to: str, suffix: bool, result: Result, exported: Callable[[str], Path]
) -> None:
    """By VTK's own readers, as ParaView has them."""
    import pyvista

    series, path = result.fields, exported(to)
    if to == "vtkhdf":
        from vtkmodules.vtkIOHDF import vtkHDFReader

        reader = vtkHDFReader()
        reader.SetFileName(str(path))
        for k in range(4):
            reader.SetStep(k)
            reader.Update()
            assert reader.GetTimeValue() == series.t[k]
            mesh = pyvista.wrap(reader.GetOutput())
            assert (mesh.celltypes == 28).all()
            np.testing.assert_array_equal(mesh.cells.reshape(-1, 10)[:, 1:], series.cells)
            check_mesh(mesh, series, k, suffix)
        return
    reader = pyvista.get_reader(path)
    assert list(reader.time_values) == list(series.t)
    for k, t in enumerate(series.t):
        reader.set_active_time_value(t)
        mesh = reader.read()
        check_mesh(mesh[0] if isinstance(mesh, pyvista.MultiBlock) else mesh, series, k, suffix)


def test_h5py_finds_the_units(result: Result, exported: Callable[[str], Path]) -> None:
    import h5py

    with h5py.File(exported("vtkhdf")) as file:
        root = file["VTKHDF"]
        for group, fields in (("PointData", NODES), ("CellData", ELEMENTS)):
            assert {name: data.attrs["units"] for name, data in root[group].items()} == fields
        np.testing.assert_array_equal(root["Steps/Values"], result.fields.t)
        stored = root["PointData/velocity"][:].reshape(4, -1, 3)
        np.testing.assert_array_equal(stored[:, :, :2], result.fields.nodal["velocity"])


def test_gmsh_reads_mesh_and_views(result: Result, exported: Callable[[str], Path]) -> None:
    import gmsh

    series = result.fields
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.merge(str(exported("msh")))
        tags, points, _ = gmsh.model.mesh.getNodes()
        same(points.reshape(-1, 3)[np.argsort(tags), :2], series.points)
        views = {gmsh.option.getString(f"View[{i}].Name"): tag for i, tag in enumerate(gmsh.view.getTags())}
        assert set(views) == {f"{name} [{UNITS[name]}]" for name in (*NODES, *ELEMENTS)}
        for k in range(4):
            _, _, data, t, _ = gmsh.view.getModelData(views["velocity [m/s]"], k)
            assert t == series.t[k]
            same(np.array(data)[:, :2], series.nodal["velocity"][k])
            _, _, data, _, _ = gmsh.view.getModelData(views["stress_von_mises [Pa]"], k)
            same(np.array(data)[:, 0], series.elemental["stress_von_mises"][k])
    finally:
        gmsh.finalize()


def test_parquet_has_every_bit_and_the_units(result: Result, exported: Callable[[str], Path]) -> None:
    import pyarrow.parquet as pq

    table = pq.read_table(exported("parquet") / "history.parquet")
    assert table.column_names == list(result.history)
    for name, values in result.history.items():
        np.testing.assert_array_equal(table[name].to_numpy(), values)
        assert table.schema.field(name).metadata[b"unit"].decode() == result.history.units[name]
    nodes = pq.read_table(exported("parquet") / "nodes.parquet")
    velocity = result.fields.nodal["velocity"]
    np.testing.assert_array_equal(nodes["velocity_y"].to_numpy(), velocity[:, :, 1].ravel())
    assert nodes.num_rows == velocity.shape[0] * velocity.shape[1]


def test_csv_has_every_bit_and_the_units(result: Result, exported: Callable[[str], Path]) -> None:
    with (exported("csv") / "history.csv").open(newline="") as file:
        names, *rows = csv.reader(file)
    assert names[:4] == ["t [s]", "theta [rad]", "omega [rad/s]", "v_gx [m/s]"]
    np.testing.assert_array_equal([float(row[3]) for row in rows], result.history["v_gx"])
    assert {path.name for path in exported("csv").glob("*.csv")} == {
        "history.csv",
        "rigid.csv",
        "nodes.csv",
        "elements.csv",
    }


def test_the_command_exports_a_result_folder(
    result: Result, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = result.save(tmp_path / "run", pictures=False)
    manifest = json.loads((folder / ".tailslap-result.json").read_text())
    assert "fields.npz" in {entry["path"] for entry in manifest["files"]}
    with pytest.raises(SystemExit) as left:
        main(["export", str(folder), "--to", "vtkhdf"])
    assert left.value.code == 0
    assert capsys.readouterr().out == f"Written: {folder}-vtkhdf/fields.vtkhdf\n"
    assert (tmp_path / "run-vtkhdf" / "fields.vtkhdf").is_file()


@pytest.mark.parametrize("to", FORMATS)
def test_without_fields_there_are_histories_alone(to: str, tmp_path: Path) -> None:
    bare = tailslap.rigid("paper-table-3")
    if to in ("csv", "parquet"):
        folder = tailslap.export(bare, to, tmp_path / to)
        assert [path.name for path in folder.glob("[!.]*")] == [f"rigid.{to}"]
        return
    with pytest.raises(InputError, match=r"output\.fields: given nothing; no fields were kept"):
        tailslap.export(bare, to, tmp_path / to)
    assert not (tmp_path / to).exists()


def test_another_format_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="allowed is one of vtkhdf, xdmf, vtu, msh, csv, parquet"):
        tailslap.export(tailslap.rigid("paper-table-3"), "stl", tmp_path / "x")


def test_without_h5py_the_library_is_named(
    result: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(ImportError, match="VTKHDF needs h5py: `pip install h5py`"):
        tailslap.export(result, "vtkhdf", tmp_path / "x")
    assert not (tmp_path / "x").exists()
