"""Records by key in a file: a line of JSON each, on disk before it counts, bound to what the records depend on."""

from __future__ import annotations

import hashlib
import json
import math
import os
import stat
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import tailslap
from tailslap.errors import InputError
from tailslap.files.manifest import whole_file

Key = str | int

NUMBER = "not finite"


class RecordFile(Mapping[Key, Any]):
    """Records by key, read from the file when they are asked for: memory holds keys and places alone.

    Lines are only ever added, and the first record of a key stays. A line that a crash tore apart is left out.

    definition: all that the records depend on; a file of another definition or version is begun anew, and one that is
    of another kind is refused. noted: called with each key and record that the file has or gets.
    """

    def __init__(
        self,
        path: Path,
        definition: Mapping[str, Any],
        noted: Callable[[Key, Any], None] = lambda key, record: None,
    ) -> None:
        text = json.dumps({"version": tailslap.__version__, **definition}, sort_keys=True, default=str)
        self._head = {"definition": hashlib.sha256(text.encode()).hexdigest()}
        self._path, self._noted = path, noted
        self._begins: dict[Key, int] = {}
        if not (os.path.lexists(path) and self._scan()):
            with whole_file(path) as partial:
                partial.write_bytes(_line(self._head))
        self._added, self._read = open(path, "ab", buffering=0), open(path, "rb")  # noqa: SIM115

    def close(self) -> None:
        """Close the file."""
        self._added.close()
        self._read.close()

    def add(self, records: Mapping[Any, Any]) -> None:
        """Put the records of keys that have none yet on disk, in one piece, before anything else happens."""
        new = {key: record for key, record in records.items() if key not in self}
        lines = [_line({"key": key, "record": record}) for key, record in new.items()]
        begin = self._added.seek(0, os.SEEK_END)
        left = memoryview(b"".join(lines))
        while left:
            left = left[self._added.write(left) :]
        os.fsync(self._added.fileno())
        for (key, record), line in zip(new.items(), lines, strict=True):
            self._note(key, record, begin)
            begin += len(line)

    def __getitem__(self, key: Key) -> Any:
        self._read.seek(self._begins[key])
        return json.loads(self._read.readline(), object_hook=_unnamed)["record"]

    def __contains__(self, key: object) -> bool:
        return key in self._begins

    def __iter__(self) -> Iterator[Key]:
        return iter(self._begins)

    def __len__(self) -> int:
        return len(self._begins)

    def _note(self, key: Key, record: Any, begin: int) -> None:
        self._begins[key] = begin
        self._noted(key, record)

    def _scan(self) -> bool:
        """Whether the file is of this definition: then what it has is noted, and its end made whole."""
        if not stat.S_ISREG(self._path.lstat().st_mode):
            raise self._foreign()
        with self._path.open("rb") as file:
            begin, ours = self._scan_head(file.readline())
            line = b"\n"
            for line in file:
                found = _record(line)
                if ours and found and found["key"] not in self:
                    self._note(found["key"], found["record"], begin)
                if not (ours or found) and line.endswith(b"\n"):
                    raise self._foreign()
                begin += len(line)
        if ours and not line.endswith(b"\n"):
            self._mend(line, begin)
        return ours

    def _scan_head(self, line: bytes) -> tuple[int, bool]:
        """Where the records begin, and whether they are of this definition."""
        head = _parsed(line)
        if set(head) != {"definition"} or not line.endswith(b"\n"):
            raise self._foreign()
        return len(line), head == self._head

    def _mend(self, line: bytes, end: int) -> None:
        """What is added must begin on a line of its own: a last line without end is ended, or cut off if torn."""
        with self._path.open("r+b") as file:
            file.truncate(end if _record(line) else end - len(line))
            file.seek(0, os.SEEK_END)
            file.write(b"\n" if _record(line) else b"")

    def _foreign(self) -> InputError:
        allowed = "this file is in the way and is no journal; move it away, or give another --out"
        return InputError("--out", str(self._path), allowed)


def _line(content: Mapping[str, Any]) -> bytes:
    """Numbers that are not finite, which JSON does not have, are objects with their names."""
    try:
        text = json.dumps(content, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    except ValueError:
        text = json.dumps(_named(content), ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    return text.encode() + b"\n"


def _named(value: Any) -> Any:
    if isinstance(value, float) and not math.isfinite(value):
        return {NUMBER: str(value)}
    if isinstance(value, Mapping):
        return {key: _named(item) for key, item in value.items()}
    return [_named(item) for item in value] if isinstance(value, list | tuple) else value


def _unnamed(found: dict[str, Any]) -> Any:
    return float(found[NUMBER]) if found.keys() == {NUMBER} else found


def _record(line: bytes) -> dict[str, Any]:
    """Key and record of a line; an empty one for a line that holds none."""
    found = _parsed(line)
    return found if set(found) == {"key", "record"} and isinstance(found["key"], str | int) else {}


def _parsed(line: bytes) -> dict[str, Any]:
    """The object that a line holds; an empty one for a line that holds none."""
    try:
        found = json.loads(line, object_hook=_unnamed)
    except (ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}
