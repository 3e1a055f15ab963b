"""Accuracy, robustness and cost of a run, beside the required values.

    .venv/bin/python benchmarks/main_job.py

Times are medians of several runs in this process or of several processes, with the least and the largest.
"""

from __future__ import annotations

import itertools
import math
import subprocess
import tempfile
from collections.abc import Callable
from functools import partial

import command_line
import numpy as np
from command_line import TAILSLAP, corner_case, row, seconds, spread

from fem.run.corner import Stepper, simulate
from fem.start.inertia_relief import RigidStart, to_global
from fem.start.start_kinds import start_fields
from tailslap.case.corner.outcome import CornerOutcome

SIZES = ((4.0, 1.5), (10.0, 2.438), (19.0, 2.7))
FRICTIONS = (0.05, 0.2, 0.47, 0.8)
MODULI = (20e9, 200e9, 2e12)
REACTIONS = ("drag", "none", "signed")
START = RigidStart(0.26, 0.707, 25.053)


def outcome(name: str, *changes: str) -> CornerOutcome:
    """Run a scene with changes."""
    return corner_case(name, *changes).run()


def worst(result: CornerOutcome) -> float:
    """Return the largest of the five differences, infinite without a tail-slap."""
    return max(map(abs, result.difference.values()), default=math.inf)


def accuracy() -> None:
    """Print the five differences of the two scenes of the paper."""
    for name in ("paper-table-3", "paper-abaqus"):
        result = outcome(name)
        values = ", ".join(f"{key} {value:+.1e}" for key, value in result.difference.items())
        row(f"{name}: largest of five differences", "5e-4", f"{worst(result):.1e}  ({values})")


def robustness() -> None:
    """Count runs that are correct, rejected or undetected."""
    correct: list[float] = []
    rejected = undetected = 0
    for (length, width), modulus, friction, reaction in itertools.product(
        SIZES, MODULI, FRICTIONS, REACTIONS
    ):
        size = f"vehicle.length={length}", f"vehicle.width={width}", f"plate.youngs_modulus={modulus}"
        contact = f"impact.friction={friction}", f"corner.reaction={reaction}"
        result = outcome("paper-table-3", *size, *contact)
        if not result.passed:
            rejected += 1
        elif worst(result) <= 2e-3:
            correct.append(worst(result))
        else:
            undetected += 1
    what = "E / 10, E, E x 10; 4 x 1.5 to 19 x 2.7 m; friction 0.05 to 0.8"
    largest = f"{len(correct)} correct (largest difference {max(correct):.1e})"
    row(what, "0 undetected", f"{largest}, {rejected} rejected, {undetected} undetected")


def exactness() -> None:
    """Print forces of rigid motions, and kinetic energy beside closed form."""
    model = outcome("paper-abaqus").fe_plan.model
    stepper, forces = Stepper(model), []
    for angle, shift in ((0.0, 1.0), (0.26, 0.0), (2.0, 0.0)):
        state = stepper.start(START, "unstressed")
        positions = to_global(angle) @ model.discretisation.positions + [[shift], [0.0]]
        positions[1] -= positions[1, model.parameters.corner.nodes[0]]  # the spring at the corner is slack
        rest = {"velocities": np.zeros_like(positions), "sums": np.zeros(4)}
        later = stepper.advance(state._replace(positions=np.ascontiguousarray(positions), **rest), 1)
        forces.append(np.abs(later.velocities * model.parameters.mass / model.parameters.time_step).max())
    what = "rigid translation and rotation: largest force over E t L"
    row(what, "rounding", f"{max(forces) / 1.06e11:.1e}")
    _, velocities = start_fields(model, START, "unstressed")
    energy = 0.5 * float((model.parameters.mass * velocities**2).sum())
    v_g = velocities @ model.parameters.mass / model.mass
    exact = 0.5 * model.mass * float(v_g @ v_g) + 0.5 * model.mass * (100.0 + 2.438**2) / 12 * 0.707**2
    row("kinetic energy of rigid motion, relative error", "exact", f"{abs(energy / exact - 1):.1e}")


def timed(function: Callable[[], object], repeats: int) -> str:
    """Return the median, least and largest time of a function [s]."""
    return f"{spread([seconds(function) for _ in range(repeats)])} s, {repeats} times"


def cost() -> None:
    """Print the times of the loop and of whole processes."""
    plan = outcome("paper-table-3").fe_plan
    loop = timed(lambda: simulate(plan.model, plan.start, plan.case.motion.strike.t), 15)
    row("time loop of paper-table-3, one core", "0.05 s", loop)
    with tempfile.TemporaryDirectory() as folder:
        run = [*TAILSLAP, "run", "paper-table-3", "--no-pictures", "--out", f"{folder}/out"]
        for required, command in (("2 s", run), ("0.5 s", [*TAILSLAP, "rigid", "paper-table-3"])):
            spent = timed(partial(subprocess.run, command, check=True, capture_output=True), 7)
            row(f"whole process, tailslap {command[3]}", required, spent)


if __name__ == "__main__":
    command_line.options(__doc__)
    for part in (accuracy, robustness, exactness, cost):
        part()
