"""How progress is shown: said in the environment, so that processes started meanwhile follow it."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

MODE = "TAILSLAP_PROGRESS"
"""Variable of the environment: "auto", "lines" or "none"."""


def mode() -> str:
    """How it is shown."""
    return os.environ.get(MODE, "auto")


@contextmanager
def shown_as(way: str) -> Iterator[None]:
    """Within it, and in processes started within it, progress is shown so."""
    before = os.environ.get(MODE)
    os.environ[MODE] = way
    try:
        yield
    finally:
        os.environ.pop(MODE)
        if before is not None:
            os.environ[MODE] = before
