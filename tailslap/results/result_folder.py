"""A result folder is complete or absent: it is filled beside its place and moved there at the end.

A result carries a manifest of its files (manifest.py). Only an absent or empty folder is taken as a place, or an
earlier result whose files are unchanged: those are replaced, all of them, and whatever the user has added beside them
stays in the folder as it is. A file of a result that the user changed is refused, and so is an added one that the new
result would overwrite; nothing is then changed.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import stat
from collections.abc import Iterator
from pathlib import Path

from tailslap.errors import place_error
from tailslap.results.earlier_result import find_earlier, put_in_place
from tailslap.results.leftovers import clear_leftovers, unfinished_folder
from tailslap.results.manifest import entry, write_manifest


@contextlib.contextmanager
def result_folder(place: Path) -> Iterator[Path]:
    """Yield an empty folder to fill with files; on success it becomes `place`, on any failure nothing is left of it.

    A link to a folder is followed. Raises InputError if `place` cannot be written or would lose what is not ours.
    """
    place = resolved(place)
    find_earlier(place)
    made = make_folders(place.parent, place)
    clear_leftovers(place)
    try:
        with _unfinished(place) as folder:
            with _filled(folder, place):
                yield folder
            put_in_place(folder, place)
    except BaseException:
        remove_folders(made)
        raise


def demand_place(place: Path) -> None:
    """Before long work: raise InputError if `place` holds something else than an unchanged earlier result, or cannot be
    written."""
    place = resolved(place)
    find_earlier(place)
    made = make_folders(place.parent, place)
    try:
        with _unfinished(place) as folder:
            folder.rmdir()
    finally:
        remove_folders(made)


def resolved(place: Path) -> Path:
    """The absolute path, links followed. Raises InputError where there is none."""
    try:
        return Path(os.path.realpath(place))
    except OSError as error:
        raise place_error(place, "the folder has no path", error) from None


@contextlib.contextmanager
def _unfinished(place: Path) -> Iterator[Path]:
    """A fresh folder beside `place`."""
    with contextlib.ExitStack() as stack:
        try:
            folder = stack.enter_context(unfinished_folder(place))
        except OSError as error:
            raise place_error(place, "the folder cannot be written", error) from None
        yield folder


@contextlib.contextmanager
def _filled(folder: Path, place: Path) -> Iterator[None]:
    """The folder has its manifest when this ends; it is removed if that fails."""
    try:
        yield
        _seal(folder)
        folder.chmod(stat.S_IMODE(place.stat().st_mode) if place.exists() else 0o755)
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise


def _seal(folder: Path) -> None:
    """Write the manifest of a folder that is complete."""
    entries = [entry(path) for path in folder.iterdir()]
    if None in entries:
        raise ValueError("a result holds plain files alone")
    write_manifest(folder, (item for item in entries if item))


def make_folders(folder: Path, place: Path) -> list[Path]:
    """Make a folder and those above it; returns those that were not there, innermost first.

    Raises InputError, which names the place that was asked for.
    """
    missing = [path for path in (folder, *folder.parents) if not path.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        remove_folders(missing)
        raise place_error(place, "the folder cannot be made", error) from None
    return missing


def remove_folders(folders: list[Path]) -> None:
    """Remove those that are empty."""
    for folder in folders:
        try:
            folder.rmdir()
        except OSError:
            return
