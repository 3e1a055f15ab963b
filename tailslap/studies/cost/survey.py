"""All settings measured, one after the other in one process, and what follows from them."""

from __future__ import annotations

import math
import statistics
import time
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

from postprocess.grid_convergence import GridConvergence, grid_convergence
from tailslap.plan import Plan
from tailslap.progress import progress_bar
from tailslap.rigid import COMPARED
from tailslap.studies.cost.measure import error_from, measure, rigid_truth
from tailslap.studies.cost.settings import (
    EXACT,
    FE,
    HOLD,
    MESH,
    MODAL,
    STEP,
    Setting,
    settings,
)
from tailslap.studies.journal import Journal

ROUNDING = 2.2e-12
"""What the exact solution is held to: its distance from DOP853, at most, over 1000 inputs (benchmarks/rigid.py)."""


@dataclass(frozen=True)
class Point:
    """A setting as measured. error: from the exact rigid motion; from_limit: from the FE's own limit, NaN for others.

    Times [s]: the fastest of several, and the median; compile_s apart. failed: names of the run's failed checks.
    """

    setting: Setting
    error: float
    from_limit: float
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
    """The study: the points, grid convergence of each quantity by group, and the FE's own limit."""

    plan: Plan
    points: tuple[Point, ...]
    convergence: dict[str, dict[str, GridConvergence]]
    limit: dict[str, float]
    has_limit: bool
    seconds: float


def survey(plan: Plan, name: str, changes: tuple[str, ...], place: Path) -> CostSurvey:
    """Measure every setting; an interrupted survey of the same scene goes on from its journal beside `place`."""
    began, todo = time.perf_counter(), settings(plan.scene)
    definition = {"study": "cost", "scene": plan.scene.model_dump(), "settings": [s.key for s in todo]}
    with (
        Journal(place, definition) as journal,
        progress_bar(f"{plan.scene.name}: {len(todo)} settings") as progress,
    ):
        for number, setting in enumerate(todo):
            if setting.key not in journal.records:
                journal.add(setting.key, measure(name, changes, setting))
            progress((number + 1) / len(todo))
        records = {setting.key: journal.records[setting.key] for setting in todo}
    convergence = _convergence(todo, records)
    limit, known = _limit(convergence, plan)
    points = tuple(_point(setting, records[setting.key], plan, limit) for setting in todo)
    return CostSurvey(plan, points, convergence, limit, known, time.perf_counter() - began)


def _convergence(todo: list[Setting], records: dict[str, Any]) -> dict[str, dict[str, GridConvergence]]:
    """By group, the three finest meshes or steps of each quantity."""
    found = {}
    for group in (MESH, HOLD, STEP):
        chosen = [records[setting.key] for setting in todo if _in_group(setting, group)]
        chosen = [r for r in chosen if "values" in r and all(map(math.isfinite, r["values"].values()))][-3:]
        if len(chosen) < 3 or (group == STEP and not _halved([record["steps"] for record in chosen])):
            continue
        coarse, medium, fine = (record["values"] for record in chosen)
        found[group] = {
            name: grid_convergence((fine[name], medium[name], coarse[name]), (2.0, 2.0)) for name in COMPARED
        }
    return found


def _in_group(setting: Setting, group: str) -> bool:
    if group == STEP:  # the scene's own step, and those that are halves of it
        return setting.group == STEP or (setting.group == MESH and setting.refinement == 1.0)
    return setting.group == group and setting.refinement >= 0.5


def _halved(steps: list[int]) -> bool:
    """Whether each has twice the steps of the last; on soft plates the least number of steps stands against it."""
    return all(abs(later / earlier - 2.0) < 0.02 for earlier, later in pairwise(steps))


def _limit(convergence: dict[str, dict[str, GridConvergence]], plan: Plan) -> tuple[dict[str, float], bool]:
    """Extrapolated values of the exact constraint's meshes, and whether v_GY, which moves most, converges."""
    by_name = convergence.get(HOLD) or convergence.get(MESH)
    if not by_name:
        return dict.fromkeys(COMPARED, math.nan), False
    converges = by_name["v_gy"].behaviour in ("converging", "settled")
    return {name: by_name[name].extrapolated for name in COMPARED}, converges


def _point(setting: Setting, record: dict[str, Any], plan: Plan, limit: dict[str, float]) -> Point:
    if "refused" in record:
        return Point(setting, math.nan, math.nan, 0.0, 0.0, 0.0, 0.0, 0, (), record["refused"])
    error = error_from(record["values"], rigid_truth(plan))
    if setting.kind == EXACT:
        error = max(error, ROUNDING)
    from_limit = error_from(record["values"], limit) if setting.kind in (FE, MODAL) else math.nan
    return Point(
        setting,
        error,
        from_limit if from_limit > 0.0 else math.nan,  # 0: the setting whose values stand for the limit
        min(record["setup"]),
        min(record["loop"]),
        statistics.median(record["loop"]),
        record.get("compile", 0.0),
        record["steps"],
        tuple(record["failed"]),
    )


def front(points: tuple[Point, ...], by: str) -> list[Point]:
    """The points that no other beats in both time and error; by: "error" or "from_limit"."""
    found: list[Point] = []
    for point in sorted((p for p in points if p.valid), key=lambda p: (p.seconds, getattr(p, by))):
        if math.isfinite(getattr(point, by)) and (not found or getattr(point, by) < getattr(found[-1], by)):
            found.append(point)
    return found


def cheapest(points: tuple[Point, ...], level: float, by: str) -> Point | None:
    """The cheapest valid point with at most this error."""
    good = [p for p in points if p.valid and getattr(p, by) <= level]
    return min(good, key=lambda p: p.seconds, default=None)
