"""Observers that report progress, end a run, record states or save checkpoints.

A run is resumed from a checkpoint with the same bits.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from fem.run.runner import Arrays, Observer, PlateStepper, S, Size, Sizes

if TYPE_CHECKING:
    from fem.explicit.impact_loop import ImpactLoopState
    from fem.explicit.time_loop import State

SHAPES = 4
"""Instants of a run for which the stable time step of the deformed plate is computed."""

Nodal = tuple[np.ndarray, np.ndarray]
"""Positions [m] and velocities [m/s] in the wall's frame, shape (2, nodes) each."""


class Progress(Observer):
    """Observer that reports the simulated time [s].

    interval: between rows [s].
    """

    def __init__(self, callback: Callable[[float], None], interval: float) -> None:
        self._callback, self._interval = callback, interval

    def look(self, rows: np.ndarray, state: State | ImpactLoopState) -> bool:
        """Call the callback with the simulated time."""
        self._callback(self._interval * (len(rows) - 1))
        return False


class EndCondition(Observer):
    """Observer that ends the run when `over` is true.

    over: takes all rows so far. every: rows between two calls; 0 for each stop. first: row at which they begin.
    """

    def __init__(self, over: Callable[[np.ndarray], bool], every: int = 0, first: int = 0) -> None:
        self._over, self._every, self._first = over, every, first

    def due(self, row: int) -> int:
        """Return the number of rows until the next of these rows."""
        return self._every and self._every - (row - self._first) % self._every

    def look(self, rows: np.ndarray, state: State | ImpactLoopState) -> bool:
        """Evaluate the condition, except at the start alone."""
        return len(rows) > 1 and self._over(rows)


class ShapeSampler(Observer):
    """Observer that records positions at multiples of a number of rows.

    The start is the first. They serve the frequency of the deformed plate. refresh: number of rows after which the
    last positions are replaced in addition.
    """

    def __init__(self, every: int, refresh: float = math.inf) -> None:
        self._every, self._refresh = every, refresh
        self.samples, self.last = list[np.ndarray](), np.zeros(0)

    def due(self, row: int) -> int:
        """Return the rows until the next positions are recorded."""
        return int(min(self._every - row % self._every, self._refresh - (row + 1) % self._refresh))

    def look(self, rows: np.ndarray, state: State | ImpactLoopState) -> bool:
        """Record the positions."""
        self.last = state.positions
        if (len(rows) - 1) % self._every == 0:
            self.samples.append(state.positions)
        return False

    def arrays(self) -> dict[str, np.ndarray]:
        """Return the arrays from which `resume` continues."""
        return {"seen": np.array(self.samples), "last": self.last}

    def sizes(self, row: int, nodal: Size) -> dict[str, Size]:
        """Return the shapes of `arrays` after this row."""
        return {"seen": (row // self._every + 1, *nodal), "last": nodal}

    def resume(self, arrays: Arrays) -> None:
        """Continue from these arrays."""
        self.samples, self.last = list(arrays["seen"]), arrays["last"]


@dataclass(frozen=True)
class Snapshots:
    """Motion of all nodes at some instants.

    Attributes
    ----------
    t : ndarray, shape (instants,)
        Instants [s]: the first is 0, the last the end of the run.
    positions, velocities : ndarray, shape (instants, 2, nodes)
        In the wall's frame [m], [m/s].
    """

    t: np.ndarray
    positions: np.ndarray
    velocities: np.ndarray


class SnapshotKeeper(Observer):
    """Observer that records motions at even instants of the expected time.

    Those of the nearest rows are recorded, and the end of the run.

    Parameters
    ----------
    count : int
        Instants, the end included.
    rows : float
        Expected from the start to the end.
    nodal : callable
        Positions and velocities of the nodes of a state.
    """

    def __init__(self, count: int, rows: float, nodal: Callable[[Any], Nodal]) -> None:
        self._spacing = rows / (count - 1) if count > 1 else math.inf
        self._count, self._nodal = count, nodal
        self._recorded = list[Nodal]()

    def _row(self, k: int) -> int:
        """Return the row of an instant, different for all instants."""
        return max(k, round(self._spacing * k))

    def due(self, row: int) -> int:
        """Return the rows until the next instant.

        It is 0 where only the end of the run is missing.
        """
        incomplete = len(self._recorded) < self._count - 1
        return self._row(len(self._recorded)) - row if incomplete else 0

    def look(self, rows: np.ndarray, state: State | ImpactLoopState) -> bool:
        """Record the motion."""
        if len(self._recorded) < self._count - 1:
            self._recorded.append(self._nodal(state))
        return False

    def arrays(self) -> dict[str, np.ndarray]:
        """Return the arrays from which `resume` continues."""
        return {"kept": np.array(self._recorded)} if self._recorded else {}

    def sizes(self, row: int, nodal: Size) -> dict[str, Size]:
        """Return the shapes of `arrays` after this row."""
        count = sum(self._row(k) <= row for k in range(self._count - 1))
        return {"kept": (count, 2, *nodal)} if count else {}

    def resume(self, arrays: Arrays) -> None:
        """Continue from these arrays."""
        self._recorded = [(positions, velocities) for positions, velocities in arrays.get("kept", ())]

    def finished(self, t: np.ndarray, end: Nodal) -> Snapshots:
        """Return all recorded motions and the end of the run.

        t: instants of all rows [s].
        """
        motions = ((self._row(k), *nodal) for k, nodal in enumerate(self._recorded))
        entries = [entry for entry in motions if t[entry[0]] < t[-1]] + [(-1, *end)]
        rows, positions, velocities = zip(*entries, strict=True)
        return Snapshots(t[list(rows)], np.array(positions), np.array(velocities))


class Checkpoint(Protocol):
    """Store of a run's checkpoints, which decides when they are saved."""

    def load(self, sizes: Callable[[int], Sizes]) -> Arrays | None:
        """Return the last checkpoint of this run, None without any.

        sizes: function that returns the shapes of its arrays after a number of rows; it raises ValueError where the
        run has fewer rows.
        """

    def save(self, arrays: Callable[[], Arrays]) -> None:
        """Save the arrays if a checkpoint is due.

        Called between the rows of the history.
        """


class Saver(Observer):
    """Observer that offers checkpoints to their store."""

    def __init__(self, checkpoint: Checkpoint | None, observers: Sequence[Observer]) -> None:
        self._checkpoint, self._observers = checkpoint, observers

    def resumed_state(
        self, stepper: PlateStepper[S], like: S, most: int, start: Callable[[], S]
    ) -> tuple[S, np.ndarray | None]:
        """Return the state and the rows from which the run continues.

        Observers are restored. Without a checkpoint the state is that of the start, and there are no rows. like: a
        state of the same form. most: rows of the run, without that of the start.
        """

        def sizes(rows: int) -> Sizes:
            if not 1 <= rows <= most + 1:
                raise ValueError(f"the run has at most {most + 1} rows")
            shapes = {name: array.shape for name, array in packed("state", like).items()}
            for observer in self._observers:
                shapes |= observer.sizes(rows - 1, like.positions.shape)
            return shapes | {"rows": (rows, *stepper.record(like, 0, 1).rows.shape[1:])}

        saved = self._checkpoint.load(sizes) if self._checkpoint else None
        if saved is None:
            return start(), None
        for observer in self._observers:
            observer.resume(saved)
        return unpacked("state", like, saved), saved["rows"]

    def look(self, rows: np.ndarray, state: State | ImpactLoopState) -> bool:
        """Offer a checkpoint."""
        if self._checkpoint:
            self._checkpoint.save(functools.partial(self._all_arrays, rows, state))
        return False

    def _all_arrays(self, rows: np.ndarray, state: State | ImpactLoopState) -> dict[str, np.ndarray]:
        arrays = packed("state", state)
        for observer in self._observers:
            arrays |= observer.arrays()
        return arrays | {"rows": rows}


def packed(name: str, value: Any) -> dict[str, np.ndarray]:
    """Return the arrays of a named tuple by dotted names.

    Arrays of tuples within it are included; None has none.
    """
    if value is None or isinstance(value, np.ndarray):
        return {} if value is None else {name: value}
    parts = (packed(f"{name}.{field}", part) for field, part in value._asdict().items())
    return {key: array for part in parts for key, array in part.items()}


def unpacked(name: str, like: Any, arrays: Arrays) -> Any:
    """Return the named tuple of packed arrays.

    like: one of the same form.
    """
    if like is None or isinstance(like, np.ndarray):
        return None if like is None else np.ascontiguousarray(arrays[name])
    parts = like._asdict().items()
    return like._make(unpacked(f"{name}.{field}", part, arrays) for field, part in parts)
