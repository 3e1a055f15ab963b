"""Verify pages, plots, pictures and data frames of Python results."""

import sys

import numpy as np
import pytest
from chart_samples import samples
from PIL import Image

import tailslap
from postprocess.fields import contours
from postprocess.units import number
from tailslap import Columns, InputError


@pytest.fixture(scope="module")
def result():
    return tailslap.run("mash-tl4-sut", {"plate.youngs_modulus": "2 TPa"})


@pytest.mark.parametrize(("scene", "group", "name"), [
    ("mash-tl4-sut", "stage3", "peak_force"), ("impact-mash-tl4-sut", "peaks", "mean_50ms"),
])  # fmt: skip
def test_the_rigid_force_stands_beside_the_design_forces(scene, group, name):
    """The chart of the force has the impulse as its area.

    Forces of AASHTO and MASH are in a table with the ratio.
    """
    result = tailslap.rigid(scene)
    assert list(result.charts) == ["force", "set-up"]
    computed, *others = result.tables["Design forces"].rows
    mash, aashto = (next(row for row in others if name in row["name"]) for name in ("(TTI)", "AASHTO"))
    of_triangle = 0.75 if name == "peak_force" else 1.0  # mean of 100 ms over the middle 50 ms
    assert computed["force"] == pytest.approx(of_triangle * result.summary[group][name])
    assert mash["force"] == pytest.approx(80.0 * 4448.2216, rel=1e-6)  # TTI 9-1002-5, TL-4: 80 kip
    assert aashto["force"] == pytest.approx(54.0 * 4448.2216, rel=1e-6)  # AASHTO LRFD A13.2-1, TL-4: 54 kip
    assert mash["ratio"] == pytest.approx(computed["force"] / mash["force"])
    assert ("Strikes" in result.tables) == (scene != "mash-tl4-sut")
    raw = samples(result.charts["force"])[0]
    drawn = np.array([raw.at, raw.values], dtype=float).T
    assert (raw.where, raw.heading) == ("t [s]", "raw: force on the wall [kN]")
    if scene == "mash-tl4-sut":
        pulse = drawn[drawn[:, 0] > result.summary["stage2"]["t"]]
        impulse = result.summary["stage3"]["impulse"]
        assert np.trapezoid(pulse[:, 1], pulse[:, 0]) * 1e3 == pytest.approx(impulse, rel=2e-3)


def test_a_result_is_a_line_a_page_and_a_plot(result, tmp_path):
    assert repr(result).startswith("<run mash-tl4-sut passed: ")
    assert "\n" not in repr(result)
    html = result._repr_html_()
    for value in (result.summary["fe"]["v_gy"], result.summary["rigid"]["t"]):
        assert f"<td>{number(value)}</td>" in html
    plot = result.plot("v_gy")
    (axes,) = plot.figure.axes
    assert axes.get_ylabel() == "v_gy [m/s]"
    drawn = {line.get_label(): line.get_ydata() for line in axes.lines}
    np.testing.assert_array_equal(drawn["FE"], result.history["v_gy"])
    np.testing.assert_array_equal(drawn["rigid"], result.rigid["v_gy"])
    for ending, start in ((".png", b"\x89PNG"), (".svg", b"<?xml"), (".pdf", b"%PDF")):
        assert plot.save(tmp_path / f"plot{ending}").read_bytes().startswith(start)
    with pytest.raises(InputError, match=r"allowed are\s+t, theta"):
        result.plot("colour")


def test_a_field_is_a_picture(result, tmp_path):
    """The pixels are those that `export` writes in few colours.

    The scale and view are of the instant; v_gy is the velocity across the wall.
    """
    with_fields = tailslap.run("mash-tl4-sut", {"plate.youngs_modulus": "2 TPa", "output.fields": 2})
    for k, t in ((0, 0.0), (1, None)):
        (path,) = contours.draw_instants(tmp_path, with_fields.fields.at(k), "velocity_y")
        exported = Image.open(path).convert("RGB")
        assert (
            with_fields.plot_field("v_gy", t).quantize(contours.COLOURS).convert("RGB").tobytes()
            == exported.tobytes()
        )
    assert result.plot_field("stress_von_mises").size == with_fields.plot_field("velocity_y").size
    assert result.plot_field("v_gx").tobytes() != result.plot_field("v_gy").tobytes()
    with pytest.raises(InputError, match=r"did you mean stress_von_mises\?"):
        result.plot_field("von_mises")
    with pytest.raises(InputError, match="the result has no fields"):
        tailslap.rigid("mash-tl4-sut").plot_field("v_gy")


def test_what_failed_is_told():
    result = tailslap.run("paper-table-3", {"verify.tolerance": 1e-9})
    assert not result.passed
    assert repr(result).startswith("<run paper-table-3 FAILED: ")
    assert "agreement with rigid motion" in result._repr_html_() or "Failed check" in result._repr_html_()


def test_a_history_is_a_data_frame(result):
    pandas = pytest.importorskip("pandas")
    both = (result.history, result.histories["FE"]), (result.rigid, result.histories["rigid"])
    for frame, columns in both:
        assert isinstance(frame, pandas.DataFrame)
        assert frame.attrs["units"] == columns.units
        for table in (frame, pandas.DataFrame(frame), pandas.DataFrame(columns)):
            assert list(table) == list(columns)
            np.testing.assert_array_equal(table.to_numpy(), np.column_stack(list(columns.values())))


def test_without_pandas_a_history_behaves_like_one_column_by_column(result, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    history = tailslap.rigid("mash-tl4-sut").history
    assert isinstance(history, Columns)
    assert list(history.columns) == list(history) == list(tailslap.rigid("mash-tl4-sut").rigid)
    assert (history["t"][0], history.attrs["units"]["v_gy"], "v_gy" in history) == (0.0, "m/s", True)
    with pytest.raises(KeyError, match=r"columns are t, .*; did you mean v_gy\?"):
        history["v_gz"]


def test_columns_say_what_is_missing(result, monkeypatch):
    for library in ("pandas", "polars"):
        monkeypatch.setitem(sys.modules, library, None)
        with pytest.raises(ImportError, match=f"{library} is not installed: `pip install {library}`"):
            getattr(result.histories["FE"], f"to_{library}")()


@pytest.mark.parametrize("library", ["pandas", "polars"])
def test_columns_are_those_of_a_real_data_frame(result, library):
    """Histories, and columns of words and integers of sweeps."""
    pytest.importorskip(library)
    mixed = Columns({"run": np.arange(2), "status": np.array(["passed", ""], dtype=object)}, {})
    for columns in (*result.histories.values(), mixed):
        frame = getattr(columns, f"to_{library}")()
        assert list(frame.columns) == list(columns)
        for name in columns:
            assert frame[name].to_list() == columns[name].tolist()


def test_every_column_has_its_unit(result):
    impact = tailslap.rigid("impact-mash-tl4-sut")
    for columns in (*result.histories.values(), *impact.histories.values()):
        assert [name for name in columns if name not in columns.units] == []


def test_records_are_frozen(result):
    with pytest.raises(AttributeError):
        result.scene = "another"
