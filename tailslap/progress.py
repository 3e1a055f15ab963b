"""Signs of life on the terminal, for what takes over two seconds; silent where standard error is no terminal."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

DELAY = 2.0
"""Seconds before anything is shown."""


@contextmanager
def progress_bar(label: str) -> Iterator[Callable[[float], None]]:
    """Yield a function that takes the share done, 0 to 1."""
    if not sys.stderr.isatty():
        yield lambda share: None
        return
    from tqdm import tqdm

    form = "{desc}: {percentage:3.0f} %|{bar}| {elapsed} of {remaining}"
    with tqdm(total=1.0, desc=label, delay=DELAY, leave=False, file=sys.stderr, bar_format=form) as bar:
        yield lambda share: bar.update(share - bar.n) and None


@contextmanager
def announced(text: str, delay: float = DELAY) -> Iterator[None]:
    """Say what is being done if it is not done after `delay` seconds."""
    if not sys.stderr.isatty():
        yield
        return
    timer = threading.Timer(delay, lambda: print(text, file=sys.stderr, flush=True))
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
