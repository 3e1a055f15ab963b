"""What the study found: settings with their error and time, and the best of them."""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from postprocess.comparison.grid_convergence import GridConvergence
from tailslap.case.corner.case import CornerCase
from tailslap.studies.cost.limits import Limit, observed_order
from tailslap.studies.cost.settings import EXACT, FE, MODAL, ODE, Setting

LEVELS = tuple(10.0**-exponent for exponent in range(2, 12))
SETTING_COLUMNS = ("kind", "group", "label", "refinement", "soft", "choice")
POINT_COLUMNS = ("error", "added", "seconds", "setup_s", "loop_s", "median_s", "compile_s", "steps")


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
        """Time to solution in a process that has all it needs compiled and loaded."""
        return self.setup_s + self.loop_s

    @property
    def valid(self) -> bool:
        """Whether it gave a result that passed the program's checks."""
        return not self.refused and not self.failed and math.isfinite(self.error)

    @property
    def own_error(self) -> float:
        """What a choice adds; else the error."""
        return self.added if self.setting.choice else self.error

    @property
    def checks(self) -> str:
        """Whether it passed, which checks failed, or why there is no run."""
        if self.refused:
            return f"refused: {self.refused}"
        return f"failed: {', '.join(self.failed)}" if self.failed else "passed"

    @property
    def row(self) -> dict[str, Any]:
        """Setting and numbers, flat, as `points.csv` and the summary hold them."""
        setting = {name: getattr(self.setting, name) for name in SETTING_COLUMNS}
        own = {name: getattr(self, name) for name in POINT_COLUMNS}
        failed = {"failed": ", ".join(self.failed), "refused": self.refused}
        return {"setting": self.setting.key, **setting, **own, **failed}


def point_of(
    setting: Setting, record: Mapping[str, Any], limit: Limit, mesh_limit: Limit | None = None
) -> Point:
    """The point of a setting's record; limit: what errors are measured from; mesh_limit: of its mesh, for a choice."""
    if "refused" in record:
        return Point(setting, math.nan, math.nan, 0.0, 0.0, 0.0, 0.0, 0, (), record["refused"])
    return Point(
        setting,
        limit.error_of(record["values"]),
        mesh_limit.error_of(record["values"]) if mesh_limit and setting.choice else math.nan,
        min(record["setup"]),
        min(record["loop"]),
        statistics.median(record["loop"]),
        record.get("compile", 0.0),
        record["steps"],
        tuple(record["failed"]),
    )


@dataclass(frozen=True)
class CostResults:
    """The study: the points, and grid convergence of each quantity by group.

    soft: what makes the plate soft; limit: of the soft plate; mesh_limit: of the mesh that choices are made on;
    flexibility: distance of the soft plate's limit from its rigid motion.
    """

    plan: CornerCase
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


def front(points: Iterable[Point]) -> list[Point]:
    """The points that no other beats in both time and error. The exact solution is what errors are measured from, and
    choices are made on one mesh: neither is among them."""
    found: list[Point] = []
    for point in sorted((p for p in points if p.valid), key=lambda p: (p.seconds, p.error)):
        beats = not found or point.error < found[-1].error
        if beats and point.setting.kind != EXACT and not point.setting.choice:
            found.append(point)
    return found


def by_level(points: Sequence[Point]) -> list[dict[str, Any]]:
    """For each level of error, the key of the cheapest setting, and the cheapest point of each kind; None for none."""
    kinds = {kind: [p for p in points if p.setting.kind == kind] for kind in (ODE, MODAL, FE)}
    rows: list[dict[str, Any]] = []
    for level in LEVELS:
        best = cheapest(points, level)
        rows.append({"level": f"{level:.0e}", "key": best and best.setting.key})
        rows[-1] |= {kind: cheapest(its, level) for kind, its in kinds.items()}
    return rows


def quickest(points: Iterable[Point]) -> Point | None:
    """The cheapest finite-element setting with at most the power of ten next above the least error of them."""
    fe = [p for p in points if p.setting.kind == FE and p.valid]
    return cheapest(fe, 10.0 ** math.ceil(math.log10(min(p.error for p in fe)))) if fe else None


def order_of(points: Iterable[Point], known: float) -> float:
    """Observed order of the points of a group."""
    good = [p for p in points if math.isfinite(p.own_error)]
    return observed_order([p.setting.refinement for p in good], [p.own_error for p in good], known)


def cheapest(points: Iterable[Point], level: float) -> Point | None:
    """The cheapest valid point with at most this error."""
    good = [p for p in points if p.valid and p.error <= level]
    return min(good, key=lambda p: p.seconds, default=None)
