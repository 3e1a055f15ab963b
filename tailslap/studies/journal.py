"""A journal of the finished parts of a long study, a JSON line each: an interrupted study goes on from it."""

from __future__ import annotations

import hashlib
import json
import os
import stat
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, TextIO

import tailslap
from tailslap.errors import InputError, Interrupted
from tailslap.results.manifest import whole_file
from tailslap.results.result_folder import resolved


class Journal:
    """Records by key in the file `.NAME.journal` beside the result folder NAME; removed when the study is done.

    definition: all that the records depend on; a journal of another definition or version is begun anew, and a file of
    that name which is no journal is refused.
    """

    def __init__(self, place: Path, definition: Mapping[str, Any]) -> None:
        place = resolved(place)
        self.path = place.parent / f".{place.name}.journal"
        text = json.dumps({"version": tailslap.__version__, **definition}, sort_keys=True, default=str)
        self._head = hashlib.sha256(text.encode()).hexdigest()
        self.records: dict[str, Any] = {}
        self._file: TextIO | None = None

    def __enter__(self) -> Journal:
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self.records = self._read()
            self._file = self._begin()
        except OSError as error:
            raise InputError(
                "--out", str(self.path), f"the journal cannot be written: {error.strerror}"
            ) from None
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        assert self._file is not None
        self._file.close()
        if kind is None or not self.records:
            self.path.unlink(missing_ok=True)
        elif isinstance(error, KeyboardInterrupt):
            raise Interrupted(
                f"interrupted; {len(self.records)} parts are kept, and the same command goes on from there"
            ) from None

    def add(self, key: str, record: Any) -> None:
        """Note a finished part; it is on disk when this returns."""
        assert self._file is not None
        self.records[key] = record
        self._file.write(_line(key, record))
        self._file.flush()
        os.fsync(self._file.fileno())

    def _begin(self) -> TextIO:
        """Write the journal anew, whole or not at all, and open it for more."""
        with whole_file(self.path) as partial:
            lines = [_line(key, record) for key, record in self.records.items()]
            partial.write_text(_head_line(self._head) + "".join(lines), encoding="utf-8")
        return self.path.open("a", encoding="utf-8")

    def _read(self) -> dict[str, Any]:
        """Records of an earlier, interrupted study of the same definition; a torn last line is left out."""
        if not os.path.lexists(self.path):
            return {}
        found = _read_journal(self.path)
        if found is None:
            allowed = (
                "this file is in the way and is no journal of a study; move it away, or give another --out"
            )
            raise InputError("--out", str(self.path), allowed)
        head, records = found
        return records if head == self._head else {}


def _head_line(digest: str) -> str:
    return json.dumps({"definition": digest}) + "\n"


def _line(key: str, record: Any) -> str:
    return json.dumps({"key": key, "record": record}) + "\n"


def _read_journal(path: Path) -> tuple[str, dict[str, Any]] | None:
    """The digest of the definition and the records; None for a file that no study has written."""
    if not stat.S_ISREG(path.lstat().st_mode):
        return None
    head, *lines = path.read_text(encoding="utf-8", errors="replace").split("\n")
    first, records = _parsed(head), [_parsed(line) for line in lines[:-1]]
    whole = all(set(found) == {"key", "record"} and isinstance(found["key"], str) for found in records)
    if set(first) != {"definition"} or not whole:
        return None
    return first["definition"], {found["key"]: found["record"] for found in records}


def _parsed(line: str) -> dict[str, Any]:
    """The object that a line holds; an empty one for a line that holds none."""
    try:
        found = json.loads(line)
    except (ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}
