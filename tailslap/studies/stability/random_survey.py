"""The random survey: cells with all axes drawn together, run on several processes."""

from __future__ import annotations

import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from tailslap.planning.plan import Plan
from tailslap.studies.journal import Journal
from tailslap.studies.parallel import run_parts
from tailslap.studies.stability.axes import Tables, base_tables
from tailslap.studies.stability.draw import draw
from tailslap.studies.stability.random_verdict import KINDS, RandomVerdict, judge_draw


@dataclass(frozen=True)
class RandomSurvey:
    """The cells by number: their tables and verdicts; wall-clock time that it took [s]."""

    plan: Plan
    seed: int
    tables: dict[int, Tables]
    verdicts: dict[int, RandomVerdict]
    seconds: float

    @property
    def counts(self) -> dict[str, int]:
        """Number of cells by verdict."""
        found = Counter(verdict.kind for verdict in self.verdicts.values())
        return {kind: found[kind] for kind in KINDS}

    def of_kind(self, *kinds: str) -> dict[int, RandomVerdict]:
        """The cells with one of these verdicts."""
        return {number: verdict for number, verdict in self.verdicts.items() if verdict.kind in kinds}


def random_survey(plan: Plan, count: int, seed: int, place: Path, workers: int | None) -> RandomSurvey:
    """Judge the first `count` draws; an interrupted survey of the scene and seed goes on from its journal."""
    began, base = time.perf_counter(), base_tables(plan.scene)
    tables = {number: draw(base, seed, number) for number in range(count)}
    parts = {f"{number:04d}": (tables[number],) for number in tables}
    definition = {"study": "stability, random", "scene": base, "seed": seed}
    with Journal(place, definition) as journal:
        run_parts(judge_draw, parts, journal, f"{plan.scene.name}: {count} random cells", workers)
        verdicts = {number: RandomVerdict(**journal.records[f"{number:04d}"]) for number in tables}
    return RandomSurvey(plan, seed, tables, verdicts, time.perf_counter() - began)
