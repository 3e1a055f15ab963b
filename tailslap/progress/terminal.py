"""What is said on the terminal once it has been silent for some time, from a thread of its own."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from tailslap.progress.mode import mode

DELAY = 1.0
"""Seconds of silence before anything is shown."""


class Terminal:
    """What this process has left on standard error.

    Attributes
    ----------
    last_sign : float
        When something was seen last [s]: at first, when the process had come as far as this.
    open_line_ends_by : str
        What ends a line that waits for more; empty where none does.
    """

    def __init__(self) -> None:
        self.last_sign = time.monotonic()
        self.open_line_ends_by = ""

    def write(self, text: str, ends_by: str) -> None:
        """Write what is seen now, and ends later."""
        print(end=text, file=sys.stderr, flush=True)
        self.open_line_ends_by, self.last_sign = ends_by, time.monotonic()

    def end_line(self) -> None:
        """End a line that has been left open, before anything else is said."""
        if self.open_line_ends_by:
            self.write(self.open_line_ends_by, "")


TERMINAL = Terminal()


@contextmanager
def announced(text: str) -> Iterator[None]:
    """Say what is being done once the terminal has been silent for so long, and then each second how long it takes."""

    def tell(seconds: float) -> None:
        if mode() != "none":  # else something else shows its progress
            TERMINAL.write(f"\r{text} {seconds:.0f} s", ends_by="\n")

    if not sys.stderr.isatty() or mode() == "none":
        yield
        return
    try:
        with each_second(tell):
            yield
    finally:
        TERMINAL.end_line()


@contextmanager
def each_second(tell: Callable[[float], None]) -> Iterator[None]:
    """Tell how many seconds it takes, whenever the terminal has been silent for so long."""
    done = threading.Event()
    thread = threading.Thread(target=_wait, args=(tell, done), daemon=True)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()


def _wait(tell: Callable[[float], None], done: threading.Event) -> None:
    began = time.monotonic()
    ended = done.wait(max(0.0, TERMINAL.last_sign + DELAY - began))
    while not ended:
        if time.monotonic() >= TERMINAL.last_sign + 0.9 * DELAY:
            tell(time.monotonic() - began)
        ended = done.wait(DELAY)


def compiling(seconds: float, done: bool) -> None:
    """Say that a time loop is being compiled, and how long that takes; terminal or not, for nothing else is seen."""
    text = (
        "compiled" if done else "compiling the time loop of this kind of model, once on this machine: about"
    )
    TERMINAL.end_line()
    print(f"tailslap: {text}{' in' if done else ''} {seconds:.0f} s", file=sys.stderr, flush=True)
