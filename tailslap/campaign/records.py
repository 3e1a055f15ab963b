"""Records of parts in an SQLite file.

The table `record` has one line per part, with its value as JSON. The view `result` has the columns of the values, for
any program that reads SQLite. SQLite has no checksums. Each line therefore contains a digest, and damaged lines are
computed again.
"""

from __future__ import annotations

import errno
import hashlib
import json
import math
import os
import re
import sqlite3
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager, suppress
from operator import itemgetter
from pathlib import Path
from types import TracebackType
from typing import Any, TypeVar

import tailslap
from machine_code.system.folder import own_sources
from tailslap.errors import InputError, Interrupted, is_there, place_error
from tailslap.storage import folder, manifest

Key = str | int
"""Key of a part."""

K = TypeVar("K", str, int, Key)

Record = dict[str, Any]
"""Values of a part by name."""

PACKAGES = ("fem", "machine_code", "meshes", "postprocess", "solver", "tailslap")
"""Packages whose sources identify the program."""
APPLICATION_ID = 0x7461696C
"""Application number of SQLite files of this program, "tail" in ASCII."""
SQLITE_HEADER, ID_OFFSET = b"SQLite format 3\0", 68
"""First bytes of an SQLite file, and position of its application number."""
LOCAL = {"btrfs", "ext2", "ext3", "ext4", "f2fs", "overlay", "tmpfs", "xfs", "zfs"}
"""File systems on which a write-ahead log is safe. Processes on network file systems have no common memory."""
MOUNTS, OCTAL = Path("/proc/mounts"), re.compile(rb"\\([0-3][0-7]{2})")
"""File in which Linux lists the file systems, and its octal code of special characters in paths."""
PATIENCE_S = 600.0
"""Time to wait for another program that reads the file [s]."""
NUMBER = "not finite"
"""Key of an object that represents a number that is not finite."""
MACHINE = {
    *(sqlite3.SQLITE_FULL, sqlite3.SQLITE_IOERR, sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED),
    *(sqlite3.SQLITE_CANTOPEN, sqlite3.SQLITE_READONLY, sqlite3.SQLITE_PERM, sqlite3.SQLITE_NOMEM),
}
"""Errors of SQLite that are due to the machine and not to the content of the file."""
DAMAGES = (sqlite3.DatabaseError, UnicodeDecodeError)
"""Errors of SQLite for a damaged file, and of Python for the text of such an error."""

TABLES = """
CREATE TABLE campaign(digest TEXT, program TEXT, definition TEXT, view TEXT);
CREATE TABLE record(
    key PRIMARY KEY NOT NULL, status TEXT, reason TEXT, seconds REAL, value TEXT NOT NULL, sha256 TEXT NOT NULL
);
"""
RESET = f"BEGIN; DROP VIEW IF EXISTS result; DROP TABLE record; DROP TABLE campaign; {TABLES} COMMIT;"
INSERT_DEFINITION = "INSERT INTO campaign VALUES (?, ?, ?, ?)"
SEAL = "seal(CAST({} AS BLOB), CAST({} AS BLOB), CAST({} AS BLOB), CAST({} AS BLOB))"
"""Digest of key, status, reason and value of a line, as bytes of any type."""
INSERT = f"INSERT OR IGNORE INTO record VALUES (?1, ?2, ?3, ?4, ?5, {SEAL.format('?1', '?2', '?3', '?5')})"
DAMAGED = f"DELETE FROM record WHERE sha256 IS NOT {SEAL.format('key', 'status', 'reason', 'value')}"
FIRST = ("key", "status", "reason", "seconds")
"""Columns of the view that do not depend on the values."""


def program() -> str:
    """Return the version of this program.

    It includes a digest of the sources, so that rows of two programs are never mixed.
    """
    return f"{tailslap.__version__}+{own_sources(*PACKAGES)[:16]}"


class Records(Mapping[Key, Any]):
    """Records by key in a file, read on access.

    The first record of a key remains. A file of another definition or program is emptied.

    Parameters
    ----------
    path : Path
        The file.
    definition : dict
        All values on which the records depend.

    Attributes
    ----------
    statuses : Counter
        Numbers of records by "status", where they have one.
    columns : dict
        Names in all records that are mappings, in order of appearance.

    Raises
    ------
    InputError
        Where the file is of another kind.
    """

    def __init__(self, path: Path, definition: Mapping[str, object]) -> None:
        text = json.dumps(definition, sort_keys=True, default=str)
        head = (hashlib.sha256(text.encode()).hexdigest(), program(), text)
        self._path = path
        if not is_there(path):
            _create(path, head)
        if not _is_records_file(path):
            raise _invalid_file(path)
        self._file = sqlite3.connect(path, timeout=PATIENCE_S)
        try:
            self._file.create_function("seal", 4, _seal)
            self._begin(head)
        except DAMAGES as error:
            self._file.close()
            if getattr(error, "sqlite_errorcode", 0) & 0xFF in MACHINE:
                raise _fault(path, error) from None
            raise _invalid_file(path) from None

    def _begin(self, head: tuple[str, str, str]) -> None:
        """Set up the file.

        Records of another definition are removed, and the others are counted.
        """
        file, mode = self._file, "WAL" if _file_system(self._path) in LOCAL else "DELETE"
        file.execute(f"PRAGMA journal_mode={mode}")
        file.execute("PRAGMA synchronous=FULL")
        if file.execute("PRAGMA integrity_check").fetchone() != ("ok",):
            raise sqlite3.DatabaseError
        if file.execute("SELECT digest, program FROM campaign").fetchall() != [head[:2]]:
            file.executescript(RESET)
            file.execute(INSERT_DEFINITION, (*head, _seal(None)))
        if file.execute("SELECT view FROM campaign").fetchone() != (self._view(),):
            raise sqlite3.DatabaseError
        file.execute(DAMAGED)
        file.commit()
        self.columns = dict.fromkeys(name for _, name, *_ in file.execute("PRAGMA table_info(result)"))
        self._count()

    def _count(self) -> None:
        """Count the records of the file by status."""
        counts = self._file.execute("SELECT status, COUNT(*) FROM record GROUP BY status")
        self.statuses: Counter[str | None] = Counter(dict(counts))

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def add(self, records: Mapping[K, object], seconds: Mapping[K, float] | None = None) -> None:
        """Write the records of new keys, all or none.

        records: by key, those of existing keys are ignored; seconds: times of the parts by key [s].
        """
        new = {key: record for key, record in records.items() if key not in self}
        values = {key: record if isinstance(record, Mapping) else {} for key, record in new.items()}
        names = dict.fromkeys(name for value in values.values() for name in value)
        lines = [
            (key, value.get("status"), value.get("reason"), (seconds or {}).get(key), _text(new[key]))
            for key, value in values.items()
        ]
        try:
            with self._file:
                self._file.executemany(INSERT, lines)
                if not names.keys() <= self.columns.keys():
                    self._show(names)
            self.statuses.update(value.get("status") for value in values.values())
        except sqlite3.OperationalError as error:
            raise _fault(self._path, error) from None
        except KeyboardInterrupt:  # before the records are written or behind that
            self._count()
            raise

    def _show(self, names: Mapping[str, None]) -> None:
        """Add columns to the view."""
        self.columns |= names
        inner = {
            name: name.replace("'", "''") for name in self.columns if name not in FIRST and '"' not in name
        }
        extracted = [f"""json_extract(value, '$."{path}"') AS "{name}\"""" for name, path in inner.items()]
        self._file.execute("DROP VIEW IF EXISTS result")
        self._file.execute(f"CREATE VIEW result AS SELECT {', '.join([*FIRST, *extracted])} FROM record")
        self._file.execute("UPDATE campaign SET view = ?", (self._view(),))

    def _view(self) -> str:
        """Return the digest of the definition of the view."""
        row = self._file.execute(
            "SELECT CAST(sql AS BLOB) FROM sqlite_master WHERE name = 'result'"
        ).fetchone()
        return _seal(*row or (None,))

    def in_order(self) -> Iterator[Any]:
        """Yield all records in order of their keys."""
        return (_value(text) for (text,) in self._file.execute("SELECT value FROM record ORDER BY key"))

    def __getitem__(self, key: Key) -> Any:
        """Return the record of a key. Raises KeyError."""
        row = self._file.execute("SELECT value FROM record WHERE key = ?", (key,)).fetchone()
        if row is None:
            raise KeyError(key)
        return _value(row[0])

    def __contains__(self, key: object) -> bool:
        """Return True if the key has a record."""
        return self._file.execute("SELECT 1 FROM record WHERE key = ?", (key,)).fetchone() is not None

    def __iter__(self) -> Iterator[Key]:
        """Iterate over the keys in order."""
        return (key for (key,) in self._file.execute("SELECT key FROM record ORDER BY key"))

    def __len__(self) -> int:
        """Return the number of records."""
        return self.statuses.total()


class Journal:
    """Records of an unfinished study beside its result folder.

    The file `.NAME.journal` is removed by `kept` when the files of the study are written. `records` exists within a
    `with` block.

    Parameters
    ----------
    place : Path
        Result folder NAME.
    definition : dict
        All values on which the records depend, see `Records`.
    """

    records: Records

    def __init__(self, place: Path, definition: Mapping[str, object]) -> None:
        self.path, self._definition = _journal_path(place), definition

    def __enter__(self) -> Journal:
        """Open or create the journal. Raises InputError."""
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self.records = Records(self.path, self._definition)
        except OSError as error:
            raise place_error(self.path, "the journal cannot be written", error) from None
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the journal, and remove an empty one."""
        saved = len(self.records)
        self.records.close()
        if not saved:
            remove(self.path)
        elif isinstance(error, KeyboardInterrupt):
            raise _interrupted(saved) from None


@contextmanager
def kept(place: Path) -> Iterator[None]:
    """Keep the journal of a study until its files are written.

    place: result folder. Raises Interrupted for an interrupt with saved parts.
    """
    path = _journal_path(place)
    try:
        yield
    except Interrupted:
        raise
    except KeyboardInterrupt:
        if is_there(path) and (saved := count(path)):
            raise _interrupted(saved) from None
        raise
    if is_there(path) and count(path):
        remove(path)


def _journal_path(place: Path) -> Path:
    """Return the path of the journal of a result folder."""
    place = folder.resolved(place)
    return place.parent / f".{place.name}.journal"


def _interrupted(saved: int) -> Interrupted:
    """Return the interrupt of a study with saved parts."""
    return Interrupted(f"interrupted; {saved} parts are saved, and the same command resumes from there")


def count(path: Path) -> int:
    """Return the number of records of a file.

    It is 0 for a file of another kind.
    """
    if not _is_records_file(path):
        return 0
    with suppress(*DAMAGES), closing(sqlite3.connect(path)) as file:
        return int(file.execute("SELECT COUNT(*) FROM record").fetchone()[0])
    return 1  # a damaged file may contain records, and is not removed


def remove(path: Path) -> None:
    """Remove a file of records and its companions.

    The file itself is removed last, so that an interrupted removal can be repeated.
    """
    for ending in ("-journal", "-wal", "-shm", ""):
        path.with_name(path.name + ending).unlink(missing_ok=True)


def _create(path: Path, head: tuple[str, str, str]) -> None:
    """Create a file without records, completely or not at all."""
    with manifest.whole_file(path) as partial, closing(sqlite3.connect(partial)) as file:
        file.executescript(f"PRAGMA journal_mode=MEMORY; PRAGMA application_id={APPLICATION_ID}; {TABLES}")
        file.execute(INSERT_DEFINITION, (*head, _seal(None)))
        file.commit()


def _is_records_file(path: Path) -> bool:
    """Return True for a file of records.

    Raises OSError where it cannot be read.
    """
    with manifest.valid_content(), open(path, "rb", opener=manifest.open_plain) as file:
        head = file.read(ID_OFFSET + 4)
        return head.startswith(SQLITE_HEADER) and head[ID_OFFSET:] == APPLICATION_ID.to_bytes(4, "big")
    return False


def _file_system(path: Path) -> str:
    """Return the type of file system of a path, or ""."""
    path = path.resolve()
    try:
        lines = [line.split(b" ") for line in MOUNTS.read_bytes().split(b"\n")]
    except OSError:
        return ""
    mounts = [
        (os.fsdecode(OCTAL.sub(lambda code: bytes([int(code[1], 8)]), words[1])), words[2].decode())
        for words in lines
        if words[2:]
    ]
    above = [(len(place), kind) for place, kind in mounts if path.is_relative_to(place)]
    # Of two mounts at the same place, the later one covers the other.
    return max(reversed(above), key=itemgetter(0), default=(0, ""))[1]


def _seal(*parts: bytes | None) -> str:
    """Return the digest of a line's parts."""
    return hashlib.sha256(repr(parts).encode()).hexdigest()


def _invalid_file(path: Path) -> InputError:
    """Return the error for a file of another kind."""
    allowed = "this file is not a valid journal; remove it, or choose another --out"
    return InputError("--out", str(path), allowed)


def _fault(path: Path, error: Exception) -> OSError:
    """Convert an error of SQLite to one of the system."""
    is_full = getattr(error, "sqlite_errorcode", 0) == sqlite3.SQLITE_FULL
    number = errno.ENOSPC if is_full else errno.EIO
    return OSError(number, str(error), str(path))


def _text(value: object) -> str:
    """Convert a value to JSON.

    Numbers that are not finite become objects with their names.
    """
    return json.dumps(_named(value), ensure_ascii=False, separators=(",", ":"), allow_nan=False)


def _named(value: object) -> object:
    """Replace numbers that are not finite by objects."""
    if isinstance(value, float) and not math.isfinite(value):
        return {NUMBER: str(value)}
    if isinstance(value, Mapping):
        return {key: _named(item) for key, item in value.items()}
    return [_named(item) for item in value] if isinstance(value, list | tuple) else value


def _value(text: str) -> Any:
    """Convert JSON to a value."""

    def unnamed(members: Record) -> float | Record:
        return float(members[NUMBER]) if members.keys() == {NUMBER} else members

    return json.loads(text, object_hook=unnamed)
