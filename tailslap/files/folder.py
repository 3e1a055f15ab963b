"""A result folder is complete or absent: it is filled beside its place and moved there at the end.

A result carries a manifest of its files (manifest.py). Only an absent or empty folder is taken as a place, or an
earlier result whose files are unchanged: those are replaced, all of them, and whatever the user has added beside them
stays in the folder as it is. A file of a result that the user changed is refused, and so is an added one that the new
result would overwrite; nothing is then changed.

Nothing is removed but files that a manifest lists, one by one, and folders that are empty then. Until the new result is
in its place the earlier one is kept whole beside it, under a name that is not hidden: killed in between, it is there.
"""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import stat
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import click

from tailslap import errors
from tailslap.files import manifest
from tailslap.files.manifest import Entry

SWEEP = "sweep.json"
"""The file by which the folder of a sweep is known, which is not replaced: it may hold days of runs."""

ALLOWED = "allowed is a new or empty folder, or a result of tailslap"


class Earlier(NamedTuple):
    """The files of an earlier result in a place, all unchanged, and names that the user has added."""

    ours: frozenset[Entry] = frozenset()
    added: tuple[str, ...] = ()
    is_empty: bool = True


@contextlib.contextmanager
def result_folder(place: Path) -> Iterator[Path]:
    """Yield an empty folder to fill with files; on success it becomes `place`, on any failure nothing is left of it.

    A link to a folder is followed. Raises InputError if `place` cannot be written or would lose what is not ours.
    """
    place = resolved(place)
    with _unfinished(place) as folder:
        try:
            yield folder
            _seal(folder)
            folder.chmod(stat.S_IMODE(place.stat().st_mode) if place.exists() else 0o755)
        except BaseException:
            shutil.rmtree(folder, ignore_errors=True)
            raise
        _put_in_place(folder, place)


def demand_place(place: Path) -> None:
    """Before long work: raise InputError if `place` holds something else than an unchanged earlier result, or cannot be
    written."""
    with _unfinished(resolved(place)) as folder:
        folder.rmdir()


def demand_own(place: Path, scene: str, force: bool) -> None:
    """Raise InputError where the place holds the result of another scene, unless that is to be replaced by force."""
    if force or manifest.read_manifest(place) is None:
        return
    with contextlib.suppress(OSError, ValueError, AttributeError):
        other = json.loads((place / "summary.json").read_text(encoding="utf-8")).get("scene", scene)
        if other != scene:
            allowed = (
                f"it holds the result of the scene {other!r}; --force replaces it, or give another folder"
            )
            raise errors.InputError("--out", str(place), allowed)


def resolved(place: Path) -> Path:
    """The absolute path, links followed. Raises InputError where there is none."""
    try:
        return Path(os.path.realpath(place))
    except OSError as error:
        raise errors.place_error(place, "the folder has no path", error) from None


def make_folders(folder: Path, place: Path) -> list[Path]:
    """Make a folder and those above it; returns those that were not there, innermost first.

    Raises InputError, which names the place that was asked for.
    """
    missing = [path for path in (folder, *folder.parents) if not path.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        remove_folders(missing)
        raise errors.place_error(place, "the folder cannot be made", error) from None
    return missing


def remove_folders(folders: list[Path]) -> None:
    """Remove those that are empty."""
    with contextlib.suppress(OSError):
        for folder in folders:
            folder.rmdir()


@contextlib.contextmanager
def _unfinished(place: Path) -> Iterator[Path]:
    """Yield a fresh folder beside `place`, which may be taken; folders made for it that stay empty go again."""
    _find_earlier(place)
    made = make_folders(place.parent, place)
    manifest.clear_leftovers(place)
    with contextlib.ExitStack() as stack:
        stack.callback(remove_folders, made)
        try:
            folder = stack.enter_context(manifest.unfinished(place, lambda path: path.mkdir(0o700)))
        except OSError as error:
            raise errors.place_error(place, "the folder cannot be written", error) from None
        yield folder


def _seal(folder: Path) -> None:
    """Write the manifest of a folder that is complete."""
    entries = [manifest.entry(path) for path in folder.iterdir()]
    if None in entries:
        raise ValueError("a result holds plain files alone")
    manifest.write_manifest(folder, (item for item in entries if item))


def _find_earlier(place: Path) -> Earlier:
    """The content of the place. Raises InputError for anything but an absent or empty folder or an unchanged result."""
    try:
        names = sorted(os.listdir(place))
    except FileNotFoundError:
        return Earlier()
    except NotADirectoryError:
        raise errors.InputError(
            "--out", str(place), "this is a file, or in one; allowed is a folder"
        ) from None
    except OSError as error:
        raise errors.place_error(place, "the folder cannot be read", error) from None
    if not names:
        return Earlier()
    listed = manifest.read_manifest(place)
    if listed is None or SWEEP in names:
        raise others(place, names, ALLOWED)
    ours = frozenset(item for item in listed if item.path in names)
    known = {item.path for item in ours}
    for name in sorted(known):
        if manifest.entry(place / name) not in ours:
            raise _refusal(place, f"{name} in it was changed since the program wrote it")
    return Earlier(ours, tuple(name for name in names if name not in {manifest.NAME, *known}), False)


def others(place: Path, names: list[str], allowed: str) -> errors.InputError:
    """Make the error for a place with files of others."""
    shown = ", ".join(names[:2]) + (", ..." if names[2:] else "")
    return errors.InputError("--out", str(place), f"it holds other files ({shown}); {allowed}")


def _refusal(place: Path, why: str) -> errors.InputError:
    return errors.InputError("--out", str(place), f"{why}; move that file away, or give another folder")


def _put_in_place(folder: Path, place: Path) -> None:
    """Make the filled folder `place`: the files of an earlier result go, what the user has added stays there.

    On any failure the place is as it was, and the filled folder is gone.
    """
    new = manifest.read_manifest(folder) or frozenset()
    try:
        earlier = _find_earlier(place)
        for name in sorted({item.path for item in new} - {item.path for item in earlier.ours}):
            if os.path.lexists(place / name):  # asked of the folder: "A" and "a" may be one file there
                raise _refusal(place, f"{name} in it was added, and the new result has a file of that name")
        aside = _exchange(folder, place, earlier)
    except BaseException as error:
        _discard(folder, new)
        if isinstance(error, OSError):
            raise errors.place_error(place, "the result cannot be moved there", error) from None
        raise
    if aside is not None:
        try:
            _discard(aside, earlier.ours)
        except KeyboardInterrupt:
            said = f"interrupted; the result is in {place}, and the rest of the earlier one in {aside}"
            raise errors.Interrupted(said) from None


def _exchange(folder: Path, place: Path, earlier: Earlier) -> Path | None:
    """Move the folder to its place, and what was added into it; returns where the rest of the earlier result is."""
    if earlier.is_empty:
        os.rename(folder, place)
        return None
    aside = Path(tempfile.mkdtemp(prefix=f"{place.name}.", dir=place.parent))
    try:
        os.rename(place, aside)
        os.rename(folder, place)
        for name in earlier.added:
            if os.path.lexists(place / name):
                raise FileExistsError(f"{name} is there already")
            os.rename(aside / name, place / name)
    except BaseException:
        try:
            _undo(folder, place, aside, earlier.added)
        except (OSError, KeyboardInterrupt):
            why = (
                f"moving the result there failed, and so did undoing it; what was there before is in {aside}"
            )
            raise errors.InputError("--out", str(place), f"{why}, or in {place} still") from None
        raise
    return aside


def _undo(folder: Path, place: Path, aside: Path, added: tuple[str, ...]) -> None:
    """Move back what was moved, as found on disk: an interrupt may have come after any step."""
    if not any(aside.iterdir()) and place.exists() and folder.exists():  # nothing was moved yet
        aside.rmdir()
        return
    for name in added:
        if os.path.lexists(place / name) and not os.path.lexists(aside / name):
            os.rename(place / name, aside / name)
    if place.exists():
        os.rename(place, folder)
    os.rename(aside, place)


def _discard(folder: Path, listed: frozenset[Entry]) -> None:
    """Remove the listed files, if they are unchanged, and the folder, if it is empty then; else say where it is."""
    with contextlib.suppress(OSError):
        for item in listed:
            if manifest.entry(folder / item.path) == item:
                (folder / item.path).unlink()
        (folder / manifest.NAME).unlink()
        folder.rmdir()
    if folder.exists():
        click.echo(f"tailslap: not all of {folder} could be removed; look what is in it", err=True)
