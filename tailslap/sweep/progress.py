"""How far a sweep is: a line that moves on a terminal, else a line now and then."""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Callable, Iterator

EVERY_S = 30.0
"""Seconds between lines where standard error is no terminal."""

Show = Callable[[int, int, int], None]
"""Takes runs that are done, runs that failed or ended in an error, and the workers' threads."""


@contextlib.contextmanager
def sweep_progress(total: int, before: int) -> Iterator[Show]:
    """Yield what shows the progress; before: runs that were done when the sweep began, which count for no rate."""
    began = time.monotonic()

    def words(done: int, failed: int, threads: int) -> str:
        seconds = time.monotonic() - began
        rate = (done - before) / seconds if seconds else 0.0
        left = clock((total - done) / rate) if rate else "?"
        idle = "" if threads else "; no worker is there, waiting for one"
        return f"{done} of {total} done, {failed} failed, {rate:.3g} runs/s, {left} left{idle}"

    with _terminal(total) if sys.stderr.isatty() else _lines() as write:
        yield lambda done, failed, threads: write(done, words(done, failed, threads))


def clock(seconds: float) -> str:
    """Hours, minutes and seconds."""
    minutes, seconds = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{seconds:02d}" if hours else f"{minutes}:{seconds:02d}"


@contextlib.contextmanager
def _terminal(total: int) -> Iterator[Callable[[int, str], None]]:
    from tqdm import tqdm

    form = "{percentage:3.0f} %|{bar:20}| {desc}"
    with tqdm(total=total, leave=False, file=sys.stderr, bar_format=form) as bar:

        def write(done: int, words: str) -> None:
            bar.n = done
            bar.set_description_str(words)

        yield write


@contextlib.contextmanager
def _lines() -> Iterator[Callable[[int, str], None]]:
    last = time.monotonic()

    def write(done: int, words: str) -> None:
        nonlocal last
        if time.monotonic() - last >= EVERY_S:
            last = time.monotonic()
            print(f"tailslap: {words}", file=sys.stderr, flush=True)

    yield write
