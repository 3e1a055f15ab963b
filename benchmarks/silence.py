"""The longest silence of each command on a terminal: nothing is to be silent for over two seconds.

    .venv/bin/python benchmarks/silence.py [--only WORD]...

Each command runs in a pseudo-terminal of 80 columns, in an empty folder; warm, unless the machine has yet to compile,
and with bytecode on disk, as users have it.
"""

from __future__ import annotations

import argparse
import fcntl
import os
import pty
import select
import struct
import sys
import tempfile
import termios
import time

COMMANDS = (
    "check mash-tl4-sut",
    "run mash-tl4-sut",
    "run impact-mash-tl4-sut",
    "run paper-table-3 --tolerance 1e-5",
    "run paper-table-3 --no-pictures --set plate.elements=[160,48]",
    "modes mash-tl4-sut",
    "modal mash-tl4-sut",
    "paper",
    "sweep mash-tl4-sut --vary corner.friction=0.1:0.6:40",
    "study uncertainty mash-tl4-sut",
    "study uncertainty impact-mash-tl4-sut --samples 288",
    "study flexibility mash-tl4-sut --points 4",
)
ASKED_S = 2.0
BYTECODE = os.path.join(tempfile.gettempdir(), f"tailslap-bytecode-{os.getuid()}")


def longest_silence(command: str) -> tuple[float, float, str]:
    """Longest time [s] without output, the whole time [s], and the last words before the silence."""
    with tempfile.TemporaryDirectory() as folder:
        process, terminal = pty.fork()
        if process == 0:
            os.chdir(folder)
            os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
            os.environ["PYTHONPYCACHEPREFIX"] = BYTECODE
            os.execv(sys.executable, [sys.executable, "-m", "tailslap", *command.split()])
        fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 80, 0, 0))
        began = last = time.perf_counter()
        longest, before, said = 0.0, "", ""
        while text := _read(terminal):
            now = time.perf_counter()
            if now - last > longest:
                longest, before = now - last, said
            last, said = now, text.strip() or said
        status = os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])
        assert status in (0, 1), f"{command} ended with {status}: {said}"
        return longest, time.perf_counter() - began, before


def _read(terminal: int) -> str:
    """What comes next; empty at the end, which Linux tells by an error."""
    select.select([terminal], [], [])
    try:
        return os.read(terminal, 65536).decode(errors="replace")
    except OSError:
        return ""


def main() -> int:
    """Print the table; 1 if a command was silent for longer than asked."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--only", action="append", default=[])
    given = parser.parse_args()
    print(f"{'command':<66}{'silent':>8}{'whole':>8}  after")
    worst = 0.0
    for command in COMMANDS:
        if given.only and not any(word in command for word in given.only):
            continue
        silent, whole, before = longest_silence(command)
        worst = max(worst, silent)
        after = before.splitlines()[-1][-50:] if before else "the start"
        print(f"{command:<66}{silent:>6.1f} s{whole:>6.1f} s  {after!r}", flush=True)
    return int(worst > ASKED_S)


if __name__ == "__main__":
    sys.exit(main())
