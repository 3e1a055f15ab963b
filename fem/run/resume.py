"""Checkpoints of a run, from which it is resumed with the same bits."""

import functools
from collections.abc import Callable, Sequence
from typing import Any, Protocol

import numpy as np

from fem.run.runner import Arrays, Observer, PlateStepper, Sizes


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
        self, stepper: PlateStepper, like: Any, most: int, start: Callable[[], Any]
    ) -> tuple[Any, np.ndarray | None]:
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

    def look(self, rows: np.ndarray, state: Any) -> bool:
        """Offer a checkpoint."""
        if self._checkpoint:
            self._checkpoint.save(functools.partial(self._all_arrays, rows, state))
        return False

    def _all_arrays(self, rows: np.ndarray, state: Any) -> dict[str, np.ndarray]:
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
