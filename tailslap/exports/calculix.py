"""Run CalculiX in a folder, within limits of time, output and files."""

import contextlib
import os
import shutil
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from typing import IO

import numpy as np

from machine_code.system import operating_system
from postprocess.comparison.nodal import read_centre_of_mass
from tailslap.errors import InputError, shortened
from tailslap.progress import announced

LAST_LINES = 12
"""Number of the last lines of a failed program in its message."""

MAX_LOG, TAIL = 16_000_000, 65_536
"""Largest output of a program, and of one read [bytes]."""

BYTES_PER_NODE = 200_000
"""Largest size of the files over the nodes of a layer [bytes]: twice that of CalculiX."""

POLL, GRACE = 0.05, 2.0
"""Seconds between polls of a program, and between SIGTERM and SIGKILL."""

COMMAND = "ccx"
DECK, RESULT, LOG = "plate.inp", "plate.dat", "ccx.log"
INSTALL = (
    "`ccx` was not found on the PATH; install CalculiX: `apt-get install calculix-ccx`, or www.calculix.de"
)
TESTED = "tested with CalculiX 2.20, `ccx -v` prints the version"


def run_calculix(folder: Path, time_limit: float, nodes: int) -> tuple[dict[str, np.ndarray], float]:
    """Run the deck in a folder, and return motion and duration [s].

    nodes: of a layer. The motion is that of the centre of mass, SI. Raises InputError where CalculiX is not installed,
    and OSError with the last lines of a program that fails, or takes longer than the limit [s].
    """
    if shutil.which(COMMAND) is None:
        raise InputError("--with", "calculix", INSTALL)
    began = time.monotonic()
    with announced("Running CalculiX ..."):
        _run(folder, time_limit, MAX_LOG + BYTES_PER_NODE * nodes)
    seconds = time.monotonic() - began
    try:
        return read_centre_of_mass(_result_in(folder)), seconds
    except (OSError, ValueError) as error:
        raise failed(f"{COMMAND} wrote no complete result, {error} ({TESTED})", folder) from None


def _run(folder: Path, time_limit: float, room: int) -> None:
    """Run the deck in its folder.

    room: largest size of the files [bytes]. Raises OSError.
    """
    with (folder / LOG).open("wb") as log, _program([COMMAND, DECK.removesuffix(".inp")], folder) as program:
        why = _watch(program, log, folder, time_limit, room)
    if why or program.returncode:
        raise failed(f"{COMMAND} {why or f'ended with status {program.returncode}'}", folder)


@contextlib.contextmanager
def _program(command: list[str], folder: Path) -> Iterator[subprocess.Popen[bytes]]:
    """Yield a program in a separate process group.

    The group ends with the block.
    """
    with subprocess.Popen(
        command,
        cwd=folder,
        start_new_session=True,
        bufsize=0,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    ) as program:
        try:
            yield program
        finally:
            operating_system.end_group(program, GRACE, POLL)


def _watch(
    program: subprocess.Popen[bytes], log: IO[bytes], folder: Path, time_limit: float, room: int
) -> str:
    """Log the output of a program until it ends.

    Returns the limit that it exceeds, or "".
    """
    assert program.stdout is not None
    operating_system.read_at_once(program)
    deadline = time.monotonic() + time_limit
    while True:
        has_ended = program.poll() is not None
        text = program.stdout.read(TAIL) or b""
        if log.tell() + len(text) > MAX_LOG:
            return f"printed more than {MAX_LOG / 1e6:g} MB"
        log.write(text)
        if has_ended and not text:
            return ""
        if time.monotonic() > deadline:
            return f"ran longer than --time-limit {time_limit:g} s"
        if _size(folder) > room:
            return f"wrote files of more than {room / 1e6:.0f} MB"
        if not text:
            time.sleep(POLL)


def _size(folder: Path) -> int:
    """Return the bytes of all files below a folder."""
    size = 0
    for place, _, names in os.walk(folder):
        for name in names:
            with contextlib.suppress(FileNotFoundError):
                size += os.lstat(os.path.join(place, name)).st_size
    return size


def _result_in(folder: Path) -> Path:
    """Return the file of the motion.

    Raises ValueError for a file that is not of this run.
    """
    deck, result = folder / DECK, folder / RESULT
    if not result.is_file():
        raise ValueError(f"{RESULT} is missing")
    if result.stat().st_mtime_ns < deck.stat().st_mtime_ns:
        raise ValueError(f"{RESULT} is older than {DECK}: it is of an earlier run")
    return result


def failed(why: str, folder: Path) -> OSError:
    """Return the error of a failed program with its last lines."""
    with (folder / LOG).open("rb") as log:
        log.seek(max(0, log.seek(0, os.SEEK_END) - TAIL))
        text = log.read(TAIL).decode("utf-8", "replace")
    lines = [shortened(line) for line in text.splitlines() if line.strip()]
    ending = "its last lines:" if lines else "it printed nothing"
    return ChildProcessError("\n".join([f"{why}; {ending}", *lines[-LAST_LINES:]]))
