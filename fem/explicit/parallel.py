"""The time loop on several threads for large meshes, compiled.

Each thread has its own elements, forces and scratch. The threads wait for each other at barriers between the parts of
a step. The last thread to arrive does the work that is common to all, and releases the others. These spin for about
as long as it takes to wake a thread, then sleep, so that a core can be used by another program. Forces are summed in
the order of the threads, and a run repeats to the bit on the same number of threads.
"""

import ctypes
import threading
from typing import NamedTuple

import numpy as np

from fem.explicit.elastic_damping import SUMS, add_damping_force, power_correction, sum_motion
from fem.explicit.internal_force import Scratch, subtract_forces_of
from fem.explicit.simd_blocks import BLOCK_SIZE, aligned, slot_count
from fem.explicit.time_loop import LoopParameters, State, add_reaction, drift, follow
from machine_code.compiled import Kernel, compiled
from machine_code.intrinsics import atomic_add, atomic_load, atomic_store, library_function

WORD = 8
"""Distance between the two numbers of a barrier, a cache line."""

ARRIVED, GENERATION = 0, WORD
"""Places of these numbers: arrivals at barriers, and the last barrier that was released."""

SPINS = 20_000
"""Reads of a barrier's state before a thread sleeps, about 20 us."""

OBJECT_BYTES = 128
"""Bytes that hold a mutex or a condition variable of any C library."""

_lock = library_function("pthread_mutex_lock", 1)
_unlock = library_function("pthread_mutex_unlock", 1)
_sleep = library_function("pthread_cond_wait", 2)
_wake_all = library_function("pthread_cond_broadcast", 1)


class Barrier(NamedTuple):
    """Barrier at which threads wait for each other.

    numbers: see ARRIVED and GENERATION, int64. mutex, condition: addresses of the objects of the C library. memory:
    array that holds these objects.
    """

    numbers: np.ndarray
    mutex: int
    condition: int
    memory: np.ndarray


def new_barrier() -> Barrier:
    """Return a barrier at which no thread has arrived."""
    library, memory = ctypes.CDLL(None), np.zeros((2, OBJECT_BYTES // 8), dtype=np.int64)
    mutex, condition = (part.ctypes.data for part in memory)
    library.pthread_mutex_init(ctypes.c_void_p(mutex), None)
    library.pthread_cond_init(ctypes.c_void_p(condition), None)
    return Barrier(np.zeros(2 * WORD, dtype=np.int64), mutex, condition, memory)


class Team:
    """Workspaces of the threads for one model."""

    def __init__(self, parameters: LoopParameters, scratch: Scratch, threads: int) -> None:
        self._parameters, self._threads = parameters, threads
        self._scratch, self._rows = scratch, aligned(threads * scratch.rows.size).reshape(threads, -1)
        self._forces = np.zeros((threads, 2, parameters.mass.size))
        self._powers = np.zeros((2, threads))
        self._motions, self._shift = np.zeros((2, threads, SUMS)), np.zeros(1)

    def advance(self, state: State, steps: int) -> None:
        """Advance the state in place by this many steps."""
        parts = self._parts(state, steps)
        workers = [threading.Thread(target=advance_thread, args=(t, *parts)) for t in range(1, self._threads)]
        for thread in workers:
            thread.start()
        advance_thread(0, *parts)
        for thread in workers:
            thread.join()

    def step_call(self, state: State) -> tuple[Kernel, tuple[object, ...]]:
        """Return the compiled function of a thread, and arguments of its types."""
        return advance_thread, (0, *self._parts(state, 0))

    def _parts(self, state: State, steps: int) -> tuple[object, ...]:
        shared = (self._powers, self._motions, self._shift)
        workspaces = (self._forces, self._scratch, self._rows, *shared, new_barrier())
        return state, steps, self._parameters, *workspaces


@compiled
def advance_thread(t, state, steps, parameters, forces, shared, rows, powers, motions, shift, barrier):
    """Advance the part of thread t.

    The step is that of `fem.explicit.time_loop.advance`.
    """
    positions, velocities, part = state.positions, state.velocities, forces[t]
    table, material = parameters.table, parameters.material
    mass, time_step = parameters.mass, parameters.time_step
    viscosity, hourglass = parameters.viscosity, parameters.hourglass
    damping, threads, nodes = parameters.elastic_damping, forces.shape[0], parameters.mass.size
    slots = slot_count(table.connectivity, shared.lattice)
    blocks = (slots + BLOCK_SIZE - 1) // BLOCK_SIZE
    first, last = blocks * t // threads * BLOCK_SIZE, min(slots, blocks * (t + 1) // threads * BLOCK_SIZE)
    begin, end = nodes * t // threads, nodes * (t + 1) // threads
    motion = motions[1, t]
    scratch = Scratch(
        rows[t], shared.gradients, shared.weights, shared.lattice, motion, shared.hourglass, shared.reference,
        shared.quadrilateral, shared.nine_nodes,
    )  # fmt: skip
    for step in range(steps):
        part[:] = 0.0
        powers[0, t] = subtract_forces_of(
            first, last, positions, velocities, viscosity, hourglass, part, table, material, scratch, None
        )
        sum_motion(damping, positions, velocities, mass, begin, end, motions[0, t])
        _wait_for_all(barrier, threads, 3 * step + 1)
        _sum_forces(forces, begin, end)
        _sum_threads(motions[0], motion)
        powers[0, t] -= add_damping_force(
            damping, motion, positions, velocities, mass, time_step, begin, end, forces[0]
        )
        if _arrive(barrier, threads, 3 * step + 2):
            place = add_reaction(parameters, state, time_step * _sum(powers[0]), forces[0])
            shift[0] = follow(place, parameters.span, state.origin)
            _release(barrier, 3 * step + 2)
        else:
            _wait_for_release(barrier, 3 * step + 2)
        powers[1, t] = power_correction(damping, motion, state, time_step, begin, end, forces[0])
        drift(positions, velocities, forces[0], mass, time_step, shift[0], begin, end)
        if _arrive(barrier, threads, 3 * step + 3):
            state.sums[1] += time_step * _sum(powers[1])
            _release(barrier, 3 * step + 3)
        else:
            _wait_for_release(barrier, 3 * step + 3)


@compiled
def _sum(values):
    """Return the sum of the values of all threads."""
    total = 0.0
    for value in values:
        total += value
    return total


@compiled
def _sum_forces(forces, begin, end):
    """Add the forces of all threads on a range of nodes."""
    for t in range(1, forces.shape[0]):
        for i in range(2):
            total, part = forces[0, i, begin:end], forces[t, i, begin:end]
            for node in range(total.size):
                total[node] += part[node]


@compiled
def _sum_threads(motions, total):
    """Add up the sums of all threads."""
    total[:] = 0.0
    for t in range(motions.shape[0]):
        for k in range(total.size):
            total[k] += motions[t, k]


@compiled
def _wait_for_all(barrier, threads, generation):
    """Wait until all threads have arrived at this barrier."""
    if _arrive(barrier, threads, generation):
        _release(barrier, generation)
    else:
        _wait_for_release(barrier, generation)


@compiled
def _arrive(barrier, threads, generation):
    """Arrive at a barrier, and return True in the last thread."""
    return atomic_add(barrier.numbers, ARRIVED, 1) == threads * generation - 1


@compiled
def _release(barrier, generation):
    """Release the threads that wait at a barrier.

    A thread that reads under the mutex that the barrier is not released is asleep before the mutex is locked here.
    """
    atomic_store(barrier.numbers, GENERATION, generation)
    _lock(barrier.mutex)
    _wake_all(barrier.condition)
    _unlock(barrier.mutex)


@compiled
def _wait_for_release(barrier, generation):
    """Spin, then sleep, until the barrier is released."""
    for _ in range(SPINS):
        if atomic_load(barrier.numbers, GENERATION) >= generation:
            return
    _lock(barrier.mutex)
    while atomic_load(barrier.numbers, GENERATION) < generation:
        _sleep(barrier.condition, barrier.mutex)
    _unlock(barrier.mutex)
