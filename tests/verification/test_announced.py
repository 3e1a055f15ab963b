"""Verification: what takes long on a terminal says so, counts the seconds, and leaves whole lines."""

from __future__ import annotations

import io
import time
from types import SimpleNamespace

import pytest

from tailslap import progress
from tailslap.progress import announced, compiling

pytestmark = pytest.mark.verification


class Terminal(io.StringIO):
    """Takes what is written, and says that it is a terminal."""

    def isatty(self) -> bool:
        return True


@pytest.fixture
def terminal(monkeypatch: pytest.MonkeyPatch) -> Terminal:
    made = Terminal()
    monkeypatch.setattr(progress, "sys", SimpleNamespace(stderr=made))  # pytest sets its own in sys
    monkeypatch.setattr(progress, "DELAY", 0.05)
    monkeypatch.setattr(progress, "_last_sign", time.monotonic())
    monkeypatch.delenv(progress.MODE, raising=False)
    return made


def seen(terminal: Terminal, words: str, times: int = 1) -> None:
    """Wait until they have been said so often."""
    end = time.monotonic() + 5.0
    while terminal.getvalue().count(words) < times:
        assert time.monotonic() < end, terminal.getvalue()
        time.sleep(0.01)


def test_what_is_over_at_once_is_not_mentioned(terminal: Terminal, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(progress, "DELAY", 60.0)
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


def test_the_line_of_a_bar_is_taken_back(terminal: Terminal) -> None:
    with announced("Impacts ...", transient=True):
        seen(terminal, "Impacts", times=2)
    assert terminal.getvalue().endswith(progress.ERASED)
    assert "\n" not in terminal.getvalue()
