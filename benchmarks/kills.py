"""Kill commands at random instants or calls, and check their folders.

    .venv/bin/python benchmarks/kills.py [COUNT [SEED]]
    .venv/bin/python benchmarks/kills.py calls [KIND...]
    .venv/bin/python benchmarks/kills.py race [ROUNDS]

Each time a command fills a folder that has an earlier result already; TERM, INT or KILL comes at an instant drawn
evenly over the time that the command takes alone. After it the folder must hold the earlier result or the new one,
whole; no process of the command may live on and no port be open; remains of a killed command must be gone after the
next one. A sweep's folder must take the sweep up again and end with the rows of one left alone.

`calls`: KILL comes by strace at each rename, link, unlink, mkdir, rmdir and sync in the folder, and at each write of
manifest, log, lock and definition. `race`: eight processes fill one folder at once: one wins, seven end with status 2
and a message, and the folder has the result of the one.
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
from contextlib import suppress
from pathlib import Path

import command_line
import psutil
from command_line import ROOT, TAILSLAP, run_command, sweep_rows

from tailslap.storage.folder import locked, recover
from tailslap.storage.manifest import LOCK, LOG, NAME, entry, read_manifest

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
RACED = ("run", "paper-table-3", "--set", "plate.elements=[12,4]", "--no-pictures")
EXACT = {
    "run": ("run", "paper-table-3", *SMALL, "--no-pictures", "--force"),
    "study": ("study", "uncertainty", "mash-tl4-sut", "--samples", "1000", "--force"),
    "export": ("export", "{earlier}", "--to", "csv", "--force"),
    "sweep": ("sweep", "paper-table-3", *SMALL, "--vary", "impact.friction=0.1:0.8:3", "--workers", "1"),
}
"""Commands that are killed at their calls; before them there is EARLIER, but of a sweep, the same sweep or nothing."""
CALLS = (
    "rename,renameat,renameat2,link,linkat,unlink,unlinkat,mkdir,mkdirat,rmdir,fsync,fdatasync,write,pwrite64"
)
WRITTEN = (NAME, LOG, LOCK, "sweep.json")
ADDED = "the user's"


def started(
    arguments: tuple[str, ...], out: Path, tracer: str = "", messages: int = subprocess.DEVNULL
) -> subprocess.Popen[bytes]:
    """Start the command in a process group of its own.

    tracer: words before it; messages: file of its messages.
    """
    line = [*tracer.split(), *TAILSLAP, *arguments, "--out", str(out)]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    quiet = {"stdout": subprocess.DEVNULL, "stderr": messages}
    return subprocess.Popen(line, env=environment, cwd=out.parent, start_new_session=True, **quiet)  # type: ignore[call-overload]


def whole(folder: Path) -> str | None:
    """Return the digest of a complete result, None for any other folder."""
    listed = read_manifest(folder)
    if not listed or any(entry(folder / item.path) != item for item in listed):
        return None
    return hashlib.sha256((folder / NAME).read_bytes()).hexdigest()


def killed(arguments: tuple[str, ...], out: Path, delay: float, number: signal.Signals) -> list[str]:
    """Kill the command, and list the faults of processes that live on."""
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
    with suppress(psutil.NoSuchProcess):
        return list(psutil.Process(pid).children(recursive=True))
    return []


def _lives(process: psutil.Process) -> bool:
    with suppress(psutil.NoSuchProcess):
        return process.is_running() and process.status() != psutil.STATUS_ZOMBIE
    return False


def rows(out: Path) -> list[str]:
    """List the rows of a finished sweep without times."""
    return sorted(json.dumps(row, sort_keys=True, default=str) for row in sweep_rows(out))


def look(out: Path) -> list[str]:
    """List the faults of a killed run's folder for its reader."""
    recover(out)
    faults = [] if whole(out) else ["neither the earlier nor the new result is whole"]
    if not (out / "mine.txt").exists() or (out / "mine.txt").read_text() != ADDED:
        faults.append("the file of the user is gone or has changed")
    return faults


def prepared(folder: Path, before: Path | None) -> Path:
    """Return the place of a result, with files in it.

    They are a copy of an earlier one and a file of the user.
    """
    shutil.rmtree(folder / "at-work", ignore_errors=True)
    out = folder / "at-work" / "out"
    out.parent.mkdir()
    if before:
        shutil.copytree(before, out)
        (out / "mine.txt").write_text(ADDED)
    return out


def settled(
    out: Path, arguments: tuple[str, ...], before: Path | None, reference: list[str]
) -> tuple[list[str], str]:
    """List faults after a kill, and the content of the folder.

    The next command clears the remains; a sweep is made to its end, with the rows of the reference.
    """
    if before and before.name == "earlier":
        faults, end = look(out), "the earlier result" if whole(out) == whole(before) else "a new result"
        with locked(out):
            pass
    else:
        faults, end = look(out) if before else [], "gone on to the same rows"
        again = started(arguments, out, messages=subprocess.PIPE)
        messages = again.communicate()[1].decode()
        if again.returncode:
            return [*faults, f"it does not go on, status {again.returncode}: {messages}"], "lost"
        if rows(out) != reference:
            faults.append("its rows differ from those of a sweep left alone")
    return faults + _left(out.parent, out), end


def _left(folder: Path, out: Path) -> list[str]:
    """List remains in the folder and beside it, except journals."""
    journals = [path.name for path in folder.glob(".*.journal")]  # and what SQLite has beside one
    taken_up = {name + ending for name in journals for ending in ("", "-journal", "-wal", "-shm")}
    beside = {path.name for path in folder.iterdir() if path != out} - taken_up
    within = {path.name for path in out.glob(".tailslap*")} - {NAME}
    return [f"{name} is left" for name in sorted(beside | within)]


def at_every_call(kinds: list[str]) -> int:
    """Kill commands at their calls, print the faults, and return their number."""
    wrong, total = 0, 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        assert started(EARLIER, folder / "earlier").wait() == 0
        assert started(EXACT["sweep"], folder / "sweep").wait() == 0
        reference = rows(folder / "sweep")
        for kind in kinds or [*EXACT, "sweep again"]:
            arguments = tuple(w.format(earlier=folder / "earlier") for w in EXACT[kind.partition(" ")[0]])
            before = {"sweep": None, "sweep again": folder / "sweep"}.get(kind, folder / "earlier")
            points = _calls(arguments, prepared(folder, before))
            ends = Counter[str]()
            for number, (call, nth) in enumerate(points):
                out = prepared(folder, before)
                tracer = f"strace -o /dev/null -e inject={call}:signal=SIGKILL:when={nth}"
                status = started(arguments, out, tracer).wait()
                faults, end = settled(out, arguments, before, reference)
                ended = "killed" if status == -signal.SIGKILL else f"not killed, {status}"
                ends[f"{kind}, {ended}: {end}"] += 1
                wrong += len(faults)
                print(*(f"\r{kind}, {call} {nth}: {fault}\n" for fault in faults), sep="", end="", flush=True)
                print(f"\r{kind}: {number + 1} of {len(points)}", end="", file=sys.stderr, flush=True)
            total += len(points)
            print("\r" + command_line.counts(ends), flush=True)
    print(f"{total} kills at calls: {wrong} faults")
    return wrong


def _calls(arguments: tuple[str, ...], out: Path) -> list[tuple[str, int]]:
    """List the calls of the command in its folder, numbered by name."""
    trace = out.parent / "trace"
    assert started(arguments, out, f"strace -y -o {trace} -e trace={CALLS}").wait() in (0, 1)
    counts, calls = Counter[str](), []
    for line in trace.read_text().splitlines():
        call = line.partition("(")[0]
        counts[call] += 1
        is_write = "write" in call and not any(f"/{name}>" in line for name in WRITTEN)
        if str(out) in line and not is_write:
            calls.append((call, counts[call]))
    return calls


def _contend(out: Path, k: int, start: int) -> None:
    """Wait for the start, run a command, and write its outcome."""
    os.read(start, 1)
    began, friction = time.monotonic(), f"impact.friction={0.1 + 0.05 * k}"
    status, output, text = run_command(*RACED, "--force", "--json", "--set", friction, "--out", out)
    if status == 0:
        text = f"wins {json.loads(output)['fe']['v_gy']}"
    elif status == 2 and text.count("another command uses this folder") == text.count("\n") == 1:
        text = f"told {time.monotonic() - began}"
    (out.parent / f"said-{k}").write_text(text)


def race(rounds: int) -> int:
    """Let eight processes fill one folder, and return the faults."""
    from tailslap import load

    ends, wrong, slowest = Counter[str](), 0, 0.0
    with tempfile.TemporaryDirectory() as name:
        out = Path(name) / "out"
        assert run_command(*RACED, "-q", "--out", out)[0] == 0
        (out / "mine.txt").write_text(ADDED)
        for number in range(rounds):
            reading, writing = os.pipe()
            children = []
            for k in range(8):
                if not (child := os.fork()):
                    os.close(writing)
                    _contend(out, k, reading)
                    os._exit(0)
                children.append(child)
            os.close(reading)
            os.close(writing)  # at this they start
            for child in children:
                os.waitpid(child, 0)
            files = [*Path(name).glob("said-*")]
            texts = [path.read_text() for path in files]
            for path in files:
                path.unlink()
            winners, refused = (
                [float(text.split()[1]) for text in texts if text.startswith(word)]
                for word in ("wins", "told")
            )
            slowest = max(slowest, *refused)
            faults = look(out) + _left(out.parent, out)
            end = f"{len(winners)} won, {len(refused)} were told"
            if (len(winners), len(refused)) != (1, 7):
                faults.append(f"{end}: {texts}")
            elif winners[0] != load(out).summary["fe"]["v_gy"]:
                faults.append("the result is of another")
            ends[end] += 1
            wrong += len(faults)
            print(*(f"\r{number}: {fault}\n" for fault in faults), sep="", end="", flush=True)
    print(command_line.counts(ends))
    print(f"{rounds} rounds of 8: {wrong} faults; the last was told after {slowest:.2f} s")
    return wrong


def at_random(count: int, seed: int) -> int:
    """Kill commands at random instants, print the faults, and return their number."""
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job would have it ignored
    dice, wrong, ends = random.Random(seed), 0, Counter[str]()
    with tempfile.TemporaryDirectory() as name:
        folder, times = Path(name), dict[str, float]()
        earlier = folder / "earlier"
        assert started(EARLIER, earlier).wait() == 0
        for kind, arguments in COMMANDS.items():
            for attempt in ("first", kind):  # the second is warm
                began = time.monotonic()
                assert started(arguments, folder / f"{kind}-{attempt}").wait() == 0, kind
                times[kind] = time.monotonic() - began
        reference = rows(folder / "sweep-sweep")
        for number in range(count):
            kind, how = dice.choice(list(COMMANDS)), dice.choice(SIGNALS)
            delay, before = dice.uniform(0.0, 1.05 * times[kind]), None if kind == "sweep" else earlier
            out = prepared(folder, before)
            faults = killed(COMMANDS[kind], out, delay, how)
            more, end = settled(out, COMMANDS[kind], before, reference)
            ends[f"{kind}, {end}"] += 1
            wrong += bool(faults + more)
            for fault in faults + more:
                print(f"\r{number}: {kind}, {how.name} after {delay:.2f} s: {fault}", flush=True)
            print(f"\r{number + 1} of {count}, {wrong} wrong", end="", file=sys.stderr, flush=True)
    print(f"\n{count} kills, seed {seed}: {wrong} ended wrongly")
    print(command_line.counts(ends))
    return wrong


def main() -> int:
    """Kill commands, and return 1 where there are faults."""
    part, *more = command_line.options(__doc__, ("words", [])).words or ["200"]
    if part == "calls":
        return int(at_every_call(more) > 0)
    if part == "race":
        return int(race(int(more[0]) if more else 200) > 0)
    return int(at_random(int(part), int(more[0]) if more else 1) > 0)


if __name__ == "__main__":
    sys.exit(main())
