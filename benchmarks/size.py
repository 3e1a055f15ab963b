"""Time and memory over the number of elements, with fitted exponents.

    .venv/bin/python benchmarks/size.py [--budget 90]

Sizes are 120 to a million elements. Each runs in a process of its own, within a limit of time [s] and of memory; those
that do not finish are named. The whole run is predicted, steps times time per step, because a million elements would
take hours.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import time
from collections.abc import Callable
from typing import Any

import command_line
import numpy as np
from command_line import seconds

SIZES = ((20, 6), (40, 12), (80, 24), (160, 48), (320, 96), (640, 192), (1280, 384), (2048, 512))
DURATION = 0.3832
"""Time to the tail-slap of the paper's Table 3 [s]."""
MEMORY = 18 * 2**30
"""Bytes of address space of a size."""
COLUMNS = ("mesh_s", "model_s", "relief_s", "step_s", "steps", "run_s", "memory_gib", "relief_gib")
"""Columns of the table. Memory is the process's peak up to the steps, and after inertia relief."""
FIT_FROM = 1920
"""Fewest elements to which the exponents are fitted: below, fixed costs are visible."""
BATCHES, BATCH_S = 9, 0.4


def tell(**values: float) -> None:
    """Print values for the parent process."""
    print(json.dumps(values), flush=True)


def stage(name: str, function: Callable[[], Any]) -> Any:
    """Report the time of a function, and return its value."""
    start = time.perf_counter()
    value = function()
    tell(**{name: time.perf_counter() - start})
    return value


def peak() -> float:
    """Return the most memory that this process has used [GiB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 2**30


def measure(elements: tuple[int, int]) -> None:
    """Measure a size in this process, with set-up, steps and start."""
    from fem.laws.friction import Drag
    from fem.model.plate_model import build_model
    from fem.plate.properties import CornerProperties, PlateProperties, StepProperties
    from fem.run.corner import Stepper
    from fem.start.inertia_relief import RigidStart
    from meshes import plate_mesh

    properties = PlateProperties(0.053, 7800.0, 200e9, 0.3), CornerProperties(Drag(0.47)), StepProperties()
    mesh = stage("mesh_s", lambda: plate_mesh(10.0, 2.438, elements))
    model = stage("model_s", lambda: build_model(mesh, *properties))
    stepper, start = Stepper(model), RigidStart(0.26, 0.707, 25.053)
    state = stepper.start(start, "unstressed")
    stepper.advance(state, 1)
    count = max(1, round(BATCH_S / seconds(lambda: stepper.advance(state, 2))))
    step = min(seconds(lambda: stepper.advance(state, count)) for _ in range(BATCHES)) / count
    steps = DURATION / model.parameters.time_step
    tell(step_s=step, steps=steps, run_s=step * steps, memory_gib=peak())
    stage("relief_s", lambda: stepper.start(start, "inertia-relief"))
    tell(relief_gib=peak())


def in_process(elements: tuple[int, int], budget: float) -> dict[str, Any]:
    """Measure a size in a process of its own, within its limits."""
    command = [sys.executable, __file__, "--one", *map(str, elements)]
    one_thread = os.environ | {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL")}
    limit, failure = lambda: resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY)), ""
    settings: dict[str, Any] = {"env": one_thread, "preexec_fn": limit, "capture_output": True, "text": True}
    try:
        process = subprocess.run(command, timeout=budget, **settings)
        output = process.stdout
        if process.returncode:
            failure = (process.stderr.strip().splitlines() or ["ended"])[-1][:60]
    except subprocess.TimeoutExpired as expired:
        output, failure = (expired.stdout or b"").decode(), f"stopped after {budget:g} s"
    values: dict[str, Any] = {"failure": failure}
    for line in output.splitlines():
        values |= json.loads(line)
    return values


def exponent(name: str, rows: dict[int, dict[str, Any]]) -> float:
    """Return the exponent of a column over the number of elements."""
    large = {count: row[name] for count, row in rows.items() if name in row and count >= FIT_FROM}
    return float(np.polyfit(np.log([*large]), np.log([*large.values()]), 1)[0]) if len(large) > 1 else np.nan


def main() -> None:
    """Measure every size and print."""
    options = command_line.options(__doc__, budget=90.0, one=(0,))
    if len(options.one) == 2:
        measure(tuple(options.one))
        return
    print(f"{'elements':>9}" + "".join(f"{name:>12}" for name in COLUMNS))
    rows = {}
    for elements in SIZES:
        count = elements[0] * elements[1]
        rows[count] = row = in_process(elements, options.budget)
        cells = "".join(f"{row.get(name, np.nan):>12.3g}" for name in COLUMNS)
        print(f"{count:>9}{cells}  {row['failure']}", flush=True)
    exponents = "".join(f"{exponent(name, rows):>12.2f}" for name in COLUMNS)
    print(f"{'exponent':>9}{exponents}  of the number of elements, from {FIT_FROM} on")


if __name__ == "__main__":
    main()
