"""The table of all settings."""

from __future__ import annotations

import math

from postprocess.pages.study_page import StudyTable
from tailslap.studies.cost.points import CostSurvey, Point, front
from tailslap.studies.cost.report.words import milliseconds


def all_table(found: CostSurvey) -> StudyTable:
    """Every setting; those on the Pareto front of the error from the rigid motion are set off."""
    best = {p.setting.key for points in (found.rigid, found.flexible) for p in front(points)}
    rows = tuple(_row(point) for point in found.points)
    marked = frozenset(i for i, point in enumerate(found.points) if point.setting.key in best)
    columns = (
        *("setting", "checks", "error", "added", "whole answer", "set-up", "loop", "loop, median"),
        *("compile", "steps"),
    )
    note = (
        "Error: of the scene as it is, from the exact rigid motion; of the soft plate, from its limit. Added: what a "
        "choice adds to its mesh's error. Whole answer: set-up and loop, the fastest of several, in a process that has "
        "all compiled and loaded. Set off: on the Pareto front of its question."
    )
    return StudyTable(columns, rows, texts=2, marked=marked, note=note)


def _row(point: Point) -> tuple[str, ...]:
    if point.refused:
        return (point.setting.key, "refused: " + point.refused[:90], *("–",) * 8)
    verdict = "failed: " + ", ".join(point.failed) if point.failed else "passed"
    times = (point.seconds, point.setup_s, point.loop_s, point.median_s, point.compile_s)
    shown = (milliseconds(value) if value else "–" for value in times)
    return (
        point.setting.key,
        verdict,
        _error(point.error),
        _error(point.added),
        *shown,
        str(point.steps or "–"),
    )


def _error(value: float) -> str:
    return f"{value:.1e}" if math.isfinite(value) else "–"
