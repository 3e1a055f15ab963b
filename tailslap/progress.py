"""Progress on standard error: on a terminal a line that moves, once the terminal has been silent for a second.

One line at a time: what runs within something that shows its progress is silent. The environment variable `MODE` says
how: "auto"; "lines", from time to time a line also where standard error is no terminal; or "none". Processes started
meanwhile follow it.
"""

import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

MODE = "TAILSLAP_PROGRESS"
DELAY, LOGGED_EVERY, ASKED_EVERY = 1.0, 30.0, 5.0
"""Seconds of silence before anything moves; between lines of a count where standard error is no terminal; where lines
were asked for."""

_last_sign = time.monotonic()
"""Instant when something was seen last [s]: at first, when the process had come as far as this."""

_follower = threading.local()
"""Listener to the progress of a thread, if there is one."""

_live: Any = None
"""The line that moves, a `rich.live.Live`, while there is one."""


@contextmanager
def shown_as(mode: str) -> Iterator[None]:
    """Show progress in this mode, also in processes started within this block."""
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
    """Call a function with each line of progress in this thread, in place of showing it."""
    _follower.listener = listener
    try:
        yield
    finally:
        del _follower.listener


@contextmanager
def announced(text: str) -> Iterator[None]:
    """Say on a terminal that this is being done, and for how long."""
    began = time.monotonic()
    with _shown(lambda: f"{text} {time.monotonic() - began:.0f} s", None, None):
        yield


@contextmanager
def progress_bar(label: str, total: int = 0) -> Iterator[Callable[[float], None]]:
    """Yield a function that takes the fraction done, 0 to 1, of `total` things; silent where there is no terminal."""
    with counted(label, total, 0, None) as show:
        yield lambda fraction: show(fraction * max(total, 1))


@contextmanager
def counted(
    label: str,
    total: int,
    before: int,
    logged: float | None = LOGGED_EVERY,
    work_left: Callable[[float], float] | None = None,
) -> Iterator[Callable[..., None]]:
    """Yield a function that takes how many of `total` are done, and a note; it logs where there is no terminal.

    total: 0 where a fraction is shown in per cent. before: how many were done when this begins, which count for no
    rate. logged: seconds between log lines, None for none. work_left: what is left when so many are done, where they
    differ in cost.
    """
    began, done, note = time.monotonic(), float(before), ""
    left = work_left or (lambda count: max(total, 1) - count)

    def line() -> str:
        elapsed, own = time.monotonic() - began, done - before
        count = f"{round(done)} of {total}" if total else f"{100.0 * done:.0f} %"
        rate = f", {own / elapsed:.3g}/s" if total and own else ""
        return f"{label}: {count}{rate}, {_left(left(done), left(before) - left(done), elapsed)}{note}"

    def show(count: float, remark: str = "") -> None:
        nonlocal done, note
        done, note = count, remark
        log()

    with _shown(line, lambda: done / max(total, 1), logged) as log:
        yield show


def estimated(text: str) -> None:
    """Say what a long campaign will take, terminal or not, unless progress is silent."""
    if os.environ.get(MODE) != "none":
        compiling(text)


def compiling(text: str) -> None:
    """Say that a time loop is being compiled, terminal or not, for nothing else is seen."""
    global _last_sign
    message = f"tailslap: {text}"
    if _live is None:
        print(message, file=sys.stderr, flush=True)
    else:
        _live.console.print(message, markup=False, highlight=False, soft_wrap=True)
    _last_sign = time.monotonic()


def clock(seconds: float) -> str:
    """Hours, minutes and seconds."""
    minutes, seconds = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{seconds:02d}" if hours else f"{minutes}:{seconds:02d}"


def _left(rest: float, done: float, elapsed: float) -> str:
    return f"{clock(rest * elapsed / done)} left" if done > 0.0 else f"{clock(elapsed)} so far"


Line = Callable[[], str]


@contextmanager
def _shown(line: Line, fraction: Callable[[], float] | None, logged: float | None) -> Iterator[Line]:
    """Show a line that moves, or log it; yield what logs it where that is due. logged: seconds between log lines."""
    mode, every = os.environ.get(MODE, "auto"), logged if fraction else None
    every = ASKED_EVERY if mode == "lines" and fraction else every
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
            with _moving(line, fraction):
                yield str
        else:
            yield log


@contextmanager
def _moving(line: Line, fraction: Callable[[], float] | None) -> Iterator[None]:
    """Show the line, with a bar, from a thread; it is erased at the end."""
    ended = threading.Event()
    thread = threading.Thread(target=_show, args=(line, fraction, ended), daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()


def _show(line: Line, fraction: Callable[[], float] | None, ended: threading.Event) -> None:
    global _live, _last_sign
    if ended.wait(max(0.0, _last_sign + DELAY - time.monotonic())):
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
        console.show_cursor(True)  # a process that is killed would leave the terminal without
        ended.wait()
    _live, _last_sign = None, time.monotonic()
