"""Kill runs, studies and sweeps at random instants, and look at what is left.

    .venv/bin/python benchmarks/kills.py [COUNT [SEED]]

Each time a command fills a folder that has an earlier result already; TERM, INT or KILL comes at an instant drawn
evenly over the time that the command takes alone. After it the folder must hold the earlier result or the new one,
whole; no process of the command may live on and no port be open; what a killed one leaves must be gone once the next
command has looked at it. A sweep's folder must take the sweep up again and end with the rows of one left alone.
"""

from __future__ import annotations

import hashlib
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import psutil

sys.path.insert(0, str(Path(__file__).parents[1]))

from tailslap.campaign.definition import CIRCUMSTANCES
from tailslap.files.folder import locked, recover
from tailslap.files.manifest import NAME, entry, read_manifest

SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)
SCENE, SMALL = ("paper-table-3", "--set", "plate.elements=[10,3]"), ("--set", "plate.elements=[6,2]")
COMMANDS = {
    "run": ("run", *SCENE, "--no-pictures"),
    "study": ("study", "flexibility", "paper-table-3", *SMALL, "--points", "4", "--force"),
    "sweep": ("sweep", *SCENE, "--vary", "impact.friction=0.1:0.8:12", "--workers", "2"),
}
EARLIER = ("run", "paper-table-3", "--set", "plate.elements=[8,3]", "--no-pictures")
GONE_S = 10.0
"""Time in which processes must be gone [s]."""


def started(arguments: tuple[str, ...], out: Path) -> subprocess.Popen[bytes]:
    """The command, in a group of processes of its own."""
    line = [sys.executable, "-m", "tailslap", *arguments, "--out", str(out)]
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[1])}
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    return subprocess.Popen(line, env=environment, cwd=out.parent, start_new_session=True, **quiet)  # type: ignore[call-overload]


def whole(folder: Path) -> str | None:
    """Digest of what a complete result holds; None for what is none."""
    listed = read_manifest(folder)
    if not listed or any(entry(folder / item.path) != item for item in listed):
        return None
    return hashlib.sha256((folder / NAME).read_bytes()).hexdigest()


def killed(arguments: tuple[str, ...], out: Path, delay: float, number: signal.Signals) -> list[str]:
    """Kill the command; what is wrong with what it leaves running."""
    process = started(arguments, out)
    time.sleep(delay)
    family = {child.pid: child for child in _children(process.pid)}
    process.send_signal(number)
    try:
        process.wait(timeout=60.0)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        return [f"hangs for a minute after {number.name}"]
    end = time.monotonic() + GONE_S
    while (alive := [child for child in family.values() if _lives(child)]) and time.monotonic() < end:
        time.sleep(0.05)
    ports = [c.laddr.port for child in alive for c in child.net_connections("inet") if c.status == "LISTEN"]
    return [f"process {child.pid} lives on, ports {ports}" for child in alive]


def _children(pid: int) -> list[psutil.Process]:
    try:
        return psutil.Process(pid).children(recursive=True)
    except psutil.NoSuchProcess:
        return []


def _lives(process: psutil.Process) -> bool:
    try:
        return process.is_running() and process.status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False


def rows(out: Path) -> list[str]:
    """Rows of a finished sweep without times, and without what a worker had from rows before."""
    import pyarrow.parquet as parquet

    table = parquet.read_table(next(out.glob("*.parquet")))
    kept = [name for name in table.column_names if name not in CIRCUMSTANCES]
    return sorted(json.dumps(row, sort_keys=True, default=str) for row in table.select(kept).to_pylist())


def look(out: Path, added: str) -> list[str]:
    """What is wrong with the folder of a run or study after it was killed, as who reads it next sees it."""
    recover(out)
    found = [] if whole(out) else ["neither the earlier nor the new result is whole"]
    if not (out / "mine.txt").exists() or (out / "mine.txt").read_text() != added:
        found.append("what the user has added is gone or has changed")
    return found


def main() -> None:
    """Kill so many, and say what was wrong."""
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job would have it ignored
    count, seed = (int(text) for text in (*sys.argv[1:], *("200", "1")[len(sys.argv) - 1 :]))
    dice, wrong, ends = random.Random(seed), [], Counter[str]()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        times, reference = _undisturbed(folder)
        for number in range(count):
            kind, how = dice.choice(list(COMMANDS)), dice.choice(SIGNALS)
            delay = dice.uniform(0.0, 1.05 * times[kind])
            place = folder / str(number)
            if kind == "sweep":
                found, end = _sweep(place, how, delay, reference)
            else:
                found, end = _result(place, kind, how, delay, folder / "earlier")
            shutil.rmtree(place)
            ends[f"{kind}, {end}"] += 1
            faults = [f"{number}: {kind}, {how.name} after {delay:.2f} s: {fault}" for fault in found]
            wrong += faults
            print(*(f"\r{fault}\n" for fault in faults), sep="", end="", flush=True)
            print(f"\r{number + 1} of {count}, {len(wrong)} wrong", end="", file=sys.stderr, flush=True)
    print(f"\n{count} kills, seed {seed}: {len(wrong)} ended wrongly")
    print(*(f"  {end}: {times}" for end, times in sorted(ends.items())), sep="\n")
    sys.exit(bool(wrong))


def _undisturbed(folder: Path) -> tuple[dict[str, float], list[str]]:
    """How long each command takes, warm, and the rows of the sweep."""
    times = {}
    assert started(EARLIER, folder / "earlier").wait() == 0
    for kind, arguments in COMMANDS.items():
        for attempt in ("first", kind):
            began = time.monotonic()
            assert started(arguments, folder / f"{kind}-{attempt}").wait() == 0, kind
            times[kind] = time.monotonic() - began
    return times, rows(folder / "sweep-sweep")


def _sweep(folder: Path, how: signal.Signals, delay: float, reference: list[str]) -> tuple[list[str], str]:
    """Kill a sweep, and let it go on to its end."""
    folder.mkdir()
    out = folder / "out"
    found = killed(COMMANDS["sweep"], out, delay, how)
    if started(COMMANDS["sweep"], out).wait() != 0:
        return [*found, "it does not go on"], "lost"
    if rows(out) != reference:
        found.append("its rows differ from those of a sweep left alone")
    return found + _left(folder, out), "resumed to the same rows"


def _result(
    folder: Path, kind: str, how: signal.Signals, delay: float, earlier: Path
) -> tuple[list[str], str]:
    """Kill what replaces an earlier result, to which the user has added a file."""
    out, added = folder / "out", "the user's"
    shutil.copytree(earlier, out)
    (out / "mine.txt").write_text(added)
    before = whole(out)
    found = killed(COMMANDS[kind], out, delay, how) + look(out, added)
    end = "the earlier result" if whole(out) == before else "a new result"
    with locked(out):  # as the next command does first
        pass
    return found + _left(folder, out), end


def _left(folder: Path, out: Path) -> list[str]:
    """What lies in the folder and beside it after that, journals apart, which the study itself takes up."""
    beside = {path.name for path in folder.iterdir() if path != out and not path.name.endswith(".journal")}
    within = {path.name for path in out.glob(".tailslap*")} - {NAME}
    return [f"{name} is left" for name in sorted(beside | within)]


if __name__ == "__main__":
    main()
