"""A sweep that is complete, and what it took."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from tailslap.sweeps.definition import Definition
from tailslap.sweeps.row import ERROR, FAILED


@dataclass(frozen=True)
class Effort:
    """What making runs took: how many, on how many threads, wall time [s] and the sum of the runs' own times [s]."""

    runs: int = 0
    threads: int = 0
    wall_s: float = 0.0
    runs_s: float = 0.0

    @property
    def rate(self) -> float:
        """Runs a second."""
        return self.runs / self.wall_s if self.runs else 0.0

    @property
    def overhead_s(self) -> float:
        """What a run costs a thread beyond its own time [s]."""
        return (self.wall_s * self.threads - self.runs_s) / self.runs if self.runs else 0.0


@dataclass(frozen=True)
class Sweep:
    """A sweep that is complete: how many rows have each status, and what the last call's runs took."""

    definition: Definition
    statuses: Mapping[str, int]
    effort: Effort

    @property
    def failures(self) -> int:
        """Runs that failed a check or ended in an error."""
        return self.statuses[FAILED] + self.statuses[ERROR]
