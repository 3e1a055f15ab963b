"""Time and memory over the number of elements, with fitted exponents.

    .venv/bin/python benchmarks/size.py

Sizes are 120 to a million elements. Each runs in a process of its own, within a limit of time and of memory; those that
do not finish are named. The whole run is predicted, steps times time per step: to let a million elements strike would
take hours.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import command_line
import numpy as np

SIZES = ((20, 6), (40, 12), (80, 24), (160, 48), (320, 96), (640, 192), (1280, 384), (2048, 512))
DURATION = 0.3832
"""Time to the tail-slap of the paper's Table 3 [s]."""

MEMORY = 18 * 2**30
"""Bytes of address space that a size may take."""

COLUMNS = {
    "mesh_s": "mesh, s",
    "model_s": "model, s",
    "relief_s": "inertia relief, s",
    "step_s": "step, s",
    "steps": "steps",
    "run_s": "run, s",
    "memory_gib": "memory, GiB",
    "relief_gib": "relief, GiB",
}
"""Columns of the table. Memory is the process's peak up to the steps, and after inertia relief."""

FIT_FROM = 1920
"""Elements from which on the exponents are fitted: below, fixed costs show."""


def tell(**values: float) -> None:
    """Print values for the parent process."""
    print(json.dumps(values), flush=True)


@contextmanager
def stage(name: str) -> Iterator[None]:
    """Send the time of a stage to the parent process."""
    began = time.perf_counter()
    yield
    tell(**{name: time.perf_counter() - began})


def peak() -> float:
    """Most memory that this process has used [GiB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 2**30


def measure(elements: tuple[int, int]) -> None:
    """One size, in this process: set-up, steps, then inertia relief, the hungriest, last."""
    from fem.laws.friction import Drag
    from fem.model.plate_model import build_model
    from fem.plate.properties import CornerProperties, PlateProperties, StepProperties
    from fem.run.corner import Stepper
    from fem.start.inertia_relief import RigidStart
    from meshes import plate_mesh

    with stage("mesh_s"):
        mesh = plate_mesh(10.0, 2.438, elements)
    with stage("model_s"):
        plate = PlateProperties(0.053, 7800.0, 200e9, 0.3)
        model = build_model(mesh, plate, CornerProperties(Drag(0.47)), StepProperties())
    stepper, start = Stepper(model), RigidStart(0.26, 0.707, 25.053)
    state = stepper.start(start, "unstressed")
    stepper.advance(state, 1)
    step, steps = time_per_step(stepper, state), DURATION / model.parameters.time_step
    tell(step_s=step, steps=steps, run_s=step * steps, memory_gib=peak())
    with stage("relief_s"):
        stepper.start(start, "inertia-relief")
    tell(relief_gib=peak())


def time_per_step(stepper: Any, state: Any, seconds: float = 0.2, batches: int = 9) -> float:
    """Best of several batches [s]."""
    began = time.perf_counter()
    stepper.advance(state, 2)
    steps = max(1, round(2 * seconds / (time.perf_counter() - began)))
    best = np.inf
    for _ in range(batches):
        began = time.perf_counter()
        stepper.advance(state, steps)
        best = min(best, (time.perf_counter() - began) / steps)
    return float(best)


def in_process(elements: tuple[int, int], budget: float) -> dict[str, Any]:
    """One size in a process of its own, as far as it gets."""
    command = [sys.executable, __file__, "--one", *map(str, elements)]
    one_thread = os.environ | {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL")}

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))

    failure = ""
    try:
        done = subprocess.run(
            command, env=one_thread, preexec_fn=limit, capture_output=True, text=True, timeout=budget
        )
        output = done.stdout
        if done.returncode:
            failure = (done.stderr.strip().splitlines() or ["ended"])[-1][:60]
    except subprocess.TimeoutExpired as expired:
        output, failure = (expired.stdout or b"").decode(), f"stopped after {budget:g} s"
    values: dict[str, Any] = {"failure": failure}
    for line in output.splitlines():
        values |= json.loads(line)
    return values


def exponent(counts: list[int], values: list[float]) -> float:
    """Slope of log(value) over log(count)."""
    return float(np.polyfit(np.log(counts), np.log(values), 1)[0])


def print_exponents(found: dict[int, dict[str, Any]]) -> None:
    """Print the fitted exponents over the sizes with a result."""
    cells = ""
    for name in COLUMNS:
        large = {count: row[name] for count, row in found.items() if name in row and count >= FIT_FROM}
        cells += f"{exponent(list(large), list(large.values())):>15.2f}" if len(large) > 1 else f"{'-':>15}"
    print(f"{'exponent':>9}{cells}  of the number of elements, from {FIT_FROM} on")


def main() -> None:
    """Measure every size and print."""
    parser = command_line.parser(__doc__)
    parser.add_argument("--budget", type=float, default=90.0, help="seconds that one size may take")
    parser.add_argument("--one", type=int, nargs=2, help="only this size, in this process")
    given = parser.parse_args()
    if given.one:
        measure(tuple(given.one))
        return
    print(f"{'elements':>9}" + "".join(f"{title:>15}" for title in COLUMNS.values()))
    found = {}
    for elements in SIZES:
        count = elements[0] * elements[1]
        found[count] = row = in_process(elements, given.budget)
        cells = (f"{row[name]:>15.3g}" if name in row else f"{'-':>15}" for name in COLUMNS)
        print(f"{count:>9}{''.join(cells)}  {row['failure']}", flush=True)
    print_exponents(found)


if __name__ == "__main__":
    main()
