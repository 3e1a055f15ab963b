"""The journal of a sweep: a line of JSON a finished run, on disk before the run counts as done.

Lines are only ever added. One that a crash tore apart cannot be read, and its run is made again.
"""

from __future__ import annotations

import contextlib
import json
import os
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from tailslap.sweep.worker import Finished

NAME = "journal.jsonl"


class Journal:
    """The journal of a folder; made if it is not there.

    Attributes: `begins`, run -> byte of the file where its row begins; `statuses`, how many rows of each.
    """

    def __init__(self, path: Path, runs: int) -> None:
        self._path, self._file = path, open(path, "ab", buffering=0)  # noqa: SIM115
        self.begins: dict[int, int] = {}
        self.statuses: Counter[str] = Counter()
        self._read(runs)

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def add(self, rows: Iterable[Finished]) -> None:
        """Put the rows of runs that have none yet on disk, before anything else happens."""
        first: dict[int, Finished] = {}
        for row in rows:
            if row.run not in self.begins:
                first.setdefault(row.run, row)
        new = list(first.values())
        begin = self._file.seek(0, os.SEEK_END)
        left = memoryview(b"".join(row.line for row in new))
        while left:
            left = left[self._file.write(left) :]
        os.fsync(self._file.fileno())
        for row in new:
            self._note(row.run, row.status, begin)
            begin += len(row.line)

    def missing(self, runs: int) -> list[int]:
        """Runs without a row, in order."""
        return [run for run in range(runs) if run not in self.begins]

    def rows(self) -> Iterator[dict[str, Any]]:
        """All rows, in the order of their runs."""
        with open(self._path, "rb") as file:
            for run in sorted(self.begins):
                file.seek(self.begins[run])
                yield json.loads(file.readline())

    def _note(self, run: int, status: str, begin: int) -> None:
        self.begins[run] = begin
        self.statuses[status] += 1

    def _read(self, runs: int) -> None:
        begin, line = 0, b"\n"
        with open(self._path, "rb") as file:
            for line in file:
                row = _row(line, runs)
                if row is not None and row["run"] not in self.begins:
                    self._note(row["run"], row["status"], begin)
                begin += len(line)
        if not line.endswith(b"\n"):  # torn: what is added must begin on a line of its own
            self._file.write(b"\n")


@contextlib.contextmanager
def open_journal(folder: Path, runs: int) -> Iterator[Journal]:
    """The journal in this folder; runs: how many the sweep has."""
    with contextlib.closing(Journal(folder / NAME, runs)) as journal:
        yield journal


def _row(line: bytes, runs: int) -> dict[str, Any] | None:
    """The row that a line holds, or None for a line that is none."""
    try:
        row = json.loads(line)
    except ValueError:
        return None
    whole = isinstance(row, dict) and isinstance(row.get("run"), int) and isinstance(row.get("status"), str)
    return row if whole and 0 <= row["run"] < runs else None
