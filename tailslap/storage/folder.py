"""Fill result folders that are complete at any time.

A folder contains the earlier or the new result, whenever a command or the machine ends. The folder itself is never
renamed, and files of the user in it are never touched. A command locks the folder until its last write. It writes new
files into a folder within, and when they are complete a log of the files that they replace, on disk before anything is
replaced. Then they are renamed one by one, the manifest last, and the log is removed. The next process that opens the
folder finishes the replacements of a log, or drops new files without one.

Only an absent or empty folder is accepted, or an earlier result of the same command, scene and changes whose files
are unchanged: the manifest lists them (manifest.py).
"""

import contextlib
import hashlib
import os
import re
import shlex
import shutil
import time
from collections.abc import Iterable, Iterator
from pathlib import Path

from machine_code.system.operating_system import HAS_FORK
from tailslap import errors
from tailslap.storage import manifest
from tailslap.storage.manifest import LOCK, LOG, NEW, Entry, Origin

SWEEP = "sweep.json"
"""File that marks the folder of a sweep, which is not replaced: it may hold days of runs."""

ALLOWED = "allowed is a new or empty folder, or a result of tailslap"
ANOTHER = "choose another folder"
RESULTS = Path("results")
UNKNOWN = Origin("", "")
MAX_SUFFIX = 80
BLANK, UNFIT = r"[\s\"'\[\](){}]", "[^A-Za-z0-9_.,=+^-]"
"""Largest length of the changes in the name of a folder; letters of them that it omits, and that it replaces."""

PATIENCE_S = 10.0
"""Time that a reader waits for a command that replaces files [s]."""


def default_place(scene: str, changes: Iterable[str], ending: str = "") -> Path:
    """Return the default folder of a result, results/SCENE with its changes.

    changes: texts KEY=VALUE, in the order of the keys. Where the name cannot contain them it ends with a digest.
    """
    texts = [text for text in changes if not text.startswith("name=")]  # the scene's name, which comes first
    plain = "".join(f"+{re.sub(BLANK, '', text)}" for text in texts).replace("/", "_")  # "/" of units
    suffix = re.sub(UNFIT, "_", plain)
    if len(suffix) > MAX_SUFFIX or suffix != plain:
        digest = hashlib.sha256("\n".join(texts).encode("utf-8", "backslashreplace")).hexdigest()
        suffix = f"{suffix[:MAX_SUFFIX]}-{digest[:8]}"
    return RESULTS / f"{scene}{suffix}{ending}"


@contextlib.contextmanager
def result_folder(
    place: Path, inputs: Iterable[Path] = (), force: bool = False, origin: Origin = UNKNOWN
) -> Iterator[Path]:
    """Yield an empty folder, whose files become the result in `place`.

    On any failure none of them does. inputs: files and folders that are read, which are not replaced; force: also
    replace the result of another origin. Raises InputError if `place` cannot be written, is in use or would lose files
    that are not the program's.
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
    """Raise InputError unless a place is empty or may be replaced.

    An unchanged result may be replaced; without force it must be of this origin.
    """
    names = visible_names(place)
    if manifest.read_manifest(place) is None or SWEEP in names:
        if names or errors.is_there(place / manifest.NAME):
            names = names or [manifest.NAME]
            listed = ", ".join(names[:2]) + (", ..." if names[2:] else "")
            why = f"the folder contains other files ({listed}); {ALLOWED}"
            raise errors.InputError("--out", str(place), why)
        return
    earlier(place)
    present = manifest.read_origin(place)
    if present != origin and not force:
        sets = " ".join(f"--set {shlex.quote(text)}" for text in present.changes)
        words = " ".join(filter(None, (present.command, present.scene, errors.shortened(sets))))
        content = f"the result of `tailslap {words}`" if words else "the result of an earlier version"
        raise errors.InputError(
            "--out", str(place), f"the folder contains {content}; --force replaces it, or {ANOTHER}"
        )


def visible_names(place: Path) -> list[str]:
    """List names except the program's auxiliary files."""
    return sorted({*os.listdir(place)} - {manifest.NAME, LOCK, NEW, LOG})


@contextlib.contextmanager
def locked(place: Path) -> Iterator[Path]:
    """Make the folder, links followed, and lock it.

    Files of a process that has died are completed or dropped. A new folder that stays empty is removed again. Raises
    InputError.
    """
    place = resolved(place)
    with contextlib.ExitStack() as stack:
        _make_and_lock(place, stack)
        stack.callback(_leave, place)
        try:
            if HAS_FORK:
                (place / LOCK).write_text(str(os.getpid()))
            _finish_log(place)
            _drop(place)
        except OSError as error:
            raise errors.place_error(place, "the folder cannot be written", error) from None
        yield place


def _make_and_lock(place: Path, stack: contextlib.ExitStack) -> None:
    """Make and lock the folder until the stack is closed. Raises InputError."""
    while True:
        stack.callback(_remove_folders, _make_folders(place))
        try:
            stack.enter_context(manifest.locked_file(place / LOCK))
            return
        except FileNotFoundError:  # another process has removed the folder
            continue
        except BlockingIOError as busy:
            allowed = f"another command uses this folder; wait for it, or {ANOTHER}"
            raise errors.InputError("--out", str(place), allowed) from busy
        except OSError as error:
            raise errors.place_error(place, "the folder cannot be locked", error) from None


def _leave(place: Path) -> None:
    """Remove the lock and unlisted new files."""
    with contextlib.suppress(OSError):
        if _is_held(place) and not errors.is_there(place / LOG):
            _drop(place)
    with contextlib.suppress(OSError):
        if _is_held(place):
            (place / LOCK).unlink()


def _is_held(place: Path) -> bool:
    """Return True while the lock of this process is in the folder.

    Another process may have removed the folder, but on Windows. On a full disk the lock has no number.
    """
    if not HAS_FORK:
        return True
    with manifest.valid_content(), open(place / LOCK, opener=manifest.open_plain) as file:
        return file.read() in ("", str(os.getpid()))
    return False


def fresh(place: Path) -> Path:
    """Return the empty folder for new files in a locked place."""
    manifest.sync(place)  # else a removed log could apply to the new files
    _drop(place)
    (place / NEW).mkdir()
    return place / NEW


def _drop(place: Path) -> None:
    """Remove new files."""
    if errors.is_there(place / NEW):
        shutil.rmtree(place / NEW)


def commit(place: Path, origin: Origin = UNKNOWN) -> None:
    """Make the new files the result in a locked place.

    Files of an earlier result are removed, files of the user stay. Raises InputError where a changed or added file
    would be lost; nothing is then changed.
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
    """Return the files of the earlier result.

    Raises InputError for a changed file, and for a user's file of these names.
    """
    listed = manifest.read_manifest(place) or frozenset()
    ours = {item.path: item for item in listed if errors.is_there(place / item.path)}
    for name, item in sorted(ours.items()):
        if manifest.entry(place / name) != item:
            raise _refusal(place, f"its file {name} was modified")
    for name in sorted(set(names) - ours.keys()):
        if errors.is_there(place / name):  # in some file systems "A" and "a" are one file
            raise _refusal(place, f"its file {name} does not belong to the result and would be overwritten")
    return frozenset(ours.values())


def _write_log(place: Path, origin: Origin) -> None:
    """Write the new files with their manifest to disk, then the log."""
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
    """Return old and new files of a log, None without one.

    Raises InputError for a damaged log.
    """
    if not errors.is_there(place / LOG):
        return None
    log = manifest.read_object(place / LOG)
    old, new = (manifest.read_entries(log.get(name)) for name in ("old", "new"))
    has_manifest = new and any(item.path == manifest.NAME for item in new)
    if old is None or new is None or not has_manifest or len(log) > 2 or (place / NEW).is_symlink():
        raise _damaged(place, LOG)
    return old, new


def _damaged(place: Path, name: str) -> errors.InputError:
    """Return the error for a damaged file of an interrupted command."""
    allowed = f"its file {name}, of an interrupted command, is damaged; remove it and {NEW}, or {ANOTHER}"
    return errors.InputError("folder", str(place), allowed)


def _finish_log(place: Path) -> None:
    """Finish the replacements that the log of a locked place lists."""
    if log := _read_log(place):
        old, new = log
        waiting = [item for item in new if errors.is_there(place / NEW / item.path)]
        for item in waiting:
            if manifest.entry(place / NEW / item.path) != item:
                raise _damaged(place, f"{NEW}/{item.path}")
            if errors.is_there(place / item.path) and manifest.entry(place / item.path) not in old:
                raise _refusal(place, f"its file {item.path} was modified")
        for item in old:
            if item.path not in {entry.path for entry in new} and manifest.entry(place / item.path) == item:
                (place / item.path).unlink()
        for item in sorted(waiting, key=lambda item: (item.path == manifest.NAME, item.path)):
            os.replace(place / NEW / item.path, place / item.path)
        manifest.sync(place)
        (place / LOG).unlink()


def recover(place: Path) -> None:
    """Finish the log of a dead process before a result is read.

    A living process is waited for. A folder without write access stays as it is: see `path_in`. Raises InputError.
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
    """Return the path of a result file.

    Where a log could not be finished it may be among the new files.
    """
    waiting = place / NEW / name
    return waiting if _read_log(place) and errors.is_there(waiting) else place / name


def resolved(place: Path) -> Path:
    """Return the absolute path, links followed. Raises InputError."""
    try:
        return Path(os.path.realpath(place))
    except OSError as error:
        raise errors.place_error(place, "the path is invalid", error) from None


def _make_folders(place: Path) -> list[Path]:
    """Make the folder and its parents, and return the new ones.

    The innermost is first. Raises InputError.
    """
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
    """Remove empty folders."""
    with contextlib.suppress(OSError):
        for folder in folders:
            folder.rmdir()


def _refusal(place: Path, why: str) -> errors.InputError:
    """Return the error for a file that would be lost."""
    return errors.InputError("--out", str(place), f"{why}; rename this file, or {ANOTHER}")
