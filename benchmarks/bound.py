"""Bandwidth and multiply-add rate of the machine, and the needs of the time loop.

Needs are counted from the source, for n nodes and p points an element. Additions and multiplications:

    _add_point      F 8 m - 4 | strain 13 | stress 7 | w S 3 | P = F S 12 | nodal forces 8 m    per point
    mapped elements J 8 m - 4 | det J 3 | its inverse 5 | F 12 | w det J 1 | P J^-T 12          per point, besides
                    reference positions less the first 2 m                                    per element
    bilinear ones   F 20 | J 8 | strain to P 35 | det J, inverse, w det J, P J^-T 21 | forces 12 per point
                    to and from their modes 12                                                per element
    subtract_first  2 m                                                                       per element
    balance         2 m                                                                       per element
    scatter         2 n                                                                       per element
    drift           v += dt f / m, x += dt v: 2 x 5                                           per node

with m = n - 1. Bytes, each array once for every pass over it, as if nothing stayed in a cache between passes:

    gather          positions 16                                                              per node
                    connectivity 4 n where the numbers of the nodes differ                    per element
    force           cleared 16 | added to 32                                                  per node
    drift           positions 32 | velocities 32 | force 16 | mass 8                          per node
    _add_point      8 p (2 m + 1) where elements are neither congruent nor mapped             per element
                    reference positions 16 where they are mapped                              per node

The bandwidth is a bound where these arrays are far larger than the cache. Below that only arithmetic is.
"""

from __future__ import annotations

import re
import threading
import time
from typing import Any

import numba
import numpy as np

from fem.explicit.internal_force import subtract_internal_forces
from fem.run.corner import Stepper

CHAIN = 16
"""Consecutive multiply-adds of a number, few enough that the processor overlaps those of several vectors."""

MULTIPLY_ADD = re.compile(r"^\s+vfn?m(?:add|sub)\d+([ps])d\s(.*)$", re.MULTILINE)


@numba.njit(fastmath={"contract"}, error_model="numpy", nogil=True)
def _chains(values: np.ndarray, repeats: int, factor: float, term: float) -> None:
    for _ in range(repeats):
        for i in range(values.size):
            value = values[i]
            for _ in range(CHAIN):
                value = value * factor + term
            values[i] = value


def copy_rate() -> float:
    """Bytes read and written per second by a copy of arrays far above the cache."""
    source = np.ones(16_000_000)
    target = np.zeros_like(source)
    began = time.perf_counter()
    np.copyto(target, source)
    return 2.0 * source.nbytes / (time.perf_counter() - began)


def multiply_add_rate(threads: int = 1) -> float:
    """Operations per second in packed multiply-adds on registers, two each, of all threads together."""
    values, repeats = np.ones((threads, 256)), 20_000
    _chains(values[0], 1, 0.5, 0.5)
    team = [threading.Thread(target=_chains, args=(row, repeats, 0.5, 0.5)) for row in values]
    began = time.perf_counter()
    for thread in team:
        thread.start()
    for thread in team:
        thread.join()
    return 2.0 * CHAIN * values.size * repeats / (time.perf_counter() - began)


def flops_per_update(stepper: Stepper) -> float:
    """Additions and multiplications an element and step; see above."""
    table, nodes = stepper.parameters.table, len(stepper.parameters.table.per_element)
    element = len(table.weights) * (16 * (nodes - 1) + 31) + 4 * (nodes - 1) + 2 * nodes
    if table.mapping is not None and len(table.mapping.gradients[0]) == 2:
        element += len(table.weights) * (96 - 16 * (nodes - 1) - 31) + 2 * (nodes - 1) + 12
    elif table.mapping is not None:
        element += len(table.weights) * (8 * (nodes - 1) + 29) + 2 * (nodes - 1)
    return element + 10 * _nodes_per_element(stepper)


def bytes_per_update(stepper: Stepper) -> float:
    """Bytes an element and step; see above."""
    table, nodes = stepper.parameters.table, len(stepper.parameters.table.per_element)
    moved = 152 * _nodes_per_element(stepper)
    if stepper._scratch.lattice is None:
        moved += 4 * nodes
    if table.mapping is not None:
        return moved + 16 * _nodes_per_element(stepper)
    return moved if table.weights.shape[1] == 1 else moved + 8 * len(table.weights) * (2 * nodes - 1)


def _nodes_per_element(stepper: Stepper) -> float:
    return float(stepper.parameters.mass.size / stepper.parameters.table.connectivity.shape[1])


def multiply_adds(stepper: Stepper) -> tuple[int, int]:
    """Count packed and scalar multiply-adds in the machine code of the internal forces.

    The kernel is compiled again, since code from the cache on disk cannot be read. Every packed loop has its
    scalar twin, for arrays that overlap; the twin is never taken.
    """
    dispatcher = subtract_internal_forces.dispatcher
    parameters, positions = stepper.parameters, stepper.model.discretisation.positions
    parts: tuple[Any, ...] = (parameters.viscosity, parameters.hourglass, np.zeros_like(positions))
    scratch = stepper._scratch
    given = (positions, np.zeros_like(positions), *parts, parameters.table, parameters.material, scratch)
    dispatcher.compile(tuple(map(numba.typeof, given)))
    found = MULTIPLY_ADD.findall("\n".join(dispatcher.inspect_asm().values()))
    packed = sum(kind == "p" and ("ymm" in operands or "zmm" in operands) for kind, operands in found)
    return packed, sum(kind == "s" for kind, _ in found)
