"""What the study found: settings with their error and time, and the best of them."""

from __future__ import annotations

import math
from dataclasses import dataclass

from postprocess.comparison.grid_convergence import GridConvergence
from tailslap.planning.plan import Plan
from tailslap.studies.cost.limits import Limit
from tailslap.studies.cost.settings import EXACT, Setting


@dataclass(frozen=True)
class Point:
    """A setting as measured. error: of the scene as it is, from the exact rigid motion; of the soft plate, from its
    limit; never below what that is known to. added: what a choice adds to the error of its mesh, else NaN.

    Times [s]: the fastest of several, and the median; compile_s apart. failed: names of the run's failed checks.
    """

    setting: Setting
    error: float
    added: float
    setup_s: float
    loop_s: float
    median_s: float
    compile_s: float
    steps: int
    failed: tuple[str, ...]
    refused: str = ""

    @property
    def seconds(self) -> float:
        """Time to the answer in a process that has all it needs compiled and loaded."""
        return self.setup_s + self.loop_s

    @property
    def valid(self) -> bool:
        """Whether it gave an answer that passed the program's checks."""
        return not self.refused and not self.failed and math.isfinite(self.error)


@dataclass(frozen=True)
class CostSurvey:
    """The study: the points, and grid convergence of each quantity by group.

    soft: what makes the plate soft; limit: of the soft plate; mesh_limit: of the mesh that choices are made on;
    flexibility: distance of the soft plate's limit from its rigid motion.
    """

    plan: Plan
    points: tuple[Point, ...]
    convergence: dict[str, dict[str, GridConvergence]]
    soft: tuple[str, ...]
    limit: Limit
    mesh_limit: Limit
    flexibility: float
    seconds: float

    @property
    def rigid(self) -> tuple[Point, ...]:
        """Points of the scene as it is."""
        return tuple(point for point in self.points if not point.setting.soft)

    @property
    def flexible(self) -> tuple[Point, ...]:
        """Points of the soft plate."""
        return tuple(point for point in self.points if point.setting.soft)


def front(points: tuple[Point, ...]) -> list[Point]:
    """The points that no other beats in both time and error. The exact solution is what errors are measured from, and
    choices are made on one mesh: neither is among them."""
    found: list[Point] = []
    for point in sorted((p for p in points if p.valid), key=lambda p: (p.seconds, p.error)):
        beats = not found or point.error < found[-1].error
        if beats and point.setting.kind != EXACT and not point.setting.choice:
            found.append(point)
    return found


def cheapest(points: tuple[Point, ...], level: float) -> Point | None:
    """The cheapest valid point with at most this error."""
    good = [p for p in points if p.valid and p.error <= level]
    return min(good, key=lambda p: p.seconds, default=None)
