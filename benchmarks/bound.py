"""Multiply-adds of the machine and of the internal forces."""

from __future__ import annotations

import re
import threading
import time

import numpy as np

from fem.explicit.internal_force import subtract_internal_forces
from fem.run.corner import Stepper
from machine_code.compiled import compiled

CHAIN = 16
"""Consecutive multiply-adds of a number, few enough that the processor overlaps those of several vectors."""
MULTIPLY_ADD = re.compile(r"^\s+vfn?m(?:add|sub)\d+([ps])d\s(.*)$", re.MULTILINE)


@compiled
def _chains(values: np.ndarray, repeats: int, factor: float, term: float) -> None:
    for _ in range(repeats):
        for i in range(values.size):
            value = values[i]
            for _ in range(CHAIN):
                value = value * factor + term
            values[i] = value


def multiply_add_rate(threads: int = 1) -> float:
    """Return the rate of packed multiply-adds on registers of all threads [1/s]."""
    values, repeats = np.ones((threads, 256)), 20_000
    _chains(values[0], 1, 0.5, 0.5)
    team = [threading.Thread(target=_chains, args=(row, repeats, 0.5, 0.5)) for row in values]
    start = time.perf_counter()
    for thread in team:
        thread.start()
    for thread in team:
        thread.join()
    return 2.0 * CHAIN * values.size * repeats / (time.perf_counter() - start)


def multiply_adds(stepper: Stepper) -> tuple[int, int]:
    """Count packed and scalar multiply-adds in the internal forces.

    Every packed loop has its scalar twin, for arrays that overlap; the twin is never executed.
    """
    loop, positions = stepper.parameters, stepper.model.discretisation.positions
    parts = (loop.viscosity, loop.hourglass, np.zeros_like(positions))
    arguments = (positions, np.zeros_like(positions), *parts, loop.table, loop.material, stepper._scratch)
    matches = MULTIPLY_ADD.findall(subtract_internal_forces.assembly(*arguments))
    packed = sum(kind == "p" and ("ymm" in operands or "zmm" in operands) for kind, operands in matches)
    return packed, sum(kind == "s" for kind, _ in matches)
