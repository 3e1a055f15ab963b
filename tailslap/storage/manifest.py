"""List the program's files in a folder.

The manifest has the size and digest of each. Listed files that are unchanged may be replaced or removed. Everything
else belongs to the user: added files, and files of the program that were changed since.
"""

import contextlib
import errno
import hashlib
import json
import os
import re
import stat
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

import tailslap
from machine_code.system import operating_system
from machine_code.system.operating_system import sync
from tailslap.errors import ABSENT

NAME, LOCK, NEW, LOG = ".tailslap-result.json", ".tailslap-lock", ".tailslap-new", ".tailslap-redo.json"
"""Names of the manifest, and, while a command runs, of its lock, its new files, and the log of what they replace."""

PROGRAM = "tailslap"
KEYS = {"program", "version", "command", "scene", "changes", "files"}
"""Value of the manifest's key "program", and its keys."""

SUFFIX = ".tailslap"
"""Ending of the names of unfinished files."""

IRREGULAR = {errno.ELOOP, errno.ENXIO}
"""Errors of opening a link or a socket as a plain file."""

NOT_REGULAR = "it is not a regular file"
MAX_STEM = 100
"""Characters of a file's name in that of its unfinished copy."""


class Entry(NamedTuple):
    """Name, size [bytes] and SHA-256 digest of a file."""

    path: str
    size: int
    sha256: str


class Origin(NamedTuple):
    """Command, scene and texts KEY=VALUE of its changes of a result.

    They are empty where they are unknown.
    """

    command: str
    scene: str
    changes: tuple[str, ...] = ()


def open_plain(name: str, flags: int) -> int:
    """Open a plain file.

    Used as an opener of `open`. Raises OSError or ValueError.
    """
    try:
        number = os.open(name, flags | operating_system.PLAIN)
    except OSError as error:
        if error.errno in IRREGULAR:
            raise ValueError(NOT_REGULAR) from None
        raise
    if stat.S_ISREG(os.fstat(number).st_mode):
        return number
    os.close(number)
    raise ValueError(NOT_REGULAR)


def entry(path: Path) -> Entry | None:
    """Return the entry of a plain file, None without one.

    Raises OSError where it cannot be read.
    """
    with valid_content():
        return read_entry(path)
    return None


@contextlib.contextmanager
def valid_content() -> Iterator[None]:
    """End the block at an invalid file.

    It is absent, irregular, or has invalid content. Raises other errors of the system, after which the file may exist.
    """
    try:
        yield
    except (OSError, ValueError, RecursionError) as error:
        if isinstance(error, OSError) and error.errno not in ABSENT:
            raise


def read_entry(path: Path) -> Entry:
    """Read the entry of a file.

    Raises OSError for a file that cannot be read, ValueError for one that is not plain.
    """
    with open(path, "rb", opener=open_plain) as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
        return Entry(path.name, file.tell(), digest)


def read_manifest(folder: Path) -> frozenset[Entry] | None:
    """Return the entries of the folder's manifest.

    None if there is no manifest, or not one that the program writes.
    """
    content = read_object(folder / NAME)
    entries = read_entries(content.get("files"))
    is_ours = content.get("program") == PROGRAM and content.keys() <= KEYS
    return entries if is_ours and entries and all(e.path != NAME for e in entries) else None


def read_origin(folder: Path) -> Origin:
    """Return the origin of the folder's result from its manifest."""
    content = read_object(folder / NAME)
    changes = content.get("changes")
    texts = tuple(map(str, changes)) if isinstance(changes, list) else ()
    return Origin(str(content.get("command", "")), str(content.get("scene", "")), texts)


def write_manifest(folder: Path, entries: Iterable[Entry], origin: Origin) -> None:
    """Write the manifest of the folder."""
    files = [item._asdict() for item in sorted(entries)]
    head = {"program": PROGRAM, "version": tailslap.__version__}
    write_object(folder / NAME, {**head, **origin._asdict(), "files": files})


def write_object(path: Path, content: Mapping[str, object]) -> None:
    """Write an object as JSON with its digest."""
    path.write_text(json.dumps({**content, "sha256": _digest(content)}, indent=2), encoding="utf-8")


def read_object(path: Path) -> dict[str, object]:
    """Return the object in a JSON file.

    Its digest is removed. It is empty for an absent or damaged file. Raises OSError where the file cannot be read.
    """
    with valid_content():
        with open(path, encoding="utf-8", opener=open_plain) as file:
            content = json.load(file)
        if isinstance(content, dict) and content.pop("sha256", None) == _digest(content):
            return content
    return {}


def _digest(content: Mapping[str, object]) -> str:
    """Return the digest of an object in JSON."""
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def read_entries(items: object) -> frozenset[Entry] | None:
    """Return entries from JSON.

    None if they are not a list of plain files in the folder itself.
    """
    if not isinstance(items, list):
        return None
    try:
        entries = [Entry(item["path"], item["size"], item["sha256"]) for item in items]
    except (TypeError, LookupError):
        return None
    return frozenset(entries) if all(map(_is_plain, entries)) else None


def _is_plain(item: Entry) -> bool:
    """Return True if an entry names a file in the folder itself."""
    if not (isinstance(item.path, str) and isinstance(item.sha256, str) and type(item.size) is int):
        return False
    is_inside = re.fullmatch(r"[^/\0]+", item.path) and item.path not in (".", "..", LOCK, NEW, LOG)
    return bool(is_inside and re.fullmatch("[0-9a-f]{64}", item.sha256))


@contextlib.contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Yield a temporary name for a new file.

    It becomes the file when it is complete; on a failure the file is unchanged. Another process that writes the same
    file waits.
    """
    partial = path.with_name(f".{path.name[:MAX_STEM]}{SUFFIX}")
    lock = partial if operating_system.HAS_FORK else partial.with_name(f"{partial.name}-lock")
    with locked_file(lock, wait=True):
        partial.write_bytes(b"")  # a process that died may have written a part
        try:
            yield partial
            sync(partial)
            os.replace(partial, path)
            sync(path.parent)
        except BaseException:
            partial.unlink(missing_ok=True)
            raise


@contextlib.contextmanager
def locked_file(path: Path, wait: bool = False) -> Iterator[None]:
    """Lock a file, which is made if it is absent.

    The lock ends with its process. Raises BlockingIOError where another process has it, OSError for a file that is not
    plain or a file system without locks.
    """
    while True:
        number, is_new = _open_lock(path)
        try:
            try:
                if not stat.S_ISREG(os.fstat(number).st_mode):
                    raise OSError(errno.EINVAL, f"{path.name} is not a regular file")
                operating_system.lock(number, wait)
                is_there = _is_there(number, path)  # else its last owner has removed the file in between
            except OSError as error:
                if is_new and not isinstance(error, BlockingIOError):
                    path.unlink()
                raise
            if is_there:
                yield
                return
        finally:
            with contextlib.suppress(OSError):  # the lock is released in any case
                os.close(number)
                if not operating_system.HAS_FORK:  # the owner could not remove it
                    path.unlink()


def _open_lock(path: Path) -> tuple[int, bool]:
    """Return the descriptor of a lock file, and whether it is new."""
    flags = os.O_RDWR | os.O_CREAT | operating_system.PLAIN
    with contextlib.suppress(FileExistsError):
        return os.open(path, flags | os.O_EXCL, 0o666), True
    return os.open(path, flags, 0o666), False


def _is_there(number: int, path: Path) -> bool:
    """Return True if an open file still has this path."""
    with contextlib.suppress(FileNotFoundError):
        return os.path.samestat(os.fstat(number), os.lstat(path))
    return False
