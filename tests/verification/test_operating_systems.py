"""Verify commands without the names that are missing on Windows or macOS."""

import contextlib
import os
import signal
import subprocess
import sys
from pathlib import Path

import psutil
import pytest
import structure

from machine_code.system import operating_system

ROOT = Path(__file__).parents[2]
HANG = 300.0

HIDE = f"""
import builtins
import types
plain = builtins.__import__
PACKAGES = {structure.PACKAGES}
MODULES, NAMES = {structure.UNIX_MODULES}, {structure.UNIX_NAMES}
class Hidden(types.ModuleType):
    def __init__(self, name):
        super().__init__(name)
        self.__dict__["real"] = plain(name)
    def __getattr__(self, attribute):
        if attribute in NAMES[self.__name__]:
            raise AttributeError(f"{{self.__name__}}.{{attribute}} is hidden")
        return getattr(self.__dict__["real"], attribute)
hidden = {{name: Hidden(name) for name in NAMES}}
def find(name, globals=None, locals=None, fromlist=(), level=0):
    importing = str((globals or {{}}).get("__name__")).partition(".")[0]
    if level == 0 and importing in PACKAGES:
        if name.partition(".")[0] in MODULES:
            raise ModuleNotFoundError(f"{{name}} is hidden")
        if name in hidden:
            return hidden[name]
    return plain(name, globals, locals, fromlist, level)
builtins.__import__ = find
"""
"""Module that a process imports at its start. It hides names from the packages of the program alone."""


@pytest.fixture(scope="module")
def elsewhere(tmp_path_factory):
    """Environment of a process without these names."""
    folder = tmp_path_factory.mktemp("hide")
    (folder / "sitecustomize.py").write_text(HIDE)
    return {**os.environ, "PYTHONPATH": os.pathsep.join([str(folder), str(ROOT)])}


def test_one_module_has_what_differs_between_operating_systems(tmp_path):
    """The count finds each form of a name."""
    assert structure.of_one_system() == []
    place = tmp_path / "meshes"
    place.mkdir()
    (tmp_path / "bootstrap.py").write_text("import os\nfrom signal import SIGKILL\nos.fork()\nos.listdir()\n")
    (place / "a.py").write_text("def lock():\n    import fcntl\n    from resource import getrlimit\n")
    expected = ["meshes/a.py: fcntl", "meshes/a.py: resource.getrlimit", "bootstrap.py: signal.SIGKILL"]
    assert structure.of_one_system(tmp_path) == [*expected, "bootstrap.py: os.fork"]


def test_the_names_are_hidden(elsewhere):
    code = "from machine_code.system import operating_system as s; print(s.HAS_FORK, len(s.ENDING), s.PLAIN)"
    process = subprocess.run(
        [sys.executable, "-c", code], env=elsewhere, capture_output=True, text=True, cwd=ROOT
    )
    assert process.stdout.split() == ["False", "1", "0"], process.stderr


def test_the_installation_starts_with_the_standard_library_alone():
    code = f"import sys; sys.path.insert(0, {str(ROOT)!r}); import bootstrap; print(bootstrap.sudo())"
    process = subprocess.run([sys.executable, "-I", "-S", "-c", code], capture_output=True, text=True)
    assert process.returncode == 0, process.stderr


@pytest.mark.parametrize("words", [
    ("scenes",),
    ("rigid", "paper-table-3"),
    ("run", "paper-table-3", "--no-pictures", "--set", "plate.elements=[8,2]"),
    ("sweep", "paper-table-3", "--set", "plate.elements=[8,2]", "--vary", "corner.friction=0.2,0.4", "--workers", "1"),
], ids=lambda words: words[0])  # fmt: skip
def test_a_command_runs_without_these_names(words, elsewhere, tmp_path):
    """It prints the same and writes the same files as with them."""
    outputs = []
    for name, environment in (("plain", dict(os.environ)), ("elsewhere", elsewhere)):
        place = tmp_path / name
        place.mkdir()
        command = [sys.executable, "-m", "tailslap", *words]
        options = {"capture_output": True, "text": True, "timeout": HANG, "cwd": place}
        process = subprocess.run(command, env={**environment, "COLUMNS": "200"}, **options)
        assert process.returncode == 0, process.stderr
        lines = [line.partition(" steps in ")[0] for line in process.stdout.splitlines()]  # without times
        lines = [line for line in lines if not line.startswith("Cost:")]
        files = {path.relative_to(place) for path in place.rglob("*") if path.is_file()}
        outputs.append((lines, files))
    assert outputs[0] == outputs[1]
    assert len(outputs[0][0]) > 3


def test_workers_of_any_kind_end_with_their_owner(elsewhere, tmp_path, proc):
    """The owner is killed while its worker computes."""
    code = (
        "import os, sys, time\nfrom tailslap.campaign import pools\n"
        "if __name__ == '__main__':\n"
        "    with pools.local(1) as pool:\n"
        "        print(pool.submit(os.getpid).result(), flush=True)\n"
        "        pool.submit(time.sleep, 1000.0).result()\n"
    )
    command = [sys.executable, "-c", code]
    with subprocess.Popen(command, env=elsewhere, cwd=tmp_path, stdout=subprocess.PIPE) as owner:
        assert owner.stdout is not None
        worker = psutil.Process(int(owner.stdout.readline()))
        assert worker.is_running()
        owner.send_signal(signal.SIGKILL)
    with contextlib.suppress(psutil.NoSuchProcess):
        worker.wait(HANG)
    assert not worker.is_running()


def test_a_lock_excludes_another_process_and_ends_with_it(tmp_path, elsewhere):
    path, code = (
        tmp_path / "lock",
        (
            "import sys, time\nfrom pathlib import Path\nfrom tailslap.storage import manifest\n"
            "with manifest.locked_file(Path(sys.argv[1])):\n    print('locked', flush=True)\n    time.sleep(1000.0)\n"
        ),
    )
    with subprocess.Popen([sys.executable, "-c", code, path], env=elsewhere, stdout=subprocess.PIPE) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == b"locked\n"
        number = os.open(path, os.O_RDWR)
        with pytest.raises(BlockingIOError):
            operating_system.lock(number, wait=False)
        other.kill()
    operating_system.lock(number, wait=True)
    os.close(number)


def test_memory_and_cores_are_those_of_the_system(proc):
    lines = Path("/proc/meminfo").read_text().splitlines()
    (available,) = (1024.0 * float(line.split()[1]) for line in lines if line.startswith("MemAvailable:"))
    assert operating_system.free_memory() == pytest.approx(available, abs=3e8)
    assert operating_system.available_cores() == len(os.sched_getaffinity(0))
    pages = float(Path("/proc/self/statm").read_text().split()[0])
    assert operating_system.used_address_space() == pytest.approx(pages * os.sysconf("SC_PAGE_SIZE"), rel=0.1)
