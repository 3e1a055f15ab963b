"""Verification: the functions of `import tailslap` return the bits of the commands, and are described."""

import csv
import doctest
import importlib
import inspect
import io
import json
import os
import pydoc
import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any, get_type_hints

import numpy as np
import pytest
from PIL import Image

import tailslap
from fem import FRICTION_LAWS, MATERIALS
from postprocess.fields import contours
from postprocess.units import number
from tailslap import Columns, InputError, cli
from tailslap.campaign import pools, sweep_run
from tailslap.campaign.sweep_run import StoppedError
from tailslap.campaign.sweep_table import CIRCUMSTANCES
from tailslap.case.resources import available_cores
from tailslap.scene.vary import named

EXTENSIONS = Path(__file__).parents[1] / "extensions"
FUNCTIONS = (
    *("check", "compare", "confirm", "export", "load", "modal", "modes", "new", "paper", "rigid", "run"),
    *("scenes", "study", "sweep", "validate"),
)
TIMES = {"setup_s", "time_loop_s", "pictures_s", "integration_s", "estimate_s", "seconds"}
SECTIONS = ("Parameters", "Returns", "Raises", "Examples")
TAKES_NOTHING = ("Returns", "Examples")
"""Sections of a function without parameters, which no input makes fail."""


def command(capsys, *arguments):
    assert cli._status(list(arguments)) == 0
    return capsys.readouterr().out


def without_times(value):
    if isinstance(value, dict):
        return {key: without_times(inner) for key, inner in value.items() if key not in TIMES}
    return value


@pytest.fixture(scope="module")
def result():
    return tailslap.run("mash-tl4-sut", {"plate.youngs_modulus": "2 TPa"})


def test_import_loads_nothing():
    code = "import sys, tailslap; dir(tailslap); print(*sys.modules)"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not {"numpy", "pydantic", "click", "tailslap.errors"} & set(run.stdout.split())


def test_a_run_has_the_bits_of_the_command(result, tmp_path, capsys):
    stiff = ("--set", "plate.youngs_modulus=2 TPa")
    command(capsys, "run", "mash-tl4-sut", *stiff, "--out", str(tmp_path / "a"))
    expected = json.loads((tmp_path / "a" / "summary.json").read_text())
    assert without_times(result.summary) == without_times(expected)
    saved = result.save(tmp_path / "b")
    assert {path.name for path in saved.iterdir()} == {path.name for path in (tmp_path / "a").iterdir()}
    for name in ("history.csv", "rigid.csv"):
        assert (saved / name).read_bytes() == (tmp_path / "a" / name).read_bytes()


def test_a_whole_impact_has_the_bits_of_the_command(tmp_path, capsys):
    result = tailslap.run("impact-mash-tl4-sut", {"plate.elements": (10, 3), "time.end": "0.4 s"})
    words = ("--set", "plate.elements=[10,3]", "--set", "time.end=0.4 s", "--no-pictures")
    command(capsys, "run", "impact-mash-tl4-sut", *words, "--out", str(tmp_path / "a"))
    expected = json.loads((tmp_path / "a" / "summary.json").read_text())
    mine, theirs = without_times(result.summary), without_times(expected)
    assert theirs.pop("left_out") != mine.pop("left_out")  # the pictures
    assert mine == theirs
    saved = result.save(tmp_path / "b", pictures=False)
    assert (saved / "history.csv").read_bytes() == (tmp_path / "a" / "history.csv").read_bytes()


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


def test_names_are_listed_for_completion():
    assert {"run", "rigid", "sweep", "load", "InputError"} <= set(dir(tailslap)) == set(tailslap.__all__)


def test_help_begins_with_the_functions():
    """Each with a line, above the classes; and the name of no file, which an installation may not have."""
    page = pydoc.plain(pydoc.render_doc(tailslap))
    opening = page[: page.index("PACKAGE CONTENTS")]
    assert [name for name in FUNCTIONS if not re.search(rf"^ +{name}  +\w.*", opening, re.MULTILINE)] == []
    assert not re.search(r"\w\.(md|py|html)\b", opening)


def test_editors_and_type_checkers_see_the_names(tmp_path):
    """From the stub, without running anything: a function's result, and a name that is wrong."""
    lines = (
        "import tailslap", "reveal_type(tailslap.scenes())", "tailslap.run('a').history['v_gy'].rolling(5)",
    )  # fmt: skip
    code = "\n".join((*lines, "tailslap.walk()", ""))
    (tmp_path / "a.py").write_text(code)
    command = [sys.executable, "-m", "mypy", "--config-file=", "--follow-imports=silent", "a.py"]
    process = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert 'note: Revealed type is "dict[str, str]"' in process.stdout.replace("builtins.", "")
    assert 'error: Module has no attribute "walk"' in process.stdout
    assert '"rolling"' not in process.stdout, "columns have the methods of a series of pandas"


UNTYPED: Any = tailslap
"""The package for calls that a type checker refuses too."""


@pytest.mark.parametrize(("call", "kind", "hint"), [
    (lambda: UNTYPED.run("paper-table-3", tolerence=1e-3), TypeError, "tolerance"),
    (lambda: UNTYPED.sweep("paper-table-3", {}, foldr="x"), TypeError, "folder"),
    (lambda: tailslap.rigid("paper-table3"), InputError, "paper-table-3"),
    (lambda: tailslap.rigid("mash-tl4-sut", {"impact": {"sped": 20.0}}), InputError, "impact.speed"),
    (lambda: tailslap.rigid("mash-tl4-sut", {"mass": 20.0}), InputError, "vehicle.mass"),
    (lambda: tailslap.rigid("mash-tl4-sut").plot("v_gz"), InputError, "v_gy"),
    (lambda: tailslap.study("uncertanty", "mash-tl4-sut"), InputError, "uncertainty"),
    (lambda: tailslap.study("uncertainty", "mash-tl4-sut", sample=9), InputError, "samples"),
    (lambda: tailslap.export(tailslap.rigid("mash-tl4-sut"), "cvs"), InputError, "csv"),
    (lambda: tailslap.compare(*2 * [tailslap.rigid("mash-tl4-sut")], only=["v_gys"]), InputError, "v_gy"),
])  # fmt: skip
def test_wrong_names_get_the_nearest(call, kind, hint):
    with pytest.raises(kind, match=rf"; did you mean {re.escape(hint)}\?$"):
        call()


METHODS = tuple(getattr(tailslap.Result, name) for name in ("mesh", "plot", "plot_field", "save"))
TAKEN = [
    (function, name)
    for function in (*(getattr(tailslap, name) for name in FUNCTIONS), *METHODS)
    for name in inspect.signature(function).parameters
    if name not in ("self", "options")
]
VALID = {"scene": "mash-tl4-sut", "name": "uncertainty", "vary": {"impact.speed": [20.0]}, "to": "csv"}
"""Valid values of arguments without default."""


@pytest.mark.parametrize(("function", "name"), TAKEN, ids=lambda part: getattr(part, "__qualname__", part))
@pytest.mark.parametrize("wrong", [object(), b"x", 1j])
def test_an_argument_of_another_type_is_refused_by_its_name(function, name, wrong):
    parameters = inspect.signature(function).parameters
    options = {other: VALID[other] for other in parameters if other in VALID}
    several = parameters[name].kind is inspect.Parameter.VAR_POSITIONAL
    with pytest.raises(InputError) as caught:
        function("x", wrong) if several else function(**options | {name: wrong})
    assert (caught.value.key, caught.value.given) == (name, repr(wrong))
    assert re.search(rf"^ *\*?{name} : {re.escape(caught.value.allowed.removeprefix('allowed is '))}$",
                     inspect.getdoc(function) or "", re.MULTILINE)  # fmt: skip


@pytest.mark.parametrize(("call", "key"), [
    (lambda: UNTYPED.new("\0"), "name"), (lambda: UNTYPED.new("\ud800"), "name"),
    (lambda: UNTYPED.new("\1"), "name"),
    (lambda: UNTYPED.load("\0"), "folder"), (lambda: UNTYPED.load(Path("\0")), "folder"),
    (lambda: UNTYPED.load("\ud800"), "folder"),
    (lambda: UNTYPED.rigid("mash-tl4-sut", [("impact.speed",)]), "changes"),
    (lambda: UNTYPED.rigid("mash-tl4-sut", "impact.speed=20"), "changes"),
    (lambda: UNTYPED.rigid("mash-tl4-sut", {3: 20.0}), "changes"),
    (lambda: UNTYPED.rigid("mash-tl4-sut", units="imperial"), "units"),
    (lambda: UNTYPED.sweep("mash-tl4-sut", {"impact.speed": 20.0}), "vary"),
    (lambda: UNTYPED.run("mash-tl4-sut", tolerance="1 %"), "tolerance"),
    (lambda: UNTYPED.run("mash-tl4-sut", tolerance=True), "tolerance"),
])  # fmt: skip
def test_what_no_argument_can_be_is_refused_by_its_name(call, key):
    with pytest.raises(InputError) as caught:
        call()
    assert caught.value.key == key


def test_numbers_and_rows_of_numpy_are_taken():
    changes = np.array(["impact.speed=56 mph"])
    assert UNTYPED.modes("paper-table-3", count=np.int64(1)).summary["modes"]
    assert UNTYPED.rigid("mash-tl4-sut", changes).summary == tailslap.rigid("mash-tl4-sut").summary


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


def test_a_run_shows_its_force():
    result = tailslap.run("mash-tl4-sut", {"impact": {"speed": "20 m/s"}})
    force = result.summary["peak_force"]["fe"] / 1e3
    assert f"Peak lateral force at the tail-slap: {force:.0f} kN (90 % of such impacts: " in repr(result)


def test_the_headline_of_a_whole_impact_has_units():
    """Those that people read, not the form in which a page keeps quantities."""
    result = tailslap.run("impact-mash-tl4-sut", {"plate.elements": [8, 2]})
    force = result.summary["fe"]["peaks"]["mean_50ms"]
    assert result.headline.answer.startswith(
        f"Largest 50 ms mean of the lateral force: {force / 1e3:.0f} kN (90 % of such impacts: "
    )
    assert "".join(result.headline.lines).isprintable()
    assert str(result).startswith(result.headline.answer[:60])


def test_another_scenes_result_is_replaced_by_force_alone(tmp_path):
    one, other = tailslap.rigid("mash-tl4-sut"), tailslap.rigid("paper-table-3")
    one.save(tmp_path / "a")
    again = tailslap.load(one.save(tmp_path / "a"))
    assert (again.command, again.summary) == ("rigid", one.summary)
    np.testing.assert_array_equal(again.rigid["v_gy"], one.rigid["v_gy"])
    with pytest.raises(InputError, match="the folder contains the result of `tailslap rigid mash-tl4-sut`"):
        other.save(tmp_path / "a")
    assert tailslap.load(other.save(tmp_path / "a", force=True)).scene == "paper-table-3"


@pytest.mark.parametrize("scene", ["mash-tl4-sut", "impact-mash-tl4-sut"])
def test_rigid_has_the_bits_of_the_command(scene, capsys):
    result = tailslap.rigid(scene)
    assert result.summary == json.loads(command(capsys, "rigid", scene, "--json"))
    assert f"{result}\n" == command(capsys, "rigid", scene)
    assert result.history["t"][0] == 0.0


@pytest.mark.parametrize(("scene", "group", "name"), [
    ("mash-tl4-sut", "stage3", "peak_force"), ("impact-mash-tl4-sut", "peaks", "mean_50ms"),
])  # fmt: skip
def test_the_rigid_force_stands_beside_the_design_forces(scene, group, name):
    """As a chart over time, whose area over the tail-slap is its impulse, and over each force of AASHTO and MASH."""
    result = tailslap.rigid(scene)
    assert list(result.charts) == ["force", "set-up"]
    computed, mash, *_, aashto = result.tables["Design forces"].rows
    of_triangle = 0.75 if name == "peak_force" else 1.0  # mean of 100 ms over the middle 50 ms
    assert computed["force"] == pytest.approx(of_triangle * result.summary[group][name])
    assert mash["force"] == pytest.approx(80.0 * 4448.2216, rel=1e-6)  # TTI 9-1002-5, TL-4: 80 kip
    assert aashto["force"] == pytest.approx(54.0 * 4448.2216, rel=1e-6)  # AASHTO LRFD A13.2-1, TL-4: 54 kip
    assert mash["ratio"] == pytest.approx(computed["force"] / mash["force"])
    assert ("Strikes" in result.tables) == (scene != "mash-tl4-sut")
    header, *lines = csv.reader(io.StringIO(result.charts["force"].csv))
    drawn = np.array([row[:2] for row in lines if row[0]], dtype=float)
    assert header[:2] == ["t [s]", "raw: force on the wall [kN]"]
    if scene == "mash-tl4-sut":
        pulse = drawn[drawn[:, 0] > result.summary["stage2"]["t"]]
        impulse = result.summary["stage3"]["impulse"]
        assert np.trapezoid(pulse[:, 1], pulse[:, 0]) * 1e3 == pytest.approx(impulse, rel=2e-3)


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


@pytest.mark.parametrize(("options", "why"), [
    ({"samples": 1000.5}, "1000.5 is not a whole number"), ({"samples": 3}, "3 is not in the range"),
    ({"colour": "red"}, "allowed are samples, range, fix"),
])  # fmt: skip
def test_options_of_a_study_have_the_bounds_of_the_command(options, why):
    with pytest.raises(InputError, match=why):
        tailslap.study("uncertainty", "mash-tl4-sut", **options)


def test_changes_may_be_texts_as_a_command_takes_them():
    texts = ["impact.speed=50 mph", "impact.friction="]
    with pytest.raises(InputError, match=r"^impact.friction: "):
        tailslap.rigid("mash-tl4-sut", texts)
    result = tailslap.rigid("mash-tl4-sut", texts[:1], units="us")
    assert result.summary == tailslap.rigid("mash-tl4-sut", {"impact.speed": "50 mph"}).summary
    assert "mph" in result.text


def test_a_sweep_has_a_row_a_run(tmp_path):
    values = {"corner.friction": [0.2, 0.47]}
    result = tailslap.sweep("paper-table-3", values, folder=tmp_path / "s", workers=1)
    assert list(result.history["corner.friction"]) == [0.2, 0.47]
    assert (set(result.history["status"]), len(tailslap.load(tmp_path / "s").history["run"])) == (
        {"passed"},
        2,
    )


def test_without_a_folder_a_sweep_writes_nothing(tmp_path, monkeypatch):
    """Table, sentences and charts are those of a sweep in a folder, and `save` writes its files."""
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
    assert (axes.get_xlabel(), np.asarray(axes.lines[0].get_xdata()).tolist()) == (
        "corner.friction",
        [0.2, 0.3, 0.47],
    )


def test_without_a_folder_a_study_writes_nothing(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    unstored = tailslap.study("uncertainty", "mash-tl4-sut", samples=1000)
    assert list(tmp_path.iterdir()) == []
    stored = tailslap.study("uncertainty", "mash-tl4-sut", samples=1000, folder="kept")
    assert repr(unstored) == repr(stored)
    assert {path.name for path in unstored.save("saved").iterdir()} == {
        p.name for p in Path("kept").iterdir()
    }
    assert (
        {f"{name}.svg" for name in unstored.charts}
        == {path.name for path in Path("kept").glob("*.svg")}
        != set()
    )


SCRIPT = """
print("begun")
import tailslap
found = tailslap.sweep("paper-table-3", {"corner.friction": "0.1:0.5:5"}, {"plate.elements": [6, 2]}, workers=2)
print(found.summary["effort"]["threads"], len(found.history["run"]), found.passed)
"""


def test_a_script_needs_no_guard(tmp_path):
    """Processes do not import it: its first line is printed once."""
    (tmp_path / "script.py").write_text(SCRIPT)
    process = subprocess.run([sys.executable, "script.py"], cwd=tmp_path, capture_output=True, text=True)
    assert process.stdout.splitlines() == ["begun", f"{min(2, available_cores())} 5 True"], process.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["script.py"]


@pytest.mark.parametrize(("count", "own", "workers", "expected"), [
    (3, False, None, 0), (4, False, None, None), (4, True, None, 0), (2, False, 2, 2),
])  # fmt: skip
def test_where_the_runs_of_a_sweep_are_made(count, own, workers, expected, monkeypatch):
    """Up to three, and those with an object of one's own, in this process."""
    arguments = []
    monkeypatch.setattr(
        sweep_run,
        "sweep_result",
        lambda definition, place, cluster, workers, *a, **k: arguments.append(workers),
    )
    reaction = law(3.0) if own else "drag"
    try:
        values = {"corner.friction": list(np.linspace(0.1, 0.4, count))}
        tailslap.sweep("paper-table-3", values, {"corner.reaction": reaction}, workers=workers)
        assert arguments == [expected]
        if own:
            with pytest.raises(
                InputError, match=r"corner\.reaction = own is registered in this process only"
            ):
                tailslap.sweep("paper-table-3", values, {"corner.reaction": reaction}, workers=2)
    finally:
        FRICTION_LAWS.pop("own", None)


def test_an_interrupted_sweep_says_that_no_row_is_kept(monkeypatch):
    def interrupted(*given):
        raise KeyboardInterrupt

    monkeypatch.setattr(pools, "run_batch", interrupted)
    with pytest.raises(StoppedError, match=r"^interrupted; without a folder no row is kept$"):
        tailslap.sweep("paper-table-3", {"corner.friction": [0.2, 0.47]})


def test_a_scene_may_be_tables_or_a_path(tmp_path):
    from tailslap.scene.read import read_source, scene_text

    tables = read_source("paper-table-3").given
    path = tmp_path / "own.toml"
    path.write_text(scene_text("paper-table-3"))
    changes = {"vehicle.mass": np.float64(9000.0)}
    summaries = [
        tailslap.rigid(scene, changes).summary for scene in (tables, path, str(path), "paper-table-3")
    ]
    assert all(summary == summaries[0] for summary in summaries)


def law(rounding, name="own"):
    """A friction law that a user has written: as in tests/extensions, with its own type of constants."""
    module: dict[str, Any] = {"__name__": f"own_{rounding:g}"}
    text = (EXTENSIONS / "smoothed_friction.py").read_text().replace("FRICTION_LAWS.register(LAW)", "")
    text = text.replace('name="smoothed"', f'name="{name}"').replace("= 1.0", f"= {rounding}")
    exec(compile(text, f"<cell {rounding}>", "exec"), module)
    return module["LAW"]


def test_a_law_of_ones_own_is_an_object():
    first, second = law(1.0), law(2000.0)
    try:
        near = tailslap.run("paper-table-3", {"corner.reaction": first})
        assert near.passed
        assert FRICTION_LAWS["own"] is first
        limit = 0.47 * np.sqrt(near.history["reaction_normal"] ** 2 + 1.0)
        np.testing.assert_allclose(np.abs(near.history["reaction_tangential"][:-1]), limit[:-1], rtol=1e-12)
        assert named({"corner.reaction": second}) == {"corner.reaction": "own"}
        assert FRICTION_LAWS["own"] is second
    finally:
        FRICTION_LAWS.pop("own")


def test_objects_that_are_none_are_refused():
    with pytest.raises(InputError, match=r"^corner.reaction: given .*; allowed is a name or a FrictionLaw$"):
        tailslap.run("paper-table-3", {"corner.reaction": MATERIALS["neo-hookean"]})
    with pytest.raises(InputError, match="the program has an object of this name"):
        tailslap.run("paper-table-3", {"corner.reaction": law(1.0, "drag")})
    assert FRICTION_LAWS["drag"].constants.__name__ == "Drag"


@pytest.mark.parametrize("change", [("plate.colour", 1), ("vehicle.mass", "9 m")])
def test_wrong_input_names_its_key(change, refused):
    assert refused(tailslap.run, "paper-table-3", dict([change])) == change[0]


def test_unusual_numbers_are_remarked_upon():
    with pytest.warns(UserWarning, match=r"impact.speed = 56 without a unit is 56 m/s"):
        tailslap.rigid("mash-tl4-sut", {"impact.speed": 56})


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
    """The pixels of those that `export` writes in 256 colours, with the scale and view of its instant; v_gy is the
    velocity across the wall."""
    with_fields = tailslap.run("mash-tl4-sut", {"plate.youngs_modulus": "2 TPa", "output.fields": 2})
    for k, t in ((0, 0.0), (1, None)):
        (path,) = contours.draw_instants(tmp_path, with_fields.fields.at(k), "velocity_y")
        exported = Image.open(path).convert("RGB")
        assert with_fields.plot_field("v_gy", t).quantize(256).convert("RGB").tobytes() == exported.tobytes()
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


def test_columns_go_to_a_data_frame(monkeypatch):
    class Frame(dict[str, Any]):
        def __init__(self, columns):
            super().__init__(columns)
            self.attrs: dict[str, Any] = {}

    fake = type(sys)("pandas")
    fake.DataFrame = Frame  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "pandas", fake)
    frame = Columns({"t": np.arange(3.0)}, {"t": "s"}).to_pandas()
    assert (list(frame["t"]), frame.attrs["units"]) == ([0.0, 1.0, 2.0], {"t": "s"})


@pytest.mark.parametrize("library", ["pandas", "polars"])
def test_columns_are_those_of_a_real_data_frame(result, library):
    """Of a history, and of columns of words and whole numbers as sweeps have them."""
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


def test_the_interface_is_complete_and_its_types_are_known():
    assert {*FUNCTIONS, "Columns", "InputError", "Result"} == set(tailslap.__all__)
    stub = (Path(tailslap.__file__).parent / "__init__.pyi").read_text()
    assert [name for name in tailslap.__all__ if f" as {name}\n" not in stub] == []
    for name in FUNCTIONS:
        function = getattr(tailslap, name)
        hints = get_type_hints(function)
        assert {*inspect.signature(function).parameters, "return"} <= hints.keys()


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_function_is_described_with_an_example(name):
    function = getattr(tailslap, name)
    takes_nothing = not inspect.signature(function).parameters
    text, sections = inspect.getdoc(function) or "", TAKES_NOTHING if takes_nothing else SECTIONS
    assert [title for title in sections if f"\n{title}\n{'-' * len(title)}\n" not in text] == []
    assert ">>> " in text


@pytest.mark.parametrize("name", [*FUNCTIONS, "Columns"])
def test_examples_are_right(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    value = getattr(tailslap, name)
    module = importlib.import_module(value.__module__)
    tests = doctest.DocTestFinder(recurse=False).find(value, name, globs={**vars(module), "np": np})
    runner = doctest.DocTestRunner(verbose=False)
    assert all(runner.run(test).failed == 0 for test in tests)
    assert sum(len(test.examples) for test in tests) > 0


def test_modules_do_not_hide_the_functions():
    """An import of a module of the same name would put it in the function's place."""
    code = "import tailslap.cli as c, tailslap; c.commands.get_command; print(*map(callable, ({})))"
    names = ", ".join(f"tailslap.{name}" for name in FUNCTIONS)
    run = subprocess.run(
        [sys.executable, "-c", code.format(names)], capture_output=True, text=True, check=True, env=os.environ
    )
    assert set(run.stdout.split()) == {"True"}
    folder = Path(tailslap.__file__).parent
    assert [name for name in FUNCTIONS if (folder / name).exists() or (folder / f"{name}.py").exists()] == []
