"""A line with a bar, which moves."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext

from tailslap.progress import terminal
from tailslap.progress.mode import mode, shown_as
from tailslap.progress.terminal import TERMINAL, each_second

Label = Callable[[], str]
Write = Callable[[float, Label], None]
"""Takes how much is done, and what makes the label, which is called where they are shown."""

EVERY, LOGGED_EVERY, ASKED_EVERY = 0.1, 30.0, 5.0
"""Seconds between two states of the line; between lines of a count where standard error is no terminal; where lines
were asked for."""

ERASED = "\r\x1b[2K"
"""What takes a line back."""


@contextmanager
def progress_bar(label: str, total: int = 0) -> Iterator[Callable[[float], None]]:
    """Yield a function that takes the share done, 0 to 1, of `total` things; silent where standard error is no
    terminal."""
    began = time.monotonic()

    def line(share: float) -> str:
        elapsed = time.monotonic() - began
        done = f"{round(share * total)} of {total}" if total else f"{100.0 * share:.0f} %"
        rate = f", {share * total / elapsed:.3g}/s" if total and share else ""
        return f"{label}: {done}{rate}, {_left(1.0 - share, share, elapsed)}"

    with _shown(1.0, nullcontext(_silent), 0.0, lambda: line(0.0)) as write:
        yield lambda share: write(share, lambda: line(share))


@contextmanager
def counted(label: str, total: int, before: int) -> Iterator[Callable[..., None]]:
    """Yield a function that takes how many of `total` are done, and what else is to be said.

    before: how many were done when this begins, which count for no rate. Where standard error is no terminal it is a
    line now and then.
    """
    began = time.monotonic()

    def line(done: int, note: str) -> str:
        elapsed, own = time.monotonic() - began, done - before
        rate = f", {own / elapsed:.3g}/s" if own else ""
        return f"{label}: {done} of {total}{rate}, {_left(total - done, own, elapsed)}{note}"

    with _shown(total, _log(LOGGED_EVERY), before, lambda: line(before, "")) as write:
        yield lambda done, note="": write(done, lambda: line(done, note))


def clock(seconds: float) -> str:
    """Hours, minutes and seconds."""
    minutes, seconds = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{seconds:02d}" if hours else f"{minutes}:{seconds:02d}"


def _left(rest: float, done: float, elapsed: float) -> str:
    return f"{clock(rest * elapsed / done)} left" if done > 0.0 else f"{clock(elapsed)} so far"


@contextmanager
def _shown(
    total: float, otherwise: AbstractContextManager[Write], done: float, label: Label
) -> Iterator[Write]:
    """A line that moves on a terminal; elsewhere lines, if asked for, or something else; within it nothing."""
    way, moves = mode(), sys.stderr.isatty()
    lines = _line(total, done, label) if moves else _log(ASKED_EVERY) if way == "lines" else otherwise
    with shown_as("none"), nullcontext(_silent) if way == "none" else lines as write:
        yield write


def _silent(done: float, label: Label) -> None:
    """Write nothing."""


@contextmanager
def _log(every: float) -> Iterator[Write]:
    """Yield what prints a line from time to time [s]."""
    last = time.monotonic()

    def write(done: float, label: Label) -> None:
        nonlocal last
        if time.monotonic() - last >= every:
            last = time.monotonic()
            print(f"tailslap: {label()}", file=sys.stderr, flush=True)

    yield write


@contextmanager
def _line(total: float, done: float, label: Label) -> Iterator[Write]:
    """Yield what writes a line with a bar over the last one; it is written again each second, and gone at the end."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn

    console = Console(file=sys.stderr)
    bar = Progress(
        TextColumn("{task.percentage:3.0f} %"),
        BarColumn(20),
        TextColumn("{task.description}", markup=False),
        console=console,
        auto_refresh=False,
        transient=True,
        redirect_stdout=False,
        redirect_stderr=False,
    )
    task, due, last = bar.add_task("", total=total), TERMINAL.last_sign + terminal.DELAY, (done, label)
    alone = threading.Lock()

    def write(done: float, label: Label) -> None:
        nonlocal due, last
        last = done, label
        with alone:
            if time.monotonic() < due:
                return
            bar.update(task, completed=done, description=label())
            if TERMINAL.open_line_ends_by != ERASED:
                TERMINAL.end_line()
            bar.start()
            console.show_cursor(True)  # a process that is killed would leave the terminal without
            bar.refresh()
            TERMINAL.write("", ends_by=ERASED)
            due = time.monotonic() + EVERY

    try:
        with each_second(lambda seconds: write(*last)):
            yield write
    finally:
        bar.stop()
        TERMINAL.open_line_ends_by = ""
