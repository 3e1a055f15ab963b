"""The folder of a sweep. It is there from the start, belongs to one sweep alone, and can be resumed.

    sweep.json      what the sweep is: another one in the same folder is refused
    journal.jsonl   a line a finished run, see journal.py
    sweep.parquet   the table, written when the sweep ends or is interrupted
    report.html, summary.json

One process at a time works in it: the lock goes with the process, however that ends.
"""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, BinaryIO

from tailslap.errors import InputError
from tailslap.sweep.definition import Definition
from tailslap.sweep.journal import NAME as JOURNAL

DEFINITION, LOCK = "sweep.json", ".lock"


@contextlib.contextmanager
def sweep_folder(place: Path, definition: Definition) -> Iterator[Path]:
    """The folder, locked, with the definition in it. What was new is removed again if it ends without any row.

    Raises InputError if it cannot be written, holds another sweep or something else, or is at work.
    """
    place = place.absolute()
    _refuse_foreign(place)
    made = _make(place)
    try:
        with _locked(place):
            new = _claim(place, definition)
            try:
                yield place
            finally:
                if new and not _has_rows(place):
                    _remove([place / name for name in (DEFINITION, JOURNAL, LOCK)], Path.unlink)
    finally:
        _remove(made, Path.rmdir)  # those that are empty


def _remove(paths: list[Path], how: Callable[[Path], None]) -> None:
    for path in paths:
        with contextlib.suppress(OSError):
            how(path)


def write_whole(path: Path, content: bytes) -> None:
    """Write a file so that it is there with all of its content, or not at all."""
    partial = path.with_name(f".{path.name}.part")
    with open(partial, "wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
    os.replace(partial, path)


def _refuse_foreign(place: Path) -> None:
    if place.exists() and not place.is_dir():
        raise InputError("--out", str(place), "this is a file; allowed is a folder")
    ours = (DEFINITION, LOCK, f".{DEFINITION}.part")
    names = {path.name for path in place.iterdir()} if place.is_dir() else set()
    if DEFINITION not in names and names.difference(ours):
        raise InputError("--out", str(place), "it holds other files; allowed is a new folder or a sweep's")


def _make(place: Path) -> list[Path]:
    """Make the folder and those above it; returns those that were not there, innermost first."""
    missing = [path for path in (place, *place.parents) if not path.exists()]
    try:
        place.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        _remove(missing, Path.rmdir)
        raise InputError("--out", str(place), f"the folder cannot be made: {error.strerror}") from None
    return missing


@contextlib.contextmanager
def _locked(place: Path) -> Iterator[BinaryIO]:
    try:
        file = open(place / LOCK, "ab")  # noqa: SIM115
    except OSError as error:
        raise InputError("--out", str(place), f"the folder cannot be written: {error.strerror}") from None
    with file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            allowed = "another sweep is at work in it; wait for its end, or give another folder"
            raise InputError("--out", str(place), allowed) from None
        yield file


def _claim(place: Path, definition: Definition) -> bool:
    """Write the definition, or hold it against the one that is there; whether it was written."""
    path, ours = place / DEFINITION, definition.as_written()
    if not path.exists():
        write_whole(path, json.dumps(ours, indent=2, ensure_ascii=False).encode() + b"\n")
        return True
    theirs = _read(path)
    different = [name for name in ours if theirs.get(name) != ours[name]]
    if different:
        shown = ", ".join(name for name in different if name not in ("digest", "runs")) or "values"
        allowed = f"it holds another sweep: {shown} differ (see {DEFINITION}); allowed is that sweep or a new folder"
        raise InputError("--out", str(place), allowed)
    return False


def _read(path: Path) -> dict[str, Any]:
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except ValueError:
        found = None
    if not isinstance(found, dict):
        raise InputError("--out", str(path.parent), f"{DEFINITION} in it is damaged; allowed is a new folder")
    return found


def _has_rows(place: Path) -> bool:
    journal = place / JOURNAL
    return journal.is_file() and journal.stat().st_size > 0
