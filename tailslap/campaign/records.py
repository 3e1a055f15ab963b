"""Records by key in an SQLite file, each on disk before it counts, bound to what they depend on.

The table `record` has a line a part, its value as JSON; the view `result` has the value's own columns, for any tool
that reads SQLite. SQLite has no checksums: a line has its own, and one that was damaged is made anew.
"""

from __future__ import annotations

import errno
import functools
import hashlib
import json
import math
import os
import re
import sqlite3
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import closing, suppress
from operator import itemgetter
from pathlib import Path
from types import TracebackType
from typing import Any

import tailslap
from tailslap.errors import InputError, Interrupted, is_there, place_error
from tailslap.storage import folder, manifest

Key = str | int

PACKAGES = ("fem", "machine_code", "meshes", "postprocess", "solver", "tailslap")
OURS = 0x7461696C
"""By which SQLite files of this program are known: "tail"."""
HEAD, OURS_AT = b"SQLite format 3\0", 68
LOCAL = {"btrfs", "ext2", "ext3", "ext4", "f2fs", "overlay", "tmpfs", "xfs", "zfs"}
"""File systems on which a log beside the file (WAL) is safe: on those of a network processes share no memory."""
MOUNTS, OCTAL = Path("/proc/mounts"), re.compile(rb"\\([0-3][0-7]{2})")
"""File in which Linux lists the file systems, and its text of a space in their paths."""
PATIENCE_S = 600.0
"""Seconds to wait for another program that reads the file."""
NUMBER = "not finite"
MACHINE = {
    *(sqlite3.SQLITE_FULL, sqlite3.SQLITE_IOERR, sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED),
    *(sqlite3.SQLITE_CANTOPEN, sqlite3.SQLITE_READONLY, sqlite3.SQLITE_PERM, sqlite3.SQLITE_NOMEM),
}
"""Errors of SQLite that are no fault of the file's content."""
DAMAGES = (sqlite3.DatabaseError, UnicodeDecodeError)
"""Errors of SQLite over a damaged file, and of Python over the text of such an error."""

TABLES = """
CREATE TABLE campaign(digest TEXT, program TEXT, definition TEXT, view TEXT);
CREATE TABLE record(
    key PRIMARY KEY NOT NULL, status TEXT, reason TEXT, seconds REAL, value TEXT NOT NULL, sha256 TEXT NOT NULL
);
"""
ANEW = f"BEGIN; DROP VIEW IF EXISTS result; DROP TABLE record; DROP TABLE campaign; {TABLES} COMMIT;"
BEGIN = "INSERT INTO campaign VALUES (?, ?, ?, ?)"
SEAL = "seal(CAST({} AS BLOB), CAST({} AS BLOB), CAST({} AS BLOB), CAST({} AS BLOB))"
"""Digest of a line: of key, status, reason and value, as bytes, whatever text they may have become."""
INSERT = f"INSERT OR IGNORE INTO record VALUES (?1, ?2, ?3, ?4, ?5, {SEAL.format('?1', '?2', '?3', '?5')})"
DAMAGED = f"DELETE FROM record WHERE sha256 IS NOT {SEAL.format('key', 'status', 'reason', 'value')}"
FIRST = ("key", "status", "reason", "seconds")
"""Columns of the view whatever the values are."""


@functools.cache
def program() -> str:
    """Version of this program, with a digest of all its sources: rows of two programs are never mixed."""
    root, digest = Path(tailslap.__file__).parents[1], hashlib.sha256()
    for path in sorted(path for name in PACKAGES for path in (root / name).rglob("*.py")):
        digest.update(f"{path.relative_to(root)}\0".encode() + path.read_bytes())
    return f"{tailslap.__version__}+{digest.hexdigest()[:16]}"


class Records(Mapping[Key, Any]):
    """Records by key, read from the file when they are asked for; the first record of a key stays.

    Parameters
    ----------
    path : path
        Of the file; made if it is not there.
    definition : mapping
        All that the records depend on beside the program; a file of another definition or program is begun anew.

    Attributes
    ----------
    statuses : Counter
        How many records have each "status", where they have one.
    columns : dict
        Names in all records that are mappings, in the order in which they came.

    Raises
    ------
    InputError
        Where the file is of another kind.
    """

    def __init__(self, path: Path, definition: Mapping[str, Any]) -> None:
        text = json.dumps(definition, sort_keys=True, default=str)
        head = (hashlib.sha256(text.encode()).hexdigest(), program(), text)
        self._path = path
        if not is_there(path):
            _create(path, head)
        if not _is_ours(path):
            raise _in_the_way(path)
        self._file = sqlite3.connect(path, timeout=PATIENCE_S)
        try:
            self._file.create_function("seal", 4, _seal)
            self._begin(head)
        except DAMAGES as error:
            self._file.close()
            if getattr(error, "sqlite_errorcode", 0) & 0xFF in MACHINE:
                raise _fault(path, error) from None
            raise _in_the_way(path) from None

    def _begin(self, head: tuple[str, str, str]) -> None:
        """Set the file up; what it has is of another definition, or is counted."""
        file, mode = self._file, "WAL" if _file_system(self._path) in LOCAL else "DELETE"
        file.execute(f"PRAGMA journal_mode={mode}")
        file.execute("PRAGMA synchronous=FULL")
        if file.execute("PRAGMA integrity_check").fetchone() != ("ok",):
            raise sqlite3.DatabaseError
        if file.execute("SELECT digest, program FROM campaign").fetchall() != [head[:2]]:
            file.executescript(ANEW)
            file.execute(BEGIN, (*head, _seal(None)))
        if file.execute("SELECT view FROM campaign").fetchone() != (self._view(),):
            raise sqlite3.DatabaseError
        file.execute(DAMAGED)
        file.commit()
        self.columns = dict.fromkeys(name for _, name, *_ in file.execute("PRAGMA table_info(result)"))
        counts = file.execute("SELECT status, COUNT(*) FROM record GROUP BY status")
        self.statuses: Counter[Any] = Counter(dict(counts))

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def add(self, records: Mapping[Any, Any], seconds: Mapping[Any, float] | None = None) -> None:
        """Put the records of keys that have none yet on disk, all or none; seconds: what each part took."""
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
        except sqlite3.OperationalError as error:
            raise _fault(self._path, error) from None
        self.statuses.update(value.get("status") for value in values.values())

    def _show(self, names: Mapping[str, None]) -> None:
        """Let the view have these columns too."""
        self.columns |= names
        inner = {
            name: name.replace("'", "''") for name in self.columns if name not in FIRST and '"' not in name
        }
        shown = [f"""json_extract(value, '$."{path}"') AS "{name}\"""" for name, path in inner.items()]
        self._file.execute("DROP VIEW IF EXISTS result")
        self._file.execute(f"CREATE VIEW result AS SELECT {', '.join([*FIRST, *shown])} FROM record")
        self._file.execute("UPDATE campaign SET view = ?", (self._view(),))

    def _view(self) -> str:
        """Digest of the view's definition, by which its columns are known to be whole."""
        found = self._file.execute(
            "SELECT CAST(sql AS BLOB) FROM sqlite_master WHERE name = 'result'"
        ).fetchone()
        return _seal(*found or (None,))

    def in_order(self) -> Iterator[Any]:
        """All records in the order of their keys, one after the other."""
        return (_value(text) for (text,) in self._file.execute("SELECT value FROM record ORDER BY key"))

    def __getitem__(self, key: Key) -> Any:
        found = self._file.execute("SELECT value FROM record WHERE key = ?", (key,)).fetchone()
        if found is None:
            raise KeyError(key)
        return _value(found[0])

    def __contains__(self, key: object) -> bool:
        return self._file.execute("SELECT 1 FROM record WHERE key = ?", (key,)).fetchone() is not None

    def __iter__(self) -> Iterator[Key]:
        return (key for (key,) in self._file.execute("SELECT key FROM record ORDER BY key"))

    def __len__(self) -> int:
        return self.statuses.total()


class Journal:
    """Records of a study in the file `.NAME.journal` beside the result folder NAME; removed when the study is done.

    definition: all that the records depend on, see `Records`, which `records` is within a `with` block.
    """

    records: Records

    def __init__(self, place: Path, definition: Mapping[str, Any]) -> None:
        place = folder.resolved(place)
        self.path, self._definition = place.parent / f".{place.name}.journal", definition

    def __enter__(self) -> Journal:
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self.records = Records(self.path, self._definition)
        except OSError as error:
            raise place_error(self.path, "the journal cannot be written", error) from None
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        kept = len(self.records)
        self.records.close()
        if kind is None or not kept:
            remove(self.path)
        elif isinstance(error, KeyboardInterrupt):
            said = f"interrupted; {kept} parts are saved, and the same command resumes from there"
            raise Interrupted(said) from None


def count(path: Path) -> int:
    """Number of records of a file, whoever is at work on it: none where it is not one of ours."""
    if not _is_ours(path):
        return 0
    with suppress(*DAMAGES), closing(sqlite3.connect(path)) as file:
        return int(file.execute("SELECT COUNT(*) FROM record").fetchone()[0])
    return 1  # of one that is damaged nobody knows, and it stays


def remove(path: Path) -> None:
    """Remove what SQLite has left beside the file of records, then the file: whoever finds it may remove the rest."""
    for ending in ("-journal", "-wal", "-shm", ""):
        path.with_name(path.name + ending).unlink(missing_ok=True)


def _create(path: Path, head: tuple[str, str, str]) -> None:
    """Make the file without records, whole or not at all."""
    with manifest.whole_file(path) as partial, closing(sqlite3.connect(partial)) as file:
        file.executescript(f"PRAGMA journal_mode=MEMORY; PRAGMA application_id={OURS}; {TABLES}")
        file.execute(BEGIN, (*head, _seal(None)))
        file.commit()


def _is_ours(path: Path) -> bool:
    """Return True for a regular file that this program has made. Raises OSError where it cannot be read."""
    with manifest.valid_content(), open(path, "rb", opener=manifest.open_plain) as file:
        head = file.read(OURS_AT + 4)
        return head.startswith(HEAD) and head[OURS_AT:] == OURS.to_bytes(4, "big")
    return False


def _file_system(path: Path) -> str:
    """The kind of file system that a path is on, as Linux calls it; "" where the system does not tell."""
    path = path.resolve()
    try:
        lines = [line.split(b" ") for line in MOUNTS.read_bytes().split(b"\n")]
    except OSError:
        return ""
    mounts = [(os.fsdecode(OCTAL.sub(_byte, words[1])), words[2].decode()) for words in lines if words[2:]]
    above = [(len(place), kind) for place, kind in mounts if path.is_relative_to(place)]
    # Of two at one place the later one covers the other.
    return max(reversed(above), key=itemgetter(0), default=(0, ""))[1]


def _byte(code: re.Match[bytes]) -> bytes:
    return bytes([int(code[1], 8)])


def _seal(*parts: bytes | None) -> str:
    return hashlib.sha256(repr(parts).encode()).hexdigest()


def _in_the_way(path: Path) -> InputError:
    allowed = "this file is not a valid journal; remove it, or choose another --out"
    return InputError("--out", str(path), allowed)


def _fault(path: Path, error: Exception) -> OSError:
    """An error of SQLite as one of the system."""
    is_full = getattr(error, "sqlite_errorcode", 0) == sqlite3.SQLITE_FULL
    number = errno.ENOSPC if is_full else errno.EIO
    return OSError(number, str(error), str(path))


def _text(value: Any) -> str:
    """The value as JSON; numbers that are not finite, which it does not have, are objects with their names."""
    return json.dumps(_named(value), ensure_ascii=False, separators=(",", ":"), allow_nan=False)


def _named(value: Any) -> Any:
    if isinstance(value, float) and not math.isfinite(value):
        return {NUMBER: str(value)}
    if isinstance(value, Mapping):
        return {key: _named(item) for key, item in value.items()}
    return [_named(item) for item in value] if isinstance(value, list | tuple) else value


def _value(text: str) -> Any:
    def unnamed(found: dict[str, Any]) -> Any:
        return float(found[NUMBER]) if found.keys() == {NUMBER} else found

    return json.loads(text, object_hook=unnamed)
