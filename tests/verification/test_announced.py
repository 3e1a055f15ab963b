"""Verification: what takes long on a terminal says so, counts the seconds, and leaves whole lines."""

from __future__ import annotations

import io
import re
import time
from types import SimpleNamespace

import pytest

from tailslap.progress import announced, bar, compiling, counted, progress_bar
from tailslap.progress import terminal as terminal_module
from tailslap.progress.mode import MODE

pytestmark = pytest.mark.verification


class Terminal(io.StringIO):
    """Takes what is written, and says that it is a terminal."""

    def isatty(self) -> bool:
        return True


@pytest.fixture
def terminal(monkeypatch: pytest.MonkeyPatch) -> Terminal:
    made = Terminal()
    monkeypatch.setattr(terminal_module, "sys", SimpleNamespace(stderr=made))  # pytest sets its own in sys
    monkeypatch.setattr(bar, "sys", SimpleNamespace(stderr=made))
    monkeypatch.setattr(terminal_module, "DELAY", 0.05)
    terminal_module.TERMINAL.write("", ends_by="")
    monkeypatch.delenv(MODE, raising=False)
    return made


def seen(terminal: Terminal, words: str, times: int = 1) -> None:
    """Wait until they have been said so often."""
    end = time.monotonic() + 5.0
    while terminal.getvalue().count(words) < times:
        assert time.monotonic() < end, terminal.getvalue()
        time.sleep(0.01)


def test_what_is_over_at_once_is_not_mentioned(terminal: Terminal, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(terminal_module, "DELAY", 60.0)
    with announced("Building ..."):
        pass
    assert terminal.getvalue() == ""


def test_long_work_counts_its_seconds_on_one_line(terminal: Terminal) -> None:
    with announced("Building ..."):
        seen(terminal, "\rBuilding ... ", times=3)
    assert terminal.getvalue().count("\n") == 1
    assert terminal.getvalue().endswith(" s\n")


def test_what_is_said_meanwhile_has_a_line_of_its_own(terminal: Terminal) -> None:
    with announced("Building ..."):
        seen(terminal, "Building")
        compiling(10.0, False)
        seen(terminal, "about 10 s\n\rBuilding")
    assert " s\ntailslap: compiling" in terminal.getvalue()


def test_an_error_ends_the_line(terminal: Terminal) -> None:
    def fail() -> None:
        with announced("Building ..."):
            seen(terminal, "Building")
            raise ValueError

    with pytest.raises(ValueError, match=r"^$"):
        fail()
    assert terminal.getvalue().endswith("s\n")


def test_a_bar_that_does_not_move_counts_its_seconds(
    terminal: Terminal, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bar, "clock", lambda seconds: f"{1000.0 * seconds:.0f} ms")
    with progress_bar("Impacts"):
        seen(terminal, "Impacts: 0 %, ", times=3)
    told = re.findall(r"0 %, (\d+) ms so far", terminal.getvalue())
    assert len(set(told)) > 1
    assert terminal.getvalue().endswith("\x1b[2K")


def test_a_count_begins_with_what_was_done_before(terminal: Terminal) -> None:
    with counted("Cells", 200, 50):
        seen(terminal, " 25 % ")
        seen(terminal, "Cells: 50 of 200, 0:00 so far")


def test_within_a_bar_only_the_bar_is_seen(terminal: Terminal) -> None:
    with progress_bar("Impacts") as show, announced("Building ..."), progress_bar("Steps"):
        show(0.5)
        seen(terminal, "Impacts: 50 %, 0:00 left", times=3)
    assert "Building" not in terminal.getvalue()
    assert "Steps" not in terminal.getvalue()


def test_a_message_takes_the_line_of_a_bar(terminal: Terminal) -> None:
    with progress_bar("Impacts"):
        seen(terminal, "Impacts")
        compiling(10.0, False)
        seen(terminal, "Impacts", times=3)
    assert f"{bar.ERASED}tailslap: compiling the time loop" in terminal.getvalue()
