"""Folder of compiled code, and digests of sources.

A loop contains the functions that it calls, of any file. The content of the folder is executed. Therefore folder and
files must belong to this user and be closed to others, and only plain files are opened.
"""

import fcntl
import functools
import hashlib
import os
import stat
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

import platformdirs

PACKAGES = ("machine_code", "fem")
"""Packages whose sources are in every digest, because compiled code anywhere may contain theirs."""

REGISTERED: list[Callable[[], Iterable[Any]]] = []
"""Functions that return registered laws, whose fields are kernels and the type of their constants."""

USUAL_S, LONGEST_S, TIME_FILE = 2.0, 3600.0, "seconds"
"""Usual and longest time [s] in which a loop is compiled, and the file of the last time.

The usual time is expected where the file is missing.
"""

PATIENCE_S = 2.0
"""Time [s] after which waiting for another process is reported."""

ROOT = Path(__file__).resolve().parents[1]
"""Folder of the packages."""


def cache_folder() -> Path:
    """Return the folder of the compiled code.

    It is below $TAILSLAP_CACHE_DIR, else below the user's cache folder.
    """
    base = os.environ.get("TAILSLAP_CACHE_DIR") or platformdirs.user_cache_path("tailslap", appauthor=False)
    return Path(base) / own_sources()[:16]


@functools.cache
def own_sources() -> str:
    """Return the digest of the sources of PACKAGES."""
    digest = hashlib.sha256()
    for source in (path for name in PACKAGES for path in sorted((ROOT / name).rglob("*.py"))):
        digest.update(source.read_bytes())
    return digest.hexdigest()


def sources_of_laws(kinds: Iterable[type] | None = None) -> str:
    """Return the digest of the sources of registered laws outside PACKAGES.

    kinds: types of their constants; None for all laws.
    """
    laws = (law for registered in REGISTERED for law in registered())
    chosen = (law for law in laws if kinds is None or law.constants in kinds)
    functions = {value for law in chosen for value in vars(law).values() if isinstance(value, FunctionType)}
    return "".join(sorted(filter(None, map(sources_of, functions))))


@functools.cache
def sources_of(function: FunctionType) -> str:
    """Return the digest of the sources of a function outside PACKAGES.

    They are its file, or all files of its package, and those of functions of other packages that it names.
    """
    path, depth = Path(function.__code__.co_filename).resolve(), function.__module__.count(".")
    if any(ROOT / name in path.parents for name in PACKAGES):
        return ""  # among `own_sources`
    digest = hashlib.sha256(_source_of(function))
    with suppress(OSError):
        for source in sorted(path.parents[depth - 1].rglob("*.py")) if depth else []:
            digest.update(source.read_bytes())
    for value in _named(function):
        kernel = getattr(value, "py_func", None)
        digest.update(sources_of(kernel).encode() if kernel else _source_of(value))
    return digest.hexdigest()


def _source_of(function: FunctionType) -> bytes:
    """Return the source file of a function, if any, and its code.

    The numbers of its closure belong to it.
    """
    code, cells = function.__code__, [cell.cell_contents for cell in function.__closure__ or ()]
    numbers = [value for value in cells if isinstance(value, int | float)]
    description = repr((code.co_code, code.co_consts, code.co_names, numbers)).encode()
    with suppress(OSError):
        return Path(code.co_filename).read_bytes() + description
    return description


def _named(function: FunctionType) -> list[Any]:
    """Return the functions of other packages that a function names."""
    names, package = function.__code__.co_names, function.__module__.partition(".")[0]
    values = [function.__globals__.get(name) for name in names]
    values += [
        vars(module).get(name) for module in values if isinstance(module, ModuleType) for name in names
    ]
    functions = (value for value in values if isinstance(getattr(value, "py_func", value), FunctionType))
    return [
        value for value in functions if str(value.__module__).partition(".")[0] not in (package, *PACKAGES)
    ]


def read(path: Path, most: int) -> bytes:
    """Return the content of a file that is safe to execute.

    The result is empty where there is none of at most `most` bytes. The file is a plain file, and it and its folder
    belong to this user and are closed to others.
    """
    with suppress(OSError):
        _claim(path.parent)
        with open(path, "rb", opener=_open) as file:
            status = os.fstat(file.fileno())
            if stat.S_ISREG(status.st_mode) and status.st_size <= most and _is_closed(status):
                return file.read(most)
    return b""


def write(path: Path, content: bytes) -> None:
    """Write a file completely or not at all.

    Raises OSError, also for a folder to which others can write.
    """
    import tempfile

    _claim(path.parent)
    with tempfile.TemporaryDirectory(dir=path.parent, prefix=".") as temporary:
        with open(new := Path(temporary, path.name), "xb", opener=_open) as file:
            file.write(content)
        os.replace(new, path)


def _claim(folder: Path) -> None:
    """Make a folder where there is none.

    Raises OSError for a folder of another user, or one open to others.
    """
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    if not _is_closed(folder.lstat()):
        raise PermissionError("it must belong to this user and be inaccessible to others (chmod 700)")


def _is_closed(status: os.stat_result) -> bool:
    """Return True if only this user can read and write."""
    return status.st_uid == os.geteuid() and not status.st_mode & 0o077


def _open(name: str, flags: int) -> int:
    """Open a file without following a link.

    It does not wait for the other end of a pipe.
    """
    return os.open(name, flags | os.O_NOFOLLOW | os.O_NONBLOCK, mode=0o600)


def expected_time() -> float:
    """Return the time [s] that the last loop took to be compiled."""
    with suppress(ValueError):
        seconds = float(read(cache_folder() / TIME_FILE, 32))
        if 0.0 < seconds < LONGEST_S:
            return seconds
    return USUAL_S


def save_time(seconds: float) -> None:
    """Save the compilation time [s] of a loop.

    Raises OSError where nothing can be stored.
    """
    write(cache_folder() / TIME_FILE, f"{seconds:.4g}".encode())


@contextmanager
def one_process_compiles(code: Path, on_wait: Callable[[], None]) -> Iterator[None]:
    """Make other processes wait for the compilation of the same code.

    They then load the result of this one. on_wait: called when this process has waited for some time. Where nothing
    can be stored, each process compiles its own code.
    """
    timer = threading.Timer(PATIENCE_S, on_wait)
    with ExitStack() as open_files:
        with suppress(OSError):
            _claim(code.parent)
            lock = open_files.enter_context(open(code.with_suffix(".lock"), "ab", opener=_open))
            timer.start()
            fcntl.flock(lock, fcntl.LOCK_EX)
        timer.cancel()
        yield
