"""The journal of a sweep: the row of each finished run, by its number."""

from __future__ import annotations

import contextlib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tailslap.execution.record_file import RecordFile
from tailslap.sweeps.definition import Definition

NAME = "journal.jsonl"


@dataclass(frozen=True)
class Rows:
    """The rows on disk by run, and how many have each status."""

    records: RecordFile
    statuses: Counter[str]

    def missing(self, runs: int) -> list[int]:
        """Runs without a row, in order."""
        return [run for run in range(runs) if run not in self.records]

    def in_order(self) -> Iterator[dict[str, Any]]:
        """All rows, in the order of their runs."""
        return (self.records[run] for run in sorted(self.records))


@contextlib.contextmanager
def open_rows(folder: Path, definition: Definition) -> Iterator[Rows]:
    """The rows of this sweep in its folder."""
    statuses: Counter[str] = Counter()

    def note(run: object, row: Any) -> None:
        statuses[row["status"]] += 1

    with contextlib.closing(RecordFile(folder / NAME, definition.as_written(), note)) as records:
        yield Rows(records, statuses)
