"""Show progress on standard error.

On a terminal a line is updated, once the terminal has been silent for a second. There is one line at a time: a task
within another one that shows its progress is silent. The environment variable `MODE` selects "auto"; "lines", lines at
intervals also where standard error is not a terminal; or "none". Processes started meanwhile follow it.
"""

import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.live import Live

MODE = "TAILSLAP_PROGRESS"
DELAY, LOG_INTERVAL, LINES_INTERVAL = 1.0, 30.0, 5.0
"""Seconds of silence before a line is shown; between lines of a count where standard error is not a terminal; between
lines in the mode "lines"."""

Line = Callable[[], str]
"""Function that returns the present line of progress."""

_last_output = time.monotonic()
"""Instant of the last output [s], at first of the start of the process."""

_follower = threading.local()
"""Listener to the progress of a thread, if there is one."""

_live: "Live | None" = None
"""Line on the terminal, while there is one."""


@contextmanager
def shown_as(mode: str) -> Iterator[None]:
    """Show progress in this mode, also in processes started in the block."""
    before = os.environ.get(MODE)
    os.environ[MODE] = mode
    try:
        yield
    finally:
        os.environ.pop(MODE)
        if before is not None:
            os.environ[MODE] = before


@contextmanager
def followed(listener: Callable[[str], None]) -> Iterator[None]:
    """Call a function with each line of progress in this thread.

    The line is not shown.
    """
    _follower.listener = listener
    try:
        yield
    finally:
        del _follower.listener


@contextmanager
def announced(text: str) -> Iterator[None]:
    """Show on a terminal the task in progress and its duration."""
    began = time.monotonic()
    with _shown(lambda: f"{text} {time.monotonic() - began:.0f} s", None, None):
        yield


@contextmanager
def progress_bar(label: str, total: int = 0) -> Iterator[Callable[[float], None]]:
    """Yield a function that takes the completed fraction of `total` items.

    The fraction is 0 to 1. Nothing is printed where standard error is not a terminal.
    """
    with counted(label, total, 0, None) as show:
        yield lambda fraction: show(fraction * max(total, 1))


@contextmanager
def counted(
    label: str,
    total: int,
    before: int,
    logged: float | None = LOG_INTERVAL,
    work_left: Callable[[float], float] | None = None,
) -> Iterator[Callable[..., None]]:
    """Yield a function that takes the number completed, and a note.

    It logs where standard error is not a terminal. total: number of items; 0 where a fraction is shown in per cent.
    before: number completed at the start, which does not count for the rate. logged: seconds between log lines, None
    for no log. work_left: remaining work by the number completed, where items differ in cost.
    """
    began, completed, note = time.monotonic(), float(before), ""
    remaining = work_left or (lambda count: max(total, 1) - count)

    def line() -> str:
        elapsed, recent = time.monotonic() - began, completed - before
        count = f"{round(completed)} of {total}" if total else f"{100.0 * completed:.0f} %"
        rate = f", {recent / elapsed:.3g}/s" if total and recent else ""
        time_left = _time_left(remaining(completed), remaining(before) - remaining(completed), elapsed)
        return f"{label}: {count}{rate}, {time_left}{note}"

    def show(count: float, remark: str = "") -> None:
        nonlocal completed, note
        completed, note = count, remark
        log()

    with _shown(line, lambda: completed / max(total, 1), logged) as log:
        yield show


def estimated(text: str) -> None:
    """Print the estimated cost of a campaign unless progress is silent."""
    if os.environ.get(MODE) != "none":
        compiling(text)


def compiling(text: str) -> None:
    """Print that a time loop is compiled, also without a terminal."""
    global _last_output
    message = f"tailslap: {text}"
    if _live is None:
        print(message, file=sys.stderr, flush=True)
    else:
        _live.console.print(message, markup=False, highlight=False, soft_wrap=True)
    _last_output = time.monotonic()


def clock(seconds: float) -> str:
    """Return a time [s] as hours, minutes and seconds."""
    minutes, seconds = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{seconds:02d}" if hours else f"{minutes}:{seconds:02d}"


def _time_left(remaining: float, completed: float, elapsed: float) -> str:
    """Return the remaining time by the rate, or the elapsed time."""
    if completed > 0.0:
        return f"{clock(remaining * elapsed / completed)} left"
    return f"{clock(elapsed)} so far"


@contextmanager
def _shown(line: Line, fraction: Callable[[], float] | None, logged: float | None) -> Iterator[Line]:
    """Show or log a line, and yield the function that logs it.

    logged: seconds between log lines.
    """
    mode, every = os.environ.get(MODE, "auto"), logged if fraction else None
    every = LINES_INTERVAL if mode == "lines" and fraction else every
    last = time.monotonic()

    def follow() -> str:
        _follower.listener(line())
        return ""

    def log() -> str:
        nonlocal last
        if every is not None and time.monotonic() - last >= every:
            last = time.monotonic()
            print(f"tailslap: {line()}", file=sys.stderr, flush=True)
        return ""

    with shown_as("none"):
        if mode == "none":
            yield str
        elif hasattr(_follower, "listener"):
            yield follow
        elif sys.stderr.isatty():
            with _on_terminal(line, fraction):
                yield str
        else:
            yield log


@contextmanager
def _on_terminal(line: Line, fraction: Callable[[], float] | None) -> Iterator[None]:
    """Update the line with a bar, and erase it at the end.

    A thread updates it.
    """
    ended = threading.Event()
    thread = threading.Thread(target=_update, args=(line, fraction, ended), daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()


def _update(line: Line, fraction: Callable[[], float] | None, ended: threading.Event) -> None:
    """Update the line on the terminal until the event is set."""
    global _live, _last_output
    if ended.wait(max(0.0, _last_output + DELAY - time.monotonic())):
        return
    from rich.console import Console
    from rich.live import Live
    from rich.progress_bar import ProgressBar
    from rich.table import Table
    from rich.text import Text

    def row() -> Table:
        grid = Table.grid(padding=(0, 1))
        text = Text(line(), no_wrap=True, overflow="ellipsis")
        if fraction is None:
            grid.add_row(text)
        else:
            grid.add_row(f"{100.0 * fraction():3.0f} %", ProgressBar(1.0, fraction(), width=10), text)
        return grid

    console = Console(file=sys.stderr)
    with Live(get_renderable=row, console=console, transient=True, refresh_per_second=10) as _live:
        console.show_cursor(True)  # else a killed process would hide the cursor of the terminal
        ended.wait()
    _live, _last_output = None, time.monotonic()
