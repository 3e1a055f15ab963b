"""Verify the order of parts of a study, and their journal."""

import contextlib
import operator
import signal
import sqlite3
import subprocess
import sys
import time

import pytest
from processes import alive, children

from tailslap import progress
from tailslap.campaign.engine import run_parts
from tailslap.campaign.records import Journal, count, kept
from tailslap.errors import InputError, Interrupted, Verbatim


@pytest.fixture
def journal(tmp_path):
    return lambda **definition: Journal(tmp_path / "out", definition)


def interrupt(journal, records):
    with journal as begun:
        begun.records.add(records)
        raise KeyboardInterrupt


def test_journal_is_taken_up_until_the_files_are_written(journal, tmp_path):
    """An error of the report, and an interrupt during it, lose nothing."""
    records, place = {"x": {"value": 1.5}, "y": {"value": float("inf")}}, tmp_path / "out"
    with pytest.raises(Interrupted, match="2 parts are saved"), kept(place):
        interrupt(journal(a=1), records)

    def reported(error):
        with journal(a=1) as again:
            assert again.records == records
        raise error

    with pytest.raises(OSError, match="disk full"), kept(place):
        reported(OSError("disk full"))
    with pytest.raises(Interrupted, match="2 parts are saved"), kept(place):
        reported(KeyboardInterrupt())
    with kept(place), journal(a=1) as again:
        assert again.records == records
    assert list(tmp_path.iterdir()) == []


def test_a_link_in_the_place_of_the_journal_is_refused(journal, tmp_path):
    with pytest.raises(Interrupted):
        interrupt(journal(a=1), {"x": 1})
    path = journal(a=1).path
    path.rename(tmp_path / "elsewhere")
    path.symlink_to(tmp_path / "elsewhere")
    with pytest.raises(InputError, match="not a valid journal"), journal(a=1):
        pass
    assert path.is_symlink()


def test_a_journal_is_not_lost_if_it_cannot_be_begun_anew(journal, monkeypatch):
    """Another program writes to the file, for example."""
    with pytest.raises(Interrupted):
        interrupt(journal(a=1), {"x": 1})
    monkeypatch.setattr("tailslap.campaign.records.PATIENCE_S", 0.1)
    with contextlib.closing(sqlite3.connect(journal(a=1).path)) as connection:
        connection.execute("BEGIN IMMEDIATE")
        with pytest.raises((InputError, OSError), match="locked"), journal(a=2):
            pass
    with journal(a=1) as again:
        assert again.records == {"x": 1}


def test_parts_that_the_journal_has_are_not_run_again(journal):
    with journal(a=1) as noted:
        noted.records.add({"seven": "kept"})
        run_parts(operator.add, {"seven": (3, 4), "five": (2, 3)}, noted, "adding", workers=1)
        assert noted.records == {"seven": "kept", "five": 5}


def started(journal, parts, expected, monkeypatch):
    """Order of the parts of a single worker, and the messages."""
    messages: list[tuple[str, int]] = []
    order: list[str] = []
    monkeypatch.setattr("tailslap.progress.compiling", lambda text: messages.append((text, len(order))))
    with journal(a=1) as noted:
        noted.records.add({"done": None})
        run_parts(order.append, parts, noted, "cells", 1, expected)
        assert noted.records.keys() == parts.keys()
    return order, messages


def test_the_costliest_parts_come_first_none_is_lost_and_the_time_is_said_before(journal, monkeypatch):
    monkeypatch.delenv(progress.MODE, raising=False)
    parts = {key: (key,) for key in ("a", "done", "b", "c", "d")}
    expected = {"a": 10.0, "done": 1000.0, "b": 40.0, "c": 10.0, "d": 60.0}
    order, said = started(journal, parts, expected, monkeypatch)
    assert order == ["d", "b", "a", "c"]
    assert said == [("cells: expected time 2:00 on one core", 0)]


def test_parts_of_unknown_cost_keep_their_order_and_nothing_is_said(journal, monkeypatch):
    parts = {key: (key,) for key in ("b", "done", "c", "a")}
    assert started(journal, parts, {}, monkeypatch) == (["b", "c", "a"], [])


def test_silent_progress_announces_no_time(journal, monkeypatch):
    monkeypatch.setenv(progress.MODE, "none")
    assert started(journal, {"done": (), "a": ("a",)}, {"a": 1.0}, monkeypatch) == (["a"], [])


def test_the_time_left_is_that_of_the_work_which_is_left(monkeypatch):
    monkeypatch.setattr(progress, "_time_left", lambda rest, part, elapsed: f"{rest:g} after {part:g}")
    lines: list[str] = []
    work = [0.0, 0.5, 1.0, 10.0]
    remaining = lambda n: work[4 - round(n)]  # noqa: E731
    with progress.followed(lines.append), progress.counted("x", 4, 1, work_left=remaining) as show:
        show(2)
        show(4)
    assert [line.rpartition(", ")[2] for line in lines] == ["1 after 9", "0 after 10"]


@pytest.mark.long
@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_a_study_that_is_ended_keeps_what_was_done_and_leaves_no_process(tmp_path, sent):
    """Two parts sleep for ten minutes, and end with their workers."""
    code = (
        "import time\nfrom pathlib import Path\nfrom tailslap.campaign.engine import run_parts\n"
        "from tailslap.campaign.records import Journal\nif __name__ == '__main__':\n"
        "    parts = {'short': (0.0,), 'long': (600.0,), 'longer': (600.0,)}\n"
        f"    with Journal(Path({str(tmp_path / 'out')!r}), {{}}) as journal:\n"
        "        run_parts(time.sleep, parts, journal, 'x', workers=2)\n"
    )
    script = tmp_path / "script.py"
    script.write_text(code)
    journal = tmp_path / ".out.journal"
    process = subprocess.Popen([sys.executable, str(script)], stderr=subprocess.PIPE, text=True)
    for _ in range(4800):
        if journal.is_file() and count(journal):
            break
        time.sleep(0.05)
    below = children(process.pid)
    assert len(below) >= 2
    began = time.monotonic()
    process.send_signal(sent)
    _, error = process.communicate(timeout=120)
    while any(map(alive, below)):
        assert time.monotonic() - began < 120.0
        time.sleep(0.05)
    assert ("1 parts are saved" in error, count(journal)) == (sent == signal.SIGINT, 1)


@pytest.mark.long
def test_a_part_s_error_is_raised_as_it_was(journal):
    """It keeps its type across processes, and earlier parts remain."""
    for workers in (1, 2):
        with pytest.raises(InputError, match="SCENE: given nothing-1; x"), journal(workers=workers) as noted:
            run_parts(raising, {"a": (0,), "b": (1,)}, noted, "raising", workers)
        with journal(workers=workers) as again:
            assert again.records == {"a": 0}


def raising(number):
    if number:
        time.sleep(1.0)
        raise InputError("SCENE", Verbatim(f"nothing-{number}"), "x")
    return number
