"""Rows of a run's history, made by a compiled stepper under observers.

A stepper (`PlateStepper`)
1. leaves every state that it receives unchanged;
2. makes the same bits however many rows it is asked for at once;
3. makes fewer rows only where the run ends, and at least one;
4. returns with the rows the state of the last one and that of the row before.

An observer (`Observer`)
1. states in `due` after how many rows it is to be called; the runner makes at most the least of these numbers at once;
2. sees in `look` all rows so far and the state of the last one, and changes neither;
3. ends the run by the result of `look`; those behind it are then not called;
4. gives in `arrays` all that `resume` needs to continue with the same bits, of the shapes that `sizes` states.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, TypeVar

import numpy as np

from fem.explicit import internal_force, time_loop
from fem.model.plate_model import PlateModel
from machine_code.object_code import Prepared

if TYPE_CHECKING:
    from fem.explicit.impact_loop import ImpactLoopState
    from fem.explicit.time_loop import State

S = TypeVar("S", bound="State | ImpactLoopState")
"""State of a loop."""

Arrays = Mapping[str, np.ndarray]
Size = tuple[int, ...]
Sizes = Mapping[str, Size]
"""Shapes of such arrays."""

LONGEST_S = 0.1
"""Approximate time [s] of rows recorded at once.

Between them a run reports its progress, and can be ended.
"""


class Recorded(NamedTuple, Generic[S]):
    """Rows of the history, with two states.

    rows: shape (rows, values). before: the state of the last row but one, or of the beginning. state: that of the
    last.
    """

    rows: np.ndarray
    before: S
    state: S


class Observer:
    """Observer of a run.

    This base class is called whenever the runner stops, never ends the run, and has no arrays.
    """

    def due(self, row: int) -> int:
        """Return the number of rows until the next call, at least 1.

        0 requests a call whenever the runner stops. For row -1, the start is shown where the result is 1.
        """
        return 0

    def look(self, rows: np.ndarray, state: State | ImpactLoopState) -> bool:
        """Examine all rows so far and the state of the last one.

        Returns True when the run is over.
        """
        return False

    def arrays(self) -> dict[str, np.ndarray]:
        """Return the arrays from which `resume` continues."""
        return {}

    def sizes(self, row: int, nodal: Size) -> dict[str, Size]:
        """Return the shapes of `arrays` after this row.

        nodal: shape of the positions.
        """
        return {}

    def resume(self, arrays: Arrays) -> None:
        """Continue from these arrays and those of the run."""


class PlateStepper(Generic[S]):
    """Compiled loop of a plate with its parameters and workspace.

    It leaves states that it receives unchanged. record: (state, stride, count) -> `Recorded`; makes `count` rows from
    a state on, `stride` steps apart, or fewer where the run ends.
    """

    record: Callable[[S, int, int], Recorded[S]]

    def __init__(self, model: PlateModel) -> None:
        self.model, self.parameters = model, model.parameters
        self._reference = model.discretisation.positions
        self._force = np.zeros_like(self._reference)
        self._scratch = internal_force.scratch_for(self.parameters.table, self.parameters.hourglass)
        last = time_loop.LastRow(np.zeros_like(self._reference), np.zeros(3))
        parts = self._reference, self._force, self._scratch, last
        self._workspace = [Prepared(part) for part in parts]
        self._prepared = Prepared(self.parameters)

    @property
    def _fixed(self) -> Prepared:
        """Parameters of the loop, prepared again where they have been replaced."""
        if self._prepared.value is not self.parameters:
            self._prepared = Prepared(self.parameters)
        return self._prepared

    @property
    def _all_parts(self) -> tuple[object, ...]:
        """Arguments of the compiled functions behind state and steps."""
        return self._fixed, *self._workspace

    def nodal(self, state: S, later: S | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Return positions [m] and velocities [m/s] at the state's instant.

        They are in the wall's frame, shape (2, nodes) each. later: state of the next step, made where it is None.
        """
        later = later or self.record(state, 1, 1).state
        velocities = 0.5 * (state.velocities + later.velocities)
        return state.positions + np.array([[state.origin[0]], [0.0]]), velocities


def run(
    stepper: PlateStepper[S],
    state: S,
    stride: int,
    rows: int,
    observers: Sequence[Observer],
    earlier: np.ndarray | None = None,
) -> Recorded[S]:
    """Make rows until an observer ends the run.

    Parameters
    ----------
    stepper : PlateStepper
        The compiled step.
    state : State or ImpactLoopState
        At the start, or of the last of `earlier` rows.
    stride : int
        Steps between rows.
    rows : int
        Largest number of rows, without that of the start.
    observers : sequence of Observer
        In the order in which they are called; those behind one that ends the run are not called any more.
    earlier : ndarray, optional
        Rows of an earlier run that continues here.

    Returns
    -------
    Recorded
        All rows, and states.
    """
    before, pace, finished = state, math.inf, False
    history = stored = stepper.record(state, 0, 1).rows if earlier is None else earlier
    if earlier is None:
        waits = [observer.due(-1) or 2 for observer in observers]
        finished = _call_observers(observers, waits, 1, history, state)
    while not finished and len(history) <= rows:
        waits = [observer.due(len(history) - 1) for observer in observers]
        most = min([rows + 1 - len(history), *filter(None, waits)])
        began = time.perf_counter()
        new, before, state = stepper.record(state, stride, max(1, min(most, int(LONGEST_S / pace))))
        pace = (time.perf_counter() - began) / len(new)
        stored = _extended(stored, len(history), new)
        history = stored[: len(history) + len(new)]
        finished = _call_observers(observers, waits, len(new), history, state)
    return Recorded(history, before, state)


def _extended(stored: np.ndarray, count: int, new: np.ndarray) -> np.ndarray:
    """Return an array with new rows behind the first `count`.

    It doubles where it is full, so that the cost of a row does not grow with their number.
    """
    if count + len(new) > len(stored):
        stored = np.concatenate([stored[:count], np.empty((count + len(new), stored.shape[1]))])
    stored[count : count + len(new)] = new
    return stored


def _call_observers(
    observers: Sequence[Observer],
    waits: list[int],
    count: int,
    rows: np.ndarray,
    state: State | ImpactLoopState,
) -> bool:
    """Call the observers that are due after `count` rows.

    Returns True when one of them ends the run.
    """
    called = [observer for observer, wait in zip(observers, waits, strict=True) if wait <= count]
    return any(observer.look(rows, state) for observer in called)


def assign_state(target: Any, state: Any) -> None:
    """Copy the arrays of a state into those of another."""
    for old, new in zip(target, state, strict=True):
        np.copyto(old, new)


def copy_state(state: Any) -> Any:
    """Copy a state and all states within it.

    The loop advances a state in place.
    """
    if state is None or isinstance(state, np.ndarray):
        return None if state is None else state.copy()
    return type(state)(*map(copy_state, state))
