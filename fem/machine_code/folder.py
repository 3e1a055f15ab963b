"""The folder of the compiled code, named after a digest of all sources that the code depends on.

Numba itself only looks at the file of the function that it loads, and would go on using a loop whose inlined callee has
changed.
"""

from __future__ import annotations

import fcntl
import functools
import hashlib
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import platformdirs

from fem.registry import PACKAGE, outside_sources, watch

USUAL_S, TIME_FILE = 10.0, "seconds"
"""Seconds that a loop takes to be compiled where no other tells; the file that keeps what the last one took, of
whatever version."""


@functools.cache
def cache_folder() -> Path:
    """Folder of the compiled code: under $NUMBA_CACHE_DIR, else under the user's cache folder."""
    digest = _own_digest().copy()
    for source in outside_sources():
        digest.update(source)
    base = os.environ.get("NUMBA_CACHE_DIR") or platformdirs.user_cache_path("tailslap", appauthor=False)
    return Path(base) / digest.hexdigest()[:16]


watch(cache_folder.cache_clear)  # laws have changed: code that knows of them belongs into another folder


@functools.cache
def _own_digest() -> Any:
    digest = hashlib.sha256()
    for source in sorted(PACKAGE.rglob("*.py")):
        digest.update(source.read_bytes())
    return digest


def own_sources(function: Callable[..., Any]) -> str:
    """Digest of the sources of a function from outside this package: of its file, or of all of its package."""
    return _sources_of(function.__module__, function.__code__.co_filename)


@functools.cache
def _sources_of(module: str, file: str) -> str:
    path, depth = Path(file).resolve(), module.count(".")
    if PACKAGE in path.parents:
        return ""  # they name the folder
    digest = hashlib.sha256()
    with suppress(OSError):
        for source in sorted(path.parents[depth - 1].rglob("*.py")) if depth else [path]:
            digest.update(source.read_bytes())
    return digest.hexdigest()


def expected_time() -> float:
    """Seconds that a loop takes to be compiled: those that the last one took on this machine."""
    try:
        return float((cache_folder().parent / TIME_FILE).read_text())
    except (OSError, ValueError):
        return USUAL_S


def keep_time(seconds: float) -> None:
    """Keep what a loop took to be compiled, for the next to expect."""
    with suppress(OSError):
        (cache_folder().parent / TIME_FILE).write_text(f"{seconds:.2f}")


@contextmanager
def one_process_compiles(code: Path) -> Iterator[None]:
    """Make other processes wait that are here for the same code: they then load what this one has compiled.

    Where the folder of the compiled code cannot be written, each compiles for itself.
    """
    try:
        code.parent.mkdir(parents=True, exist_ok=True)
        lock = open(code.with_suffix(".lock"), "a")  # noqa: SIM115
    except OSError:
        yield
        return
    with lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield
