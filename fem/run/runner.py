"""The run: rows of a history, made by a compiled stepper, at which observers look now and then.

An observer says how many rows it can wait (`due`); the runner makes no more than the least of these at once, and lets
each look whose time has come. What an observer needs to go on after an interruption it gives away as named arrays, and
takes back. How many rows are made at once changes no bit of them.

Observers that any run may have: how far it is, whether it is over, states to look at again, checkpoints.
"""

import functools
import math
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np

from fem.explicit import internal_force
from fem.machine_code.object_code import Prepared
from fem.model.plate_model import PlateModel
from fem.stability import deformed

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

    def nodal(self, state: Any) -> tuple[np.ndarray, np.ndarray]:
        """Positions [m] and velocities [m/s] at the state's instant in the wall's frame, shape (2, nodes) each."""
        later = self.record(state, 1, 1).state
        velocities = 0.5 * (state.velocities + later.velocities)
        return state.positions + np.array([[state.origin[0]], [0.0]]), velocities


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
    looking = [observer for observer, wait in zip(observers, waits, strict=True) if wait <= made]
    return any(observer.look(rows, state) for observer in looking)


LOOKS = 4
"""Instants of a run at which the stable time step is looked at again, in the deformed plate."""

Nodal = tuple[np.ndarray, np.ndarray]
"""Positions [m] and velocities [m/s] in the wall's frame, shape (2, nodes) each."""


class Progress(Observer):
    """Tells the time [s] that is done; interval: between rows [s]."""

    def __init__(self, callback: Callable[[float], None], interval: float) -> None:
        self._callback, self._interval = callback, interval

    def look(self, rows: np.ndarray, state: Any) -> bool:
        """Call the callback with the time that is done."""
        self._callback(self._interval * (len(rows) - 1))
        return False


class Until(Observer):
    """Ends the run at rows for which `over` says so.

    over: takes all rows so far. every: rows between two looks; 0 for each stop. first: at which row they begin.
    """

    def __init__(self, over: Callable[[np.ndarray], bool], every: int = 0, first: int = 0) -> None:
        self._over, self._every, self._first = over, every, first

    def due(self, row: int) -> int:
        """At the next of these rows."""
        return self._every and self._every - (row - self._first) % self._every

    def look(self, rows: np.ndarray, state: Any) -> bool:
        """Ask; the start alone is never the end."""
        return len(rows) > 1 and self._over(rows)


class Shapes(Observer):
    """Keeps the plate's positions at the start and every so many rows, for its frequency as deformed.

    glance: besides, rows between which the positions that were looked at last are replaced.
    """

    def __init__(self, every: int, glance: float = math.inf) -> None:
        self._every, self._glance = every, glance
        self.seen, self.last = list[np.ndarray](), np.zeros(0)

    def due(self, row: int) -> int:
        """At multiples of `every`, and a row before those of `glance`."""
        return int(min(self._every - row % self._every, self._glance - (row + 1) % self._glance))

    def look(self, rows: np.ndarray, state: Any) -> bool:
        """Keep them."""
        self.last = state.positions
        if (len(rows) - 1) % self._every == 0:
            self.seen.append(state.positions)
        return False

    def arrays(self) -> dict[str, np.ndarray]:
        """Arrays with which `resume` goes on."""
        return {"seen": np.array(self.seen), "last": self.last}

    def sizes(self, row: int, nodal: Size) -> dict[str, Size]:
        """Shapes of `arrays` after this row."""
        return {"seen": (row // self._every + 1, *nodal), "last": nodal}

    def resume(self, arrays: Arrays) -> None:
        """Go on from these arrays."""
        self.seen, self.last = list(arrays["seen"]), arrays["last"]


def highest_frequency(model: PlateModel, shapes: Iterable[np.ndarray]) -> float:
    """The highest [rad/s] of the plate in these positions, but for what is not finite; infinite without any."""
    finite = [positions for positions in shapes if np.isfinite(positions).all()]
    return max((deformed.deformed_frequency(model, positions) for positions in finite), default=np.inf)


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
    """Keeps the rows nearest to even instants of the time that is expected, and the end of the run.

    Parameters
    ----------
    count : int
        Instants, the end included.
    rows : float
        Expected, from the start to the end.
    nodal : callable
        Positions and velocities of a state's nodes.
    """

    def __init__(self, count: int, rows: float, nodal: Callable[[Any], Nodal]) -> None:
        self._spacing = rows / (count - 1) if count > 1 else math.inf
        self._count, self._nodal = count, nodal
        self._kept = list[Nodal]()

    def _row(self, k: int) -> int:
        """The row of an instant; no two have the same."""
        return max(k, round(self._spacing * k))

    def due(self, row: int) -> int:
        """At the row nearest to the next instant; at stops where only the end is left."""
        left = len(self._kept) < self._count - 1
        return self._row(len(self._kept)) - row if left else 0

    def look(self, rows: np.ndarray, state: Any) -> bool:
        """Record the motion."""
        if len(self._kept) < self._count - 1:
            self._kept.append(self._nodal(state))
        return False

    def arrays(self) -> dict[str, np.ndarray]:
        """Arrays with which `resume` goes on."""
        return {"kept": np.array(self._kept)} if self._kept else {}

    def sizes(self, row: int, nodal: Size) -> dict[str, Size]:
        """Shapes of `arrays` after this row."""
        count = sum(self._row(k) <= row for k in range(self._count - 1))
        return {"kept": (count, 2, *nodal)} if count else {}

    def resume(self, arrays: Arrays) -> None:
        """Go on from these arrays."""
        self._kept = [(positions, velocities) for positions, velocities in arrays.get("kept", ())]

    def finished(self, t: np.ndarray, end: Nodal) -> Snapshots:
        """All motions that were recorded, and the end of the run; t: instants of all rows [s]."""
        kept = ((self._row(k), *nodal) for k, nodal in enumerate(self._kept))
        entries = [entry for entry in kept if t[entry[0]] < t[-1]] + [(-1, *end)]
        rows, positions, velocities = zip(*entries, strict=True)
        return Snapshots(t[list(rows)], np.array(positions), np.array(velocities))


class Checkpoint(Protocol):
    """Keeper of a run's checkpoints: decides when and where they are kept."""

    def load(self, sizes: Callable[[int], Sizes]) -> Arrays | None:
        """The last one that was kept of this run; None to begin at the beginning.

        sizes: shapes of its arrays after so many rows; raises ValueError where the run has no so many.
        """

    def save(self, arrays: Callable[[], Arrays]) -> None:
        """Keep what `arrays` returns, if it is time to; called between the rows of the history."""


class Saver(Observer):
    """Gives the run's rows, its state and what other observers need to the keeper of its checkpoints."""

    def __init__(self, checkpoint: Checkpoint | None, others: Sequence[Observer]) -> None:
        self._checkpoint, self._others = checkpoint, others

    def begun(
        self, stepper: PlateStepper, like: Any, most: int, start: Callable[[], Any]
    ) -> tuple[Any, np.ndarray | None]:
        """State and rows to go on from, with the other observers as they were; else those of the start, no rows yet.

        like: a state of the same form; most: rows of the run, beside that of the start.
        """

        def sizes(rows: int) -> Sizes:
            if not 1 <= rows <= most + 1:
                raise ValueError(f"the run has at most {most + 1} rows")
            found = {name: array.shape for name, array in packed("state", like).items()}
            for observer in self._others:
                found |= observer.sizes(rows - 1, like.positions.shape)
            return found | {"rows": (rows, *stepper.record(like, 0, 1).rows.shape[1:])}

        kept = self._checkpoint.load(sizes) if self._checkpoint else None
        if kept is None:
            return start(), None
        for observer in self._others:
            observer.resume(kept)
        return unpacked("state", like, kept), kept["rows"]

    def look(self, rows: np.ndarray, state: Any) -> bool:
        """Offer a checkpoint."""
        if self._checkpoint:
            self._checkpoint.save(functools.partial(self._all_arrays, rows, state))
        return False

    def _all_arrays(self, rows: np.ndarray, state: Any) -> dict[str, np.ndarray]:
        kept = packed("state", state)
        for observer in self._others:
            kept |= observer.arrays()
        return kept | {"rows": rows}


def copy_state(state: Any) -> Any:
    """A state of its own, for the loop advances in place; of those within it too."""
    if state is None or isinstance(state, np.ndarray):
        return None if state is None else state.copy()
    return type(state)(*map(copy_state, state))


def packed(name: str, value: Any) -> dict[str, np.ndarray]:
    """Arrays of a tuple with named fields, of those within it too, by dotted names; None has none."""
    if value is None or isinstance(value, np.ndarray):
        return {} if value is None else {name: value}
    parts = (packed(f"{name}.{field}", part) for field, part in value._asdict().items())
    return {key: array for part in parts for key, array in part.items()}


def unpacked(name: str, like: Any, arrays: Arrays) -> Any:
    """The tuple again; like: one of the same form."""
    if like is None or isinstance(like, np.ndarray):
        return None if like is None else np.ascontiguousarray(arrays[name])
    parts = like._asdict().items()
    return like._make(unpacked(f"{name}.{field}", part, arrays) for field, part in parts)
