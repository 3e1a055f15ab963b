"""Verify commands, exit statuses, messages, result folders and light imports."""

import csv
import fcntl
import json
import os
import pty
import select
import signal
import struct
import subprocess
import termios
import time
import warnings

import pytest
from click.testing import CliRunner
from processes import imported, started

from postprocess.report.provenance import CRATE
from tailslap import delivery, scene_commands
from tailslap.cli import _status, commands
from tailslap.exports import export as exporting
from tailslap.storage import folder
from tailslap.studies import study as study_record
from tailslap.studies import study_names

FILES = {
    "summary.json", "history.csv", "rigid.csv", "report.html", "set-up.svg", ".tailslap-result.json", CRATE,
}  # fmt: skip
CURVES = ["theta", "omega", "v_gx", "v_gy", "slide", "reaction_normal", "reaction_tangential"]
CURVES += ["energy_exchanged", "energy_stored", "energy_error", "positions"]
FILES |= {f"{name}.svg" for name in CURVES}
FLUTTER = ("--set", "impact.friction=0.8", "--set", "corner.penalty_scale=3", "--set", "damping.kind=none")
PICTURES = {
    f"contour_{name}{form}.png" for name in ("v_gx", "v_gy", "omega", "von_mises") for form in ("", "-dark")
}


def test_rigid_and_scenes_import_nothing_heavy(tmp_path):
    assert imported("rigid", "mash-tl4-sut", "--units", "us", cwd=tmp_path) == set()
    assert imported("scenes", cwd=tmp_path) == set()


def test_a_run_without_pictures_does_not_import_vtk(tmp_path):
    modules = imported("run", "paper-abaqus", "--no-pictures", cwd=tmp_path)
    assert not modules & {"vtk", "vtkmodules", "pyvista", "matplotlib"}
    assert {"gmsh", "skfem"} <= modules


def test_a_short_command_collects_no_garbage(python):
    """Collections took a sixth of the time."""
    code = (
        "import atexit, gc; from tailslap.cli import main; collected = []; gc.callbacks.append("
        "lambda phase, info: collected.append(phase)); atexit.register("
        "lambda: print(len(collected), gc.get_freeze_count() > 10_000)); main(['rigid', 'paper-table-3'])"
    )
    assert python(code, check=True).stdout.splitlines()[-1] == "0 True"


def test_rigid_json_has_the_contract_s_names(capsys):
    assert _status(["rigid", "paper-table-3", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert set(answer["stage1"]) == {"omega", "corner_speed", "impulse"}
    assert set(answer["stage2"]) == {"t", "v_gx", "v_gy", "omega", "slide"}
    assert set(answer["stage3"]) == {"impulse", "duration", "peak_force"}
    assert answer["stage2"]["v_gy"] == pytest.approx(-3.2755267205, abs=5e-11)
    assert answer["stage3"]["peak_force"] == pytest.approx(2 * 9979 * 3.2755267205 / 0.1, rel=1e-10)


def test_scenes_lists_each_with_a_line(capsys):
    assert _status(["scenes"]) == 0
    lines = [line for line in capsys.readouterr().out.splitlines() if not line.startswith(" ")]
    assert {line.split()[0] for line in lines} >= {"mash-tl4-sut", "paper-table-3", "paper-abaqus"}
    assert all(len(line.split()) > 3 for line in lines)


def test_check_says_what_a_run_would_use_and_writes_nothing(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert _status(["check", "paper-abaqus"]) == 0
    said = capsys.readouterr().out
    for words in ("120 elements, 147 nodes", "time step", "steps", "no friction code", "no damping code"):
        assert words in said
    assert not list(tmp_path.iterdir())


def test_a_run_leaves_a_complete_folder(tmp_path, monkeypatch, capfd, besides_compiling):
    monkeypatch.chdir(tmp_path)
    assert _status(["run", "paper-table-3"]) == 0
    out, err = capfd.readouterr()
    assert besides_compiling(err) == ""
    assert "FE/rigid" in out
    folder = tmp_path / "results" / "paper-table-3"
    assert {path.name for path in folder.iterdir()} == FILES | PICTURES
    assert {path.name for path in folder.parent.iterdir()} == {"paper-table-3"}
    _has_the_contract_s_numbers(json.loads((folder / "summary.json").read_text()))
    with (folder / "history.csv").open() as fe, (folder / "rigid.csv").open() as rigid:
        fe_rows, rigid_rows = list(csv.DictReader(fe)), list(csv.DictReader(rigid))
    assert [row["t"] for row in fe_rows] == [row["t"] for row in rigid_rows]
    assert list(fe_rows[0]) == list(rigid_rows[0])
    assert {"t", *CURVES[:7]} <= {*fe_rows[0]}
    report = (folder / "report.html").read_text()
    assert report.count("data:image/webp") == 8
    assert report.count("<svg") >= 5


def test_results_are_there_before_the_pictures_start(tmp_path, monkeypatch, capsys):
    """The numbers are complete, and the missing pictures are named."""
    from postprocess.fields.canvas import Canvas

    def refused(canvas):
        at_work = {".tailslap-lock", ".tailslap-new"}
        assert {path.name for path in (tmp_path / "out").iterdir()} == FILES | at_work
        raise RuntimeError("no picture can be drawn")

    monkeypatch.setattr(Canvas, "image", refused)
    small = ("run", "paper-table-3", "--set", "plate.elements=[10,3]", "--out", str(tmp_path / "out"))
    assert _status(list(small)) == 3
    assert "no picture can be drawn" in capsys.readouterr().err
    assert {path.name for path in (tmp_path / "out").iterdir()} == FILES
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["fe"]["t"] > 0.0
    assert "pictures" in {entry["part"] for entry in summary["left_out"]}


def _has_the_contract_s_numbers(summary):
    for part in ("rigid", "fe", "difference"):
        assert set(summary[part]) == {"t", "v_gx", "v_gy", "omega", "slide"}
    assert summary["scene"] == "paper-table-3"
    assert summary["passed"] is True
    assert max(map(abs, summary["difference"].values())) < 5e-6
    assert all({"name", "value", "limit", "passed"} <= set(check) for check in summary["checks"])
    assert (summary["cost"]["elements"], summary["cost"]["nodes"]) == (120, 147)
    assert {"steps", "time_step", "setup_s", "time_loop_s", "pictures_s"} <= set(summary["cost"])
    assert set(summary["metrics"]) == {"v_gx", "v_gy", "omega", "theta", "reaction_normal"}
    for metrics in summary["metrics"].values():
        assert list(metrics) == ["magnitude", "phase", "combined", "mean_residual", "deviation"]
        assert max(map(abs, metrics.values())) < 1e-5
    assert {entry["part"] for entry in summary["left_out"]} == {"damping"}


def test_what_is_left_out_is_said(tmp_path):
    out = tmp_path / "out"
    bare = [part for table in ("impact", "wall") for part in ("--set", f"{table}=")]
    assert _status(["run", "paper-abaqus", *bare, "--no-pictures", "--out", str(out)]) == 0
    summary = json.loads((out / "summary.json").read_text())
    reasons = {entry["part"]: entry["why"] for entry in summary["left_out"]}
    assert set(reasons) == {"stage 1", "friction", "damping", "wall", "pictures"}
    assert summary["stage1"] is None
    assert (summary["cost"]["pictures_s"], {path.name for path in out.iterdir()}) == (0.0, FILES)


def test_a_run_that_diverges_is_reported_too(tmp_path, capsys, besides_compiling):
    words = ["run", "paper-table-3", *FLUTTER, "--set", "plate.youngs_modulus=20 TPa"]
    assert _status([*words, "--out", str(tmp_path / "bad")]) == 1
    assert besides_compiling(capsys.readouterr().err) == ""
    summary = json.loads((tmp_path / "bad" / "summary.json").read_text())
    assert summary["fe"]["t"] is None
    assert {path.name for path in (tmp_path / "bad").iterdir()} == FILES


def test_a_run_without_a_plate_is_refused_and_rigid_does_without(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    bare = ["mash-tl4-sut", "--set", "plate=", "--set", "wall="]
    assert _status(["run", *bare]) == 2
    assert "plate: given no value" in capsys.readouterr().err
    for command in ("rigid", "check"):
        assert _status([command, *bare]) == 0


def test_an_interrupted_run_shows_progress_and_leaves_nothing(tmp_path):
    """A bar is displayed after a second, and Ctrl-C ends with 130."""
    try:
        leader, follower = pty.openpty()
    except OSError:
        pytest.skip("no pseudo-terminals, as in a chroot without /dev/pts")
    fcntl.ioctl(follower, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 80, 0, 0))
    words = ["--set", "plate.youngs_modulus=1e17", "--set", "corner.reaction=none", "--no-pictures"]
    streams = {"stdout": subprocess.DEVNULL, "stderr": follower}
    process = started("run", "paper-table-3", *words, cwd=tmp_path, **streams)
    try:
        output, end = b"", time.monotonic() + 240.0
        while b"%" not in output and time.monotonic() < end:
            if select.select([leader], [], [], 0.2)[0]:
                output += os.read(leader, 1024)
        assert b"steps" in output
        process.send_signal(signal.SIGINT)
        status = process.wait(timeout=30)
        assert status == 130, output + os.read(leader, 8192)
    finally:
        process.kill()
        os.close(leader)
        os.close(follower)
    assert not list(tmp_path.rglob("*"))


@pytest.mark.parametrize(
    "command", [*sorted(commands.commands), *(f"study {name}" for name in study_names())]
)
def test_every_command_has_help(command):
    result = CliRunner().invoke(commands, [*command.split(), "--help"])
    assert result.exit_code == 0, result.output
    assert "Usage:" in result.output


@pytest.mark.parametrize(("name", "value"), [
    ("SOURCE_DATE_EPOCH", "abc"), ("SOURCE_DATE_EPOCH", ""), ("SOURCE_DATE_EPOCH", "1e9"),
])  # fmt: skip
def test_environment_variables_that_end_a_library_are_refused(monkeypatch, capsys, name, value):
    monkeypatch.setenv(name, value)
    assert _status(["scenes"]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith(f'tailslap: environment variable {name}: given "{value}"; allowed is ')
    assert said.err.count("\n") == 1


def test_other_environment_variables_change_nothing(monkeypatch, tmp_path):
    """Relative folders are no folders (XDG), a command opens no windows."""
    settings = {"XDG_CACHE_HOME": "cache", "XDG_CONFIG_HOME": "../config", "MPLBACKEND": "none"}
    settings |= {"SOURCE_DATE_EPOCH": "0", "XDG_DATA_HOME": str(tmp_path)}
    monkeypatch.setattr(os, "environ", os.environ | settings)
    assert _status(["scenes", "--quiet"]) == 0
    assert os.environ["MPLBACKEND"] == "agg"
    assert {name: value for name, value in os.environ.items() if name.startswith("XDG_")} == {
        "XDG_DATA_HOME": str(tmp_path)
    }


def test_a_remark_of_a_library_is_its_first_line(monkeypatch, capsys):
    def warn(**options):
        warnings.warn("\nthe first line\nTraceback", UserWarning, stacklevel=1)

    monkeypatch.setattr(commands.commands["scenes"], "callback", warn)
    assert _status(["scenes"]) == 0
    assert capsys.readouterr().err == "tailslap: remark: the first line\n"


def test_every_command_names_its_folder_by_the_changes(monkeypatch):
    """The order of changes has no effect."""
    places = []

    def place(*arguments):
        places.append(folder.default_place(*arguments).name)
        raise KeyboardInterrupt

    for module in (delivery, scene_commands, study_record, exporting):
        monkeypatch.setattr(module, "default_place", place)
    changes = ["--set", "vehicle.mass=9 t", "--set", "plate.youngs_modulus=100 GPa"]
    studies = [f"study {name}" for name in study_names() if name != "tipping"]
    for changed in (["mash-tl4-sut", *changes], ["mash-tl4-sut", *changes[2:], *changes[:2]]):
        for command in ("run", "modes", "confirm", "export --to abaqus", *studies):
            assert _status([*command.split(), *changed]) == 130
        assert _status(["sweep", *changed, "--vary", "impact.speed=25 m/s"]) == 130
    beginning = "mash-tl4-sut+plate.youngs_modulus=100GPa+vehicle.mass=9t"
    assert all(name.startswith(beginning) for name in places)
    assert len({*places}) == len(studies) + 5
