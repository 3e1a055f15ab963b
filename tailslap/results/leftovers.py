"""Unfinished files and folders: each is locked by the process that fills it, so that the next one beside them can tell
what a dead process has left, and clears it.

A lock goes with its process, however that ends. Names say whose they are: `.NAME.XXXXXXXX.tailslap`.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import re
import secrets
from collections.abc import Iterator
from pathlib import Path

SUFFIX = ".tailslap"
MAX_STEM = 100
"""Characters of the place's name in that of an unfinished folder: together they must make a file name."""


@contextlib.contextmanager
def unfinished_folder(place: Path) -> Iterator[Path]:
    """A new folder beside `place`, locked by this process. Raises OSError. It is the caller's to move or remove."""
    while True:
        folder = _beside(place)
        folder.mkdir(0o700)
        with _locked(folder) as ours:
            if ours:
                yield folder
                return


@contextlib.contextmanager
def unfinished_file(path: Path) -> Iterator[Path]:
    """A new empty file beside `path`, locked likewise."""
    while True:
        partial = _beside(path)
        partial.touch(0o666, exist_ok=False)
        with _locked(partial) as ours:
            if ours:
                yield partial
                return


def clear_leftovers(place: Path) -> None:
    """Remove what dead processes have left beside `place` on their way to it; what cannot be removed stays."""
    name = re.compile(re.escape(f".{place.name[:MAX_STEM]}.") + "[0-9a-f]{16}" + re.escape(SUFFIX))
    with contextlib.suppress(OSError):
        for found in os.scandir(place.parent):
            if name.fullmatch(found.name) and not found.is_symlink():
                _clear(Path(found.path))


def _beside(place: Path) -> Path:
    return place.parent / f".{place.name[:MAX_STEM]}.{secrets.token_hex(8)}{SUFFIX}"


@contextlib.contextmanager
def _locked(path: Path) -> Iterator[bool]:
    """Whether this process has the lock, and the path is still there: another one may have cleared it in between."""
    try:
        number = os.open(path, os.O_RDONLY)
    except FileNotFoundError:
        yield False
        return
    try:
        yield _lock(number) and _is_at(number, path)
    finally:
        os.close(number)


def _lock(number: int) -> bool:
    try:
        fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def _is_at(number: int, path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(number), os.lstat(path))
    except FileNotFoundError:
        return False


def _clear(path: Path) -> None:
    """Remove it if its process is dead: of a folder the plain files in it, and then itself."""
    with contextlib.suppress(OSError), _locked(path) as dead:
        if not dead:
            return
        if not path.is_dir():
            path.unlink()
            return
        for inner in os.scandir(path):
            if inner.is_file(follow_symlinks=False):
                os.unlink(inner.path)
        path.rmdir()
