"""A result folder is complete or absent: it is filled beside its place and moved there at the end."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tailslap.errors import InputError

MARK = "summary.json"
"""The file by which an earlier result is known; only such a folder, or an empty one, is replaced."""

SWEEP = "sweep.json"
"""The file by which the folder of a sweep is known, which is not replaced: it may hold days of runs."""


@contextmanager
def result_folder(place: Path) -> Iterator[Path]:
    """Yield an empty folder to fill; on success it becomes `place`, on any failure nothing is left of it.

    Raises InputError if `place` cannot be written, or holds something else than an earlier result.
    """
    place = place.absolute()
    _refuse_foreign(place)
    made = _make_parents(place)
    try:
        folder = Path(tempfile.mkdtemp(prefix=f".{place.name}.", dir=place.parent))
    except OSError as error:
        _remove(made)
        raise InputError("--out", str(place), f"the folder cannot be written: {error.strerror}") from None
    try:
        yield folder
        folder.chmod(0o755)
        _put(folder, place)
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        _remove(made)
        raise


def demand_place(place: Path) -> None:
    """Before long work: raise InputError if `place` holds something else than an earlier result."""
    _refuse_foreign(place.absolute())


def _refuse_foreign(place: Path) -> None:
    if place.exists() and not place.is_dir():
        raise InputError("--out", str(place), "this is a file; allowed is a folder")
    foreign = not (place / MARK).is_file() or (place / SWEEP).is_file()
    if place.is_dir() and any(place.iterdir()) and foreign:
        raise InputError(
            "--out", str(place), "it holds other files; allowed is a new folder or an earlier result"
        )


def _make_parents(place: Path) -> list[Path]:
    """Make the folders above `place`; return those that were not there, innermost first."""
    missing = [parent for parent in place.parents if not parent.exists()]
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        _remove(missing)
        raise InputError("--out", str(place), f"the folder cannot be made: {error.strerror}") from None
    return missing


def _remove(folders: list[Path]) -> None:
    for folder in folders:
        try:
            folder.rmdir()
        except OSError:
            return


def _put(folder: Path, place: Path) -> None:
    if not place.exists():
        os.replace(folder, place)
        return
    old = Path(tempfile.mkdtemp(prefix=f".{place.name}.old.", dir=place.parent)) / "result"
    os.replace(place, old)
    try:
        os.replace(folder, place)
    except BaseException:
        os.replace(old, place)
        raise
    finally:
        shutil.rmtree(old.parent, ignore_errors=True)
