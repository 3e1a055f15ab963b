"""The run: rows of a history, made by a compiled stepper, at which observers look now and then.

An observer says how many rows it can wait (`due`); the runner makes no more than the least of these at once, and lets
each look whose time has come. What an observer needs to go on after an interruption it gives away as named arrays, and
takes back. How many rows are made at once changes no bit of them.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from fem.explicit import internal_force
from fem.machine_code.arguments import Prepared
from fem.model.plate_model import PlateModel

Arrays = Mapping[str, np.ndarray]
Size = tuple[int, ...]
Sizes = Mapping[str, Size]
"""Shapes of such arrays."""

LONGEST_S = 0.1
"""Time [s] that rows recorded at once may take, about: between them a run says how far it is, and can be ended."""


class Recorded(NamedTuple):
    """Rows of the history, shape (rows, values), and the states of the last but one, or of the beginning, and of the
    last."""

    rows: np.ndarray
    before: Any
    state: Any


class Observer:
    """Looks at a run while it is made. This one looks whenever the runner stops, sees nothing to end the run for, and
    has nothing to keep."""

    def due(self, row: int) -> int:
        """Rows after which it wants to look, at least 1; 0 to look whenever the runner stops. Row -1: the start is
        looked at where this is 1."""
        return 0

    def look(self, rows: np.ndarray, state: Any) -> bool:
        """Look at all rows so far and the state of the last. Returns True when the run is over."""
        return False

    def arrays(self) -> dict[str, np.ndarray]:
        """Arrays with which `resume` goes on from here."""
        return {}

    def sizes(self, row: int, nodal: Size) -> dict[str, Size]:
        """Shapes of `arrays` after this row; nodal: that of positions."""
        return {}

    def resume(self, arrays: Arrays) -> None:
        """Go on from these arrays, and those of the run."""


class PlateStepper:
    """A plate's compiled loop with its parameters and its workspace; states are the caller's, and stay as they are.

    record: (state, stride, count) -> `Recorded`; makes so many rows from a state on, `stride` steps apart, or fewer
    where the run ends by itself.
    """

    record: Callable[[Any, int, int], Recorded]

    def __init__(self, model: PlateModel) -> None:
        self.model, self.loop = model, model.loop
        self._reference = model.discretisation.positions
        self._parts = (self.loop.viscosity, self.loop.hourglass)
        self._force = np.zeros_like(self._reference)
        self._scratch = internal_force.scratch_for(self.loop.table, self.loop.hourglass)
        self._workspace, self._prepared = Prepared(self._scratch), Prepared(self.loop)

    @property
    def _fixed(self) -> Prepared:
        """The loop's parameters, laid out again where they have been replaced."""
        if self._prepared.value is not self.loop:
            self._prepared = Prepared(self.loop)
        return self._prepared

    @property
    def _all_parts(self) -> tuple[Any, ...]:
        return self._fixed, *self._parts, self._reference, self._force, self._workspace

    def nodal_velocities(self, state: Any) -> np.ndarray:
        """Velocities [m/s] at the state's instant, shape (2, nodes)."""
        later = self.record(state, 1, 1).state
        return np.asarray(0.5 * (state.velocities + later.velocities))

    def nodal(self, state: Any) -> tuple[np.ndarray, np.ndarray]:
        """Positions [m] and velocities [m/s] at the state's instant in the wall's frame, shape (2, nodes) each."""
        return state.positions + np.array([[state.origin[0]], [0.0]]), self.nodal_velocities(state)


def run(
    stepper: PlateStepper,
    state: Any,
    stride: int,
    rows: int,
    observers: Sequence[Observer],
    made: np.ndarray | None = None,
) -> Recorded:
    """Make rows until an observer says that it is over.

    Parameters
    ----------
    stepper : PlateStepper
        The compiled step.
    state : State or ImpactLoopState
        At the start, or of the last row in `made`.
    stride : int
        Steps between rows.
    rows : int
        How many to make at most, beside that of the start.
    observers : sequence of Observer
        In the order in which they look; those behind one that ends the run do not look any more.
    made : ndarray, optional
        Rows of an earlier run that goes on here.

    Returns
    -------
    Recorded
        All rows, and states.
    """
    before, pace, over = state, math.inf, False
    if made is None:
        made = stepper.record(state, 0, 1).rows
        over = _looked(observers, [observer.due(-1) or 2 for observer in observers], 1, made, state)
    while not over and len(made) <= rows:
        waits = [observer.due(len(made) - 1) for observer in observers]
        most = min([rows + 1 - len(made), *filter(None, waits)])
        entered = time.perf_counter()
        new, before, state = stepper.record(state, stride, max(1, min(most, int(LONGEST_S / pace))))
        pace = (time.perf_counter() - entered) / len(new)
        made = np.concatenate([made, new])
        over = _looked(observers, waits, len(new), made, state)
    return Recorded(made, before, state)


def _looked(observers: Sequence[Observer], waits: list[int], made: int, rows: np.ndarray, state: Any) -> bool:
    """Let those look that were to wait for no more rows than were made; True when one says that it is over."""
    return any(
        observer.look(rows, state) for observer, wait in zip(observers, waits, strict=True) if wait <= made
    )
