"""Verification: sweeps on local processes and on a cluster of `dask scheduler` and `dask worker` on loopback.

Whatever is killed, after resuming each run has one row, and the rows are those of a sweep that was left alone, bit for
bit but for times. Single rows are held against `tailslap run`.
"""

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import pytest

import tailslap
from tailslap.campaign import engine, pools
from tailslap.campaign.definition import Definition, make_definition
from tailslap.campaign.perform import RECORDS, StoppedError, open_records, perform
from tailslap.campaign.records import Records, count, program
from tailslap.campaign.table import CIRCUMSTANCES, compute_row
from tailslap.case.corner.case import CornerCase
from tailslap.cli import _status
from tailslap.errors import InputError
from tailslap.files.manifest import NAME as MANIFEST
from tailslap.scene.read import source_of_text
from tailslap.scene.vary import vary

HANG = 120.0
"""Seconds after which a test that waits gives up: a guard, not a measurement."""

SCENE = """name = "small"
vehicle = {length = 10, width = 2.438, mass = 9979}
start = {angle = 0.26, omega = 0.707, corner_speed = 25.053}
impact = {speed = 25, angle = 0.26, friction = 0.4, restitution = 0.2}
plate = {thickness = 0.053, youngs_modulus = 1e9, poissons_ratio = 0.3, elements = [6, 2]}
time = {rows = 40}
"""
VARIED = ("plate.youngs_modulus=log:1e8:1e9:40", "corner.reaction=drag,none", "corner.friction=0.1,0.9")
RUNS = 160


@pytest.fixture(autouse=True)
def hang_guard():
    """End a test that hangs."""

    def give_up(*signalled: object) -> None:
        raise TimeoutError("the test hangs")

    before = signal.signal(signal.SIGALRM, give_up)
    signal.alarm(int(HANG))
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


class Loopback(NamedTuple):
    """A scheduler's address; its process, and that which keeps the workers."""

    address: str
    processes: list[subprocess.Popen[bytes]]


def wait_until(condition: Callable[[], Any]) -> Any:
    """What the condition gives as soon as it is true."""
    end = time.monotonic() + HANG
    while not (found := condition()):
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.01)
    return found


@contextlib.contextmanager
def loopback(folder: Path, workers: int) -> Iterator[Loopback]:
    """`dask scheduler` on a free port of 127.0.0.1, and `dask worker` with so many processes."""
    file, dask = folder / "scheduler.json", [sys.executable, "-m", "dask"]
    host = ["--host", "127.0.0.1", "--no-dashboard"]
    quiet: dict[str, Any] = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    settings = {"DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "1", "OMP_NUM_THREADS": "1"}
    environment = (
        os.environ | settings | {"PYTHONPATH": os.pathsep.join(sys.path)}
    )  # it loads this module too
    scheduler = [*dask, "scheduler", *host, "--port", "0", "--scheduler-file", str(file)]
    processes = [subprocess.Popen(scheduler, env=environment, **quiet)]
    try:
        wait_until(lambda: file.exists() and file.read_text())
        address = json.loads(file.read_text())["address"]
        count = ["--nworkers", str(workers), "--nthreads", "1", "--memory-limit", "0"]
        worker = [*dask, "worker", address, *host, *count, "--local-directory", str(folder)]
        processes.append(subprocess.Popen(worker, env=environment, **quiet))
        yield Loopback(address, processes)
    finally:
        below = [child for process in processes for child in children(process.pid)]
        for process in processes:
            process.kill()
            process.wait()
        wait_until(lambda: not any(map(alive, below)))


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    with loopback(tmp_path_factory.mktemp("dask"), 2) as found:
        yield found.address


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    path = tmp_path_factory.mktemp("scene") / "small.toml"
    path.write_text(SCENE)
    return str(path)


def definition_of(scene: str, varied: tuple[str, ...] = VARIED) -> Definition:
    return make_definition(scene, (), varied, None, 307)


def table(place: Path) -> list[dict[str, Any]]:
    """Rows of the table, without times."""
    import pyarrow.parquet as pq

    rows = pq.read_table(place / "sweep.parquet").to_pylist()
    return [{name: value for name, value in row.items() if name not in CIRCUMSTANCES} for row in rows]


@pytest.fixture(scope="module")
def undisturbed(scene, cluster, tmp_path_factory):
    place = tmp_path_factory.mktemp("sweeps") / "undisturbed"
    done = perform(definition_of(scene), place, cluster)
    assert done.statuses == {"passed": 80, "failed": 0, "refused": 80, "error": 0}
    assert {path.name for path in place.iterdir() if path.suffix != ".svg"} == {
        *("sweep.json", RECORDS, "sweep.parquet", "summary.json", "report.html", MANIFEST)
    }
    assert json.loads((place / "summary.json").read_text())["statuses"] == done.statuses
    return table(place)


def test_a_small_sweep_by_the_command(scene, tmp_path, capsys):
    """Rows are those of runs made here; the same command makes none again."""
    place, varied = tmp_path / "sweep", ("corner.friction=0.1,0.9",)
    arguments = ["sweep", scene, "--vary", *varied, "--workers", "1", "--out", str(place)]
    assert _status(arguments) == 0
    rows, definition = table(place), definition_of(scene, varied)
    runs = [CornerCase(*vary(definition.source, definition.changes_of(n))).run() for n in range(2)]
    for row, outcome in zip(rows, runs, strict=True):
        found = {name: row[f"fe.{name}"] for name in outcome.fe}
        assert found == pytest.approx(outcome.fe, rel=1e-9, abs=1e-12)
    kept = (place / RECORDS).read_bytes()
    capsys.readouterr()
    assert _status(arguments) == 0
    assert (place / RECORDS).read_bytes() == kept
    assert table(place) == rows


@pytest.mark.long
def test_each_row_is_that_of_a_run(undisturbed, scene):
    """Inputs, both solutions, differences, checks and cost of a few rows against runs made here."""
    assert [row["run"] for row in undisturbed] == list(range(RUNS))
    definition = definition_of(scene)
    for number in (0, 1, 157):
        row, outcome = (
            undisturbed[number],
            CornerCase(*vary(definition.source, definition.changes_of(number))).run(),
        )
        assert row["plate.youngs_modulus"] == outcome.fe_plan.plate.youngs_modulus
        assert row["corner.friction"] == outcome.fe_plan.case.scene.corner_friction
        for group in ("fe", "rigid", "difference"):
            found = {name: row[f"{group}.{name}"] for name in outcome.fe}
            assert found == pytest.approx(getattr(outcome, group), rel=1e-9, abs=1e-12)
        values = {check.name.replace(" ", "_").replace("-", "_"): check.value for check in outcome.checks}
        found = {name[6:]: v for name, v in row.items() if name.startswith("check.") and v is not None}
        assert found == pytest.approx(values, rel=1e-6, abs=1e-9)
        assert (row["status"], row["reason"], row["cost.steps"]) == ("passed", "", outcome.run.steps)
        assert row["version.tailslap"] == tailslap.__version__


@pytest.mark.long
def test_what_a_combination_makes_impossible_is_a_refused_row(undisturbed):
    refused = [row for row in undisturbed if row["status"] == "refused"]
    assert {row["corner.reaction"] for row in refused} == {"none"}
    assert all('no meaning with corner.reaction = "none"' in row["reason"] for row in refused)
    assert all(row["fe.t"] is None for row in refused)


def started(place: Path, scene: str, *more: str) -> subprocess.Popen[bytes]:
    """`tailslap sweep` as a process of its own, returned when its first rows are on disk, or it is done."""
    varied = [part for text in VARIED for part in ("--vary", text)]
    command = [sys.executable, "-m", "tailslap.cli", "sweep", scene, *varied, "--out", str(place), *more]
    process = subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, start_new_session=True
    )
    wait_until(lambda: process.poll() is not None or ((place / RECORDS).exists() and count(place / RECORDS)))
    return process


def children(pid: int) -> list[int]:
    """Processes that this one has started, and those that they have."""
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            if int(path.read_text().rpartition(")")[2].split()[1]) == pid:
                found.append(int(path.parent.name))
    return [*found, *(below for child in found for below in children(child))]


def alive(pid: int) -> bool:
    with contextlib.suppress(OSError):
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    return False


@pytest.mark.long
@pytest.mark.parametrize("where", ["local", "cluster"])
def test_killed_in_mid_sweep_and_resumed(where, scene, cluster, undisturbed, tmp_path):
    """kill -9 of the client; with local workers it has scheduler and workers in it, and these end too."""
    place = tmp_path / "sweep"
    process = started(place, scene, *(("--workers", "2") if where == "local" else ("--cluster", cluster)))
    below = children(process.pid)
    assert (len(below) >= 4) == (where == "local")  # two workers, and what forks and tracks them
    process.kill()
    process.communicate()
    wait_until(lambda: not any(map(alive, below)))
    assert not (place / "summary.json").exists(), "it was done before it could be killed"
    kept = records_of(scene, place)
    done = perform(definition_of(scene), place, cluster)
    assert {run: row for run, row in records_of(scene, place).items() if run in kept} == kept
    assert done.effort.runs == RUNS - len(kept)
    assert table(place) == undisturbed


def records_of(scene: str, place: Path) -> dict[Any, Any]:
    with open_records(place, definition_of(scene)) as rows:
        return dict(rows)


def known(row: dict[str, Any]) -> dict[str, Any]:
    """A row without what it does not have: a table of part of the runs may lack a check's column."""
    return {name: value for name, value in row.items() if value is not None}


@pytest.mark.long
@pytest.mark.parametrize("where", ["local", "cluster"])
def test_interrupted_and_resumed(where, scene, cluster, undisturbed, tmp_path):
    """By Ctrl-C, which all processes of the terminal get."""
    place = tmp_path / "sweep"
    process = started(place, scene, *(("--workers", "2") if where == "local" else ("--cluster", cluster)))
    os.killpg(process.pid, signal.SIGINT)
    said = process.communicate(timeout=HANG)[1].decode()
    assert process.returncode == 130
    kept = table(place)
    assert (
        said.strip()
        == f"tailslap: interrupted; {len(kept)} of {RUNS} rows are kept; the same command resumes"
    )
    assert [known(row) for row in kept] == [known(undisturbed[row["run"]]) for row in kept]
    done = perform(definition_of(scene), place, cluster)
    assert done.effort.runs == RUNS - len(kept) > 0
    assert table(place) == undisturbed
    assert perform(definition_of(scene), place, "tcp://nowhere:1").effort.runs == 0


def dies_once(mark: Path, run: int, *rest: Any) -> dict[str, Any]:
    with contextlib.suppress(FileExistsError):
        if run == 20:
            mark.touch(exist_ok=False)
            os.kill(os.getpid(), signal.SIGKILL)
    return compute_row(run, *rest)


@pytest.mark.long
@pytest.mark.parametrize("where", ["local", "cluster"])
def test_a_worker_that_dies_is_survived(where, scene, cluster, undisturbed, tmp_path):
    """The first worker to compute a certain run is killed under it, with kill -9."""
    mark, place = tmp_path / "mark", tmp_path / "sweep"
    compute = partial(dies_once, mark)
    done = perform(definition_of(scene), place, cluster if where == "cluster" else None, 2, compute)
    assert mark.exists()
    assert done.failures == 0
    assert table(place) == undisturbed


def dies(runs: tuple[int, ...], pause: float, run: int, *rest: Any) -> dict[str, Any]:
    if run in runs:
        time.sleep(pause)
        os.kill(os.getpid(), signal.SIGKILL)
    return {"run": run, "status": "passed", "reason": ""}


@pytest.mark.parametrize("where", ["local", pytest.param("cluster", marks=pytest.mark.long)])
def test_a_run_that_kills_its_worker_again_and_again_is_a_row(where, scene, request, tmp_path):
    """The runs that shared its batch, or its processes, are not blamed."""
    definition = definition_of(scene, ("corner.friction=0.1:0.5:40",))
    # Dask gives up a worker that dies while it is being started.
    address, pause = (request.getfixturevalue("cluster"), 0.5) if where == "cluster" else (None, 0.0)
    killing = (7,) if address else (7, 8, 30)
    done = perform(definition, tmp_path / "sweep", address, 2, partial(dies, killing, pause))
    rows = table(tmp_path / "sweep")
    assert [row["run"] for row in rows] == list(range(40))
    assert [row["run"] for row in rows if row["status"] != "passed"] == list(killing)
    assert "its worker died each time" in rows[7]["reason"]
    if where == "local":
        assert rows[7]["corner.friction"] == definition.inputs_of(7)["corner.friction"]
    assert done.failures == len(killing)


def test_processes_that_cannot_begin_are_told(monkeypatch, scene, tmp_path):
    """And no run is blamed."""
    monkeypatch.setattr(pools, "make_ready", partial(os._exit, 1))
    with pytest.raises(StoppedError, match="no worker is left; no run was finished") as stop:
        perform(definition_of(scene), tmp_path / "sweep", workers=1)
    assert stop.value.status == 3
    assert not (tmp_path / "sweep").exists()


def test_what_breaks_in_a_run_is_its_row(monkeypatch):
    def broken(*arguments: object) -> None:
        raise ZeroDivisionError("by nought")

    monkeypatch.setattr("tailslap.case.corner.run.run_corner", broken)
    source = source_of_text(SCENE)
    parts: Any = [(run, (run, source, {"corner.friction": 0.1 * run})) for run in (3, 4)]
    rows = pools.run_batch(program(), compute_row, parts).records.values()
    assert [(row["run"], row["status"], row["reason"]) for row in rows] == [
        (3, "error", "ZeroDivisionError: by nought"),
        (4, "error", "ZeroDivisionError: by nought"),
    ]


@pytest.mark.long
def test_the_loss_of_the_scheduler_keeps_the_rows(scene, tmp_path):
    """kill -9 of scheduler and workers under a sweep; it resumes on another cluster, here on one local process."""
    place = tmp_path / "sweep"

    def compute(run: int, *rest: Any) -> dict[str, Any]:
        if run >= 10:
            time.sleep(HANG)
        return {"run": run, "status": "passed", "reason": ""}

    definition = definition_of(scene, ("corner.friction=0.1:0.5:14",))
    with loopback(tmp_path, 1) as found:

        def kill_all(show: Any) -> None:
            for process in found.processes:
                process.kill()

        with pytest.MonkeyPatch.context() as patched:
            add = Records.add

            def add_and_kill(file: Records, records: Any, seconds: Any) -> None:
                add(file, records, seconds)
                kill_all(None)

            patched.setattr(Records, "add", add_and_kill)
            with pytest.raises(
                StoppedError, match=r"the scheduler at tcp.* is gone; \d+ of 14 rows are kept"
            ) as stop:
                perform(definition, place, found.address, compute=compute)
    assert stop.value.status == 3
    assert 0 < len(table(place)) < 14


def test_a_scheduler_that_does_not_answer(scene, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(pools, "ANSWER_S", 0.3)
    for address in ("tcp://127.0.0.1:9", "127.0.0.1:9", "nonsense", "http://127.0.0.1:9", "tcp://"):
        arguments = [
            "--vary",
            "corner.friction=0.1,0.2",
            "--cluster",
            address,
            "--out",
            str(tmp_path / "sweep"),
        ]
        assert _status(["sweep", scene, *arguments]) == 2
        said = capsys.readouterr().err
        assert said.startswith(f'tailslap: --cluster: given "{address}"; no Dask scheduler answers there')
        assert not (tmp_path / "sweep").exists()


@pytest.mark.long
def test_other_versions_are_refused(scene, cluster, tmp_path, monkeypatch):
    with pytest.raises(pools.OtherProgramError):
        pools.run_batch("0.0.0", compute_row, [])
    monkeypatch.setattr(pools, "program", lambda: "9.9.9")
    with pytest.raises(InputError, match=r"--cluster: .* has tailslap .*; allowed is 9\.9\.9"):
        perform(definition_of(scene), tmp_path / "sweep", cluster)
    assert not (tmp_path / "sweep").exists()


class Flaky:
    """A pool of one worker whose first call is lost on its way; the scheduler may be lost with it."""

    died: pools.Errors = (ZeroDivisionError,)
    again: pools.Errors = (ConnectionError,)

    def __init__(self, gone: bool) -> None:
        self.calls, self.gone = 0, gone

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        future: Future[Any] = Future()
        self.calls += 1
        if self.calls == 1:
            future.set_exception(ConnectionError("reset by peer"))
        else:
            future.set_result(function(*arguments))
        return future

    def threads(self) -> int:
        if self.calls and self.gone:
            raise pools.LostError("the scheduler is gone")
        return 1

    def fault(self, error: Exception) -> Exception:
        return error


def test_connection_lost_while_rows_come_does_not_blame_a_worker(tmp_path):
    """The connection may break before the client knows: the runs wait again, or the scheduler is called lost."""
    records = Records(tmp_path / "r.sqlite", {})
    parts = engine.Parts(abs, [3, 4, 5], lambda key: (-int(key),), lambda key: "died")
    with pytest.raises(pools.LostError):
        engine.perform(parts, records, Flaky(gone=True), lambda threads: None)
    assert engine.perform(parts, records, Flaky(gone=False), lambda threads: None).runs == 3
    assert dict(records) == {3: 3, 4: 4, 5: 5}
    records.close()
