"""Verify records, table and folder of a sweep.

Damaged or foreign ones are refused, and never read as others.
"""

import contextlib
import json
import math
import signal
import sqlite3
import subprocess
import sys
import time
from types import SimpleNamespace

import pytest

from tailslap import errors
from tailslap.campaign import records
from tailslap.campaign.records import Records
from tailslap.campaign.sweep_definition import make_definition
from tailslap.campaign.sweep_run import RECORDS, open_records, sweep_folder
from tailslap.campaign.sweep_table import write_table
from tailslap.result.columns import read_columns
from tailslap.storage.folder import commit, fresh, result_folder
from tailslap.storage.manifest import NAME as MANIFEST


def row(run, **more):
    return {run: {"run": run, "status": "passed", "reason": ""} | more}


def small_sweep(friction="0:0.5:6"):
    return make_definition("paper-table-3", (), (f"corner.friction={friction}",), None, 307)


@pytest.fixture
def begun(tmp_path):
    """A folder with a sweep and the row of its first run."""
    place = tmp_path / "sweep"
    with sweep_folder(place, small_sweep()) as folder, open_records(folder, small_sweep()) as rows:
        rows.add(row(0))
    return place


def refused(message, opened, *arguments):
    with pytest.raises(errors.InputError, match=message), opened(*arguments):
        pass


def test_rows_come_back_in_the_order_of_their_runs(tmp_path):
    with open_records(tmp_path, small_sweep()) as rows:
        rows.add(row(4, deflection_ratio=0.1) | row(1))
        rows.add(row(10) | row(0))
    with open_records(tmp_path, small_sweep()) as rows:
        assert [record["run"] for record in rows.in_order()] == list(rows) == [0, 1, 4, 10]
        assert rows[4] == row(4, deflection_ratio=0.1)[4]
        assert rows.statuses["passed"] == len(rows) == 4
        assert 2 not in rows
        with pytest.raises(KeyError):
            rows[2]


def test_a_second_row_of_the_same_run_is_not_taken(tmp_path):
    with open_records(tmp_path, small_sweep()) as rows:
        rows.add(row(1, deflection_ratio=0.1))
        rows.add(row(1, deflection_ratio=0.3))
        assert [record["deflection_ratio"] for record in rows.in_order()] == [0.1]
        assert rows.statuses["passed"] == 1
    assert records.count(tmp_path / RECORDS) == 1


def test_any_tool_of_sqlite_sees_the_values_in_columns(tmp_path):
    """All values are columns, and nothing is beside the file."""
    with open_records(tmp_path, small_sweep()) as rows:
        rows.add(row(0, **{"fe.t": 1 / 3}), {0: 1.5})
        rows.add(row(1, **{"fe.t": math.inf, "it's": "x"}))
    (path,) = tmp_path.iterdir()
    file = sqlite3.connect(path)
    selected = file.execute(
        'SELECT key, status, seconds, "fe.t", "it\'s" FROM result ORDER BY key'
    ).fetchall()
    file.close()
    assert selected == [(0, "passed", 1.5, 1 / 3, None), (1, "passed", None, '{"not finite":"inf"}', "x")]


def test_records_of_another_definition_or_program_are_begun_anew(tmp_path, monkeypatch):
    path = tmp_path / "r.sqlite"
    definition = {"a": 1}
    for change, version, numbers in (({}, "1", []), ({}, "1", [0]), ({"a": 2}, "1", []), ({"a": 2}, "2", [])):
        definition |= change
        monkeypatch.setattr(records, "program", lambda version=version: version)
        file = records.Records(path, definition)
        assert list(file) == numbers
        file.add({0: {"status": "passed"}})
        file.close()


def test_records_written_before_an_interrupt_are_counted(tmp_path, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    with contextlib.closing(Records(tmp_path / "r.sqlite", {})) as rows:
        monkeypatch.setattr(rows, "statuses", SimpleNamespace(update=interrupted))
        with pytest.raises(KeyboardInterrupt):
            rows.add({"a": {"status": "passed"}})
        assert (len(rows), rows.statuses) == (1, {"passed": 1})


def test_the_program_is_known_by_its_sources(python):
    """By version and digest, of what another process finds as well."""
    code = "from tailslap.campaign.records import program; print(program())"
    output = python(code, check=True).stdout
    assert (output.strip(), len(records.program().partition("+")[2])) == (records.program(), 16)


WRITER = """
import itertools, sys
from pathlib import Path
from tailslap.campaign.records import Records
records = Records(Path(sys.argv[1]), {})
for run in itertools.count():
    records.add({run: {"run": run}})
    print(run, flush=True)
"""


MOUNTED = {
    r"proc {0}/proc proc rw 0 0": "", "": "", "masked": "", r"a {0} ext4 rw 0 0": "ext4",
    "a {0} ext4 rw 0 0\nb {1} nfs4 rw 0 0": "nfs4", "a {0} ext4 rw 0 0\nb {0} cifs rw 0 0": "cifs",
}  # fmt: skip
"""Lists of mounts, and the kind of file system of a folder whose name has a space."""


@pytest.mark.parametrize("mounts", MOUNTED)
def test_a_log_beside_the_file_is_kept_on_known_file_systems_alone(tmp_path, monkeypatch, mounts):
    """Unknown mounts and a masked /proc have the usual journal."""
    place, listed = tmp_path / "a b", tmp_path / "mounts"
    place.mkdir()
    listed.write_text(mounts.format(tmp_path, str(place).replace(" ", r"\040")) + "\n")
    monkeypatch.setattr(records, "MOUNTS", listed)
    assert records._file_system(place) == MOUNTED[mounts]
    for kind, mode in ((MOUNTED[mounts], "wal" if MOUNTED[mounts] == "ext4" else "delete"), ("", "delete")):
        with contextlib.closing(Records(place / f"{mode}.sqlite", {})) as rows:
            assert rows._file.execute("PRAGMA journal_mode").fetchone() == (mode,), kind
        monkeypatch.setattr(records, "MOUNTS", tmp_path / "none")


def test_what_was_added_before_a_kill_is_there(tmp_path):
    path = tmp_path / "r.sqlite"
    writer = subprocess.Popen([sys.executable, "-c", WRITER, str(path)], stdout=subprocess.PIPE, text=True)
    assert writer.stdout is not None
    for _ in range(20):
        writer.stdout.readline()
    time.sleep(0.003)
    writer.send_signal(signal.SIGKILL)
    printed = 20 + len(writer.communicate()[0].splitlines())
    file = records.Records(path, {})
    assert list(file) == list(range(len(file)))
    assert printed <= len(file) <= printed + 1
    file.close()
    journal = path.with_name("r.sqlite-journal")  # a killed writer may leave it, where the journal is a file
    assert {path} <= set(tmp_path.iterdir()) <= {path, journal}


def test_records_of_another_kind_or_cut_off_are_refused_and_kept(tmp_path):
    with open_records(tmp_path, small_sweep()) as rows:
        rows.add(row(0, text="x" * 10_000))
    whole = (tmp_path / RECORDS).read_bytes()
    others = b"my diary\n", b"", b"\xff\xfe\n", b"SQLite format 3\0" + bytes(4080)
    for content in (*others, whole[:100], whole[: len(whole) // 2]):
        (tmp_path / RECORDS).write_bytes(content)
        refused("not a valid journal", open_records, tmp_path, small_sweep())
        assert (tmp_path / RECORDS).read_bytes() == content


def test_records_that_were_damaged_are_made_anew_or_refused_and_never_other_ones(tmp_path):
    """A bit is flipped in each stretch of the file.

    The rows that are read are a part of those written, to the last digit.
    """
    path, rows = tmp_path / "r.sqlite", row(0, **{"fe.t": 0.125}) | row(1, text="x" * 9000) | row(7, n=3)
    file = Records(path, {})
    file.add(rows)
    file.close()
    intact, ends = path.read_bytes(), set()
    for k in range(0, len(intact), 101):
        path.write_bytes(intact[:k] + bytes([intact[k] ^ (1 << k % 8)]) + intact[k + 1 :])
        records.count(path)
        try:
            file = Records(path, {})
        except errors.InputError:
            ends.add("refused")
            continue
        content = dict(file)
        assert content.items() <= rows.items()
        assert list(content.values()) == list(file.in_order())
        assert file.statuses.total() == len(content)
        file.add(rows)
        assert dict(file) == rows
        file.close()
        ends.add(str(len(content)))
    assert ends == {"refused", "0", "2", "3"}


def test_the_table_has_what_the_records_have(tmp_path):
    numbers = {"fe.t": 0.1 + 0.2, "check.energy_balance": math.inf, "check.time_step": math.nan}
    with open_records(tmp_path, small_sweep()) as rows:
        inputs = small_sweep().inputs_of
        rows.add(row(5, **numbers, **inputs(5)))
        rows.add(row(2, status="refused", reason="no", **inputs(2)))
        path = write_table(tmp_path, small_sweep(), rows)
    columns_read = read_columns(path, ["run", "status", "reason", "corner.friction", *numbers])
    assert (columns_read["run"].tolist(), columns_read["status"].tolist()) == ([2, 5], ["refused", "passed"])
    assert (columns_read["corner.friction"].tolist(), columns_read["fe.t"][1]) == ([0.2, 0.5], 0.1 + 0.2)
    assert math.isnan(columns_read["fe.t"][0])
    assert math.isnan(columns_read["check.energy_balance"][1]), "null in the table"


def test_reading_the_table_starts_no_thread(tmp_path):
    """A thread with a buffer of the file aborts the interpreter."""
    with open_records(tmp_path, small_sweep()) as rows:
        rows.add(row(0))
        path = write_table(tmp_path, small_sweep(), rows)
    code = """
import os, sys
import pyarrow.parquet
from tailslap.result.columns import read_columns
before = os.listdir("/proc/self/task")
with open(sys.argv[1], "rb") as file:
    assert read_columns(file)["status"].tolist() == ["passed"]
assert os.listdir("/proc/self/task") == before
"""
    process = subprocess.run([sys.executable, "-c", code, str(path)], timeout=60.0)
    assert process.returncode == 0


def test_a_folder_is_one_sweep_s(begun):
    refused(r"another sweep \(vary differ", sweep_folder, begun, small_sweep("0:1:6"))
    refused("other files", result_folder, begun)
    (begun / "summary.json").write_text("{}")
    refused("other files", result_folder, begun)
    # A new SciPy may draw other samples from the same seed.
    definition = json.loads((begun / "sweep.json").read_text())
    (begun / "sweep.json").write_text(json.dumps(definition | {"digest": "0"}))
    refused(r"another sweep \(values differ", sweep_folder, begun, small_sweep())
    (begun / "sweep.json").write_text("{")
    refused("damaged", sweep_folder, begun, small_sweep())


def test_two_sweeps_in_a_folder_at_once(tmp_path):
    with sweep_folder(tmp_path / "sweep", small_sweep()) as folder:
        refused("another command uses this folder", sweep_folder, folder, small_sweep())


def test_nothing_is_left_of_a_sweep_without_rows(tmp_path):
    with sweep_folder(tmp_path / "a" / "b", small_sweep()), open_records(tmp_path / "a" / "b", small_sweep()):
        assert (tmp_path / "a" / "b" / "sweep.json").is_file()
    assert not list(tmp_path.iterdir())


def test_what_is_not_a_sweep_s_is_refused_and_nothing_is_changed(tmp_path):
    """Other files, another or damaged sweep.json, and a lock remain."""
    foreign = {"thesis.txt": {"thesis.txt": "x"}, r"\.lock": {".lock": "x"}}
    foreign["another sweep"] = {"sweep.json": "{}", "report.html": "x"}
    foreign["damaged"] = {"sweep.json": "{", "report.html": "x"}
    for number, (named, texts) in enumerate(foreign.items()):
        place = tmp_path / str(number)
        place.mkdir()
        for name, text in texts.items():
            (place / name).write_text(text)
        refused(named, sweep_folder, place, small_sweep())
        assert {path.name: path.read_text() for path in place.iterdir()} == texts


@pytest.mark.parametrize("name", ["sweep.parquet", "report.html", "summary.json"])
def test_a_result_of_a_sweep_that_was_changed_or_added_is_refused(begun, name):
    for text in ("ours", "ours again"):  # resumed, it is written again
        with sweep_folder(begun, small_sweep()) as folder:
            (fresh(folder) / name).write_text(text)
            commit(folder)
    (begun / name).write_text("mine")
    refused(f"its file {name} was modified", sweep_folder, begun, small_sweep())
    assert (begun / name).read_text() == "mine"
    (begun / MANIFEST).unlink()
    refused(f"its file {name} does not belong to the result", sweep_folder, begun, small_sweep())
    assert {path.name for path in begun.iterdir()} == {"sweep.json", RECORDS, name}
