"""Checkpoints: what a run needs to go on from where it was, as named arrays; who keeps them decides when and where."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

import numpy as np

Arrays = Mapping[str, np.ndarray]


class Checkpoint(Protocol):
    """Keeper of a run's checkpoints."""

    def load(self) -> Arrays | None:
        """The last one that was kept of this run; None to begin at the beginning."""

    def save(self, arrays: Callable[[], Arrays]) -> None:
        """Keep what `arrays` returns, if it is time to; called between the rows of the history."""


class NoCheckpoint:
    """Keeps nothing."""

    def load(self) -> None:
        """Nothing was kept."""

    def save(self, arrays: Callable[[], Arrays]) -> None:
        """Keep nothing."""


def packed(name: str, value: Any) -> dict[str, np.ndarray]:
    """Arrays of a tuple with named fields, of those within it too, by dotted names; None has none."""
    if value is None or isinstance(value, np.ndarray):
        return {} if value is None else {name: value}
    return {
        key: array
        for field, part in value._asdict().items()
        for key, array in packed(f"{name}.{field}", part).items()
    }


def unpacked(name: str, like: Any, arrays: Arrays) -> Any:
    """The tuple again; like: one of the same form."""
    if like is None or isinstance(like, np.ndarray):
        return None if like is None else arrays[name].copy()
    parts = like._asdict().items()
    return like._make(unpacked(f"{name}.{field}", part, arrays) for field, part in parts)
