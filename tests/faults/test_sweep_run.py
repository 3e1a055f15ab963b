"""Verify sweeps on local processes and on a Dask cluster.

Whatever is killed, after resuming each run has one row, and the rows are those of an undisturbed sweep, bit for bit
except times. Single rows are compared with `tailslap run`.
"""

import contextlib
import json
import math
import os
import resource
import signal
import subprocess
import sys
import textwrap
import time
from concurrent.futures import Future
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple, cast

import processes
import pytest
from processes import alive, children

import tailslap
from postprocess.report.provenance import CRATE
from tailslap import cli, errors
from tailslap.campaign import engine, pools, records
from tailslap.campaign.records import Records, count, program
from tailslap.campaign.sweep_definition import make_definition
from tailslap.campaign.sweep_run import RECORDS, StoppedError, open_records, perform
from tailslap.campaign.sweep_table import CIRCUMSTANCES, compute_row
from tailslap.case import resources
from tailslap.case.corner.corner_case import CornerCase
from tailslap.scene.read import source_of_text
from tailslap.scene.vary import vary
from tailslap.storage.manifest import NAME as MANIFEST

HANG = 600.0
"""Seconds after which a waiting test fails: a guard, not a measurement."""

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

    def give_up(*signalled):
        raise TimeoutError("the test hangs")

    before = signal.signal(signal.SIGALRM, give_up)
    signal.alarm(int(HANG))
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


class Loopback(NamedTuple):
    """A scheduler's address, its process, and that of the workers."""

    address: str
    processes: list[subprocess.Popen[bytes]]


def wait_until(condition):
    """Return the value of the condition as soon as it is true."""
    end = time.monotonic() + HANG
    while not (value := condition()):
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.01)
    return value


@contextlib.contextmanager
def loopback(folder, workers, *options):
    """`dask scheduler` and `dask worker` on a free port of 127.0.0.1.

    options: of `dask worker`.
    """
    file, dask = folder / "scheduler.json", [sys.executable, "-m", "dask"]
    host = ["--host", "127.0.0.1", "--no-dashboard"]
    settings = {"DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "1", "OMP_NUM_THREADS": "1"}
    variables = {"PYTHONPATH": os.pathsep.join(sys.path)}  # it loads this module too
    silent: dict[str, Any] = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    silent["env"] = os.environ | settings | variables
    scheduler = [*dask, "scheduler", *host, "--port", "0", "--scheduler-file", str(file)]
    processes = [subprocess.Popen(scheduler, **silent)]
    try:
        wait_until(lambda: file.exists() and file.read_text())
        address = json.loads(file.read_text())["address"]
        count = ["--nworkers", str(workers), "--nthreads", "1", "--memory-limit", "0"]
        worker = [*dask, "worker", address, *host, *count, *options, "--local-directory", str(folder)]
        processes.append(subprocess.Popen(worker, **silent))
        yield Loopback(address, processes)
    finally:
        below = [child for process in processes for child in children(process.pid)]
        for process in processes:
            process.kill()
            process.wait()
        wait_until(lambda: not any(map(alive, below)))


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    with loopback(tmp_path_factory.mktemp("dask"), 2) as address:
        yield address.address


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    path = tmp_path_factory.mktemp("scene") / "small.toml"
    path.write_text(SCENE)
    return str(path)


def definition_of(scene, varied=VARIED):
    return make_definition(scene, (), varied, None, 307)


def table(place):
    """Rows of the table, without times."""
    import pyarrow.parquet as pq

    rows = pq.read_table(place / "sweep.parquet").to_pylist()
    return [{name: value for name, value in row.items() if name not in CIRCUMSTANCES} for row in rows]


@pytest.fixture(scope="module")
def undisturbed(scene, cluster, tmp_path_factory):
    place = tmp_path_factory.mktemp("sweeps") / "undisturbed"
    result = perform(definition_of(scene), place, cluster)
    assert result.statuses == {"passed": 80, "failed": 0, "refused": 80, "error": 0}
    files = {"sweep.json", RECORDS, "sweep.parquet", "summary.json", "report.html", MANIFEST, CRATE}
    assert {path.name for path in place.iterdir() if path.suffix != ".svg"} == files
    assert json.loads((place / "summary.json").read_text())["statuses"] == result.statuses
    return table(place)


def test_a_small_sweep_by_the_command(scene, tmp_path, capsys):
    """Rows are those of single runs, and a repetition computes none.

    Inputs, solutions, differences, checks and cost are equal.
    """
    place, varied = tmp_path / "sweep", ("corner.friction=0.1,0.9",)
    arguments = ["sweep", scene, "--vary", *varied, "--workers", "1", "--out", str(place)]
    assert cli._status(arguments) == 0
    rows, definition = table(place), definition_of(scene, varied)
    runs = [CornerCase(*vary(definition.source, definition.changes_of(n))).run() for n in range(2)]
    for row, outcome in zip(rows, runs, strict=True):
        assert row["corner.friction"] == outcome.fe_plan.case.scene.corner_friction
        for group in ("fe", "rigid", "difference"):
            values = {name: row[f"{group}.{name}"] for name in outcome.fe}
            assert values == pytest.approx(getattr(outcome, group), rel=1e-9, abs=1e-12)
        checks = {check.name.replace(" ", "_").replace("-", "_"): check.value for check in outcome.checks}
        values = {name[6:]: v for name, v in row.items() if name.startswith("check.") and v is not None}
        assert values == pytest.approx(checks, rel=1e-6, abs=1e-9)
        assert (row["status"], row["reason"], row["cost.steps"]) == ("passed", "", outcome.run.steps)
        assert row["version.tailslap"] == tailslap.__version__
    assert [row["run"] for row in rows] == [0, 1]
    content = (place / RECORDS).read_bytes()
    capsys.readouterr()
    assert (cli._status(arguments), (place / RECORDS).read_bytes(), table(place)) == (0, content, rows)


def test_what_a_combination_makes_impossible_is_a_refused_row(scene, tmp_path):
    """A small sweep on a cluster."""
    place, varied = tmp_path / "sweep", ("corner.reaction=drag,none", "corner.friction=0.1,0.9")
    with loopback(tmp_path, 1, "--no-nanny") as cluster:
        result = perform(definition_of(scene, varied), place, cluster.address)
    assert result.statuses == {"passed": 2, "failed": 0, "refused": 2, "error": 0}
    refused = [row for row in table(place) if row["status"] == "refused"]
    assert {row["corner.reaction"] for row in refused} == {"none"}
    assert all('no effect with corner.reaction = "none"' in row["reason"] for row in refused)
    assert all(row["fe.t"] is None for row in refused)


def started(place, scene, *more):
    """`tailslap sweep` in a process, returned with its first rows."""
    varied = [part for text in VARIED for part in ("--vary", text)]
    words = ["sweep", scene, *varied, "--out", str(place), *more]
    streams = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE}
    process = processes.started(*words, start_new_session=True, **streams)
    wait_until(lambda: process.poll() is not None or ((place / RECORDS).exists() and count(place / RECORDS)))
    return process


@pytest.mark.long
@pytest.mark.parametrize("where", ["local", "cluster"])
def test_killed_in_mid_sweep_and_resumed(where, scene, cluster, undisturbed, tmp_path, proc):
    """kill -9 of the client also ends its local workers."""
    place = tmp_path / "sweep"
    process = started(place, scene, *(("--workers", "2") if where == "local" else ("--cluster", cluster)))
    below = children(process.pid)
    assert (len(below) >= 4) == (where == "local")  # two workers, and what forks and tracks them
    process.kill()
    process.communicate()
    wait_until(lambda: not any(map(alive, below)))
    assert not (place / "summary.json").exists(), "it was done before it could be killed"
    records_before = records_of(scene, place)
    result = perform(definition_of(scene), place, cluster)
    records_after = records_of(scene, place)
    assert {run: records_after[run] for run in records_before} == records_before
    assert (result.effort.runs, table(place)) == (RUNS - len(records_before), undisturbed)


def records_of(scene, place, definition=None):
    with open_records(place, definition or definition_of(scene)) as rows:
        return dict(rows)


def known(row):
    """Return a row without the empty cells.

    A table of part of the runs may have fewer checks.
    """
    return {name: value for name, value in row.items() if value is not None}


@pytest.mark.long
def test_loggers_of_dask_with_levels_of_their_own_are_silenced(python):
    code = """
        import logging, distributed
        loggers = logging.root.manager.loggerDict.items()
        print(*(name for name, logger in loggers if getattr(logger, "level", logging.NOTSET)))
    """
    levelled = python(textwrap.dedent(code), check=True).stdout.split()
    assert {name for name in levelled if name.split(".")[0] in ("distributed", "tornado")} <= {*pools.LOGGERS}


@pytest.mark.long
@pytest.mark.parametrize("where", ["local", "cluster"])
def test_interrupted_and_resumed(where, scene, cluster, undisturbed, tmp_path):
    """By Ctrl-C, which all processes of the terminal get."""
    place = tmp_path / "sweep"
    process = started(place, scene, *(("--workers", "2") if where == "local" else ("--cluster", cluster)))
    os.killpg(process.pid, signal.SIGINT)
    message = process.communicate(timeout=HANG)[1].decode()
    assert process.returncode == 130
    table_before = table(place)
    rows_saved = f"{len(table_before)} of {RUNS} rows are saved"
    assert message.strip() == f"tailslap: interrupted; {rows_saved}; the same command resumes the sweep"
    assert [known(row) for row in table_before] == [known(undisturbed[row["run"]]) for row in table_before]
    result = perform(definition_of(scene), place, cluster)
    assert result.effort.runs == RUNS - len(table_before) > 0
    assert table(place) == undisturbed
    assert perform(definition_of(scene), place, "tcp://nowhere:1").effort.runs == 0


PRELOADED = """
    import sys
    from tailslap.campaign import pools
    pools.NEEDED, pools.LIBRARIES, pools.START_S = (), ("preloaded",), float(sys.argv.pop(1))
    from tailslap.cli import main
    main()
"""
"""A sweep whose processes begin with the module `preloaded`."""


@pytest.mark.parametrize(("content", "patience", "ends", "status", "said"), [
    ("os.kill(os.getpid(), signal.SIGKILL)", 600.0, False, 3, "no worker remains; no run is complete"),
    ("time.sleep(1e4)", 0.5, False, 3, "no process of workers has started within 0.5 s; no run is complete"),
    ("time.sleep(1e4)", 600.0, True, 130, "interrupted; no run is complete"),
])  # fmt: skip
def test_processes_that_die_or_hang_at_their_start_are_told(
    scene, tmp_path, proc, content, patience, ends, status, said
):
    """No process is left."""
    (tmp_path / "preloaded.py").write_text(
        f"import os, signal, time\nopen('ready', 'w').close()\n{content}\n"
    )
    words = ["sweep", scene, "--vary", "corner.friction=0.1:0.5:40", "--workers", "2", "--out", "sweep"]
    process = subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(PRELOADED), str(patience), *words],
        cwd=tmp_path, stderr=subprocess.PIPE, start_new_session=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), *sys.path])},
    )  # fmt: skip
    if ends:
        wait_until((tmp_path / "ready").exists)
        process.terminate()
    message = process.communicate(timeout=HANG)[1].decode()
    assert (process.returncode, message) == (status, f"tailslap: {said}\n")
    assert not (tmp_path / "sweep").exists()
    wait_until(lambda: not any(f" {process.pid} " in stat for stat in sessions()))


def sessions():
    """Text of /proc/PID/stat of all processes."""
    for path in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            yield path.read_text()


def test_too_little_address_space_is_told_before_libraries_hang(scene, tmp_path, proc):
    limit = 350 * 2**20
    words = ["sweep", scene, "--vary", "corner.friction=0.1:0.5:40"]
    limited = partial(resource.setrlimit, resource.RLIMIT_AS, (limit, limit))
    process = processes.completed(*words, cwd=tmp_path, preexec_fn=limited)
    assert process.returncode == 3
    assert "limited to 367 MB (ulimit -v); required are 512 MB; no run is complete" in process.stderr
    assert not list(tmp_path.glob("results/*"))


def padded(run, *rest):
    return {"run": run, "status": "passed", "reason": "", "note": 1000 * "x"}


def test_a_folder_whose_name_is_no_text_is_refused(tmp_path, capsys):
    place = tmp_path / "bad\udcff" / "sweep"
    place.parent.mkdir()
    words = ["sweep", "paper-table-3", "--vary", "corner.friction=0.1,0.2", "--out", "sweep"]
    with contextlib.chdir(place.parent):
        assert cli._status(words) == 2
    assert "--out: given" in capsys.readouterr().err
    assert not place.exists()


def test_a_full_disk_is_told_with_the_rows_that_are_kept(monkeypatch, scene, tmp_path):
    """And the same command goes on."""
    plain, definition = Records._begin, definition_of(scene, ("corner.friction=0.1:0.5:400",))

    def small(self, head):
        plain(self, head)
        self._file.execute("PRAGMA max_page_count = 16")

    with monkeypatch.context() as change:
        change.setattr(Records, "_begin", small)
        with pytest.raises(StoppedError, match=r"full: .*; \d+ of 400 rows are saved; the same comm") as stop:
            perform(definition, tmp_path / "sweep", None, 1, padded)
    assert stop.value.status == 3
    count = len(records_of(scene, tmp_path / "sweep", definition))
    assert str(stop.value).split("; ")[1].startswith(f"{count} of")
    assert perform(definition, tmp_path / "sweep", None, 1, padded).effort.runs == 400 - count < 400


def test_workers_are_no_more_than_rows_and_cores(monkeypatch, scene, tmp_path):
    monkeypatch.setattr(resources, "available_cores", lambda: 4)
    cases = (None, 9), (1024, 9), (1024, 2), (3, 9)
    assert [resources.worker_count(*numbers) for numbers in cases] == [4, 4, 2, 3]
    counts = []

    def counted(workers):
        counts.append(workers)
        raise pools.LostError("counted")

    monkeypatch.setattr(pools, "local", counted)
    with pytest.raises(StoppedError):
        perform(definition_of(scene, ("corner.friction=0.1:0.5:3",)), tmp_path / "sweep", workers=1024)
    with records.Journal(tmp_path / "study", {}) as journal, pytest.raises(pools.LostError):
        engine.run_parts(int, dict.fromkeys("abcdef", ()), journal, "", workers=256)
    assert counts == [3, 4]


def dies_once(mark, run, *rest):
    with contextlib.suppress(FileExistsError):
        if run == 20:
            mark.touch(exist_ok=False)
            os.kill(os.getpid(), signal.SIGKILL)
    return compute_row(run, *rest)


@pytest.mark.long
@pytest.mark.parametrize("where", ["local", "cluster"])
def test_a_worker_that_dies_is_survived(where, scene, cluster, undisturbed, tmp_path):
    """The first worker to compute a certain run is killed."""
    mark, place = tmp_path / "mark", tmp_path / "sweep"
    compute = partial(dies_once, mark)
    result = perform(definition_of(scene), place, cluster if where == "cluster" else None, 2, compute)
    assert mark.exists()
    assert (result.failures, table(place)) == (0, undisturbed)


def dies(runs, pause, run, *rest):
    if run in runs:
        time.sleep(pause)
        os.kill(os.getpid(), signal.SIGKILL)
    return {"run": run, "status": "passed", "reason": ""}


@pytest.mark.parametrize("where", ["local", pytest.param("cluster", marks=pytest.mark.long)])
def test_a_run_that_kills_its_worker_again_and_again_is_a_row(where, scene, request, tmp_path):
    """The runs that shared its batch, or its processes, are not blamed."""
    definition = definition_of(scene, ("corner.friction=0.1:0.5:40",))
    # Dask does not replace a worker that dies while it is being started.
    address, pause = (request.getfixturevalue("cluster"), 0.5) if where == "cluster" else (None, 0.0)
    killing = (7,) if address else (7, 8, 30)
    result = perform(definition, tmp_path / "sweep", address, 2, partial(dies, killing, pause))
    rows = table(tmp_path / "sweep")
    assert [row["run"] for row in rows] == list(range(40))
    assert [row["run"] for row in rows if row["status"] != "passed"] == list(killing)
    assert "its worker process died" in rows[7]["reason"]
    if where == "local":
        assert rows[7]["corner.friction"] == definition.inputs_of(7)["corner.friction"]
    assert result.failures == len(killing)


def test_processes_that_cannot_begin_are_told(monkeypatch, scene, tmp_path):
    """And no run is blamed."""
    monkeypatch.setattr(pools, "make_ready", partial(os._exit, 1))
    with pytest.raises(StoppedError, match="no worker remains; no run is complete") as stop:
        perform(definition_of(scene), tmp_path / "sweep", workers=1)
    assert stop.value.status == 3
    assert not (tmp_path / "sweep").exists()


def test_what_breaks_in_a_run_is_its_row(monkeypatch):
    def broken(*arguments):
        raise ZeroDivisionError("by nought")

    monkeypatch.setattr("tailslap.case.corner.corner_run.run_corner", broken)
    source = source_of_text(SCENE)
    parts: list[tuple[str | int, tuple[Any, ...]]] = [
        (run, (run, source, {"corner.friction": 0.1 * run})) for run in (3, 4)
    ]
    rows = pools.run_batch(program(), compute_row, parts).records.values()
    outcomes = [(row["run"], row["status"], row["reason"]) for row in rows]
    assert outcomes == [(run, "error", "ZeroDivisionError: by nought") for run in (3, 4)]


@pytest.mark.long
def test_the_loss_of_the_scheduler_keeps_the_rows(scene, tmp_path):
    """kill -9 of scheduler and workers under a sweep."""
    place = tmp_path / "sweep"

    def compute(run, *rest):
        if run >= 10:
            time.sleep(HANG)
        return {"run": run, "status": "passed", "reason": ""}

    definition = definition_of(scene, ("corner.friction=0.1:0.5:14",))
    with loopback(tmp_path, 1) as address, pytest.MonkeyPatch.context() as patched:
        add = Records.add

        def add_and_kill(file, records, seconds):
            add(file, records, seconds)
            for process in address.processes:
                process.kill()

        patched.setattr(Records, "add", add_and_kill)
        message = r"the connection to the scheduler at tcp.* is lost; \d+ of 14 rows are saved"
        with pytest.raises(StoppedError, match=message) as stop:
            perform(definition, place, address.address, compute=compute)
    assert stop.value.status == 3
    assert 0 < len(table(place)) < 14


def test_a_scheduler_that_does_not_answer(scene, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(pools, "REPLY_S", 0.3)
    for address in ("tcp://127.0.0.1:9", "127.0.0.1:9", "nonsense", "http://127.0.0.1:9", "tcp://"):
        arguments = ["--cluster", address, "--out", str(tmp_path / "sweep")]
        assert cli._status(["sweep", scene, "--vary", "corner.friction=0.1,0.2", *arguments]) == 2
        message = capsys.readouterr().err
        assert message.startswith(f'tailslap: --cluster: given "{address}"; no Dask scheduler replies')
        assert not (tmp_path / "sweep").exists()


@pytest.mark.long
def test_other_versions_are_refused(scene, cluster, tmp_path, monkeypatch):
    with pytest.raises(pools.OtherProgramError):
        pools.run_batch("0.0.0", compute_row, [])
    from distributed import Client

    with Client(cluster) as client:
        client.wait_for_workers(1, timeout=HANG)  # a worker that comes later is asked with its first runs
    monkeypatch.setattr(pools, "program", lambda: "9.9.9")
    with pytest.raises(
        errors.InputError, match=r"--cluster: .* has tailslap .*; all workers require 9\.9\.9"
    ):
        perform(definition_of(scene), tmp_path / "sweep", cluster)
    assert not (tmp_path / "sweep").exists()


class Flaky:
    """A pool of one worker that loses the first call in transit.

    The scheduler may be lost with it.
    """

    died: pools.Errors = (ZeroDivisionError,)
    again: pools.Errors = (ConnectionError,)

    def __init__(self, gone):
        self.calls, self.gone = 0, gone

    def submit(self, function, *arguments):
        future: Future[Any] = Future()
        self.calls += 1
        if self.calls == 1:
            future.set_exception(ConnectionError("reset by peer"))
        else:
            future.set_result(function(*arguments))
        return future

    def threads(self):
        if self.calls and self.gone:
            raise pools.LostError("the scheduler is gone")
        return 1

    def fault(self, error):
        return error


def test_connection_lost_while_rows_come_does_not_blame_a_worker(tmp_path):
    """The runs wait again, or the scheduler is reported lost."""
    records = Records(tmp_path / "r.sqlite", {})
    parts = engine.Parts(abs, [3, 4, 5], lambda key: (-int(key),), lambda key: "died")
    with pytest.raises(pools.LostError):
        engine.Engine(parts, records, cast(pools.Pool, Flaky(gone=True))).run(lambda threads: None)
    assert (
        engine.Engine(parts, records, cast(pools.Pool, Flaky(gone=False))).run(lambda threads: None).runs == 3
    )
    assert dict(records) == {3: 3, 4: 4, 5: 5}
    records.close()


def test_memory_that_cannot_be_read_is_unlimited(monkeypatch, tmp_path):
    def unread():
        raise OSError

    monkeypatch.setattr(resources, "free_memory", unread)
    monkeypatch.setattr(resources, "CGROUP", tmp_path / "none")
    assert resources.available_memory() == math.inf
    with pools.local(0) as pool:
        assert pool.submit(os.getpid).result() == os.getpid()
