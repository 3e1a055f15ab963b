"""The manifest of a folder: the files that the program wrote there, with size and digest.

What it lists and is unchanged may be replaced or removed. Everything else belongs to the user: files that were added,
and files of the program that were changed since.

Unfinished files and folders are locked by the process that fills them, so that the next one beside them can tell what a
dead process has left, and clears it. A lock goes with its process, however that ends. Names say whose they are:
`.NAME.XXXXXXXX.tailslap`.
"""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import json
import os
import re
import secrets
import stat
from collections.abc import Callable, Iterable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

import tailslap
from tailslap.errors import InputError

NAME = ".tailslap-result.json"
PROGRAM = "tailslap"
SUFFIX = ".tailslap"
MAX_STEM = 100
"""Characters of the place's name in that of an unfinished folder: together they must make a file name."""


@dataclass(frozen=True)
class Entry:
    """A file of the folder: its name, size [bytes] and SHA-256 digest."""

    path: str
    size: int
    sha256: str


def entry(file: Path) -> Entry | None:
    """The file as it is now; None for a link, a folder, what is not there or cannot be read."""
    try:
        if not stat.S_ISREG(file.lstat().st_mode):
            return None
        with file.open("rb") as opened:
            digest = hashlib.file_digest(opened, "sha256").hexdigest()
            return Entry(file.name, opened.tell(), digest)
    except OSError:
        return None


def read_manifest(folder: Path) -> frozenset[Entry] | None:
    """Entries of the folder's manifest; None if there is none, or it is not one that the program writes."""
    if entry(folder / NAME) is None:
        return None
    try:
        found = json.loads((folder / NAME).read_text(encoding="utf-8"))
        entries = [Entry(item["path"], item["size"], item["sha256"]) for item in found["files"]]
    except (OSError, ValueError, TypeError, LookupError, RecursionError):
        return None
    is_ours = found.get("program") == PROGRAM and isinstance(found["files"], list)
    return frozenset(entries) if is_ours and all(map(_is_plain, entries)) else None


def write_manifest(folder: Path, entries: Iterable[Entry]) -> None:
    """Write the manifest of the folder, whole or not at all."""
    files = sorted((asdict(item) for item in entries), key=lambda item: item["path"])
    content = {"program": PROGRAM, "version": tailslap.__version__, "files": files}
    with whole_file(folder / NAME) as partial:
        partial.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")


@contextlib.contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Yield a new name to write to; what is written there becomes the file with all of its content, or not at all."""
    clear_leftovers(path)
    with unfinished(path, lambda new: new.touch(0o666, exist_ok=False)) as partial:
        try:
            yield partial
            with partial.open("rb") as written:
                os.fsync(written.fileno())
            os.replace(partial, path)
        except BaseException:
            partial.unlink(missing_ok=True)
            raise


@contextlib.contextmanager
def listed_file(path: Path) -> Iterator[Path]:
    """Write a file that the folder's manifest lists, whole or not at all; a user's own file is refused.

    Both states of the file are listed before it is replaced: killed in between, it is known in either.
    """
    demand_ours(path)
    with whole_file(path) as partial:
        yield partial
        others = {item for item in read_manifest(path.parent) or () if item.path != path.name}
        new = {Entry(path.name, item.size, item.sha256) for item in (entry(partial),) if item}
        old = {item for item in (entry(path),) if item}
        write_manifest(path.parent, others | old | new)
    write_manifest(path.parent, others | new)


def demand_ours(path: Path) -> None:
    """Raise InputError if there is a file of that name which the program has not written as it is now."""
    if os.path.lexists(path) and entry(path) not in (read_manifest(path.parent) or ()):
        allowed = (
            f"{path.name} in it was added or changed and would be lost; move it away, or give another folder"
        )
        raise InputError("--out", str(path.parent), allowed)


def _is_plain(item: Entry) -> bool:
    """True for an entry, read from a file, that names a file in the folder itself."""
    if not isinstance(item.path, str) or not isinstance(item.sha256, str) or type(item.size) is not int:
        return False
    outside = item.path in ("", ".", "..", NAME) or re.search(r"[/\0]", item.path)
    return not outside and re.fullmatch("[0-9a-f]{64}", item.sha256) is not None


@contextlib.contextmanager
def unfinished(place: Path, make: Callable[[Path], None]) -> Iterator[Path]:
    """A new file or folder beside `place`, made by `make` and locked by this process; the caller's to move or remove.

    Raises OSError.
    """
    while True:
        new = place.parent / f".{place.name[:MAX_STEM]}.{secrets.token_hex(8)}{SUFFIX}"
        make(new)
        with locked(new) as is_ours:
            if is_ours:
                yield new
                return


def clear_leftovers(place: Path) -> None:
    """Remove what dead processes have left beside `place` on their way to it; what cannot be removed stays."""
    name = re.compile(re.escape(f".{place.name[:MAX_STEM]}.") + "[0-9a-f]{16}" + re.escape(SUFFIX))
    with contextlib.suppress(OSError):
        for found in os.scandir(place.parent):
            if name.fullmatch(found.name) and not found.is_symlink():
                _clear(Path(found.path))


@contextlib.contextmanager
def locked(path: Path) -> Iterator[bool]:
    """Lock the path; yields False where another process has it, or has cleared it in between."""
    try:
        number = os.open(path, os.O_RDONLY)
    except FileNotFoundError:
        yield False
        return
    try:
        is_ours = False
        with contextlib.suppress(BlockingIOError, FileNotFoundError):
            fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
            is_ours = os.path.samestat(os.fstat(number), os.lstat(path))
        yield is_ours
    finally:
        os.close(number)


def _clear(path: Path) -> None:
    """Remove it if its process is dead: of a folder the plain files in it, and then itself."""
    with contextlib.suppress(OSError), locked(path) as is_dead:
        if not is_dead:
            return
        if not path.is_dir():
            path.unlink()
            return
        for inner in os.scandir(path):
            if inner.is_file(follow_symlinks=False):
                os.unlink(inner.path)
        path.rmdir()
