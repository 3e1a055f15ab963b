"""The time loop on several threads, for large meshes; compiled.

Each thread has its own elements, forces and scratch. Between the parts of a step the threads meet at a barrier:
each writes the number of its turn, and waits until all have written it. The forces are summed in the order of
the threads, so that a run repeats to the bit on the same number of threads.
"""

from __future__ import annotations

import threading
from typing import Any

import numpy as np
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from fem.compiled import compiled
from fem.explicit.elastic_damping import SUMS, add_up, gained, resist
from fem.explicit.internal_force import Scratch, subtract_forces_of
from fem.explicit.simd_blocks import BLOCK_SIZE, aligned, slot_count
from fem.explicit.time_loop import LoopParameters, State, drift, follow, react

WORD = 8
"""Turns lie this many numbers apart, a cache line, so that waiting threads do not disturb each other."""

_give_way = types.ExternalFunction("sched_yield", types.int32())


class Team:
    """Workspaces of the threads, for one model."""

    def __init__(self, loop: LoopParameters, scratch: Scratch, threads: int) -> None:
        self._loop, self._threads = loop, threads
        self._scratch, self._rows = scratch, aligned(threads * scratch.rows.size).reshape(threads, -1)
        self._forces = np.zeros((threads, 2, loop.mass.size))
        self._powers = np.zeros((2, threads))
        self._motions, self._shift = np.zeros((threads, SUMS)), np.zeros(1)

    def advance(self, state: State, steps: int) -> None:
        """Advance the state in place by this many steps."""
        turns = np.zeros(self._threads * WORD, dtype=np.int64)
        shared = (self._powers, self._motions, self._shift)
        workspaces = (self._forces, self._scratch, self._rows, *shared, turns)
        parts = (state, steps, self._loop, self._loop.viscosity, self._loop.hourglass, *workspaces)
        others = [threading.Thread(target=advance_thread, args=(t, *parts)) for t in range(1, self._threads)]
        for thread in others:
            thread.start()
        advance_thread(0, *parts)
        for thread in others:
            thread.join()


@compiled
def advance_thread(
    t, state, steps, loop, viscosity, hourglass, forces, shared, rows, powers, motions, shift, turns
):
    """What thread t does; see `fem.explicit.time_loop.advance` for the step."""
    positions, velocities = state.positions, state.velocities
    threads, nodes = forces.shape[0], loop.mass.size
    slots = slot_count(loop.table.connectivity, shared.lattice)
    blocks = (slots + BLOCK_SIZE - 1) // BLOCK_SIZE
    first, last = blocks * t // threads * BLOCK_SIZE, min(slots, blocks * (t + 1) // threads * BLOCK_SIZE)
    begin, end = nodes * t // threads, nodes * (t + 1) // threads
    scratch = Scratch(rows[t], shared.gradients, shared.weights, shared.lattice)
    for step in range(steps):
        forces[t] = 0.0
        powers[0, t] = subtract_forces_of(
            first,
            last,
            positions,
            velocities,
            viscosity,
            hourglass,
            forces[t],
            loop.table,
            loop.material,
            scratch,
        )
        add_up(loop.elastic_damping, positions, velocities, loop.mass, begin, end, motions[t])
        _meet(turns, t, threads, 4 * step + 1)
        _sum_forces(forces, begin, end)
        motion = motions.sum(axis=0)
        powers[0, t] -= resist(
            loop.elastic_damping,
            motion,
            positions,
            velocities,
            loop.mass,
            loop.time_step,
            begin,
            end,
            forces[0],
        )
        _meet(turns, t, threads, 4 * step + 2)
        if t == 0:
            react(loop, state, powers[0].sum(), forces[0])
            shift[0] = follow(loop, state)
        _meet(turns, t, threads, 4 * step + 3)
        powers[1, t] = gained(loop.elastic_damping, motion, state, loop.time_step, begin, end, forces[0])
        drift(positions, velocities, forces[0], loop.mass, loop.time_step, shift[0], begin, end)
        _meet(turns, t, threads, 4 * step + 4)
        if t == 0:
            state.sums[1] += loop.time_step * powers[1].sum()


@compiled
def _sum_forces(forces, begin, end):
    for t in range(1, forces.shape[0]):
        for i in range(2):
            total, part = forces[0, i, begin:end], forces[t, i, begin:end]
            for node in range(total.size):
                total[node] += part[node]


@compiled
def _meet(turns, t, threads, turn):
    """Wait until every thread has come to this turn."""
    _store(turns, t * WORD, turn)
    for other in range(threads):
        waits = 0
        while _load(turns, other * WORD) < turn:
            waits += 1
            if waits > 1000:  # another program has the core: let it run
                _give_way()


@intrinsic
def _load(context: Any, array: Any, index: Any) -> Any:
    """An atomic read, which the compiler may not move or merge."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.load_atomic(_pointer(context, builder, signature, arguments), "acquire", 8)

    return array.dtype(array, types.intp), code


@intrinsic
def _store(context: Any, array: Any, index: Any, value: Any) -> Any:
    """An atomic write: all that this thread wrote before it is seen by who reads it."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        builder.store_atomic(arguments[2], _pointer(context, builder, signature, arguments), "release", 8)
        return context.get_dummy_value()

    return types.void(array, types.intp, array.dtype), code


def _pointer(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    array = context.make_array(signature.args[0])(context, builder, arguments[0])
    return cgutils.get_item_pointer(
        context, builder, signature.args[0], array, [arguments[1]], wraparound=False
    )
