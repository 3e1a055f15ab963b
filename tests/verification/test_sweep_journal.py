"""Verification: what a sweep keeps on disk survives being torn, and belongs to one sweep and one process alone."""

from __future__ import annotations

import json
import math
import os
from pathlib import Path
from typing import Any

import pytest

from tailslap.errors import InputError
from tailslap.files.folder import result_folder
from tailslap.files.manifest import NAME as MANIFEST
from tailslap.files.manifest import demand_ours, listed_file
from tailslap.sweeps.definition import Definition, make_definition
from tailslap.sweeps.folder import sweep_folder
from tailslap.sweeps.journal import NAME, open_rows
from tailslap.sweeps.table import read_columns, write_table

pytestmark = pytest.mark.verification

RUNS = 6


def row(run: int, **more: Any) -> dict[int, dict[str, Any]]:
    return {run: {"run": run, "status": "passed", "reason": ""} | more}


def sweep(friction: str = "0:0.5:6") -> Definition:
    return make_definition("paper-table-3", (), (f"corner.friction={friction}",), None, 307)


def test_rows_come_back_in_the_order_of_their_runs(tmp_path: Path) -> None:
    with open_rows(tmp_path, sweep()) as rows:
        rows.records.add(row(4, deflection_ratio=0.1) | row(1))
        rows.records.add(row(0))
    with open_rows(tmp_path, sweep()) as rows:
        assert [found["run"] for found in rows.in_order()] == [0, 1, 4]
        assert rows.missing(RUNS) == [2, 3, 5]
        assert rows.statuses["passed"] == 3


def test_a_second_row_of_the_same_run_is_not_taken(tmp_path: Path) -> None:
    with open_rows(tmp_path, sweep()) as rows:
        rows.records.add(row(1, deflection_ratio=0.1))
        rows.records.add(row(1, deflection_ratio=0.3))
        assert [found["deflection_ratio"] for found in rows.in_order()] == [0.1]
        assert rows.statuses["passed"] == 1
    assert (tmp_path / NAME).read_bytes().count(b"\n") == 2  # the first is the head


def whole_journal(folder: Path) -> list[bytes]:
    """Lines of a journal with three rows."""
    with open_rows(folder, sweep()) as rows:
        rows.records.add(
            row(0, deflection_ratio=0.0) | row(1, deflection_ratio=1 / 3) | row(2, deflection_ratio=2 / 3)
        )
    return (folder / NAME).read_bytes().splitlines(keepends=True)


@pytest.mark.long
def test_a_journal_cut_anywhere_keeps_its_whole_lines(tmp_path: Path) -> None:
    """Cut after each byte in turn: the runs of whole lines are there, the torn one is missing and can be added."""
    head, *lines = whole_journal(tmp_path)
    whole = b"".join(lines)
    for length in range(len(whole) + 1):
        (tmp_path / NAME).write_bytes(head + whole[:length])
        complete = [run for run in range(3) if length >= sum(map(len, lines[: run + 1])) - 1]
        with open_rows(tmp_path, sweep()) as rows:
            assert sorted(rows.records) == complete
            for run in rows.missing(3):
                rows.records.add(row(run, deflection_ratio=run / 3))
        assert (tmp_path / NAME).read_bytes() == head + whole


def test_a_damaged_line_in_the_middle_is_computed_again(tmp_path: Path) -> None:
    head, first, _, last = whole_journal(tmp_path)
    (tmp_path / NAME).write_bytes(b"".join([head, first, b"\0\0\0\n", b"[1]\n", last]))
    with open_rows(tmp_path, sweep()) as rows:
        assert rows.missing(3) == [1]
        assert sorted(rows.records) == [0, 2]


def test_a_journal_of_another_kind_is_refused_and_kept(tmp_path: Path) -> None:
    (tmp_path / NAME).write_text("my diary\n")
    with pytest.raises(InputError, match="no journal"), open_rows(tmp_path, sweep()):
        pass
    assert (tmp_path / NAME).read_text() == "my diary\n"


def test_the_table_has_what_the_journal_has(tmp_path: Path) -> None:
    numbers = {"fe.t": 0.1 + 0.2, "check.energy_balance": math.inf, "check.time_step": math.nan}
    with open_rows(tmp_path, sweep()) as rows:
        rows.records.add(row(5, **numbers) | row(2, status="refused", reason="no"))
        path = write_table(tmp_path, sweep(), rows)
    found = read_columns(path, ["run", "status", "reason", "corner.friction", *numbers])
    assert found["run"].tolist() == [2, 5]
    assert found["status"].tolist() == ["refused", "passed"]
    assert found["corner.friction"].tolist() == [0.2, 0.5]
    assert found["fe.t"][1] == 0.1 + 0.2
    assert math.isnan(found["fe.t"][0])
    assert math.isnan(found["check.energy_balance"][1])  # null in the table: it has finite numbers alone


def test_a_folder_is_one_sweep_s(tmp_path: Path) -> None:
    place = tmp_path / "sweep"
    with sweep_folder(place, sweep()) as folder, open_rows(folder, sweep()) as rows:
        rows.records.add(row(0))
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


def test_other_values_by_the_same_words_are_another_sweep(tmp_path: Path) -> None:
    """A new SciPy may draw other samples from the same seed: rows must not mix."""
    place = tmp_path / "sweep"
    with sweep_folder(place, sweep()) as folder, open_rows(folder, sweep()) as rows:
        rows.records.add(row(0))
    definition = json.loads((place / "sweep.json").read_text())
    (place / "sweep.json").write_text(json.dumps(definition | {"digest": "0"}))
    with pytest.raises(InputError, match="another sweep: values differ"), sweep_folder(place, sweep()):
        pass


def test_two_sweeps_in_a_folder_at_once(tmp_path: Path) -> None:
    with (
        sweep_folder(tmp_path / "sweep", sweep()) as folder,
        pytest.raises(InputError, match="another sweep is at work"),
        sweep_folder(folder, sweep()),
    ):
        pass


def test_nothing_is_left_of_a_sweep_without_rows(tmp_path: Path) -> None:
    with sweep_folder(tmp_path / "a" / "b", sweep()), open_rows(tmp_path / "a" / "b", sweep()):
        assert (tmp_path / "a" / "b" / "sweep.json").is_file()
    assert not list(tmp_path.iterdir())


def test_what_is_not_a_sweep_s_is_refused_and_nothing_is_changed(tmp_path: Path) -> None:
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
def test_a_result_of_a_sweep_that_was_changed_or_added_is_refused(tmp_path: Path, name: str) -> None:
    place = tmp_path / "sweep"
    with sweep_folder(place, sweep()) as folder, open_rows(folder, sweep()) as rows:
        rows.records.add(row(0))
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
def test_killed_while_a_result_is_replaced_it_is_known_in_either_state(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: int
) -> None:
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
