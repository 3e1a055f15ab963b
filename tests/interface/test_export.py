"""Verify that exported files have the values of the run."""

import csv
import functools
import gc
import json
import os
from pathlib import Path

import numpy as np
import pytest

import tailslap
from postprocess.fields import FORMATS
from postprocess.fields.series import ELEMENTS, NODES, UNITS
from postprocess.units import SI
from tailslap.cli import _status
from tailslap.errors import InputError

ROOT = Path(__file__).parents[2]
SINGLE = 2e-7
"""Relative rounding of float32."""


@pytest.fixture(scope="module")
def result():
    changes = {"output.fields": 4, "plate.element": "quad9", "plate.elements": [6, 2]}
    return tailslap.run("paper-table-3", changes)


@pytest.fixture(scope="module")
def exported(result, tmp_path_factory):
    return functools.cache(lambda to: tailslap.export(result, to, tmp_path_factory.mktemp("exported") / to))


def same(values, expected):
    """To float32 of the field's size, or better."""
    np.testing.assert_allclose(values, expected, rtol=SINGLE, atol=SINGLE * np.abs(expected).max())


def check_mesh(mesh, series, k):
    """A mesh of pyvista at one instant, with the names of pages."""
    same(mesh.points[:, :2], series.points)
    for name, values in series.nodal.items():
        exported = mesh.point_data[name]
        same(exported[:, :2], values[k])
        assert not exported[:, 2].any()
    where = series.points + series.nodal["displacement"][k]
    same(mesh.warp_by_vector("displacement").points[:, :2], where)
    for name, values in series.elemental.items():
        same(mesh.cell_data[name], values[k])


@pytest.mark.parametrize("to", ["vtkhdf", "vtu", "xdmf"])
def test_vtk_reads_the_time_series(to, result, exported):
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
            check_mesh(mesh, series, k)
        return
    reader = pyvista.get_reader(path)
    assert list(reader.time_values) == list(series.t)
    for k, t in enumerate(series.t):
        reader.set_active_time_value(t)
        mesh = reader.read()
        check_mesh(mesh[0] if isinstance(mesh, pyvista.MultiBlock) else mesh, series, k)


def test_h5py_finds_the_units(result, exported):
    import h5py

    with h5py.File(exported("vtkhdf")) as file:
        root = file["VTKHDF"]
        for group, fields in (("PointData", NODES), ("CellData", ELEMENTS)):
            assert {name: data.attrs["units"] for name, data in root[group].items()} == fields
        np.testing.assert_array_equal(root["Steps/Values"], result.fields.t)
        stored = root["PointData/velocity"][:].reshape(4, -1, 3)
        np.testing.assert_array_equal(stored[:, :, :2], result.fields.nodal["velocity"])


def test_gmsh_reads_mesh_and_views(result, exported):
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


def test_parquet_has_every_bit_and_the_units(result, exported):
    import pyarrow.parquet as pq

    table = pq.read_table(exported("parquet") / "history.parquet")
    assert table.column_names == list(result.history)
    for name, values in result.history.items():
        np.testing.assert_array_equal(table[name].to_numpy(), values)
        assert table.schema.field(name).metadata[b"unit"].decode() == result.history.attrs["units"][name]
    nodes = pq.read_table(exported("parquet") / "nodes.parquet")
    velocity = result.fields.nodal["velocity"]
    np.testing.assert_array_equal(nodes["velocity_y"].to_numpy(), velocity[:, :, 1].ravel())
    assert nodes.num_rows == velocity.shape[0] * velocity.shape[1]


def test_csv_has_every_bit_and_the_units(result, exported):
    with (exported("csv") / "history.csv").open(newline="") as file:
        names, *rows = csv.reader(file)
    assert names[:4] == ["t [s]", "theta [rad]", "omega [rad/s]", "v_gx [m/s]"]
    np.testing.assert_array_equal([float(row[3]) for row in rows], result.history["v_gx"])
    files = ("history", "rigid", "nodes", "elements")
    assert {path.name for path in exported("csv").glob("*.csv")} == {f"{name}.csv" for name in files}


def test_the_command_exports_a_result_folder(result, tmp_path, capsys):
    folder = result.save(tmp_path / "run", pictures=False)
    manifest = json.loads((folder / ".tailslap-result.json").read_text())
    assert "fields.npz" in {entry["path"] for entry in manifest["files"]}
    assert _status(["export", str(folder), "--to", "vtkhdf"]) == 0
    assert capsys.readouterr().out == f"Written: {folder}-vtkhdf/fields.vtkhdf\n"
    assert (tmp_path / "run-vtkhdf" / "fields.vtkhdf").is_file()


@pytest.mark.parametrize("to", FORMATS)
def test_without_fields_there_are_histories_alone(to, tmp_path):
    bare = tailslap.rigid("paper-table-3")
    if to in ("csv", "parquet"):
        folder = tailslap.export(bare, to, tmp_path / to)
        assert [path.name for path in folder.glob("[!.]*")] == [f"rigid.{to}"]
        return
    with pytest.raises(InputError, match=r"output\.fields: given no value; the result has no fields"):
        tailslap.export(bare, to, tmp_path / to)
    assert not (tmp_path / to).exists()


def test_pictures_of_all_instants_have_one_scale(result, tmp_path):
    """Colours are those of the values, and GIFs have all instants."""
    import matplotlib.image
    from PIL import Image

    folder = tailslap.export(
        result, "png", tmp_path / "png", field="velocity_y", magnify=1000.0, picture_size="400x300"
    )
    names = [path.name for path in sorted(folder.glob("*.png"))]
    assert names == [f"velocity_y_{k:04d}.png" for k in range(4)]
    assert all(matplotlib.image.imread(path).std() > 0.05 for path in folder.glob("*.png"))
    moving = tailslap.export(
        result, "gif", tmp_path / "gif", field="stress_von_mises", picture_size="400x300"
    )
    with Image.open(moving / "stress_von_mises.gif") as image:
        assert getattr(image, "n_frames", 1) == 4
    with pytest.raises(InputError, match=r"allowed is one of\s+displacement_x"):
        tailslap.export(result, "gif", tmp_path / "x", field="colour")


@pytest.mark.parametrize("to", ["png", "gif"])
def test_pictures_are_counted_while_they_are_drawn(to, result, tmp_path):
    from tailslap.progress import followed

    lines: list[str] = []
    with followed(lines.append):
        tailslap.export(result, to, tmp_path / to, field="velocity_y", picture_size="400x300")
    assert [line.partition(",")[0] for line in lines] == [f"Drawing pictures: {k} of 4" for k in range(1, 5)]


@pytest.mark.parametrize("name", ["stress_von_mises", "velocity_y"])
def test_a_picture_shows_values_where_the_plate_is(name, result, tmp_path):
    """The middle of an element has its colour on the common scale."""
    import matplotlib as mpl
    from matplotlib.image import imread

    from postprocess.fields.contours import SIZE, colour_scale, draw_instants, view_of_plate

    series = result.fields
    (path,) = draw_instants(tmp_path, series, name, 500.0, [-1])
    assert path.name == f"{name}_0003.png"
    elastic = series.nodal["elastic_displacement"]
    places = series.points + series.nodal["displacement"] + 499.0 * elastic
    np.testing.assert_allclose(series.places(500.0), places, rtol=1e-15)
    values, scale = series.scalar(name), colour_scale(series.scalar(name))
    corners = series.cells[:, :4]
    at = values[-1] if name in ELEMENTS else values[-1][corners].mean(axis=1)
    part = (at - scale.low) / (scale.high - scale.low)
    inside = np.abs(part * scale.bands - np.rint(part * scale.bands)) > 0.02
    assert inside.sum() > 8
    middles = view_of_plate(places.reshape(-1, 2)).pixel(places[-1][corners].mean(axis=1))
    column, row = np.floor(middles[inside]).astype(int).T
    expected = mpl.colormaps["viridis"].resampled(scale.bands)(part[inside])[:, :3]
    np.testing.assert_allclose(imread(path)[SIZE[1] - 1 - row, column, :3], expected, atol=6 / 255)


def test_scalars_are_components_sizes_and_fields_of_elements(result):
    series = result.fields
    velocity = series.nodal["velocity"]
    np.testing.assert_allclose(series.scalar("velocity"), np.hypot(velocity[..., 0], velocity[..., 1]))
    np.testing.assert_array_equal(series.scalar("velocity_y"), velocity[..., 1])
    np.testing.assert_array_equal(series.scalar("stress_principal_1"), series.elemental["stress_principal_1"])
    for name in ("velocity_z", "colour", "stress_von_mises_x"):
        with pytest.raises(KeyError):
            series.scalar(name)


def test_mesh_is_a_grid_of_pyvista_with_the_fields(result):
    series = result.fields
    for t, k in ((None, 3), (0.0, 0), (0.6 * series.t[1], 1), (99.0, 3)):
        mesh = result.mesh(t)
        assert mesh.field_data["t"] == series.t[k]
        check_mesh(mesh, series, k)
        np.testing.assert_array_equal(mesh["velocity_y"], series.nodal["velocity"][k, :, 1])
    moved = mesh.warp_by_vector("displacement").points[:, :2]
    same(moved, series.points + series.nodal["displacement"][3])
    assert (mesh.celltypes == 28).all()
    assert mesh.compute_cell_sizes()["Area"].sum() == pytest.approx(10.0 * 2.438)


def test_without_fields_there_is_the_mesh_at_the_tail_slap(tmp_path):
    """The same fields as those of a run that keeps them."""
    changes = {"plate.elements": [6, 2]}
    bare = tailslap.run("paper-table-3", changes)
    stored = tailslap.run("paper-table-3", changes | {"output.fields": 3}).mesh()
    mesh = bare.mesh()
    np.testing.assert_array_equal(mesh.points, stored.points)
    assert {*mesh.array_names} == {*stored.array_names} >= {*NODES, *ELEMENTS, "velocity_x"}
    for name in mesh.array_names:
        np.testing.assert_array_equal(mesh[name], stored[name])
    loaded = tailslap.load(bare.save(tmp_path / "run", pictures=False))
    for without in (lambda: bare.mesh(0.1), loaded.mesh, tailslap.rigid("paper-table-3").mesh):
        with pytest.raises(
            InputError, match=r"run the scene with --set output\.fields=20 \(Python: \{'output"
        ):
            without()


MEMORY = """
import ctypes, gc, resource, sys
from pathlib import Path
import numpy as np
from postprocess.fields.contours import ContourField, Situation, draw_contours, draw_instants
from postprocess.fields.series import ELEMENTS, NODES, FieldSeries
x, y = np.meshgrid(np.linspace(0, 10, 21), np.linspace(1, 3.4, 7))
points = np.column_stack([x.ravel(), y.ravel()])
first = (np.arange(20) + 21 * np.arange(6)[:, None]).ravel()
cells = np.column_stack([first, first + 1, first + 22, first + 21])
{setup}
def used():
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)  # what is freed but not given back is no growth: it is used again
    return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize() / 1e6
for _ in range(3):
    draw()
before = used()
for _ in range({count}):
    draw()
print(used() - before)
"""
FIELDS = """
nodal = {name: np.random.default_rng(1).random((2, 147, 2)) for name in NODES}
series = FieldSeries("quad", points, cells, np.arange(2.0), nodal, {name: np.ones((2, 120)) for name in ELEMENTS})
draw = lambda: draw_instants(Path(), series, "velocity_y")
"""
CONTOURS = """
draw = lambda: draw_contours(Situation((points, cells)), [ContourField("v", "V", "m/s", points[:, 0])], Path())
"""


@pytest.mark.parametrize(("setup", "count"), [
    pytest.param(FIELDS, 50, id="100 fields"),
    pytest.param(CONTOURS, 100, id="101 contours"),
])  # fmt: skip
@pytest.mark.long
def test_memory_of_many_pictures_is_flat(setup, count, tmp_path, python, proc):
    """A hundred pictures need at most 20 MB more than three."""
    code = MEMORY.format(setup=setup, count=count)
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    assert float(python(code, check=True, env=environment, cwd=tmp_path).stdout) < 20.0


def test_pictures_of_instants_leave_no_meshes(result):
    """A command collects garbage rarely."""
    import pyvista

    from postprocess.fields.contours import frames

    gc.collect()
    gc.disable()
    try:
        pictures = frames(result.fields, "velocity_y", 1.0, [0, 1, 0, 1], SI, (400, 300))
        counts = [sum(pyvista.PolyData in type(item).__mro__ for item in gc.get_objects()) for _ in pictures]
    finally:
        gc.enable()
    assert counts == counts[:1] * 4


def test_exports_of_changed_scenes_have_folders_of_their_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for changes in ({}, {"vehicle.mass": "9 t"}):
        tailslap.export(tailslap.rigid("mash-tl4-sut", changes), "csv")
    names = sorted(path.name for path in Path("results").iterdir())
    assert names == ["mash-tl4-sut+vehicle.mass=9t-csv", "mash-tl4-sut-csv"]
