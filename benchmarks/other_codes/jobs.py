"""Tasks of another code, speed or the whole event."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
from other_codes.plate import Plate, Reading, from_argument

CHECKED_STEPS = 200
"""Steps from the start to the instant at which the codes' far corners are compared."""
FIRST_STEPS = 20
"""Steps by which a loop's time is foreseen."""
NEAR = 10
"""Steps left to the wall from which on each is looked at."""
PROBE_S = 2.0
"""Time for which a loop runs that would take too long."""


class Code(Protocol):
    """A code with the plate in it.

    velocity_lag: by how many steps the velocities of `state` are behind its positions.
    """

    version: str
    velocity_lag: float

    def advance(self, steps: int) -> None:
        """Make steps."""

    def state(self) -> tuple[np.ndarray, np.ndarray]:
        """Positions [m] and velocities [m/s], shape (nodes, 2), as copies."""


def answer(make: Callable[[Plate], Code]) -> None:
    """Do the task of the arguments, and print the answer."""
    began, plate = time.perf_counter(), from_argument()
    code, read = make(plate), Reading(plate, plate.body(), plate.masses())
    setup = time.perf_counter() - began
    job, *numbers = sys.argv[2:]
    result = event(plate, read, code, *map(float, numbers)) if job == "event" else rates(plate, code)
    print(json.dumps({"version": code.version, "setup_s": setup, **result}), flush=True)


def rates(plate: Plate, code: Code) -> dict[str, Any]:
    """Element updates a second, and the far corner for comparison."""
    code.advance(CHECKED_STEPS)
    far = code.state()[0][plate.far].tolist()
    return {"far_corner": far, "rates": update_rates(code.advance, plate.count)}


def update_rates(
    advance: Callable[[int], object], elements: int, batches: int = 5, seconds: float = 0.1
) -> list[float]:
    """Element updates a second in batches of fixed length."""
    began = time.perf_counter()
    advance(10)
    steps = 10 * max(1, round(seconds / (time.perf_counter() - began)))
    measured = []
    for _ in range(batches):
        began = time.perf_counter()
        advance(steps)
        measured.append(elements * steps / (time.perf_counter() - began))
    return measured


def event(plate: Plate, read: Reading, code: Code, expected: float, limit: float) -> dict[str, Any]:
    """Values at the tail-slap with the seconds of the loop."""
    began, steps = time.perf_counter(), expected / plate.time_step
    code.advance(FIRST_STEPS)
    a_step = (time.perf_counter() - began) / FIRST_STEPS
    if steps * a_step > limit:
        more = int(PROBE_S / a_step)
        code.advance(more)
        ran = time.perf_counter() - began
        return {"values": None, "loop_s": ran * steps / (FIRST_STEPS + more), "ran_s": ran}
    values = at_the_wall(plate, read, code, approach(plate, read, code))
    ran = time.perf_counter() - began
    return {"values": values, "loop_s": ran, "ran_s": ran}


def approach(plate: Plate, read: Reading, code: Code) -> int:
    """Advance to a few steps before the wall, and count them."""
    count = FIRST_STEPS
    while True:
        positions, velocities = code.state()
        omega = read.values(0.0, positions, velocities)[3]
        remaining = int(0.9 * read.angle(positions) / (omega * plate.time_step))
        if remaining <= NEAR:
            return count
        code.advance(remaining)
        count += remaining


def at_the_wall(plate: Plate, read: Reading, code: Code, count: int) -> list[float]:
    """Values at angle zero by a cubic through four steps."""
    states: list[tuple[np.ndarray, np.ndarray]] = [code.state()]
    angles: list[float] = []
    while len(angles) < 2 or angles[-2] > 0.0:
        code.advance(1)
        states.append(code.state())
        angles.append(read.angle(states[-2][0]))
    rows = []
    for number in range(len(angles))[-4:]:
        (positions, behind), (_, ahead) = states[number : number + 2]
        velocities = (1.0 - code.velocity_lag) * behind + code.velocity_lag * ahead
        rows.append(read.values((count + number) * plate.time_step, positions, velocities))
    return (at_zero(angles[-4:]) @ np.array(rows)).tolist()


def at_zero(angles: list[float]) -> np.ndarray:
    """Weights of interpolation at angle zero."""
    rests = [[a for a in angles if a != angle] for angle in angles]
    return np.array([np.prod([b / (b - a) for b in rest]) for a, rest in zip(angles, rests, strict=True)])
