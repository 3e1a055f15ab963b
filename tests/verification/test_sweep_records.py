"""Verification: what a sweep keeps on disk survives kills, and belongs to one sweep and one process alone."""

import json
import math
import os
import signal
import sqlite3
import subprocess
import sys
import time
from typing import Any

import pytest

from tailslap.campaign import records
from tailslap.campaign.definition import Definition, make_definition
from tailslap.campaign.perform import RECORDS, open_records, sweep_folder
from tailslap.campaign.table import read_columns, write_table
from tailslap.errors import InputError
from tailslap.files.folder import result_folder
from tailslap.files.manifest import NAME as MANIFEST
from tailslap.files.manifest import demand_ours, listed_file

RUNS = 6


def row(run: int, **more: Any) -> dict[int, dict[str, Any]]:
    return {run: {"run": run, "status": "passed", "reason": ""} | more}


def sweep(friction: str = "0:0.5:6") -> Definition:
    return make_definition("paper-table-3", (), (f"corner.friction={friction}",), None, 307)


def test_rows_come_back_in_the_order_of_their_runs(tmp_path):
    with open_records(tmp_path, sweep()) as rows:
        rows.add(row(4, deflection_ratio=0.1) | row(1))
        rows.add(row(10) | row(0))
    with open_records(tmp_path, sweep()) as rows:
        assert [found["run"] for found in rows.in_order()] == list(rows) == [0, 1, 4, 10]
        assert rows[4] == row(4, deflection_ratio=0.1)[4]
        assert rows.statuses["passed"] == len(rows) == 4
        assert 2 not in rows
        with pytest.raises(KeyError):
            rows[2]


def test_a_second_row_of_the_same_run_is_not_taken(tmp_path):
    with open_records(tmp_path, sweep()) as rows:
        rows.add(row(1, deflection_ratio=0.1))
        rows.add(row(1, deflection_ratio=0.3))
        assert [found["deflection_ratio"] for found in rows.in_order()] == [0.1]
        assert rows.statuses["passed"] == 1
    assert records.count(tmp_path / RECORDS) == 1


def test_any_tool_of_sqlite_sees_the_values_in_columns(tmp_path):
    """Also those that only some rows have, and numbers that JSON does not have; nothing lies beside the file."""
    with open_records(tmp_path, sweep()) as rows:
        rows.add(row(0, **{"fe.t": 1 / 3}), {0: 1.5})
        rows.add(row(1, **{"fe.t": math.inf, "it's": "x"}))
    (path,) = tmp_path.iterdir()
    file = sqlite3.connect(path)
    shown = file.execute('SELECT key, status, seconds, "fe.t", "it\'s" FROM result ORDER BY key').fetchall()
    file.close()
    assert shown == [(0, "passed", 1.5, 1 / 3, None), (1, "passed", None, '{"not finite":"inf"}', "x")]


def test_records_of_another_definition_or_program_are_begun_anew(tmp_path, monkeypatch):
    path = tmp_path / "r.sqlite"
    definition: dict[str, Any] = {"a": 1}
    for change, program, kept in (({}, "1", []), ({}, "1", [0]), ({"a": 2}, "1", []), ({"a": 2}, "2", [])):
        definition |= change
        monkeypatch.setattr(records, "program", lambda program=program: program)
        found = records.Records(path, definition)
        assert list(found) == kept
        found.add({0: {"status": "passed"}})
        found.close()


def test_the_program_is_known_by_its_sources():
    """By version and digest, of what another process finds as well."""
    code = "from tailslap.campaign.records import program; print(program())"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert said.strip() == records.program()
    assert len(records.program().partition("+")[2]) == 16


WRITER = """
import itertools, sys
from pathlib import Path
from tailslap.campaign.records import Records
found = Records(Path(sys.argv[1]), {})
for run in itertools.count():
    found.add({run: {"run": run}})
    print(run, flush=True)
"""


def test_what_was_added_before_a_kill_is_there(tmp_path):
    path = tmp_path / "r.sqlite"
    writer = subprocess.Popen([sys.executable, "-c", WRITER, str(path)], stdout=subprocess.PIPE, text=True)
    assert writer.stdout is not None
    for _ in range(20):
        writer.stdout.readline()
    time.sleep(0.003)
    writer.send_signal(signal.SIGKILL)
    said = 20 + len(writer.communicate()[0].splitlines())
    found = records.Records(path, {})
    assert list(found) == list(range(len(found)))
    assert said <= len(found) <= said + 1
    found.close()
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("content", [b"my diary\n", b"", b"SQLite format 3\0" + bytes(4080)])
def test_records_of_another_kind_are_refused_and_kept(tmp_path, content):
    (tmp_path / RECORDS).write_bytes(content)
    with pytest.raises(InputError, match="no journal"), open_records(tmp_path, sweep()):
        pass
    assert (tmp_path / RECORDS).read_bytes() == content


def test_records_that_were_cut_off_are_refused_and_kept(tmp_path):
    with open_records(tmp_path, sweep()) as rows:
        rows.add(row(0, text="x" * 10_000))
    whole = (tmp_path / RECORDS).read_bytes()
    for length in (100, len(whole) // 2):
        (tmp_path / RECORDS).write_bytes(whole[:length])
        with pytest.raises(InputError, match="no journal"), open_records(tmp_path, sweep()):
            pass
        assert (tmp_path / RECORDS).read_bytes() == whole[:length]


def test_the_table_has_what_the_records_have(tmp_path):
    numbers = {"fe.t": 0.1 + 0.2, "check.energy_balance": math.inf, "check.time_step": math.nan}
    with open_records(tmp_path, sweep()) as rows:
        rows.add(
            row(5, **numbers, **sweep().inputs_of(5))
            | row(2, status="refused", reason="no", **sweep().inputs_of(2))
        )
        path = write_table(tmp_path, sweep(), rows)
    found = read_columns(path, ["run", "status", "reason", "corner.friction", *numbers])
    assert found["run"].tolist() == [2, 5]
    assert found["status"].tolist() == ["refused", "passed"]
    assert found["corner.friction"].tolist() == [0.2, 0.5]
    assert found["fe.t"][1] == 0.1 + 0.2
    assert math.isnan(found["fe.t"][0])
    assert math.isnan(found["check.energy_balance"][1])  # null in the table: it has finite numbers alone


def test_a_folder_is_one_sweep_s(tmp_path):
    place = tmp_path / "sweep"
    with sweep_folder(place, sweep()) as folder, open_records(folder, sweep()) as rows:
        rows.add(row(0))
    with (
        pytest.raises(InputError, match=r"it holds another sweep: vary differ"),
        sweep_folder(place, sweep("0:1:6")),
    ):
        pass
    with pytest.raises(InputError, match="other files"), result_folder(place):
        pass  # a run does not replace it, whatever it holds
    (place / "summary.json").write_text("{}")
    with pytest.raises(InputError, match="other files"), result_folder(place):
        pass
    (place / "sweep.json").write_text("{")
    with pytest.raises(InputError, match="damaged"), sweep_folder(place, sweep()):
        pass


def test_other_values_by_the_same_words_are_another_sweep(tmp_path):
    """A new SciPy may draw other samples from the same seed: rows must not mix."""
    place = tmp_path / "sweep"
    with sweep_folder(place, sweep()) as folder, open_records(folder, sweep()) as rows:
        rows.add(row(0))
    definition = json.loads((place / "sweep.json").read_text())
    (place / "sweep.json").write_text(json.dumps(definition | {"digest": "0"}))
    with pytest.raises(InputError, match="another sweep: values differ"), sweep_folder(place, sweep()):
        pass


def test_two_sweeps_in_a_folder_at_once(tmp_path):
    with (
        sweep_folder(tmp_path / "sweep", sweep()) as folder,
        pytest.raises(InputError, match="another sweep is at work"),
        sweep_folder(folder, sweep()),
    ):
        pass


def test_nothing_is_left_of_a_sweep_without_rows(tmp_path):
    with sweep_folder(tmp_path / "a" / "b", sweep()), open_records(tmp_path / "a" / "b", sweep()):
        assert (tmp_path / "a" / "b" / "sweep.json").is_file()
    assert not list(tmp_path.iterdir())


def test_what_is_not_a_sweep_s_is_refused_and_nothing_is_changed(tmp_path):
    """Other files, a sweep.json of something else, one that is damaged, and a file that has the name of the lock."""
    foreign: list[tuple[str, dict[str, str]]] = [
        ("thesis.txt", {"thesis.txt": "x"}),
        ("another sweep", {"sweep.json": "{}", "report.html": "x"}),
        ("damaged", {"sweep.json": "{", "report.html": "x"}),
        (r"\.lock", {".lock": "x"}),
    ]
    for number, (named, texts) in enumerate(foreign):
        place = tmp_path / str(number)
        place.mkdir()
        for name, text in texts.items():
            (place / name).write_text(text)
        with pytest.raises(InputError, match=named), sweep_folder(place, sweep()):
            pass
        assert {path.name: path.read_text() for path in place.iterdir()} == texts


@pytest.mark.parametrize("name", ["sweep.parquet", "report.html", "summary.json"])
def test_a_result_of_a_sweep_that_was_changed_or_added_is_refused(tmp_path, name):
    place = tmp_path / "sweep"
    with sweep_folder(place, sweep()) as folder, open_records(folder, sweep()) as rows:
        rows.add(row(0))
        with listed_file(folder / name) as partial:
            partial.write_text("ours")
    with sweep_folder(place, sweep()) as folder, listed_file(folder / name) as partial:
        partial.write_text("ours again")  # resumed, it is replaced
    (place / name).write_text("mine")
    with pytest.raises(InputError, match=f"{name} in it was added or changed"), sweep_folder(place, sweep()):
        pass
    with pytest.raises(InputError, match=name), listed_file(place / name):
        pass
    assert (place / name).read_text() == "mine"
    (place / MANIFEST).unlink()
    with pytest.raises(InputError, match=name), sweep_folder(place, sweep()):
        pass


@pytest.mark.parametrize("step", [1, 2, 3])
def test_killed_while_a_result_is_replaced_it_is_known_in_either_state(tmp_path, monkeypatch, step):
    """Manifest of both states, the file, manifest of the new one: stopped before each in turn."""
    path, replace, count = tmp_path / "report.html", os.replace, 0
    with listed_file(path) as partial:
        partial.write_text("old")

    def killed(source: Any, target: Any) -> None:
        nonlocal count
        count += 1
        if count == step:
            raise SystemExit
        replace(source, target)

    with monkeypatch.context() as patched:
        patched.setattr(os, "replace", killed)
        with pytest.raises(SystemExit), listed_file(path) as partial:
            partial.write_text("new")
    assert path.read_text() == ("new" if step == 3 else "old")
    demand_ours(path)
    with listed_file(path) as partial:
        partial.write_text("newest")
    assert {found.name for found in tmp_path.iterdir()} == {"report.html", MANIFEST}
