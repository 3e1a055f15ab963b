"""The manifest of a folder: the files that the program wrote there, with size and digest.

What it lists and is unchanged may be replaced or removed. Everything else belongs to the user: files that were added,
and files of the program that were changed since.
"""

import contextlib
import errno
import fcntl
import hashlib
import json
import os
import re
import stat
from collections.abc import Iterable, Iterator, Mapping
from io import BufferedReader
from pathlib import Path
from typing import Any, NamedTuple

import tailslap
from tailslap.errors import ABSENT

NAME, LOCK, NEW, LOG = ".tailslap-result.json", ".tailslap-lock", ".tailslap-new", ".tailslap-redo.json"
"""The manifest; while a command is at work in a folder, its lock, its new files, and the log of what they replace."""

PROGRAM = "tailslap"
SUFFIX = ".tailslap"
IRREGULAR = {errno.ELOOP, errno.ENXIO}
"""Errors of opening a link or a socket as a plain file."""
NOT_REGULAR = "it is not a regular file"
MAX_STEM = 100
"""Characters of a file's name in that of its unfinished one."""


class Entry(NamedTuple):
    """A file of the folder: its name, size [bytes] and SHA-256 digest."""

    path: str
    size: int
    sha256: str


class Origin(NamedTuple):
    """Command and scene of a result; both empty where they are not known."""

    command: str
    scene: str


UNKNOWN = Origin("", "")
KEYS = {"program", "version", *Origin._fields, "files"}


def open_plain(name: str, flags: int) -> int:
    """Open a file, as an opener of `open`, which must be a plain one. Raises OSError or ValueError."""
    try:
        number = os.open(name, flags | os.O_NOFOLLOW | os.O_NONBLOCK)
    except OSError as error:
        if error.errno in IRREGULAR:
            raise ValueError(NOT_REGULAR) from None
        raise
    if stat.S_ISREG(os.fstat(number).st_mode):
        return number
    os.close(number)
    raise ValueError(NOT_REGULAR)


def entry(path: Path) -> Entry | None:
    """The file as it is now; None for what is not there or is no plain file. Raises OSError where it cannot be read."""
    with valid_content():
        return read_entry(path)
    return None


@contextlib.contextmanager
def valid_content() -> Iterator[None]:
    """End the block at a file that is absent, not a regular one, or has invalid content.

    Raises other errors of the system, after which the file may be there.
    """
    try:
        yield
    except (OSError, ValueError, RecursionError) as error:
        if isinstance(error, OSError) and error.errno not in ABSENT:
            raise


def read_entry(path: Path) -> Entry:
    """The file as it is now. Raises OSError for one that cannot be read, ValueError for what is no plain file."""
    with open(path, "rb", opener=open_plain) as file:
        return entry_of(file, path.name)


def entry_of(file: BufferedReader, name: str) -> Entry:
    """The entry of an open file, read to its end."""
    digest = hashlib.file_digest(file, "sha256").hexdigest()
    return Entry(name, file.tell(), digest)


def read_manifest(folder: Path) -> frozenset[Entry] | None:
    """Entries of the folder's manifest; None if there is none, or it is not one that the program writes."""
    found = read_object(folder / NAME)
    entries = read_entries(found.get("files"))
    is_ours = found.get("program") == PROGRAM and found.keys() <= KEYS
    return entries if is_ours and entries and all(e.path != NAME for e in entries) else None


def read_origin(folder: Path) -> Origin:
    """Command and scene of the folder's result, by its manifest."""
    found = read_object(folder / NAME)
    return Origin(str(found.get("command", "")), str(found.get("scene", "")))


def write_manifest(folder: Path, entries: Iterable[Entry], origin: Origin) -> None:
    """Write the manifest of the folder."""
    files = [item._asdict() for item in sorted(entries)]
    head = {"program": PROGRAM, "version": tailslap.__version__}
    write_object(folder / NAME, {**head, **origin._asdict(), "files": files})


def write_object(path: Path, content: Mapping[str, Any]) -> None:
    """Write an object as JSON, with a digest of it."""
    path.write_text(json.dumps({**content, "sha256": _digest(content)}, indent=2), encoding="utf-8")


def read_object(path: Path) -> dict[str, Any]:
    """The object in a JSON file, without its digest; an empty one where there is none, or it is damaged.

    Raises OSError where it cannot be read.
    """
    with valid_content():
        with open(path, encoding="utf-8", opener=open_plain) as file:
            found = json.load(file)
        if isinstance(found, dict) and found.pop("sha256", None) == _digest(found):
            return found
    return {}


def _digest(content: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def read_entries(found: Any) -> frozenset[Entry] | None:
    """Entries from JSON; None if they are no list of plain files in the folder itself."""
    try:
        entries = [Entry(item["path"], item["size"], item["sha256"]) for item in found]
    except (TypeError, LookupError):
        return None
    return frozenset(entries) if isinstance(found, list) and all(map(_is_plain, entries)) else None


def _is_plain(item: Entry) -> bool:
    """True for an entry, read from a file, that names a file in the folder itself."""
    if not (isinstance(item.path, str) and isinstance(item.sha256, str) and type(item.size) is int):
        return False
    is_inside = re.fullmatch(r"[^/\0]+", item.path) and item.path not in (".", "..", LOCK, NEW, LOG)
    return bool(is_inside and re.fullmatch("[0-9a-f]{64}", item.sha256))


@contextlib.contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Yield a new name to write to; what is written there becomes the file with all of its content, or not at all.

    Who writes the same file at the same time waits.
    """
    partial = path.with_name(f".{path.name[:MAX_STEM]}{SUFFIX}")
    with locked_file(partial, wait=True):
        os.truncate(partial, 0)  # a dead process may have begun it
        try:
            yield partial
            sync(partial)
            os.replace(partial, path)
            sync(path.parent)
        except BaseException:
            partial.unlink(missing_ok=True)
            raise


def sync(path: Path) -> None:
    """Wait until a file, or the names in a folder, are on the disk."""
    number = os.open(path, os.O_RDONLY)
    try:
        os.fsync(number)
    except OSError as error:
        if error.errno != errno.EINVAL:  # file systems of a network know of no folders to be synced
            raise
    finally:
        os.close(number)


@contextlib.contextmanager
def locked_file(path: Path, wait: bool = False) -> Iterator[None]:
    """Lock a file, which is made if it is not there. The lock goes with its process, however that ends.

    Raises BlockingIOError where another process has it, OSError where it is no plain file or where the file system has
    no locks.
    """
    while True:
        number = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_NONBLOCK, 0o666)
        try:
            if not stat.S_ISREG(os.fstat(number).st_mode):
                raise OSError(errno.EINVAL, f"{path.name} is not a regular file")
            try:
                fcntl.flock(number, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
            except OSError as error:
                if not isinstance(error, BlockingIOError):
                    path.unlink()
                raise
            if _is_there(number, path):  # else who had it has removed the file in between
                yield
                return
        finally:
            os.close(number)


def _is_there(number: int, path: Path) -> bool:
    with contextlib.suppress(FileNotFoundError):
        return os.path.samestat(os.fstat(number), os.lstat(path))
    return False
