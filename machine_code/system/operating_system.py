"""Adapt to Linux, macOS and Windows.

No other module uses names that are missing on one of them. Tests run on Linux, some of them without these names.
"""

from __future__ import annotations

import contextlib
import errno
import math
import multiprocessing
import os
import signal
import subprocess
import threading
import time
from collections.abc import Iterator, Sequence
from multiprocessing.connection import Connection
from multiprocessing.context import BaseContext
from pathlib import Path

HAS_FORK = hasattr(os, "fork")
"""False on Windows, where moreover an open file is not replaced, and a locked one not read by another descriptor."""

NO_WAIT = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
PLAIN = NO_WAIT | getattr(os, "O_NOFOLLOW", 0)
"""Flags of opening bytes without waiting for a pipe, and of a file itself, not of the target of a link."""

ENDING = {getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)}
"""Signals that end a process, but Ctrl-C."""

DESCRIPTORS = Path("/proc/self/fd")
"""Open files of this process on Linux, which a worker opens again for itself."""


def is_private(status: os.stat_result) -> bool:
    """Return True if only this user can read and write.

    On Windows a user's folders are closed to others.
    """
    return not hasattr(os, "geteuid") or (status.st_uid == os.geteuid() and not status.st_mode & 0o077)


def is_root() -> bool:
    """Return True for the superuser of Linux or macOS."""
    return hasattr(os, "geteuid") and os.geteuid() == 0


def lock(number: int, wait: bool) -> None:
    """Lock an open file until it is closed or its process ends.

    Raises BlockingIOError where another process has the lock, if it is not waited for.
    """
    from filelock import lock_descriptor

    if not lock_descriptor(number, blocking=wait):
        raise BlockingIOError(errno.EAGAIN, os.strerror(errno.EAGAIN))


def sync(path: Path) -> None:
    """Wait until a file, or a folder's names, are on disk.

    Windows does not synchronize folders, and no file opened to be read.
    """
    if not HAS_FORK and path.is_dir():
        return
    number = os.open(path, os.O_RDONLY if HAS_FORK else os.O_RDWR)
    try:
        os.fsync(number)
    except OSError as error:
        if error.errno != errno.EINVAL:  # network file systems do not synchronize folders
            raise
    finally:
        os.close(number)


def available_cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def free_memory() -> float:
    """Return the free memory of the machine [bytes]."""
    import psutil

    return float(psutil.virtual_memory().available)


def address_space() -> float:
    """Return the limit of the address space of a process [bytes]."""
    import psutil

    process = psutil.Process()
    limit = process.rlimit(psutil.RLIMIT_AS)[0] if hasattr(process, "rlimit") else math.inf
    return math.inf if limit in (-1, math.inf) else float(limit)


def used_address_space() -> float:
    """Return the size of the address space of this process [bytes]."""
    import psutil

    return float(psutil.Process().memory_info().vms)


@contextlib.contextmanager
def held_signals() -> Iterator[None]:
    """Let signals that end this process wait, for new processes too."""
    if not HAS_FORK:
        yield
        return
    from multiprocessing import resource_tracker

    resource_tracker.ensure_running()  # when it starts, it would unblock the signals
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, *ENDING})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)


def worker_context(modules: Sequence[str]) -> BaseContext:
    """Return the context of worker processes.

    They are forked from one that has imported the modules. Where this is impossible, each imports them.
    """
    context = multiprocessing.get_context("forkserver" if HAS_FORK else "spawn")
    if HAS_FORK:
        context.set_forkserver_preload(list(modules))
    return context


def end_starting_workers() -> None:
    """End the process from which workers are forked."""
    from multiprocessing import forkserver

    number = forkserver._forkserver._forkserver_pid  # type: ignore[attr-defined]
    if number is not None:
        os.kill(number, signal.SIGKILL)


def end_with_owner(lifeline: Connection) -> None:
    """Let this process end with its owner.

    The death of the owner closes the other end of the pipe. On Linux the pipe then sends a signal, since compiled code
    may block a thread for minutes. Elsewhere a thread waits.
    """
    if DESCRIPTORS.is_dir() and HAS_FORK:
        _end_by_signal(lifeline)
    else:
        threading.Thread(target=_end_by_thread, args=(lifeline,), daemon=True).start()


def _end_by_signal(lifeline: Connection) -> None:
    """Let the kernel end this process."""
    import fcntl
    import select

    signal.pthread_sigmask(signal.SIG_UNBLOCK, ENDING)
    descriptor = os.open(DESCRIPTORS / str(lifeline.fileno()), os.O_RDONLY | os.O_NONBLOCK)
    fcntl.fcntl(descriptor, fcntl.F_SETOWN, os.getpid())
    # SIGIO ends a process that does not handle it.
    fcntl.fcntl(descriptor, fcntl.F_SETFL, os.O_ASYNC | os.O_NONBLOCK)
    if select.select([descriptor], [], [], 0.0)[0]:
        os._exit(1)


def _end_by_thread(lifeline: Connection) -> None:
    """End this process when the other end of the pipe is closed."""
    with contextlib.suppress(EOFError, OSError):
        lifeline.recv_bytes()
    os._exit(1)


def read_at_once(stream: subprocess.Popen[bytes]) -> None:
    """Let reads of a program's output return at once.

    On Windows older versions of Python wait for its next output.
    """
    if stream.stdout is not None and hasattr(os, "set_blocking"):
        os.set_blocking(stream.stdout.fileno(), False)


def end_group(leader: subprocess.Popen[bytes], grace: float, interval: float) -> None:
    """End all processes of a session.

    grace: time until they are killed [s]; interval: between looks at them [s]. On Windows the first of them is ended.
    """
    if not HAS_FORK:
        leader.kill()
        leader.wait()
        return
    deadline = time.monotonic() + grace
    try:
        os.killpg(leader.pid, signal.SIGTERM)
        while time.monotonic() < deadline:
            leader.poll()
            os.killpg(leader.pid, 0)
            time.sleep(interval)
    except ProcessLookupError:
        pass
    finally:  # also where a second interrupt ends the grace
        with contextlib.suppress(ProcessLookupError):
            os.killpg(leader.pid, signal.SIGKILL)
        leader.wait()
