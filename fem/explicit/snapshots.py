"""Snapshots: positions and velocities of all nodes at a few instants of a run, where they are asked for."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

Nodal = tuple[np.ndarray, np.ndarray]
"""Positions [m] and velocities [m/s] in the wall's frame, shape (2, nodes) each."""


@dataclass(frozen=True)
class Snapshots:
    """What was kept of a run.

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


@dataclass
class SnapshotKeeper:
    """Keeps the rows nearest to even instants of the time that is expected, and the end of the run.

    Parameters
    ----------
    count : int
        Instants, the end included.
    duration : float
        Expected [s].
    """

    count: int
    duration: float
    _kept: list[tuple[float, np.ndarray, np.ndarray]] = field(default_factory=list)

    @property
    def due(self) -> float:
        """The next instant to keep [s]; infinite where only the end is left."""
        left = len(self._kept) < self.count - 1
        return self.duration * len(self._kept) / (self.count - 1) if left else np.inf

    def look(self, t: float, row: float, make: Callable[[], Nodal]) -> None:
        """Keep the instant t [s] if it is due within half of a row [s]; make: its positions and velocities."""
        if t + 0.5 * row >= self.due:
            self._kept.append((t, *make()))

    def arrays(self) -> dict[str, np.ndarray]:
        """What a checkpoint needs of it."""
        names = ("kept_t", "kept_positions", "kept_velocities")
        return {name: np.array([entry[i] for entry in self._kept]) for i, name in enumerate(names)}

    def resume(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Go on from a checkpoint."""
        kept = (arrays[name] for name in ("kept_t", "kept_positions", "kept_velocities"))
        self._kept = [(float(t), x, v) for t, x, v in zip(*kept, strict=True)]

    def finished(self, t: float, end: Nodal) -> Snapshots:
        """All that was kept, and the end of the run at t [s]."""
        entries = [entry for entry in self._kept if entry[0] < t] + [(t, *end)]
        times, positions, velocities = zip(*entries, strict=True)
        return Snapshots(np.array(times), np.array(positions), np.array(velocities))
