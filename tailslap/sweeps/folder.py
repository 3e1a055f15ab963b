"""The folder of a sweep. It is there from the start, belongs to one sweep alone, and can be resumed.

    sweep.json      what the sweep is: another one in the same folder is refused
    journal.jsonl   a line a finished run, see journal.py
    sweep.parquet   the table, written when the sweep ends or is interrupted
    report.html, summary.json
    .tailslap-result.json  the manifest of the last three, see tailslap/results/manifest.py

One process at a time works in it: the lock goes with the process, however that ends.
"""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO

from tailslap.errors import InputError, place_error
from tailslap.files.folder import make_folders, remove_folders, resolved
from tailslap.files.manifest import demand_ours, whole_file
from tailslap.sweeps.definition import Definition
from tailslap.sweeps.journal import NAME as JOURNAL

DEFINITION, LOCK = "sweep.json", ".lock"
TABLE, REPORT, SUMMARY = RESULTS = ("sweep.parquet", "report.html", "summary.json")
"""Files that are written anew each time the sweep is resumed, and refused if the user has added or changed them."""


@contextlib.contextmanager
def sweep_folder(place: Path, definition: Definition) -> Iterator[Path]:
    """The folder, locked, with the definition in it. What was new is removed again if it ends without any row.

    Raises InputError if it cannot be written, holds another sweep or something else, or is at work.
    """
    place = resolved(place)
    _refuse_foreign(place, definition)
    made = make_folders(place, place)
    try:
        with _locked(place):
            new = _claim(place, definition)
            try:
                yield place
            finally:
                if new and not _has_rows(place):
                    _forget(place)
    finally:
        remove_folders(made)


def _forget(place: Path) -> None:
    """Remove what makes the folder a sweep's; a lock that has content is the user's."""
    for name in (DEFINITION, JOURNAL, *([LOCK] if _is_lock(place / LOCK) else [])):
        with contextlib.suppress(OSError):
            (place / name).unlink()


def _refuse_foreign(place: Path, definition: Definition) -> None:
    """Before anything is written; what is there must be this sweep's, and its results as they were written."""
    if place.exists() and not place.is_dir():
        raise InputError("--out", str(place), "this is a file; allowed is a folder")
    names = sorted(os.listdir(place)) if place.is_dir() else []
    if DEFINITION in names:
        _demand_same(place, definition)
        for name in RESULTS:
            demand_ours(place / name)
        return
    foreign = [name for name in names if not (name == LOCK and _is_lock(place / name))]
    if foreign:
        shown = ", ".join(foreign[:2]) + (", ..." if foreign[2:] else "")
        raise InputError(
            "--out", str(place), f"it holds other files ({shown}); allowed is a new folder or a sweep's"
        )


def _is_lock(path: Path) -> bool:
    """A lock has no content: one that has is the user's."""
    return path.is_file() and not path.is_symlink() and path.stat().st_size == 0


@contextlib.contextmanager
def _locked(place: Path) -> Iterator[BinaryIO]:
    try:
        file = open(place / LOCK, "ab")  # noqa: SIM115
    except OSError as error:
        raise place_error(place, "the folder cannot be written", error) from None
    with file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            allowed = "another sweep is at work in it; wait for its end, or give another folder"
            raise InputError("--out", str(place), allowed) from None
        yield file


def _claim(place: Path, definition: Definition) -> bool:
    """Write the definition, or compare it with the one that is there; whether it was written."""
    path = place / DEFINITION
    if os.path.lexists(path):
        _demand_same(place, definition)
        return False
    with whole_file(path) as partial:
        text = json.dumps(definition.as_written(), indent=2, ensure_ascii=False)
        partial.write_text(text + "\n", encoding="utf-8")
    return True


def _demand_same(place: Path, definition: Definition) -> None:
    theirs, ours = _read(place / DEFINITION), definition.as_written()
    different = [name for name in ours if theirs.get(name) != ours[name]]
    if different:
        shown = ", ".join(name for name in different if name not in ("digest", "runs")) or "values"
        allowed = f"it holds another sweep: {shown} differ (see {DEFINITION}); allowed is that sweep or a new folder"
        raise InputError("--out", str(place), allowed)


def _read(path: Path) -> dict[str, Any]:
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        found = None
    if not isinstance(found, dict):
        raise InputError("--out", str(path.parent), f"{DEFINITION} in it is damaged; allowed is a new folder")
    return found


def _has_rows(place: Path) -> bool:
    """Whether the journal has more than its head."""
    journal = place / JOURNAL
    if not journal.is_file():
        return False
    with journal.open("rb") as file:
        return bool(file.readline() and file.readline())
