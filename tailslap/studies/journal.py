"""A journal of the finished parts of a long study, a JSON line each: an interrupted study goes on from it."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, TextIO

import tailslap
from tailslap.errors import InputError, Interrupted


class Journal:
    """Records by key in the file `.NAME.journal` beside the result folder NAME; removed when the study is done.

    definition: all that the records depend on; a journal of another definition or version is begun anew.
    """

    def __init__(self, place: Path, definition: Mapping[str, Any]) -> None:
        self.path = place.absolute().parent / f".{place.name}.journal"
        text = json.dumps({"version": tailslap.__version__, **definition}, sort_keys=True, default=str)
        self._head = hashlib.sha256(text.encode()).hexdigest()
        self.records: dict[str, Any] = {}
        self._file: TextIO | None = None

    def __enter__(self) -> Journal:
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self.records = self._read()
            self._file = self.path.open("w", encoding="utf-8")
        except OSError as error:
            raise InputError(
                "--out", str(self.path), f"the journal cannot be written: {error.strerror}"
            ) from None
        self._line({"definition": self._head})
        for key, record in self.records.items():
            self._line({"key": key, "record": record})
        self._sync()
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
        self.records[key] = record
        self._line({"key": key, "record": record})
        self._sync()

    def _read(self) -> dict[str, Any]:
        """Records of an earlier, interrupted study of the same definition; a torn last line is left out."""
        found: dict[str, Any] = {}
        if not self.path.is_file():
            return found
        lines = self.path.read_text(encoding="utf-8", errors="replace").splitlines()
        for number, line in enumerate(lines):
            try:
                entry = json.loads(line)
            except json.JSONDecodeError:
                continue
            if number == 0 and entry.get("definition") != self._head:
                return {}
            if "key" in entry:
                found[entry["key"]] = entry["record"]
        return found

    def _line(self, entry: dict[str, Any]) -> None:
        assert self._file is not None
        self._file.write(json.dumps(entry) + "\n")

    def _sync(self) -> None:
        assert self._file is not None
        self._file.flush()
        os.fsync(self._file.fileno())
