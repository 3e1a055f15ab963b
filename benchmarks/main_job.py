"""Accuracy, robustness and cost of a run, beside the required values.

    .venv/bin/python benchmarks/main_job.py

Times are the best of several runs in this process or of several processes, with the median beside it; the
machine's noise is in them, so no test looks at them.
"""

from __future__ import annotations

import itertools
import math
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial

import command_line
import numpy as np

from fem.run.corner import Stepper, simulate
from fem.start.inertia_relief import RigidStart, to_global
from fem.start.start_kinds import start_fields
from tailslap.case.corner.corner_case import CornerCase
from tailslap.case.corner.outcome import CornerOutcome
from tailslap.scene.read import read_scene

SIZES = ((4.0, 1.5), (10.0, 2.438), (19.0, 2.7))
FRICTIONS = (0.05, 0.2, 0.47, 0.8)
MODULI = (20e9, 200e9, 2e12)
COMMAND = [sys.executable, "-m", "tailslap.cli"]


def outcome(name: str, *changes: str) -> CornerOutcome:
    """Run a scene with changes."""
    return CornerCase(*read_scene(name, changes)).run()


def worst(result: CornerOutcome) -> float:
    """Largest of the five differences, infinite where there was no tail-slap."""
    return max(map(abs, result.difference.values()), default=math.inf)


def row(what: str, asked: str, measured: str) -> None:
    """Print one line of the table."""
    print(f"{what:<66}{asked:>12}  {measured}", flush=True)


def accuracy() -> None:
    """The five differences of the two paper scenes."""
    for name in ("paper-table-3", "paper-abaqus"):
        values = outcome(name).difference
        row(
            f"{name}: largest of five differences",
            "5e-4",
            f"{max(map(abs, values.values())):.1e}  ("
            + ", ".join(f"{key} {value:+.1e}" for key, value in values.items())
            + ")",
        )


def robustness() -> None:
    """Right to 2e-3, or caught by the run's own checks, over sizes, stiffness, friction and reaction."""
    right = caught = quiet = 0
    largest = 0.0
    for (length, width), modulus, friction in itertools.product(SIZES, MODULI, FRICTIONS):
        for reaction in ("drag", "none", "signed"):
            result = outcome(
                "paper-table-3",
                f"vehicle.length={length}",
                f"vehicle.width={width}",
                f"plate.youngs_modulus={modulus}",
                f"impact.friction={friction}",
                f"corner.reaction={reaction}",
            )
            if not result.passed:
                caught += 1
            elif worst(result) <= 2e-3:
                right += 1
                largest = max(largest, worst(result))
            else:
                quiet += 1
    row(
        "E / 10, E, E x 10; 4 x 1.5 to 19 x 2.7 m; friction 0.05 to 0.8",
        "0 quiet",
        f"{right} right (largest difference {largest:.1e}), {caught} caught, {quiet} quietly wrong",
    )


def exactness() -> None:
    """Rigid motions of the plate: forces against E t L, kinetic energy against the closed form."""
    plan = CornerCase(*read_scene("paper-abaqus"))
    model = plan.run().fe_plan.model
    body = model.discretisation.positions
    stepper = Stepper(model)
    zero = np.zeros(4)
    forces = []
    for angle, shift in ((0.0, 1.0), (0.26, 0.0), (2.0, 0.0)):
        state = stepper.start(RigidStart(0.26, 0.707, 25.053), "unstressed")
        positions = np.ascontiguousarray(to_global(angle) @ body + [[shift], [0.0]])
        positions[1] -= positions[
            1, model.parameters.corner.nodes[0]
        ]  # the corner on the wall: its spring is slack
        later = stepper.advance(
            state._replace(positions=positions, velocities=np.zeros_like(positions), sums=zero), 1
        )
        forces.append(np.abs(later.velocities * model.parameters.mass / model.parameters.time_step).max())
    row(
        "rigid translation and rotation: largest force over E t L", "rounding", f"{max(forces) / 1.06e11:.1e}"
    )
    positions, velocities = start_fields(model, RigidStart(0.26, 0.707, 25.053), "unstressed")
    energy = 0.5 * float((model.parameters.mass * velocities**2).sum())
    v_g = velocities @ model.parameters.mass / model.mass
    exact = 0.5 * model.mass * float(v_g @ v_g) + 0.5 * model.mass * (100.0 + 2.438**2) / 12 * 0.707**2
    row("kinetic energy of rigid motion, relative error", "exact", f"{abs(energy / exact - 1):.1e}")


def timed(function: Callable[[], object], repeats: int) -> str:
    """Best and median time of a function [s], in words."""
    times = []
    for _ in range(repeats):
        began = time.perf_counter()
        function()
        times.append(time.perf_counter() - began)
    return f"best {min(times):.3f} s, median {statistics.median(times):.3f} s of {repeats}"


def cost() -> None:
    """The time loop, and whole processes."""
    fe_plan = outcome("paper-table-3").fe_plan
    duration = fe_plan.case.motion.strike.t
    loop = timed(lambda: simulate(fe_plan.model, fe_plan.start, duration), 15)
    row("time loop of paper-table-3, one core", "0.15 s", loop)
    with tempfile.TemporaryDirectory() as folder:
        run = [*COMMAND, "run", "paper-table-3", "--no-pictures", "--out", f"{folder}/out"]
        rigid = [*COMMAND, "rigid", "paper-table-3"]
        for what, asked, command in (("run ... --no-pictures", "2 s", run), ("rigid", "0.5 s", rigid)):
            spent = timed(partial(subprocess.run, command, check=True, capture_output=True), 7)
            row(f"whole process, tailslap {what}", asked, spent)


if __name__ == "__main__":
    command_line.parser(__doc__).parse_args()
    row("what", "asked", "measured")
    accuracy()
    robustness()
    exactness()
    cost()
