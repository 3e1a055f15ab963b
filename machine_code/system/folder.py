"""Folder of compiled code.

Its content is executed. Therefore folder and files must belong to this user and be closed to others, and only plain
files are opened.
"""

import functools
import hashlib
import os
import stat
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

import platformdirs

from machine_code.system import operating_system

USUAL_S, LONGEST_S, TIME_FILE = 2.0, 3600.0, "seconds"
"""Usual and longest time [s] in which a loop is compiled, and the file of the last time.

The usual time is expected where the file is missing.
"""

PATIENCE_S = 2.0
"""Time [s] after which waiting for another process is reported."""

ROOT = Path(__file__).resolve().parents[2]
"""Folder of the packages."""


def cache_folder() -> Path:
    """Return the folder of the compiled code.

    It is below $TAILSLAP_CACHE_DIR, else below the user's cache folder.
    """
    base = os.environ.get("TAILSLAP_CACHE_DIR") or platformdirs.user_cache_path("tailslap", appauthor=False)
    return Path(base) / own_sources("machine_code")[:16]


@functools.cache
def own_sources(*packages: str) -> str:
    """Return the digest of files and sources of packages of this program."""
    digest = hashlib.sha256()
    for source in (path for name in packages for path in sorted((ROOT / name).rglob("*.py"))):
        digest.update(f"{source.relative_to(ROOT)}\0".encode() + source.read_bytes())
    return digest.hexdigest()


def read(path: Path, most: int) -> bytes:
    """Return the content of a file that is safe to execute.

    The result is empty where there is none of at most `most` bytes. The file is a plain file, and it and its folder
    belong to this user and are closed to others.
    """
    with suppress(OSError):
        _claim(path.parent)
        with open(path, "rb", opener=_open) as file:
            status = os.fstat(file.fileno())
            if (
                stat.S_ISREG(status.st_mode)
                and status.st_size <= most
                and operating_system.is_private(status)
            ):
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
    if not operating_system.is_private(folder.lstat()):
        raise PermissionError("it must belong to this user and be inaccessible to others (chmod 700)")


def _open(name: str, flags: int) -> int:
    """Open a file without following a link.

    It does not wait for the other end of a pipe.
    """
    return os.open(name, flags | operating_system.PLAIN, mode=0o600)


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
            operating_system.lock(lock.fileno(), wait=True)
        timer.cancel()
        yield
