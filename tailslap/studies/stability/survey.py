"""All cells of the map, run on several processes."""

from __future__ import annotations

import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from tailslap.planning.plan import Plan
from tailslap.studies.journal import Journal
from tailslap.studies.parallel import run_parts
from tailslap.studies.stability.axes import Axis, Cell, base_tables, cell_tables, cells, stability_axes
from tailslap.studies.stability.verdict import KINDS, Verdict, judge


@dataclass(frozen=True)
class Survey:
    """The map: the axes, the verdict on every cell, and the wall-clock time that it took [s]."""

    plan: Plan
    tolerance: float
    axes: tuple[Axis, ...]
    verdicts: dict[Cell, Verdict]
    seconds: float

    @property
    def counts(self) -> dict[str, int]:
        """Number of cells by verdict."""
        found = Counter(verdict.kind for verdict in self.verdicts.values())
        return {kind: found[kind] for kind in KINDS}


def survey(plan: Plan, points: int, tolerance: float, place: Path, workers: int | None) -> Survey:
    """Judge every cell; an interrupted survey of the same scene goes on from its journal beside `place`."""
    began, base, axes = time.perf_counter(), base_tables(plan.scene), stability_axes(plan.scene, points)
    todo = cells(axes)
    parts = {cell.key: (cell_tables(base, axes, cell), tolerance) for cell in todo}
    definition = {"study": "stability", "scene": base, "points": points, "tolerance": tolerance}
    with Journal(place, definition) as journal:
        run_parts(judge, parts, journal, f"{plan.scene.name}: {len(todo)} cells", workers)
        verdicts = {cell: Verdict(**journal.records[cell.key]) for cell in todo}
    return Survey(plan, tolerance, axes, verdicts, time.perf_counter() - began)
