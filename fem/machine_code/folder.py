"""The folder of the compiled code, named after a digest of all sources that the code depends on, and its files.

Numba itself only looks at the file of the function that it loads, and would go on using a loop whose inlined callee has
changed. What lies here is executed: folder and files must be this user's and closed to others, and nothing but a plain
file is opened.
"""

import fcntl
import functools
import hashlib
import os
import stat
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

import platformdirs

from fem.registry import outside_sources, source_of

USUAL_S, LONGEST_S, TIME_FILE = 10.0, 3600.0, "seconds"
"""Seconds that a loop takes to be compiled where no other tells, and less than any; the file of what the last took."""

PATIENCE_S = 2.0
"""Seconds after which it is said that another process is waited for."""


def cache_folder() -> Path:
    """Folder of the compiled code: under $NUMBA_CACHE_DIR, else under the user's cache folder."""
    base = os.environ.get("NUMBA_CACHE_DIR") or platformdirs.user_cache_path("tailslap", appauthor=False)
    return Path(base) / sources()[:16]


def sources() -> str:
    """Digest of the sources of this package and of the laws from outside it that are registered now."""
    digest = _own_digest().copy()
    for source in outside_sources():
        digest.update(source)
    return str(digest.hexdigest())


PACKAGE = Path(__file__).resolve().parents[1]


@functools.cache
def _own_digest() -> Any:
    digest = hashlib.sha256()
    for source in sorted(PACKAGE.rglob("*.py")):
        digest.update(source.read_bytes())
    return digest


@functools.cache
def own_sources(function: Callable[..., Any]) -> str:
    """Digest of the sources of a function from outside this package: of its file, or of all of its package."""
    path, depth = Path(function.__code__.co_filename).resolve(), function.__module__.count(".")
    if PACKAGE in path.parents:
        return ""  # among `sources`
    digest = hashlib.sha256(source_of(function))
    with suppress(OSError):
        for source in sorted(path.parents[depth - 1].rglob("*.py")) if depth else []:
            digest.update(source.read_bytes())
    return digest.hexdigest()


def read(path: Path, most: int) -> bytes:
    """Content of a file that may be trusted, of at most so many bytes; nothing where there is none.

    It is a plain file, it and its folder belong to this user, and they are closed to others.
    """
    with suppress(OSError):
        _claim(path.parent)
        with open(path, "rb", opener=_open) as file:
            status = os.fstat(file.fileno())
            if stat.S_ISREG(status.st_mode) and status.st_size <= most and _is_closed(status):
                return file.read(most)
    return b""


def write(path: Path, content: bytes) -> None:
    """Write a file, whole or not at all. Raises OSError, also for a folder that others can write."""
    _claim(path.parent)
    with tempfile.TemporaryDirectory(dir=path.parent, prefix=".") as own:
        with open(new := Path(own, path.name), "xb", opener=_open) as file:
            file.write(content)
        os.replace(new, path)


def _claim(folder: Path) -> None:
    """Make a folder where there is none. Raises OSError for one that is another user's, or open to others."""
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    if not _is_closed(folder.lstat()):
        raise PermissionError("it must belong to this user and be inaccessible to others (chmod 700)")


def _is_closed(status: os.stat_result) -> bool:
    """True for what belongs to this user, and nobody else can read or write."""
    return status.st_uid == os.geteuid() and not status.st_mode & 0o077


def _open(name: str, flags: int) -> int:
    """Open a file without following a link, and without waiting for the other end of a pipe."""
    return os.open(name, flags | os.O_NOFOLLOW | os.O_NONBLOCK, mode=0o600)


def expected_time() -> float:
    """Seconds that a loop takes to be compiled: those that the last one took on this machine."""
    with suppress(ValueError):
        seconds = float(read(cache_folder() / TIME_FILE, 32))
        if 0.0 < seconds < LONGEST_S:
            return seconds
    return USUAL_S


def keep_time(seconds: float) -> None:
    """Keep what a loop took to be compiled, for the next to expect. Raises OSError where nothing can be kept."""
    write(cache_folder() / TIME_FILE, f"{seconds:.2f}".encode())


@contextmanager
def one_process_compiles(code: Path, on_wait: Callable[[], None]) -> Iterator[None]:
    """Make other processes wait that are here for the same code: they then load what this one has compiled.

    on_wait: called when this one has waited for some time. Where nothing can be kept, each compiles for itself.
    """
    timer = threading.Timer(PATIENCE_S, on_wait)
    with ExitStack() as held:
        with suppress(OSError):
            _claim(code.parent)
            lock = held.enter_context(open(code.with_suffix(".lock"), "ab", opener=_open))
            timer.start()
            fcntl.flock(lock, fcntl.LOCK_EX)
        timer.cancel()
        yield
