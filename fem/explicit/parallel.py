"""The time loop on several threads, for large meshes; compiled.

Each thread has its own elements, forces and scratch. Between the parts of a step the threads meet: the last to come
does what belongs to all, and lets them go on. The others look out for that for about as long as it takes to wake a
thread, and then sleep, so that a core that another program wants is left to it. The forces are summed in the order of
the threads, so that a run repeats to the bit on the same number of threads.
"""

import ctypes
import threading
from typing import Any, NamedTuple

import numpy as np
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from fem.explicit.internal_force import SUMS, Scratch, add_up, gained, resist, subtract_forces_of
from fem.explicit.point_force import BLOCK_SIZE, aligned, slot_count
from fem.explicit.time_loop import LoopParameters, State, drift, follow, react
from fem.machine_code.compiled import compiled

WORD = 8
"""The two numbers of a meeting lie so many apart, a cache line."""

ARRIVED, TURN = 0, WORD
"""Places of these numbers: how many threads have come to meetings so far; the last meeting that is over."""

LOOKS = 20_000
"""Times that a thread looks for the end of a meeting before it sleeps: some 20 us."""

ROOM = 128
"""Bytes that hold a mutex or a condition variable, whatever the system's C library."""

_lock = types.ExternalFunction("pthread_mutex_lock", types.int32(types.uintp))
_unlock = types.ExternalFunction("pthread_mutex_unlock", types.int32(types.uintp))
_sleep = types.ExternalFunction("pthread_cond_wait", types.int32(types.uintp, types.uintp))
_wake_all = types.ExternalFunction("pthread_cond_broadcast", types.int32(types.uintp))


class Meeting(NamedTuple):
    """Meeting point at which threads wait for each other.

    numbers: see ARRIVED and TURN, int64; mutex, condition: addresses of the C library's objects; memory: that they
    lie in.
    """

    numbers: np.ndarray
    mutex: int
    condition: int
    memory: np.ndarray


def new_meeting() -> Meeting:
    """A place to meet, which no thread has come to yet."""
    library, memory = ctypes.CDLL(None), np.zeros((2, ROOM), dtype=np.uint8)
    mutex, condition = (part.ctypes.data for part in memory)
    library.pthread_mutex_init(ctypes.c_void_p(mutex), None)
    library.pthread_cond_init(ctypes.c_void_p(condition), None)
    return Meeting(np.zeros(2 * WORD, dtype=np.int64), mutex, condition, memory)


class Team:
    """Workspaces of the threads, for one model."""

    def __init__(self, loop: LoopParameters, scratch: Scratch, threads: int) -> None:
        self._loop, self._threads = loop, threads
        self._scratch, self._rows = scratch, aligned(threads * scratch.rows.size).reshape(threads, -1)
        self._forces = np.zeros((threads, 2, loop.mass.size))
        self._powers = np.zeros((2, threads))
        self._motions, self._shift = np.zeros((2, threads, SUMS)), np.zeros(1)

    def advance(self, state: State, steps: int) -> None:
        """Advance the state in place by this many steps."""
        parts = self._parts(state, steps)
        others = [threading.Thread(target=advance_thread, args=(t, *parts)) for t in range(1, self._threads)]
        for thread in others:
            thread.start()
        advance_thread(0, *parts)
        for thread in others:
            thread.join()

    def step_call(self, state: State) -> tuple[Any, ...]:
        """The compiled function of a thread, and arguments of its types."""
        return advance_thread, 0, *self._parts(state, 0)

    def _parts(self, state: State, steps: int) -> tuple[Any, ...]:
        shared = (self._powers, self._motions, self._shift)
        workspaces = (self._forces, self._scratch, self._rows, *shared, new_meeting())
        return state, steps, self._loop, self._loop.viscosity, self._loop.hourglass, *workspaces


@compiled
def advance_thread(
    t, state, steps, loop, viscosity, hourglass, forces, shared, rows, powers, motions, shift, meeting
):
    """Advance the part of thread t; see `fem.explicit.time_loop.advance` for the step."""
    positions, velocities, own = state.positions, state.velocities, forces[t]
    table, material, mass, time_step = loop.table, loop.material, loop.mass, loop.time_step
    damping, threads, nodes = loop.elastic_damping, forces.shape[0], loop.mass.size
    slots = slot_count(table.connectivity, shared.lattice)
    blocks = (slots + BLOCK_SIZE - 1) // BLOCK_SIZE
    first, last = blocks * t // threads * BLOCK_SIZE, min(slots, blocks * (t + 1) // threads * BLOCK_SIZE)
    begin, end = nodes * t // threads, nodes * (t + 1) // threads
    motion = motions[1, t]
    scratch = Scratch(
        rows[t], shared.gradients, shared.weights, shared.lattice, motion, shared.hourglass, shared.reference
    )
    for step in range(steps):
        own[:] = 0.0
        powers[0, t] = subtract_forces_of(
            first, last, positions, velocities, viscosity, hourglass, own, table, material, scratch
        )
        add_up(damping, positions, velocities, mass, begin, end, motions[0, t])
        _meet(meeting, threads, 3 * step + 1)
        _sum_forces(forces, begin, end)
        _add_up_threads(motions[0], motion)
        powers[0, t] -= resist(damping, motion, positions, velocities, mass, time_step, begin, end, forces[0])
        if _is_last(meeting, threads, 3 * step + 2):
            place = react(loop, state, powers[0].sum(), forces[0])
            shift[0] = follow(place, loop.span, state.origin)
            _end(meeting, 3 * step + 2)
        else:
            _wait_for_end(meeting, 3 * step + 2)
        powers[1, t] = gained(damping, motion, state, time_step, begin, end, forces[0])
        drift(positions, velocities, forces[0], mass, time_step, shift[0], begin, end)
        if _is_last(meeting, threads, 3 * step + 3):
            state.sums[1] += time_step * powers[1].sum()
            _end(meeting, 3 * step + 3)
        else:
            _wait_for_end(meeting, 3 * step + 3)


@compiled
def _sum_forces(forces, begin, end):
    for t in range(1, forces.shape[0]):
        for i in range(2):
            total, part = forces[0, i, begin:end], forces[t, i, begin:end]
            for node in range(total.size):
                total[node] += part[node]


@compiled
def _add_up_threads(parts, total):
    total[:] = 0.0
    for part in range(parts.shape[0]):
        for k in range(total.size):
            total[k] += parts[part, k]


@compiled
def _meet(meeting, threads, turn):
    """Wait until every thread has come to this meeting."""
    if _is_last(meeting, threads, turn):
        _end(meeting, turn)
    else:
        _wait_for_end(meeting, turn)


@compiled
def _is_last(meeting, threads, turn):
    """Come to a meeting; whether all others have."""
    return _add(meeting.numbers, ARRIVED, 1) == threads * turn - 1


@compiled
def _end(meeting, turn):
    """Let all go on; who finds the meeting not over, under the mutex, is asleep before it can be locked here."""
    _store(meeting.numbers, TURN, turn)
    _lock(meeting.mutex)
    _wake_all(meeting.condition)
    _unlock(meeting.mutex)


@compiled
def _wait_for_end(meeting, turn):
    for _ in range(LOOKS):
        if _load(meeting.numbers, TURN) >= turn:
            return
    _lock(meeting.mutex)
    while _load(meeting.numbers, TURN) < turn:
        _sleep(meeting.condition, meeting.mutex)
    _unlock(meeting.mutex)


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


@intrinsic
def _add(context: Any, array: Any, index: Any, value: Any) -> Any:
    """Add to a number that other threads add to; returns what it was. All written before is seen by the next."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        place = _pointer(context, builder, signature, arguments)
        return builder.atomic_rmw("add", place, arguments[2], "acq_rel")

    return array.dtype(array, types.intp, array.dtype), code


def _pointer(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    array = context.make_array(signature.args[0])(context, builder, arguments[0])
    return cgutils.get_item_pointer(
        context, builder, signature.args[0], array, [arguments[1]], wraparound=False
    )
