"""Speed of the computing core over that of another commit.

    git worktree add ../other COMMIT
    .venv/bin/python benchmarks/against.py ../other [--turns 5] [--parts plates plane space]

Both checkouts run with this Python, in turns, one process each. A rate is the best of a process; printed is the best of
this checkout over the best of the other, then the median of the turns with the least and the largest. Times are of the
processor.

plates   element updates of the time loop, on rectangles and distorted
plane    whole impacts of a car, a truck and a tractor with its trailer: one, and 256 samples at their own steps
space    the trucks of `space_many.py`: one, and 100 at their own steps
"""

from __future__ import annotations

import inspect
import json
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

Job = tuple[str, float, Callable[[], object]]
"""Name, work of a call, call."""
REQUIRED = {"plates": "0.95", "plane": "0.95", "space": "0.95"}
LEAST, REPEATS = 0.02, 30
"""Shortest time of a measurement [s]; measurements of a process, of which the best counts."""


def plates() -> Iterator[Job]:
    """Yield the time loops of two sizes of plate."""
    from plates import DISTORTION, make_model

    from fem.run.corner import Stepper
    from fem.start.inertia_relief import RigidStart

    for elements in ((20, 6), (160, 48)):
        for distortion in (0.0, DISTORTION):
            stepper = Stepper(make_model(elements, distortion, False), 1)
            state = stepper.start(RigidStart(0.26, 0.707, 25.053), "unstressed")
            steps, count = max(10, 240_000 // (elements[0] * elements[1])), elements[0] * elements[1]
            shape = ", distorted" if distortion else ""
            yield f"{count} elements{shape}", count * steps, partial(stepper.advance, state, steps)


def plane() -> Iterator[Job]:
    """Yield impacts of corners in the plane."""
    import numpy as np

    from solver.impact import solve_impacts

    vehicles: dict[str, dict[str, Any]] = {
        "car": {"length": 4.5, "width": 1.8, "mass": 1500.0},
        "truck": {"length": 10.0, "width": 2.438, "mass": 9979.0},
        "tractor and trailer": {"length": 6.5, "width": 2.5, "mass": 8000.0},
    }
    trailer = {"length": 14.6, "width": 2.59, "mass": 27770.0, "hitch": 5.6, "kingpin": 0.9}
    for name, vehicle in vehicles.items():
        for samples in (1, 256):
            between = partial(np.random.default_rng(3).uniform, size=samples)
            law = {"stiffness": between(0.8e6, 3e6) * vehicle["mass"] / 1e4, "restitution": between(0.1, 0.4)}
            friction = between(0.1, 0.5)
            trailers: tuple[dict[str, Any], ...] = (trailer,) if name.startswith("tractor") else ()
            if "stiffness" in inspect.signature(solve_impacts).parameters:  # before [[strip]]
                contact: dict[str, Any] = {**law, "friction": friction}
                trailers = tuple(unit | law for unit in trailers)
            else:
                from solver.impact import CrushLaw, WallContact

                contact = {"contact": WallContact(CrushLaw(**law), friction)}
            motion: dict[str, Any] = {
                "speed": between(15.0, 30.0),
                "angle": between(0.2, 0.4),
                "trailers": trailers,
            }
            yield f"{name}, {samples}", samples, partial(solve_impacts, **vehicle, **motion, **contact)


def space() -> Iterator[Job]:
    """Yield trucks in space."""
    from space_many import drawn

    from solver.space import solve_spaces

    for profile in ("vertical", "new-jersey"):
        for samples in (1, 100):
            yield f"{profile}, {samples}", samples, partial(solve_spaces, *drawn(samples, 8, profile))


PARTS: dict[str, Callable[[], Iterator[Job]]] = {"plates": plates, "plane": plane, "space": space}


def best_rate(work: float, call: Callable[[], object]) -> float:
    """Return the most work of a call over its processor time [1/s]."""
    call()  # compiles
    start = time.process_time()
    call()
    calls = max(1, round(LEAST / max(time.process_time() - start, 1e-9)))
    times = []
    for _ in range(REPEATS):
        start = time.process_time()
        for _ in range(calls):
            call()
        times.append(time.process_time() - start)
    return work * calls / min(times)


def measure(checkout: str, parts: list[str]) -> dict[str, float]:
    """Return the rates of a checkout, by a process of its own."""
    command = [sys.executable, __file__, "--measure", checkout, *parts]
    process = subprocess.run(command, cwd=checkout, capture_output=True, text=True)
    if process.returncode:
        sys.exit(f"{checkout}: {process.stderr.strip()}")
    rates: dict[str, float] = json.loads(process.stdout.splitlines()[-1])
    return rates


def main() -> None:
    """Print the ratios of rates."""
    import command_line

    options = command_line.options(__doc__, "checkout", turns=5, parts=tuple(PARTS))
    checkouts = [str(command_line.ROOT), str(Path(options.checkout).resolve())]
    rates: dict[str, list[dict[str, float]]] = {checkout: [] for checkout in checkouts}
    for turn in range(options.turns):
        for checkout in checkouts[:: 1 if turn % 2 else -1]:
            rates[checkout].append(measure(checkout, list(options.parts)))
    here, there = rates.values()
    for what in here[0]:
        best = max(turn[what] for turn in here) / max(turn[what] for turn in there)
        turns = [first[what] / second[what] for first, second in zip(here, there, strict=True)]
        required = REQUIRED[what.split(":")[0]]
        command_line.row(what, required, f"{best:.2f}, turns {command_line.spread(turns, '.2f')}")


if __name__ == "__main__":
    if sys.argv[1:2] == ["--measure"]:
        checkout, parts = sys.argv[2], sys.argv[3:]
        sys.path[:0] = [checkout, f"{checkout}/benchmarks"]
        jobs = ((f"{part}: {name}", work, call) for part in parts for name, work, call in PARTS[part]())
        print(json.dumps({name: best_rate(work, call) for name, work, call in jobs}))
    else:
        main()
