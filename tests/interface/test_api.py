"""Verify that functions of `import tailslap` return the bits of commands."""

import json
import linecache
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import pytest

import tailslap
from fem import FRICTION_LAWS, MATERIALS
from tailslap import InputError, cli
from tailslap.campaign import pools, sweep_run
from tailslap.campaign.sweep_run import StoppedError
from tailslap.campaign.sweep_table import CIRCUMSTANCES
from tailslap.case.resources import available_cores
from tailslap.scene.vary import named

EXTENSIONS = Path(__file__).parents[1] / "extensions"


TIMES = {"setup_s", "time_loop_s", "pictures_s", "integration_s", "estimate_s", "seconds"}


def command(capsys, *arguments):
    assert cli._status(list(arguments)) == 0
    return capsys.readouterr().out


def without_times(value):
    if isinstance(value, dict):
        return {key: without_times(inner) for key, inner in value.items() if key not in TIMES}
    return value


@pytest.fixture(scope="module")
def result():
    return tailslap.run("mash-tl4-sut", {"plate.youngs_modulus": "2 TPa"}, picture_size=(400, 300))


def test_a_run_has_the_bits_of_the_command(result, tmp_path, capsys):
    stiff = ("--set", "plate.youngs_modulus=2 TPa")
    small = ("--picture-size", "400x300")
    command(capsys, "run", "mash-tl4-sut", *stiff, *small, "--out", str(tmp_path / "a"))
    expected = json.loads((tmp_path / "a" / "summary.json").read_text())
    assert without_times(result.summary) == without_times(expected)
    saved = result.save(tmp_path / "b")
    assert {path.name for path in saved.iterdir()} == {path.name for path in (tmp_path / "a").iterdir()}
    for name in ("history.csv", "rigid.csv"):
        assert (saved / name).read_bytes() == (tmp_path / "a" / name).read_bytes()


def test_what_is_loaded_is_what_was_saved(result, tmp_path):
    again = tailslap.load(result.save(tmp_path / "a", pictures=False))
    assert without_times(again.summary) | {"left_out": 0} == without_times(result.summary) | {"left_out": 0}
    for name in result.history:
        np.testing.assert_array_equal(again.history[name], result.history[name])
        np.testing.assert_array_equal(again.rigid[name], result.rigid[name])
    for frame in (again.history, again.rigid):
        assert frame.attrs["units"] == result.history.attrs["units"]
    assert (again.headline, again.passed) == (result.headline, result.passed)
    copied = again.save(tmp_path / "b")
    assert (copied / "history.csv").read_bytes() == (tmp_path / "a" / "history.csv").read_bytes()


def test_scenes_paper_and_new_have_the_bits_of_the_commands(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert tailslap.scenes() == json.loads(command(capsys, "scenes", "--json"))
    report = tailslap.paper()
    assert report.summary == json.loads(command(capsys, "paper", "--json"))
    assert {path.name for path in report.save("a").iterdir()} == {
        p.name for p in Path("results/paper").iterdir()
    }
    assert tailslap.new("one") == Path("one.toml")
    command(capsys, "new", "two")
    assert Path("one.toml").read_text().replace("one", "two", 2) == Path("two.toml").read_text()
    with pytest.raises(InputError, match=r"one.toml exists"):
        tailslap.new("one")


def test_tables_of_changes_are_merged():
    changes = {"impact": {"speed": "20 m/s"}, "plate.thickness": "60 mm"}
    keys = {"impact.speed": 20.0, "plate.thickness": 0.06}
    merged, named = (tailslap.rigid("mash-tl4-sut", table).summary for table in (changes, keys))
    assert merged == named


@pytest.mark.parametrize("scene", ["mash-tl4-sut", "impact-mash-tl4-sut"])
def test_rigid_has_the_bits_of_the_command(scene, capsys):
    result = tailslap.rigid(scene)
    assert result.summary == json.loads(command(capsys, "rigid", scene, "--json"))
    assert f"{result}\n" == command(capsys, "rigid", scene)
    assert result.history["t"][0] == 0.0


def test_check_modal_and_modes_have_the_bits_of_the_commands(tmp_path, capsys):
    scene = "paper-table-3"
    checked = tailslap.check(scene)
    assert f"{checked}\n" == command(capsys, "check", scene)
    assert checked.summary == json.loads(command(capsys, "check", scene, "--json"))
    modal_result = tailslap.modal(scene, modes=2)
    expected = json.loads(command(capsys, "modal", scene, "--modes", "2", "--json"))
    assert without_times(modal_result.summary) == without_times(expected)
    command(capsys, "modes", scene, "--count", "3", "--out", str(tmp_path / "a"))
    summary = json.loads((tmp_path / "a" / "summary.json").read_text())
    assert tailslap.modes(scene, count=3).summary == summary


def test_a_study_has_the_bits_of_the_command(tmp_path, capsys):
    words = ("--samples", "1000", "--range", "impact.friction=0.2:0.5", "--fix", "impact.speed")
    command(capsys, "study", "uncertainty", "mash-tl4-sut", *words, "--out", str(tmp_path / "a"))
    result = tailslap.study(
        "uncertainty", "mash-tl4-sut", samples=1000, range={"impact.friction": "0.2:0.5"},
        fix=["impact.speed"],
    )  # fmt: skip
    expected = json.loads((tmp_path / "a" / "summary.json").read_text())
    assert without_times(result.summary) == without_times(expected)
    saved = result.save(tmp_path / "b")
    pages = [(folder / "report.html").read_text().partition("<footer>") for folder in (saved, tmp_path / "a")]
    assert pages[0][0] == pages[1][0]
    assert "from Python" in pages[0][2]
    assert "<code>tailslap study uncertainty mash-tl4-sut --samples 1000" in pages[1][2]
    assert tailslap.load(saved).command == "study uncertainty"


def test_changes_may_be_texts_as_a_command_takes_them():
    texts = ["impact.speed=50 mph", "impact.friction="]
    with pytest.raises(InputError, match=r"^impact.friction: "):
        tailslap.rigid("mash-tl4-sut", texts)
    result = tailslap.rigid("mash-tl4-sut", texts[:1], units="us")
    assert result.summary == tailslap.rigid("mash-tl4-sut", {"impact.speed": "50 mph"}).summary
    assert "mph" in result.text


def test_without_a_folder_a_sweep_writes_nothing(tmp_path, monkeypatch):
    """Table, sentences and charts are those of a sweep in a folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(pools, "Pool", None)  # no process is started
    values = {"corner.friction": [0.2, 0.3, 0.47]}
    unstored = tailslap.sweep("paper-table-3", values)
    assert list(tmp_path.iterdir()) == []
    stored = tailslap.sweep("paper-table-3", values, folder="kept")
    assert repr(unstored) == repr(stored)
    assert repr(unstored).startswith("<sweep paper-table-3 passed: Peak lateral force at the tail-slap: 65")
    assert [*unstored.tables] == [*stored.tables] != []
    for name in set(unstored.history) - {*CIRCUMSTANCES}:
        np.testing.assert_array_equal(unstored.history[name], stored.history[name])
    assert {f"{name}.svg" for name in unstored.charts} == {path.name for path in Path("kept").glob("*.svg")}
    assert unstored.charts["against-corner-friction-v_gy"]._repr_svg_().startswith("<svg")
    result = {path.name for path in Path("kept").iterdir()} - {"sweep.json", "records.sqlite"}
    assert {path.name for path in unstored.save("saved").iterdir()} == result
    assert tailslap.load("saved").summary["statuses"] == unstored.summary["statuses"]
    assert tailslap.load("saved").history.attrs["units"] == unstored.history.attrs["units"]
    (axes,) = unstored.plot("fe.v_gy").figure.axes
    assert (axes.get_ylabel(), unstored.history.attrs["units"]["rigid.peak_force"]) == ("fe.v_gy [m/s]", "N")
    assert axes.get_xlabel() == "corner.friction"
    assert np.asarray(axes.lines[0].get_xdata()).tolist() == [0.2, 0.3, 0.47]
    spaced = {**unstored.summary, "definition": {"vary": ["corner.friction = 0.2,0.3,0.47"]}}
    (axes,) = replace(unstored, summary=spaced).plot("fe.v_gy").figure.axes
    assert axes.get_xlabel() == "corner.friction"


def test_without_a_folder_a_study_writes_nothing(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    unstored = tailslap.study("uncertainty", "mash-tl4-sut", samples=1000)
    assert list(tmp_path.iterdir()) == []
    stored = tailslap.study("uncertainty", "mash-tl4-sut", samples=1000, folder="kept")
    assert repr(unstored) == repr(stored)
    result = {path.name for path in Path("kept").iterdir()}
    assert {path.name for path in unstored.save("saved").iterdir()} == result
    charts = {path.name for path in Path("kept").glob("*.svg")}
    assert {f"{name}.svg" for name in unstored.charts} == charts != set()


SCRIPT = """
print("begun")
import tailslap
sweep = tailslap.sweep("paper-table-3", {"corner.friction": "0.1:0.5:5"}, {"plate.elements": [6, 2]}, workers=2)
print(sweep.summary["effort"]["threads"], len(sweep.history["run"]), sweep.passed)
"""


def test_a_script_needs_no_guard(tmp_path):
    """Processes do not import the script, which prints its first line once."""
    (tmp_path / "script.py").write_text(SCRIPT)
    process = subprocess.run([sys.executable, "script.py"], cwd=tmp_path, capture_output=True, text=True)
    assert process.stdout.splitlines() == ["begun", f"{min(2, available_cores())} 5 True"], process.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["script.py"]


@pytest.mark.parametrize(("count", "registered", "workers", "expected"), [
    (3, False, None, 0), (4, False, None, None), (4, True, None, 0), (2, False, 2, 2),
])  # fmt: skip
def test_where_the_runs_of_a_sweep_are_made(count, registered, workers, expected, monkeypatch):
    """Up to three, and those with registered objects, are computed here."""
    arguments = []
    noted = lambda definition, place, cluster, workers, *a, **k: arguments.append(workers)  # noqa: E731
    monkeypatch.setattr(sweep_run, "sweep_result", noted)
    law_or_name = law(3.0) if registered else "drag"
    with mock.patch.dict(FRICTION_LAWS):
        values = {"corner.friction": list(np.linspace(0.1, 0.4, count))}
        tailslap.sweep("paper-table-3", values, {"corner.reaction": law_or_name}, workers=workers)
        assert arguments == [expected]
        if registered:
            message = r"corner\.reaction = own is registered in this process only"
            with pytest.raises(InputError, match=message):
                tailslap.sweep("paper-table-3", values, {"corner.reaction": law_or_name}, workers=2)


def test_an_interrupted_sweep_says_that_no_row_is_kept(monkeypatch):
    def interrupted(*arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr(pools, "run_batch", interrupted)
    with pytest.raises(StoppedError, match=r"^interrupted; without a folder no row is kept$"):
        tailslap.sweep("paper-table-3", {"corner.friction": [0.2, 0.47]})


def test_a_scene_may_be_tables_or_a_path(tmp_path):
    from tailslap.scene.read import read_source, scene_text

    tables = read_source("paper-table-3").tables
    path = tmp_path / "own.toml"
    path.write_text(scene_text("paper-table-3"))
    changes = {"vehicle.mass": np.float64(9000.0)}
    summaries = [
        tailslap.rigid(scene, changes).summary for scene in (tables, path, str(path), "paper-table-3")
    ]
    assert all(summary == summaries[0] for summary in summaries)


def law(rounding, name="own"):
    """A friction law of a user, with its own type of constants.

    It is that of tests/extensions.
    """
    module: dict[str, Any] = {"__name__": f"own_{rounding:g}"}
    text = (EXTENSIONS / "smoothed_friction.py").read_text().replace("FRICTION_LAWS.register(LAW)", "")
    text = text.replace('name="smoothed"', f'name="{name}"').replace("= 1.0", f"= {rounding}")
    cell = f"<cell {rounding} {name}>"
    linecache.cache[cell] = (len(text), None, text.splitlines(keepends=True), cell)  # as of a notebook
    exec(compile(text, cell, "exec"), module)
    return module["LAW"]


def test_a_law_of_ones_own_is_an_object():
    first, second = law(1.0), law(2000.0)
    with mock.patch.dict(FRICTION_LAWS):
        near = tailslap.run("paper-table-3", {"corner.reaction": first})
        assert near.passed
        assert FRICTION_LAWS["own"] is first
        limit = 0.47 * np.sqrt(near.history["reaction_normal"] ** 2 + 1.0)
        np.testing.assert_allclose(np.abs(near.history["reaction_tangential"][:-1]), limit[:-1], rtol=1e-12)
        assert named({"corner.reaction": second}) == {"corner.reaction": "own"}
        assert FRICTION_LAWS["own"] is second


def test_objects_that_are_none_are_refused():
    with pytest.raises(InputError, match=r"^corner.reaction: given .*; allowed is a name or a FrictionLaw$"):
        tailslap.run("paper-table-3", {"corner.reaction": MATERIALS["neo-hookean"]})
    with pytest.raises(InputError, match="the program has an object of this name"):
        tailslap.run("paper-table-3", {"corner.reaction": law(1.0, "drag")})
    assert FRICTION_LAWS["drag"].constants.__name__ == "Drag"
