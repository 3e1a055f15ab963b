"""Ratios of times to those of another checkout.

    .venv/bin/python benchmarks/process.py OTHER [--rounds 7] [--only WORDS]... [--million] [--companions]

Processes, rows of a sweep, a large plate, threads. OTHER is the folder of another checkout of this repository; it runs
in the same environment. Runs of the two follow each other in turn, after one of each that compiles. A ratio is a median
of the rounds, with its least and greatest; that of processor time beside it is hardly touched by other programs.
Threads are compared with one thread of this checkout, with as many busy cores. Ten minutes for all but --million, which
takes one more and 4 GiB, and --companions, which holds whole runs with companions against those without, of this
checkout alone, for five.
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
from contextlib import ExitStack
from pathlib import Path
from typing import NamedTuple

import command_line

ROOT = Path(__file__).resolve().parents[1]
BYTECODE = Path(tempfile.gettempdir()) / f"tailslap-bytecode-{os.getuid()}"
SWEEP = ("sweep", "paper-table-3", "--workers", "1")
RIGID = ("rigid", "paper-table-3")
MODULI, FRICTIONS = "plate.youngs_modulus=log:1e11:4e11:40", "corner.friction=0.2:0.4:40"
STEPS = """
import statistics, sys, time
from dataclasses import replace
from fem.model.plate_model import static_model
from fem.plate.properties import CornerProperties, PlateProperties
from fem.run.corner import Stepper
from fem.start.inertia_relief import RigidStart
from meshes import plate_mesh
counts, steps = (int(sys.argv[1]), int(sys.argv[2])), int(sys.argv[3])
model = static_model(plate_mesh(10.0, 2.438, counts), PlateProperties(0.053, 7800.0, 2e11, 0.3), CornerProperties())
model = replace(model, parameters=model.parameters._replace(time_step=1e-9))
steppers = [Stepper(model, threads) for threads in (1, 2)]
states = [stepper.start(RigidStart(0.26, 0.707, 25.053), "unstressed") for stepper in steppers]
for _ in range(int(sys.argv[4]) + 1):
    spent = []
    for stepper, state in zip(steppers, states, strict=True):
        began = time.perf_counter()
        stepper.advance(state, steps)
        spent.append(time.perf_counter() - began)
    print(spent[0] / spent[1])
"""
READY = """
import resource, time
began = time.perf_counter()
from tailslap.case.corner.corner_plan import make_corner_plan
from tailslap.case.corner.corner_case import CornerCase
from tailslap.scene.read import read_scene
from fem.run.corner import Stepper
plan = CornerCase(*read_scene("paper-table-3", ("plate.elements=[1600, 625]",))).plan()
Stepper(plan.model).start(plan.start, plan.plate.start)
print(time.perf_counter() - began, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20)
"""


class Spent(NamedTuple):
    """Time on the clock, and of the processor [s]."""

    wall: float
    processor: float


def print_row(what: str, asked: str, measured: str) -> None:
    """One line of the table."""
    print(f"{what:<58}{asked:>8}  {measured}", flush=True)


def _environment(checkout: Path) -> dict[str, str]:
    """That of a user: with bytecode on disk, of this benchmark's own, and one thread of BLAS, as the command sets."""
    without = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    given = {"PYTHONPATH": str(checkout), "PYTHONPYCACHEPREFIX": str(BYTECODE), "OPENBLAS_NUM_THREADS": "1"}
    return without | given


COMMAND = ("-m", "tailslap")
NEEDED = ("-c", "import numpy, click; from pydantic import BaseModel")
"""What every command loads that is not ours: no time can be below it."""


def process(checkout: Path, arguments: Sequence[str], program: Sequence[str] = COMMAND) -> Spent:
    """Run a command of a checkout in an empty folder."""
    command = [sys.executable, *program, *arguments]
    environment = _environment(checkout)
    with tempfile.TemporaryDirectory() as folder:
        began = time.perf_counter()
        child = subprocess.Popen(
            command, cwd=folder, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        _, status, used = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        assert child.returncode in (0, 1), f"{checkout}: {arguments} ended with {child.returncode}"
        return Spent(time.perf_counter() - began, used.ru_utime + used.ru_stime)


def row_of_a_sweep(checkout: Path, varied: str) -> Spent:
    """Return the time of a row in its worker, by the sweep's clock and without processor time."""
    with tempfile.TemporaryDirectory() as folder:
        command = [
            sys.executable,
            "-m",
            "tailslap",
            *SWEEP,
            "--vary",
            varied,
            "--out",
            folder + "/s",
        ]
        subprocess.run(command, env=_environment(checkout), cwd=folder, check=True, capture_output=True)
        effort = json.loads(Path(folder, "s", "summary.json").read_text())["effort"]
    whole = effort["wall_s"] * effort["threads"] / effort["runs"]
    return Spent(whole - effort["overhead_a_run_s"], float("nan"))


def compared(what: str, asked: str, measure: Callable[[Path], Spent], other: Path, rounds: int) -> None:
    """A row of the table: this checkout over the other one."""
    for checkout in (other, ROOT):
        measure(checkout)
    pairs = [(measure(other), measure(ROOT)) for _ in range(rounds)]
    walls = sorted(mine.wall / its.wall for its, mine in pairs)
    processor = statistics.median(mine.processor / its.processor for its, mine in pairs)
    shown = "" if processor != processor else f"; processor time {processor:.2f}"
    its, mine = (statistics.median(pair[k].wall for pair in pairs) for k in (0, 1))
    spread = f"{walls[0]:.2f} to {walls[-1]:.2f}"
    print_row(
        what, asked, f"{statistics.median(walls):.2f} ({spread}){shown}; {mine:.3f} s where {its:.3f} s"
    )


def threads(what: str, asked: str, counts: tuple[int, int], steps: int, busy: int, rounds: int) -> None:
    """A row of the table: speed of two threads over that of one."""
    command = [sys.executable, "-c", STEPS, *map(str, (*counts, steps, rounds))]
    environment = _environment(ROOT)
    with ExitStack() as stack:
        for _ in range(busy):
            stack.callback(subprocess.Popen([sys.executable, "-c", "while True: pass"]).kill)
        done = subprocess.run(command, env=environment, check=True, capture_output=True, text=True)
    found = sorted(map(float, done.stdout.split()[1:]))
    print_row(what, asked, f"{statistics.median(found):.2f} ({found[0]:.2f} to {found[-1]:.2f})")


def million() -> None:
    """A row of the table: a million elements."""
    environment = _environment(ROOT)
    done = subprocess.run(
        [sys.executable, "-c", READY], env=environment, check=True, capture_output=True, text=True
    )
    seconds, memory = map(float, done.stdout.split())
    print_row("a million elements: start ready", "60 s", f"{seconds:.0f} s, {memory:.1f} GiB of 4")


def main() -> None:
    """Print the table."""
    parser = command_line.parser(__doc__)
    parser.add_argument("other", type=Path, help="another checkout")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--only", action="append", default=[])
    parser.add_argument("--million", action="store_true")
    parser.add_argument("--companions", action="store_true")
    given = parser.parse_args()
    other, rounds = given.other.resolve(), given.rounds
    whole = {
        "run paper-table-3 --no-pictures": ("0.45", ("run", "paper-table-3", "--no-pictures")),
        "run mash-tl4-sut, three pictures": ("0.55", ("run", "mash-tl4-sut")),
        "rigid paper-table-3": ("0.65", RIGID),
        "run of 30 720 elements, short": (
            "0.85",
            ("run", "paper-table-3", "--no-pictures", "--set", "plate.elements=[320,96]", "--set", SHORT),
        ),
    }
    rows: dict[str, Callable[[], None]] = {
        what: lambda what=what, asked=asked, command=command: compared(  # type: ignore[misc]
            what, asked, lambda checkout: process(checkout, command), other, rounds
        )
        for what, (asked, command) in whole.items()
    }
    rows["  numpy, pydantic and click alone"] = lambda: compared(
        "  numpy, pydantic and click alone, over its rigid",
        "",
        lambda checkout: process(checkout, (), NEEDED) if checkout == ROOT else process(checkout, RIGID),
        other,
        rounds,
    )
    for what, varied in (("modulus", MODULI), ("friction", FRICTIONS)):
        rows[f"row of a sweep, {what} varies"] = lambda what=what, varied=varied: compared(  # type: ignore[misc]
            f"row of a sweep, {what} varies",
            "0.42",
            lambda checkout: row_of_a_sweep(checkout, varied),
            other,
            max(1, rounds // 2),
        )
    for busy, asked in ((0, "1.7"), (1, "0.95"), (2, "0.9")):
        name = f"two threads over one, 122 880 elements, {busy} cores busy"
        rows[name] = lambda name=name, asked=asked, busy=busy: threads(  # type: ignore[misc]
            name, asked, (640, 192), 30, busy, rounds
        )
    for what, print_it in rows.items():
        if not given.only or any(words in what for words in given.only):
            print_it()
    if given.million:
        million()
    if given.companions:
        with_companions()


def with_companions() -> None:
    """Rows of the table: whole runs with companions over those without."""
    for mesh, rounds in (("[20,6]", 7), ("[320,96]", 2)):
        command = ("run", "paper-table-3", "--no-pictures", "--set", f"plate.elements={mesh}")
        without = (*command, "--set", "verify.companion=false")

        def measure(
            checkout: Path, command: Sequence[str] = command, without: Sequence[str] = without
        ) -> Spent:
            return process(ROOT, command if checkout == ROOT else without)

        compared(f"companions, {mesh} elements", "1.25", measure, ROOT / "without", rounds)


SHORT = "start.angle=0.001"
"""A start so near the wall that the time loop takes a tenth of the whole."""


if __name__ == "__main__":
    main()
