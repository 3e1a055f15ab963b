"""A journal of the finished parts of a long study: an interrupted study goes on from it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any

from tailslap.errors import Interrupted, place_error
from tailslap.execution.record_file import RecordFile
from tailslap.files.folder import resolved


class Journal:
    """Records by key in the file `.NAME.journal` beside the result folder NAME; removed when the study is done.

    definition: all that the records depend on, see `RecordFile`, which `records` is.
    """

    records: RecordFile

    def __init__(self, place: Path, definition: Mapping[str, Any]) -> None:
        place = resolved(place)
        self.path = place.parent / f".{place.name}.journal"
        self._definition = definition

    def __enter__(self) -> Journal:
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self.records = RecordFile(self.path, self._definition)
        except OSError as error:
            raise place_error(self.path, "the journal cannot be written", error) from None
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.records.close()
        if kind is None or not self.records:
            self.path.unlink(missing_ok=True)
        elif isinstance(error, KeyboardInterrupt):
            raise Interrupted(
                f"interrupted; {len(self.records)} parts are kept, and the same command goes on from there"
            ) from None

    def add(self, key: str, record: Any) -> None:
        """Note a finished part; it is on disk when this returns."""
        self.records.add({key: record})
