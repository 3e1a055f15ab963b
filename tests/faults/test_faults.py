"""Verify that faults of the machine leave a folder complete or absent.

Processes of a sweep or study take orders from this program alone: no other user of the machine can reach them.
"""

import errno
import io
import os
import resource
import subprocess
import sys
from pathlib import Path

import failing_calls
import io_errors
import psutil
import pytest
from processes import completed

from fem import cache
from machine_code import object_code
from machine_code.compiled import compiled
from machine_code.system import folder
from tailslap import errors
from tailslap.campaign import pools
from tailslap.cli import _status

RUN = ("run", "paper-table-3", "--no-pictures", "--set", "plate.elements=[10,3]", "--out")


@pytest.mark.long
def test_a_full_disk_leaves_nothing_and_an_earlier_result_whole(tmp_path):
    assert completed(*RUN, "out", cwd=tmp_path).returncode == 0
    before = {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()}
    full = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))  # noqa: E731
    for place in ("out", "new"):
        process = completed(*RUN, place, cwd=tmp_path, preexec_fn=full)
        assert process.returncode == 3, process.stderr
        assert process.stderr.count("\n") == 1
        assert "bootstrap" not in process.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["out"]
    assert {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()} == before


@pytest.mark.long
def test_without_home_and_with_a_cache_that_cannot_be_written(tmp_path, besides_compiling):
    """The loop is then compiled, and kept nowhere."""
    (tmp_path / "file").write_text("")
    nowhere = {"HOME": "/nonexistent", "TAILSLAP_CACHE_DIR": str(tmp_path / "file" / "code")}
    process = completed(*RUN, "a", cwd=tmp_path, env=nowhere)
    assert (process.returncode, besides_compiling(process.stderr)) == (0, "")
    assert f"not kept for the next run: {tmp_path}/file/code/" in process.stderr


def doubled(value):
    return 2.0 * value


def test_a_full_cache_disk_ends_no_run(tmp_path, monkeypatch):
    def full(*arguments, **options):
        raise OSError(errno.ENOSPC, "No space left on device")

    tried = []

    def replace(*arguments):
        tried.append(1)
        full()

    monkeypatch.setattr(object_code.os, "replace", replace)
    monkeypatch.setattr(folder, "cache_folder", lambda: tmp_path)
    assert (compiled(doubled)(1.5), tried) == (3.0, [1])
    assert not list(tmp_path.iterdir())


def test_a_folder_that_is_gone_ends_no_command(tmp_path, besides_compiling):
    gone = tmp_path / "gone"
    gone.mkdir()
    process = completed("scenes", cwd=gone, preexec_fn=lambda: os.rmdir(gone))
    assert (process.returncode, besides_compiling(process.stderr)) == (0, "")


@pytest.mark.parametrize("place", ["x" * 300, "loop", "dangling/x/\x1b"])
def test_a_name_that_cannot_be_ends_without_a_traceback(place, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("dangling").symlink_to(tmp_path / "nowhere" / "at" / "all")
    Path("loop").symlink_to("loop")
    assert _status(["paper", "--out", place]) in (0, 2)
    errors_shown = capsys.readouterr().err
    assert "Traceback" not in errors_shown
    assert "bootstrap" not in errors_shown


def test_a_missing_system_library_is_named_with_its_packages(tmp_path, monkeypatch, capsys):
    (tmp_path / "gmsh.py").write_text("import ctypes\nctypes.CDLL('libnone.so.1')\n")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "gmsh", raising=False)
    cache.clear()  # meshes of earlier tests
    assert _status(["run", "paper-table-3", "--out", str(tmp_path / "out")]) == 3
    said = capsys.readouterr().err
    assert "gmsh cannot be loaded: libnone.so.1: cannot open shared object file" in said
    assert f"apt-get install -y --no-install-recommends {errors.APT_PACKAGES}" in said
    assert errors.APT_PACKAGES in (Path(__file__).parents[2] / "README.md").read_text()
    assert not (tmp_path / "out").exists()


@pytest.mark.skipif(not failing_calls.is_supported(), reason="the kernel does not ask about calls")
@pytest.mark.parametrize(("trial", "step"), [
    ("export-csv", 89), pytest.param("run-new", 173, marks=pytest.mark.long),
    pytest.param("compare", 191, marks=pytest.mark.long),
])  # fmt: skip
def test_an_error_of_the_disk_is_stated_and_one_result_is_whole(trial, step):
    """A few calls of each command fail, others in benchmarks/io_errors.py."""
    errors = (errno.ENOMEM, errno.EACCES)
    outcomes = dict(io_errors.outcomes(trial, slice(3, None, step), errors))
    assert len(outcomes) > 10
    assert any(outcome.startswith("status 3") for outcome in outcomes.values())
    assert [place for place in outcomes.items() if place[1].startswith("BAD")] == []


def test_messages_that_nobody_takes_change_no_status(tmp_path):
    with open("/dev/full", "w") as full:
        for arguments, status in (
            (("rigid", "bogus"), 2),
            (("rigid", "mash-tl4-sut", "--set", "impact.speed=45"), 0),  # which is remarked upon
        ):
            process = completed(*arguments, stderr=full)
            assert (process.returncode, "peak force" in process.stdout) == (status, status == 0)


def test_a_new_scene_where_none_can_be_written(tmp_path, monkeypatch, capsys, proc):
    monkeypatch.chdir("/proc")
    assert _status(["new", "mine"]) == 2
    assert "NAME: given " in capsys.readouterr().err
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(Path, "open", lambda path, *arguments, **options: FullFile(path, "x"))
    assert _status(["new", "mine"]) == 3
    assert list(tmp_path.iterdir()) == []


class FullFile(io.FileIO):
    def write(self, text):
        raise OSError(errno.ENOSPC, "No space left on device")


def test_a_file_that_has_the_name_of_a_package_is_named(tmp_path):
    """A module of the user hides a package, a folder not."""
    script, names = tmp_path / "script.py", ("fem", "meshes", "postprocess", "solver")
    script.write_text("import tailslap\nprint(tailslap.rigid('mash-tl4-sut').summary['scene'])\n")
    for name in names:
        (tmp_path / name).mkdir()
    path = {"cwd": tmp_path, "env": os.environ | {"PYTHONPATH": f"{tmp_path}{os.pathsep}{os.getcwd()}"}}
    call = lambda *line: subprocess.run([sys.executable, *line], capture_output=True, text=True, **path)  # noqa: E731
    assert call(script).stdout == "mash-tl4-sut\n"
    for name, first in zip(names, ("", "import meshes\n", "", "import solver\n"), strict=True):
        (tmp_path / name).rmdir()
        stranger = tmp_path / f"{name}.py"
        stranger.write_text("mine = 1\n")
        message = (
            f"{stranger} is in conflict with the package {name} of tailslap; rename it, or start elsewhere\n"
        )
        script.write_text(f"{first}import tailslap\n")
        process = call(script)
        assert (process.returncode, process.stderr.endswith(f"ImportError: {message}")) == (1, True)
        if name != names[-1]:
            stranger.unlink()
    process = call("-m", "tailslap", "scenes")
    assert (process.returncode, process.stdout, process.stderr) == (2, "", f"tailslap: {message}")


def test_processes_of_this_machine_open_no_port(proc):
    """Messages between processes go through pipes and sockets of the machine."""
    before = {socket.laddr for socket in psutil.Process().net_connections(kind="inet")}
    with pools.local(2) as pool:
        assert pool.submit(pow, 2, 10).result() == 1024
        worker = pool.submit(os.getpid).result()
        here = psutil.Process()
        family = {process.pid: process for process in (here, *here.children(recursive=True))}
        assert worker in family
        sockets = [socket for process in family.values() for socket in process.net_connections(kind="inet")]
        assert {socket.laddr for socket in sockets} == before
    assert not psutil.pid_exists(worker) or psutil.Process(worker).status() == psutil.STATUS_ZOMBIE
