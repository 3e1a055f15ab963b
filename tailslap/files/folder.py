"""A result folder holds a whole result, the earlier or the new one, whenever a command or the machine ends.

The folder itself never moves, and files of the user in it are never touched. A command holds the lock of the folder
from its first look to its last write. It writes new files into a folder within, and when they are complete a log of
what they replace, on disk before anything is replaced. Then they are moved one by one, the manifest last, and the log
is removed. Who opens the folder next finishes what a log says, or drops new files without one.

Only an absent or empty folder is taken as a place, or an earlier result of the same command and scene whose files are
unchanged: the manifest lists them (manifest.py).
"""

import contextlib
import hashlib
import os
import re
import shutil
import time
from collections.abc import Iterable, Iterator
from pathlib import Path

from tailslap import errors
from tailslap.files import manifest
from tailslap.files.manifest import LOCK, LOG, NEW, UNKNOWN, Entry, Origin

SWEEP = "sweep.json"
"""The file by which the folder of a sweep is known, which is not replaced: it may hold days of runs."""

ALLOWED = "allowed is a new or empty folder, or a result of tailslap"
ANOTHER = "choose another folder"
RESULTS = Path("results")
MOST_SHOWN = 80
BLANK, UNFIT = r"[\s\"'\[\](){}]", "[^A-Za-z0-9_.,=+^-]"
"""Letters of the changes of a scene that the name of its folder shows, at most; those that it omits, and replaces."""

PATIENCE_S = 10.0
"""Time that a reader waits for a command which is moving its files [s]."""


def default_place(scene: str, changes: Iterable[str], ending: str = "") -> Path:
    """Folder of a result for which none is named, results/SCENE, its changes and the ending.

    changes: texts KEY=VALUE, in the order of the keys. What a name cannot show of them is in a digest at its end.
    """
    texts = [text for text in changes if not text.startswith("name=")]  # it is the scene's
    plain = "".join(f"+{re.sub(BLANK, '', text)}" for text in texts).replace("/", "_")  # of units
    shown = re.sub(UNFIT, "_", plain)
    if len(shown) > MOST_SHOWN or shown != plain:
        digest = hashlib.sha256("\n".join(texts).encode("utf-8", "backslashreplace")).hexdigest()
        shown = f"{shown[:MOST_SHOWN]}-{digest[:8]}"
    return RESULTS / f"{scene}{shown}{ending}"


@contextlib.contextmanager
def result_folder(
    place: Path, inputs: Iterable[Path] = (), force: bool = False, origin: Origin = UNKNOWN
) -> Iterator[Path]:
    """Yield an empty folder: the files with which it is filled become the result in `place`; on any failure none does.

    inputs: files and folders that are read, which are not replaced; force: also replace the result of another origin.
    Raises InputError if `place` cannot be written, is in use or would lose what is not ours.
    """
    with locked(place) as place:
        listed = manifest.read_manifest(place) or ()
        replaced = {place, *(place / item.path for item in listed)}
        if any(resolved(path) in replaced for path in inputs):
            raise errors.InputError("--out", str(place), f"it is an input of the command; {ANOTHER}")
        demand_result(place, force, origin)
        before, new = manifest.entry(place / manifest.NAME), fresh(place)
        try:
            yield new
            if os.listdir(new):
                commit(place, origin)
        except OSError as error:
            if errors.is_there(place / LOG) or manifest.entry(place / manifest.NAME) == before:
                raise
            why = f"the result in {place} is complete; after it: {error.strerror}"
            raise OSError(error.errno, why, error.filename) from None


def demand_result(place: Path, force: bool, origin: Origin) -> None:
    """Raise InputError unless a place is empty, or has an unchanged result: without force, of this origin."""
    names = users(place)
    if manifest.read_manifest(place) is None or SWEEP in names:
        if names or errors.is_there(place / manifest.NAME):
            raise others(place, names or [manifest.NAME], ALLOWED)
        return
    earlier(place)
    held = manifest.read_origin(place)
    if held != origin and not force:
        words = f"{held.command} {held.scene}".strip()
        of = f"the result of `tailslap {words}`" if words else "the result of an earlier version"
        raise errors.InputError(
            "--out", str(place), f"the folder contains {of}; --force replaces it, or {ANOTHER}"
        )


def users(place: Path) -> list[str]:
    """Names in the folder but for those that the program uses for itself, in order."""
    return sorted({*os.listdir(place)} - {manifest.NAME, LOCK, NEW, LOG})


@contextlib.contextmanager
def locked(place: Path) -> Iterator[Path]:
    """Make the folder, links followed, and lock it; what a dead process has left there is finished or dropped.

    A folder that was not there and stays empty goes again. Raises InputError.
    """
    place = resolved(place)
    with contextlib.ExitStack() as stack:
        _make_and_lock(place, stack)
        stack.callback(_leave, place)
        try:
            (place / LOCK).write_text(str(os.getpid()))
            _finish_log(place)
            _drop(place)
        except OSError as error:
            raise errors.place_error(place, "the folder cannot be written", error) from None
        yield place


def _make_and_lock(place: Path, stack: contextlib.ExitStack) -> None:
    while True:
        stack.callback(_remove_folders, _make_folders(place))
        try:
            stack.enter_context(manifest.locked_file(place / LOCK))
            return
        except FileNotFoundError:  # who was there before has removed the folder
            continue
        except BlockingIOError as busy:
            said = f"another command uses this folder; wait for it, or {ANOTHER}"
            raise errors.InputError("--out", str(place), said) from busy
        except OSError as error:
            raise errors.place_error(place, "the folder cannot be locked", error) from None


def _leave(place: Path) -> None:
    """Remove new files that no log speaks of, and the lock."""
    with contextlib.suppress(OSError):
        if _is_held(place) and not errors.is_there(place / LOG):
            _drop(place)
    with contextlib.suppress(OSError):
        if _is_held(place):
            (place / LOCK).unlink()


def _is_held(place: Path) -> bool:
    """True while the lock is in the folder; not where somebody has removed that. A full disk keeps its number out."""
    with manifest.valid_content(), open(place / LOCK, opener=manifest.open_plain) as file:
        return file.read() in ("", str(os.getpid()))
    return False


def fresh(place: Path) -> Path:
    """Return the empty folder for new files in a locked place."""
    manifest.sync(place)  # a log that was removed would be read to mean the new files
    _drop(place)
    (place / NEW).mkdir()
    return place / NEW


def _drop(place: Path) -> None:
    if errors.is_there(place / NEW):
        shutil.rmtree(place / NEW)


def commit(place: Path, origin: Origin = UNKNOWN) -> None:
    """Make the new files the result in a locked place: those of an earlier one go, what the user has added stays.

    Raises InputError where a file that was changed or added would be lost; nothing is then changed.
    """
    if not _is_held(place):
        raise errors.InputError("--out", str(place), "the folder was removed during the command")
    state, logged = "the folder cannot be written", False
    try:
        _write_log(place, origin)
        logged, state = True, f"the result is in its subfolder {NEW}; the next command completes it"
        manifest.sync(place)
        _finish_log(place)
        state = "the result is complete, but the folder cannot be cleared"
        fresh(place)
    except OSError as error:
        raise errors.place_error(place, state, error) from None
    except KeyboardInterrupt:
        if not logged and not errors.is_there(place / LOG):
            raise
        _finish_log(place)
        _drop(place)
        raise errors.Interrupted(f"interrupted; the result is in {place}") from None


def earlier(place: Path, names: Iterable[str] = ()) -> frozenset[Entry]:
    """Files of the earlier result. Raises InputError for one that was changed, and for a user's file of these names."""
    listed = manifest.read_manifest(place) or frozenset()
    ours = {item.path: item for item in listed if errors.is_there(place / item.path)}
    for name, item in sorted(ours.items()):
        if manifest.entry(place / name) != item:
            raise _refusal(place, f"its file {name} was modified")
    for name in sorted(set(names) - ours.keys()):
        if errors.is_there(place / name):  # asked of the folder: "A" and "a" may be one file there
            raise _refusal(place, f"its file {name} does not belong to the result and would be overwritten")
    return frozenset(ours.values())


def _write_log(place: Path, origin: Origin) -> None:
    """Put on disk the new files with their manifest, and then what they replace."""
    new, names = place / NEW, os.listdir(place / NEW)
    entries = [manifest.read_entry(new / name) for name in names]
    old = earlier(place, names)
    manifest.write_manifest(new, entries, origin)
    before = manifest.entry(place / manifest.NAME)
    listed = {
        "old": [*old, before] if before else old,
        "new": [*entries, manifest.read_entry(new / manifest.NAME)],
    }
    log = {name: [item._asdict() for item in items] for name, items in listed.items()}
    for path in (*new.iterdir(), new):
        manifest.sync(path)
    manifest.write_object(new / LOG, log)
    manifest.sync(new / LOG)
    os.replace(new / LOG, place / LOG)


def _read_log(place: Path) -> tuple[frozenset[Entry], frozenset[Entry]] | None:
    """Old and new files of a log; None where there is none. Raises InputError for one that is damaged."""
    if not errors.is_there(place / LOG):
        return None
    found = manifest.read_object(place / LOG)
    old, new = (manifest.read_entries(found.get(name)) for name in ("old", "new"))
    has_manifest = new and any(item.path == manifest.NAME for item in new)
    if old is None or new is None or not has_manifest or len(found) > 2 or (place / NEW).is_symlink():
        raise _damaged(place, LOG)
    return old, new


def _damaged(place: Path, name: str) -> errors.InputError:
    allowed = f"its file {name}, of an interrupted command, is damaged; remove it and {NEW}, or {ANOTHER}"
    return errors.InputError("folder", str(place), allowed)


def _finish_log(place: Path) -> None:
    """Finish what the log of a locked place says, if there is one."""
    if log := _read_log(place):
        old, new = log
        waiting = [item for item in new if errors.is_there(place / NEW / item.path)]
        for item in waiting:
            if manifest.entry(place / NEW / item.path) != item:
                raise _damaged(place, f"{NEW}/{item.path}")
            if errors.is_there(place / item.path) and manifest.entry(place / item.path) not in old:
                raise _refusal(place, f"its file {item.path} was modified")
        for item in old:
            if item.path not in {its.path for its in new} and manifest.entry(place / item.path) == item:
                (place / item.path).unlink()
        for item in sorted(waiting, key=lambda item: (item.path == manifest.NAME, item.path)):
            os.replace(place / NEW / item.path, place / item.path)
        manifest.sync(place)
        (place / LOG).unlink()


def recover(place: Path) -> None:
    """Before a result is read: finish what the log of a dead process says, wait for a living one.

    A folder that may not be written stays as it is: see `path_in`. Raises InputError.
    """
    end = time.monotonic() + PATIENCE_S
    while errors.is_there(place / LOG) and os.access(place, os.W_OK):
        try:
            with locked(place):
                return
        except errors.InputError as error:
            if not isinstance(error.__cause__, BlockingIOError) or time.monotonic() > end:
                raise
            time.sleep(0.05)


def path_in(place: Path, name: str) -> Path:
    """The path of a file of the result, which is still among the new ones where a log could not be finished."""
    waiting = place / NEW / name
    return waiting if _read_log(place) and errors.is_there(waiting) else place / name


def resolved(place: Path) -> Path:
    """The absolute path, links followed. Raises InputError where there is none."""
    try:
        return Path(os.path.realpath(place))
    except OSError as error:
        raise errors.place_error(place, "the path is invalid", error) from None


def _make_folders(place: Path) -> list[Path]:
    """Make the folder and those above it; returns those that were not there, innermost first. Raises InputError."""
    missing = [path for path in (place, *place.parents) if not errors.is_there(path)]
    try:
        place.mkdir(parents=True, exist_ok=True)
    except (FileExistsError, NotADirectoryError):
        allowed = "it is a file, or inside a file; allowed is a folder"
        raise errors.InputError("--out", str(place), allowed) from None
    except OSError as error:
        _remove_folders(missing)
        raise errors.place_error(place, "the folder cannot be created", error) from None
    return missing


def _remove_folders(folders: list[Path]) -> None:
    """Remove those that are empty."""
    with contextlib.suppress(OSError):
        for folder in folders:
            folder.rmdir()


def others(place: Path, names: list[str], allowed: str) -> errors.InputError:
    """Make the error for a place with files of others."""
    shown = ", ".join(names[:2]) + (", ..." if names[2:] else "")
    return errors.InputError("--out", str(place), f"the folder contains other files ({shown}); {allowed}")


def _refusal(place: Path, why: str) -> errors.InputError:
    return errors.InputError("--out", str(place), f"{why}; rename this file, or {ANOTHER}")
