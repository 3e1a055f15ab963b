"""Ratios of times to those of another checkout.

    .venv/bin/python benchmarks/process.py OTHER [--rounds 7] [--only WORDS]... [--first] [--million]

Processes, rows of a sweep, a large plate. With --first the difference of first and second runs from an empty cache is
measured instead. OTHER is the folder of another checkout of this repository; it runs in the same environment. Runs of
the two follow each other in turn, after one of each that compiles. A ratio is a median of the
rounds, with its least and greatest; that of processor time beside it is hardly touched by other programs. Ten minutes
for all but --million, which takes one more and 3 GiB.
"""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

import command_line
from command_line import ROOT, TAILSLAP, bytecode_folder, row, spread

RIGID, RUN = ("rigid", "paper-table-3"), ("run", "paper-table-3", "--no-pictures")
SHORT = "start.angle=0.001"
"""A start so near the wall that the time loop takes a tenth of the whole."""
COMMANDS = {
    "run paper-table-3 --no-pictures": ("0.45", RUN),
    "run mash-tl4-sut, four pictures": ("1.5, processor 1.8", ("run", "mash-tl4-sut")),
    "rigid paper-table-3": ("0.65", RIGID),
    "run of 30 720 elements, short": ("0.85", (*RUN, "--set", "plate.elements=[320,96]", "--set", SHORT)),
}
FIRST = {
    "corner": ("3 s", RUN),
    "whole impact": ("4 s", ("run", "impact-mash-tl4-sut", "--no-pictures")),
    "train": ("5 s", ("run", "impact-tl5cmb-2", "--no-pictures")),
    "modal": ("3 s", ("modal", "paper-table-3")),
    "uncertainty": ("4 s", ("study", "uncertainty", "impact-mash-tl4-sut", "--samples", "1000")),
    "vehicle in space": ("4 s", ("rigid", "impact-tipping-tl4-sut")),
}
"""First runs: most seconds more than the second, and command."""
SWEPT = {"modulus": "plate.youngs_modulus=log:1e11:4e11:40", "friction": "corner.friction=0.2:0.4:40"}
NEEDED = ("-c", "import numpy, click; from pydantic import BaseModel")
"""Libraries that every command loads: no time can be below theirs."""
READY = """
import cProfile, json, pstats, resource, sys, time
began = time.perf_counter()
profile = cProfile.Profile()
profile.enable()
from tailslap.case.corner.corner_plan import make_corner_plan
from tailslap.case.corner.corner_case import CornerCase
from tailslap.scene.read import read_scene
from fem.run.corner import Stepper
plan = CornerCase(*read_scene("paper-table-3", ("plate.elements=[1600, 625]",))).plan()
Stepper(plan.model).start(plan.start, plan.plate.start)
profile.disable()
spent = time.perf_counter() - began
functions = {(file.rsplit("/", 1)[-1], name): row[3] for (file, _, name), row in pstats.Stats(profile).stats.items()}
parts = {part: functions[tuple(key)] for part, key in json.loads(sys.argv[1]).items()}
memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
print(json.dumps({"spent": spent, "memory": memory, "parts": parts}))
"""
PARTS = {
    "mesh by gmsh": ("plate_input.py", "fe_mesh"),
    "element table": ("discretisation.py", "discretise"),
    "nodal masses": ("plate_model.py", "nodal_masses"),
    "stiffness matrix": ("discretisation.py", "stiffness_matrix"),
    "levels of multigrid": ("multigrid.py", "__init__"),
    "three solutions by multigrid": ("multigrid.py", "solve"),
}
"""File and function of the parts of the start of a million elements."""


class Spent(NamedTuple):
    """Time on the clock, and of the processor [s]."""

    wall: float
    processor: float


def environment(checkout: Path, cache: str = "") -> dict[str, str]:
    """Return an environment with one thread of BLAS."""
    variables = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    variables |= {"PYTHONPYCACHEPREFIX": bytecode_folder().name, "OPENBLAS_NUM_THREADS": "1"}
    names = ("TAILSLAP_CACHE_DIR", "NUMBA_CACHE_DIR")  # the second in earlier versions
    variables |= dict.fromkeys(names, cache) if cache else {}
    return variables | {"PYTHONPATH": str(checkout)}


def process(
    checkout: Path, arguments: Sequence[str], program: Sequence[str] = TAILSLAP[1:], cache: str = ""
) -> Spent:
    """Run a command of a checkout in an empty folder."""
    command, quiet = [sys.executable, *program, *arguments], subprocess.DEVNULL
    with tempfile.TemporaryDirectory() as folder:
        start = time.perf_counter()
        child = subprocess.Popen(
            command, cwd=folder, env=environment(checkout, cache), stdout=quiet, stderr=quiet
        )
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        assert child.returncode in (0, 1), f"{checkout}: {arguments} ended with {child.returncode}"
        return Spent(time.perf_counter() - start, usage.ru_utime + usage.ru_stime)


def row_of_a_sweep(varied: str, checkout: Path) -> Spent:
    """Return the time of a row of a sweep, without processor time."""
    with tempfile.TemporaryDirectory() as folder:
        words = ("sweep", "paper-table-3", "--workers", "1", "--vary", varied, "--out", folder + "/s")
        command = [*TAILSLAP, *words]
        subprocess.run(command, env=environment(checkout), cwd=folder, check=True, capture_output=True)
        effort = json.loads(Path(folder, "s", "summary.json").read_text())["effort"]
    duration = effort["wall_s"] * effort["threads"] / effort["runs"]
    return Spent(duration - effort["overhead_a_run_s"], float("nan"))


def compare(what: str, required: str, measure: Callable[[Path], Spent], other: Path, rounds: int) -> None:
    """Print the times of this checkout over those of the other one."""
    for checkout in (other, ROOT):
        measure(checkout)
    pairs = [(measure(other), measure(ROOT)) for _ in range(rounds)]
    processor = statistics.median(mine.processor / theirs.processor for theirs, mine in pairs)
    text = "" if processor != processor else f"; processor time {processor:.2f}"
    theirs, mine = (statistics.median(pair[k].wall for pair in pairs) for k in (0, 1))
    ratios = spread([mine.wall / theirs.wall for theirs, mine in pairs], ".2f")
    row(what, required, f"{ratios}{text}; {mine:.3f} s and {theirs:.3f} s")


def first_runs(what: str, required: str, command: Sequence[str], checkouts: Sequence[Path]) -> None:
    """Print the difference of first and second runs of checkouts."""
    more = []
    for checkout in checkouts:
        process(checkout, command)  # compiles the sources
        with tempfile.TemporaryDirectory() as cache:
            first, second = (process(checkout, command, cache=cache) for _ in range(2))
        more.append(f"{first.wall - second.wall:.1f} s ({first.processor - second.processor:.1f} processor)")
    row(f"first run over the second, {what}", required, " and ".join(more))


def million() -> None:
    """Print the time and memory of the set-up of a million elements."""
    command = [sys.executable, "-c", READY, json.dumps(PARTS)]
    process = subprocess.run(command, env=environment(ROOT), check=True, capture_output=True, text=True)
    measured = json.loads(process.stdout)
    row(
        "a million elements: start ready",
        "30 s",
        f"{measured['spent']:.0f} s, {measured['memory']:.1f} GiB of 3",
    )
    for part, seconds in measured["parts"].items():
        row(f"  {part}", "", f"{seconds:.1f} s")
    row("  other", "", f"{measured['spent'] - sum(measured['parts'].values()):.1f} s")


def libraries(checkout: Path) -> Spent:
    """Return the time of libraries here, of `rigid` elsewhere."""
    return process(checkout, (), NEEDED) if checkout == ROOT else process(checkout, RIGID)


def main() -> None:
    """Print the table."""
    options = command_line.options(__doc__, "other", rounds=7, only=[], first=False, million=False)
    rows: dict[str, tuple[str, Callable[[Path], Spent]]] = {
        what: (required, partial(process, arguments=command))
        for what, (required, command) in COMMANDS.items()
    }
    rows["numpy, pydantic and click alone, over its rigid"] = "", libraries
    for name, varied in SWEPT.items():
        rows[f"row of a sweep, {name} varies"] = "0.42", partial(row_of_a_sweep, varied)
    if options.first:
        rows = {}
        for what, (required, command) in FIRST.items():
            if not options.only or any(words in what for words in options.only):
                first_runs(what, required, command, (ROOT, Path(options.other).resolve()))
    for what, (required, measure) in rows.items():
        if not options.only or any(words in what for words in options.only):
            rounds = max(1, options.rounds // 2) if what.startswith("row") else options.rounds
            compare(what, required, measure, Path(options.other).resolve(), rounds)
    if options.million:
        million()


if __name__ == "__main__":
    main()
