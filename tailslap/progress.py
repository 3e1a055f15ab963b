"""Signs of life on standard error: on a terminal a line that moves, for what takes over a second.

One line at a time: what runs within something that shows its progress is silent. The environment variable `MODE` says
how: "auto"; "lines", from time to time a line also where standard error is no terminal; or "none"."""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext

Write = Callable[[float, Callable[[], str]], None]
"""Takes how much is done, and what makes the label, which is called where they are shown."""

DELAY, EVERY = 1.0, 0.1
"""Seconds of silence before anything is shown, and between two states of the line."""

LOGGED_EVERY, ASKED_EVERY = 30.0, 5.0
"""Seconds between lines of a count where standard error is no terminal; where lines were asked for."""

MODE = "TAILSLAP_PROGRESS"

ERASED = "\r\x1b[2K"
"""What takes a line back."""

_last_sign = time.monotonic()
"""When something was seen last: at first, when the process had come as far as this."""

_line_is_open = False
"""Whether the line on the terminal waits for more."""


@contextmanager
def progress_bar(label: str, total: int = 0) -> Iterator[Callable[[float], None]]:
    """Yield a function that takes the share done, 0 to 1, of `total` things; silent where standard error is no
    terminal."""
    began = time.monotonic()

    def line(share: float) -> str:
        rate = share / max(time.monotonic() - began, 1e-9)
        done = (
            f"{round(share * total)} of {total}, {rate * total:.3g}/s" if total else f"{100.0 * share:.0f} %"
        )
        return f"{label}: {done}, {_left(1.0 - share, rate)} left"

    with announced(f"{label} ...", transient=True), _shown(1.0, nullcontext(_silent)) as write:
        yield lambda share: write(share, lambda: line(share))


@contextmanager
def counted(label: str, total: int, before: int) -> Iterator[Callable[..., None]]:
    """Yield a function that takes how many of `total` are done, and what else is to be said.

    before: how many were done when this begins, which count for no rate. Where standard error is no terminal it is a
    line now and then.
    """
    began = time.monotonic()

    def line(done: int, note: str) -> str:
        rate = (done - before) / max(time.monotonic() - began, 1e-9)
        return f"{label}: {done} of {total}, {rate:.3g}/s, {_left(total - done, rate)} left{note}"

    with announced(f"{label} ...", transient=True), _shown(total, _log(LOGGED_EVERY)) as write:
        yield lambda done, note="": write(done, lambda: line(done, note))


@contextmanager
def announced(text: str, transient: bool = False) -> Iterator[None]:
    """Say what is being done once the terminal has been silent for so long, and then each second how long it takes.

    transient: the line is gone at the end, as that of a bar.
    """
    if not sys.stderr.isatty() or _mode() == "none":
        yield
        return
    done = threading.Event()
    thread = threading.Thread(target=_tell, args=(text, done, transient), daemon=True)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()


def _tell(text: str, done: threading.Event, transient: bool) -> None:
    global _line_is_open
    began = time.monotonic()
    ended = done.wait(max(0.0, _last_sign + DELAY - began))
    while not ended:
        if (
            _mode() != "none" and time.monotonic() >= _last_sign + 0.9 * DELAY
        ):  # else something else shows its progress
            print(f"\r{text} {time.monotonic() - began:.0f} s", end="", file=sys.stderr, flush=True)
            _line_is_open = True
            _seen()
        ended = done.wait(DELAY)
    _end_line(ERASED if transient else "\n")


def _end_line(by: str = "\n") -> None:
    """End a line that has been left open, before anything else is said."""
    global _line_is_open
    if _line_is_open:
        print(end=by, file=sys.stderr, flush=True)
    _line_is_open = False


def _seen() -> None:
    global _last_sign
    _last_sign = time.monotonic()


def compiling(seconds: float, done: bool) -> None:
    """Say that a time loop is being compiled, and how long that takes; terminal or not, for nothing else is seen."""
    text = (
        "compiled" if done else "compiling the time loop of this kind of model, once on this machine: about"
    )
    _end_line()
    print(f"tailslap: {text}{' in' if done else ''} {seconds:.0f} s", file=sys.stderr, flush=True)


def clock(seconds: float) -> str:
    """Hours, minutes and seconds."""
    minutes, seconds = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{seconds:02d}" if hours else f"{minutes}:{seconds:02d}"


@contextmanager
def shown_as(mode: str) -> Iterator[None]:
    """Within it, and in processes started within it, progress is shown so."""
    before = os.environ.get(MODE)
    os.environ[MODE] = mode
    try:
        yield
    finally:
        os.environ.pop(MODE)
        if before is not None:
            os.environ[MODE] = before


def _mode() -> str:
    return os.environ.get(MODE, "auto")


@contextmanager
def _shown(total: float, otherwise: AbstractContextManager[Write]) -> Iterator[Write]:
    """A line that moves on a terminal; elsewhere lines, if asked for, or something else; within it nothing."""
    mode, moves = _mode(), sys.stderr.isatty()
    way = _line(total) if moves else _log(ASKED_EVERY) if mode == "lines" else otherwise
    with shown_as("none"), nullcontext(_silent) if mode == "none" else way as write:
        yield write


def _left(rest: float, rate: float) -> str:
    return clock(rest / rate) if rate > 0.0 else "?"


def _silent(done: float, label: Callable[[], str]) -> None:
    """Write nothing."""


@contextmanager
def _log(every: float) -> Iterator[Write]:
    """Yield what prints a line from time to time [s]."""
    last = time.monotonic()

    def write(done: float, label: Callable[[], str]) -> None:
        nonlocal last
        if time.monotonic() - last >= every:
            last = time.monotonic()
            print(f"tailslap: {label()}", file=sys.stderr, flush=True)

    yield write


@contextmanager
def _line(total: float) -> Iterator[Write]:
    """Yield what writes a line with a bar over the last one; it is gone at the end. No thread of its own draws it."""
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
    task, due = bar.add_task("", total=total), _last_sign + DELAY

    def write(done: float, label: Callable[[], str]) -> None:
        nonlocal due
        if time.monotonic() >= due:
            bar.update(task, completed=done, description=label())
            _end_line(ERASED)
            bar.start()
            console.show_cursor(True)  # a process that is killed would leave the terminal without
            bar.refresh()
            _seen()
            due = time.monotonic() + EVERY

    try:
        yield write
    finally:
        bar.stop()
