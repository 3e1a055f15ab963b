"""Verify that long work is announced with its seconds."""

import io
import re
import time
from types import SimpleNamespace

import pytest

from tailslap import progress
from tailslap.progress import announced, compiling, counted, progress_bar

ERASED = "\x1b[2K"
"""Erases a line of a terminal."""


class Terminal(io.StringIO):
    """Text stream that reports to be a terminal."""

    def isatty(self):
        return True


@pytest.fixture
def terminal(monkeypatch):
    stream = Terminal()
    monkeypatch.setattr(progress, "sys", SimpleNamespace(stderr=stream))  # pytest sets its own in sys
    monkeypatch.setattr(progress, "DELAY", 0.05)
    monkeypatch.setattr(progress, "_last_output", time.monotonic())
    monkeypatch.delenv(progress.MODE, raising=False)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "100")
    return stream


def seen(terminal, words, times=1):
    """Wait until the words were written a number of times."""
    end = time.monotonic() + 5.0
    while text(terminal).count(words) < times:
        assert time.monotonic() < end, text(terminal)
        time.sleep(0.01)


def text(terminal):
    """All that was written, without colours."""
    return re.sub(r"\x1b\[[\d;]*m", "", terminal.getvalue())


def test_what_is_over_at_once_is_not_mentioned(terminal, monkeypatch):
    monkeypatch.setattr(progress, "DELAY", 60.0)
    with announced("Building ..."):
        pass
    assert terminal.getvalue() == ""


def test_long_work_counts_its_seconds_on_one_line_that_vanishes(terminal):
    with announced("Building ..."):
        seen(terminal, "Building ... 0 s", times=3)
        seen(terminal, "Building ... 1 s")
    assert terminal.getvalue().count("\n") == 1
    assert terminal.getvalue().endswith(f"\x1b[1A{ERASED}")


def test_what_is_said_meanwhile_has_a_line_of_its_own(terminal):
    with announced("Building ..."):
        seen(terminal, "Building")
        compiling("compiling the time loop: about 10 s")
        seen(terminal, "about 10 s\n")
        seen(terminal, "Building", times=3)
    assert f"{ERASED}tailslap: compiling the time loop" in text(terminal)


def test_an_error_ends_the_line(terminal):
    def fail():
        with announced("Building ..."):
            seen(terminal, "Building")
            raise ValueError

    with pytest.raises(ValueError, match=r"^$"):
        fail()
    assert ERASED in terminal.getvalue().rpartition("Building")[2]
    assert progress._live is None


def test_a_bar_that_does_not_move_counts_its_seconds(terminal, monkeypatch):
    monkeypatch.setattr(progress, "clock", lambda seconds: f"{1000.0 * seconds:.0f} ms")
    with progress_bar("Impacts"):
        seen(terminal, "Impacts: 0 %, ", times=3)
    times = re.findall(r"0 %, (\d+) ms so far", text(terminal))
    assert len(set(times)) > 1


def test_a_count_begins_with_what_was_done_before(terminal):
    with counted("Cells", 200, 50):
        seen(terminal, " 25 % ")
        seen(terminal, "Cells: 50 of 200, 0:00 so far")


def test_within_a_bar_only_the_bar_is_seen(terminal):
    with progress_bar("Impacts") as show, announced("Building ..."), progress_bar("Steps"):
        show(0.5)
        seen(terminal, "Impacts: 50 %, 0:00 left", times=3)
    assert "Building" not in terminal.getvalue()
    assert "Steps" not in terminal.getvalue()


def test_what_follows_the_progress_gets_the_lines_of_its_thread_alone(terminal):
    """Those of what runs within are silent, and so is the terminal."""
    lines: list[str] = []
    with progress.followed(lines.append), progress_bar("steps", 10) as show:
        show(0.5)
        with counted("inner", 4, 0) as inner:
            inner(2)
    with counted("after", 4, 0, 0.0):
        pass
    (line,) = lines
    assert re.match(r"steps: 5 of 10", line)
    assert "steps" not in terminal.getvalue()
