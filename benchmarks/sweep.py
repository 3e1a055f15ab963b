"""Rate of a sweep, parts of a row, and kill -9.

    .venv/bin/python benchmarks/sweep.py

Three minutes on free cores. Rates are those while runs are made, workers being up, beside those of whole processes.
The best of two turns counts: a core that other programs use as well makes any of them slower. Processor time, which
they change little, stands for two free cores.
"""

from __future__ import annotations

import contextlib
import cProfile
import ctypes
import json
import os
import resource
import signal
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import command_line
import numpy as np
import psutil
from command_line import TAILSLAP, row, sweep_rows

from tailslap.campaign.records import count
from tailslap.campaign.sweep_run import RECORDS
from tailslap.case import case_of
from tailslap.case.corner import corner_run
from tailslap.case.corner.outcome import CornerOutcome
from tailslap.case.corner.rigid_stages import RigidStages
from tailslap.scene.read import read_scene
from tailslap.scene.vary import vary

THOUSAND = (
    *("paper-table-3", "--set", "plate.elements=[10, 3]"),
    *("--vary", "plate.youngs_modulus=log:1e10:1e12:50", "--vary", "corner.friction=0.1:0.5:20"),
)
KILLED = (
    *("paper-table-3", "--set", "plate.elements=[6, 2]", "--workers", "2"),
    *("--vary", "plate.youngs_modulus=log:1e9:1e11:20", "--vary", "corner.friction=0.1:0.5:15"),
)
ROWS = 40
PARTS = {
    "variation and validation": ("vary.py", "vary"),
    "plans": ("corner_plan.py", "make_corner_plan"),
    "initial states": ("corner.py", "start"),
    "comparison with the rigid motion": ("corner_run.py", "compare"),
    "checks": ("corner_run.py", "checked"),
}
"""File and function of the parts of a row besides the time loops."""
TURNS = 2
SUBREAPER = 36
"""What makes this process the parent of those whose own has ended (linux/prctl.h)."""


def sweep(place: Path, *arguments: str) -> subprocess.Popen[bytes]:
    """The command, started as a process of its own."""
    command = [*TAILSLAP, "sweep", *arguments, "--out", str(place)]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL)


def rates(folder: Path) -> None:
    """A thousand runs on one worker and on two, in turn."""
    efforts: dict[int, list[tuple[float, float, dict[str, Any]]]] = {1: [], 2: []}
    few = (*THOUSAND[:3], "--vary", "corner.friction=0.1,0.2", "--workers")
    sweep(folder / "compile", *few, "1").wait()
    await_children()
    start = {n: finished(sweep(folder / f"start-{n}", *few, str(n))) for n in efforts}
    for turn in range(TURNS):
        for workers, measured in efforts.items():
            place, began = folder / f"rate-{turn}-{workers}", time.perf_counter()
            processor = finished(sweep(place, *THOUSAND, "--workers", str(workers)))
            duration = time.perf_counter() - began
            effort = json.loads((place / "summary.json").read_text())["effort"]
            measured.append((duration, processor, effort))
    runs = {n: [effort["runs_a_second"] for *_, effort in measured] for n, measured in efforts.items()}
    best = {n: max(rates) for n, rates in runs.items()}
    least = {n: min(duration for duration, *_ in measured) for n, measured in efforts.items()}
    listed = {n: ", ".join(f"{rate:.1f}" for rate in rates) for n, rates in runs.items()}
    spent = {n: (min(item[1] for item in measured) - start[n]) / 998.0 for n, measured in efforts.items()}
    row("1000 runs, two workers against one: rate", "1.8 times", f"{best[2] / best[1]:.2f} times")
    row("  runs a second: one worker; two workers", "", f"{listed[1]}; {listed[2]}")
    row("  whole process, start and report included", "", f"{least[1]:.1f} s; {least[2]:.1f} s")
    text = f"{1e3 * spent[1]:.1f} ms; {1e3 * spent[2]:.1f} ms; {2.0 * spent[1] / spent[2]:.2f} times"
    row("  processor time per run, all processes; rate that it allows", "", text)
    for workers, measured in efforts.items():
        over = min(effort["overhead_a_run_s"] for *_, effort in measured)
        row(f"overhead per run, {workers} worker(s)", "5 ms", f"{1e3 * over:.1f} ms")
    first, *rest = (sweep_rows(place) for place in sorted(folder.glob("rate-*")))
    same = all(table == first for table in rest)
    row("all four tables the same, but for times", "yes", "yes" if same else "NO")


def parts() -> None:
    """Print the time of a row by parts."""
    case, loops, profile = case_of(*read_scene("paper-table-3")), [0.0], cProfile.Profile()
    attempt = corner_run.attempt

    def timed(case: RigidStages, *choices: Any, **named: Any) -> CornerOutcome:
        outcome = attempt(case, *choices, **named)
        loops[0] += outcome.run.time_loop_s
        return outcome

    def all_rows() -> float:
        began = time.perf_counter()
        for modulus in np.geomspace(1e11, 4e11, ROWS).tolist():
            changed = case_of(*vary(case.source, {"plate.youngs_modulus": modulus}))
            changed.row(changed.run())
        return 1e3 * (time.perf_counter() - began) / ROWS

    all_rows()
    corner_run.attempt = timed
    whole, loop = all_rows(), 1e3 * loops[0] / ROWS
    profile.enable()
    all_rows()
    profile.disable()
    spent = {}
    for entry in profile.getstats():
        if not isinstance(entry.code, str):
            spent[Path(entry.code.co_filename).name, entry.code.co_name] = entry.totaltime
    result = f"{whole / loop:.2f} times: {whole:.0f} and {loop:.0f} ms"
    row("row over its time loops, of run and companion", "1.5 times", result)
    for part, function in PARTS.items():
        row(f"  {part}, profiled", "", f"{1e3 * spent[function] / ROWS:.1f} ms")


def finished(process: subprocess.Popen[bytes]) -> float:
    """Wait for a sweep, and return its processor time [s].

    It includes that of its workers, which are children of this process once the sweep has ended.
    """
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    assert process.wait() in (0, 1), f"exit status {process.returncode}"
    await_children()
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime - before.ru_utime - before.ru_stime


def await_children() -> None:
    """Wait for all children, orphans of ended processes included."""
    with contextlib.suppress(ChildProcessError):
        while True:
            os.wait()


def kills(folder: Path) -> None:
    """Compare sweeps after kill -9 with an undisturbed one."""
    sweep(folder / "kill-nothing", *KILLED).wait()
    whom: dict[str, Callable[[int, list[int]], list[int]]] = {
        "a worker": lambda client, below: below[-1:],
        "the client": lambda client, below: [client],
        "everything": lambda client, below: [client, *below],
    }
    for number, (name, victims) in enumerate(whom.items()):
        place = folder / f"kill-{number}"
        process = sweep(place, *KILLED)
        while process.poll() is None and count(place / RECORDS) < 20:
            time.sleep(0.01)
        for victim in victims(process.pid, workers_of(process.pid)):
            with contextlib.suppress(ProcessLookupError):
                os.kill(victim, signal.SIGKILL)
        rows_before = count(place / RECORDS)
        status = process.wait()
        if status < 0:
            sweep(place, *KILLED).wait()
        rows_after = sweep_rows(place)
        once = [line["run"] for line in rows_after] == list(range(300))
        right = rows_after == sweep_rows(folder / "kill-nothing")
        verdict = "every row once, none lost, none wrong" if once and right else "ROWS LOST OR WRONG"
        row(f"kill -9 of {name}, after {rows_before} of 300 rows", "all rows, once", verdict)


def workers_of(pid: int) -> list[int]:
    """Worker processes of this process, forked by its server."""
    with contextlib.suppress(psutil.NoSuchProcess):
        return sorted(child.pid for server in psutil.Process(pid).children() for child in server.children())
    return []


def main() -> None:
    """Print all parts."""
    command_line.options(__doc__)
    ctypes.CDLL(None).prctl(SUBREAPER, 1)
    with tempfile.TemporaryDirectory() as folder:
        parts()
        kills(Path(folder))
        rates(Path(folder))


if __name__ == "__main__":
    main()
