"""What a new result finds in its place, and the move into it.

Nothing is removed but files that a manifest lists, one by one, and folders that are empty then. Until the new result is
in its place the earlier one is kept whole beside it, under a name that is not hidden: killed in between, it is there.
"""

from __future__ import annotations

import contextlib
import json
import os
import tempfile
from dataclasses import dataclass
from pathlib import Path

import click

from tailslap.errors import InputError, Interrupted, place_error
from tailslap.results.manifest import NAME, Entry, entry, read_manifest

SWEEP = "sweep.json"
"""The file by which the folder of a sweep is known, which is not replaced: it may hold days of runs."""

ALLOWED = "allowed is a new or empty folder, or a result of tailslap"


@dataclass(frozen=True)
class Earlier:
    """What is in a place: the files of an earlier result, all unchanged, and names that the user has added."""

    ours: frozenset[Entry] = frozenset()
    added: tuple[str, ...] = ()
    empty: bool = True


def find_earlier(place: Path) -> Earlier:
    """What is in the place. Raises InputError for anything but an absent or empty folder or an unchanged result."""
    try:
        names = sorted(os.listdir(place))
    except FileNotFoundError:
        return Earlier()
    except NotADirectoryError:
        raise InputError("--out", str(place), "this is a file, or in one; allowed is a folder") from None
    except OSError as error:
        raise place_error(place, "the folder cannot be read", error) from None
    if not names:
        return Earlier()
    listed = read_manifest(place)
    if listed is None or SWEEP in names:
        shown = ", ".join(names[:2]) + (", ..." if names[2:] else "")
        raise InputError("--out", str(place), f"it holds other files ({shown}); {ALLOWED}")
    ours = frozenset(item for item in listed if item.path in names)
    _refuse_changed(place, ours)
    known = {NAME, *(item.path for item in ours)}
    return Earlier(ours, tuple(name for name in names if name not in known), empty=False)


def demand_own(place: Path, scene: str, force: bool) -> None:
    """Raise InputError where the place holds the result of another scene, unless that is to be replaced by force."""
    if force or read_manifest(place) is None:
        return
    with contextlib.suppress(OSError, ValueError, AttributeError):
        other = json.loads((place / "summary.json").read_text(encoding="utf-8")).get("scene", scene)
        if other != scene:
            allowed = (
                f"it holds the result of the scene {other!r}; --force replaces it, or give another folder"
            )
            raise InputError("--out", str(place), allowed)


def put_in_place(folder: Path, place: Path) -> None:
    """Make the filled folder `place`: the files of an earlier result go, what the user has added stays there.

    On any failure the place is as it was, and the filled folder is gone.
    """
    new = read_manifest(folder) or frozenset()
    try:
        earlier = find_earlier(place)
        _refuse_overwriting(place, earlier, new)
        aside = _exchange(folder, place, earlier)
    except OSError as error:
        _discard(folder, new)
        raise place_error(place, "the result cannot be moved there", error) from None
    except BaseException:
        _discard(folder, new)
        raise
    if aside is not None:
        _clear(aside, earlier, place)


def _exchange(folder: Path, place: Path, earlier: Earlier) -> Path | None:
    """Move the folder to its place, and what was added into it; returns where the rest of the earlier result is."""
    if earlier.empty:
        os.rename(folder, place)
        return None
    aside = Path(tempfile.mkdtemp(prefix=f"{place.name}.", dir=place.parent))
    try:
        os.rename(place, aside)
        os.rename(folder, place)
        for name in earlier.added:
            _move(aside / name, place / name)
    except BaseException:
        _undo_or_say(folder, place, aside, earlier.added)
        raise
    return aside


def _move(source: Path, target: Path) -> None:
    if os.path.lexists(target):
        raise FileExistsError(f"{target.name} is there already")
    os.rename(source, target)


def _undo_or_say(folder: Path, place: Path, aside: Path, added: tuple[str, ...]) -> None:
    try:
        _undo(folder, place, aside, added)
    except (OSError, KeyboardInterrupt):
        why = f"moving the result there failed, and so did undoing it; what was there before is in {aside}"
        raise InputError("--out", str(place), f"{why}, or in {place} still") from None


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


def _clear(aside: Path, earlier: Earlier, place: Path) -> None:
    """Remove the earlier result's own files, now that the new ones are there."""
    try:
        _discard(aside, earlier.ours)
    except KeyboardInterrupt:
        said = f"interrupted; the result is in {place}, and the rest of the earlier one in {aside}"
        raise Interrupted(said) from None


def _discard(folder: Path, listed: frozenset[Entry]) -> None:
    """Remove the listed files, if they are unchanged, and the folder, if it is empty then; else say where it is."""
    with contextlib.suppress(OSError):
        for item in listed:
            if entry(folder / item.path) == item:
                (folder / item.path).unlink()
        (folder / NAME).unlink()
        folder.rmdir()
    if folder.exists():
        click.echo(f"tailslap: not all of {folder} could be removed; look what is in it", err=True)


def _refuse_changed(place: Path, ours: frozenset[Entry]) -> None:
    for name in sorted({item.path for item in ours}):
        if entry(place / name) not in ours:
            _refuse(place, f"{name} in it was changed since the program wrote it")


def _refuse_overwriting(place: Path, earlier: Earlier, new: frozenset[Entry]) -> None:
    """Names are looked up in the folder itself: some file systems do not tell capital letters from small ones."""
    known = {item.path for item in earlier.ours}
    for name in sorted({item.path for item in new} - known):
        if os.path.lexists(place / name):
            _refuse(place, f"{name} in it was added, and the new result has a file of that name")


def _refuse(place: Path, why: str) -> None:
    raise InputError("--out", str(place), f"{why}; move that file away, or give another folder")
