"""All settings measured, one after the other in one process, and what follows from them."""

from __future__ import annotations

import math
import time
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

from postprocess.comparison.comparison import KEYS, largest_relative
from postprocess.comparison.grid_convergence import GridConvergence, grid_convergence
from tailslap.case.corner.case import CornerCase
from tailslap.execution.journal import Journal
from tailslap.execution.run_parts import run_parts
from tailslap.scene.vary import shown, vary
from tailslap.studies import with_elements
from tailslap.studies.cost.limits import Limit, limit_of
from tailslap.studies.cost.measure import Record, measure
from tailslap.studies.cost.points import CostResults, point_of
from tailslap.studies.cost.settings import MESH, STEP, Setting, settings
from tailslap.studies.cost.soft import soft_changes, soft_settings
from tailslap.studies.study import Call

if TYPE_CHECKING:
    from tailslap.studies.cost.impacts import ImpactCost

ROUNDING = 2.2e-12
"""What the exact solution is held to: its distance from DOP853, at most, over 1000 inputs (benchmarks/rigid.py)."""

SOFT_PLATE = "soft plate"
"""The journal's name for what makes the plate soft."""

SOFT_QUAD4, LIMIT, SOFT_STEP = "soft plate, quad4", "soft plate, quad9", "soft plate, time step"
"""Names of grid convergences on the soft plate; its limit is that of quad9."""


def study_cost(call: Call) -> CostResults | ImpactCost:
    """The study as the command line asks for it."""
    if call.plan.scene.contact:
        from tailslap.studies.cost.impacts import impact_cost

        return impact_cost(call)
    return campaign(with_elements(call.plan), call.place)


def campaign(plan: CornerCase, place: Path) -> CostResults:
    """Measure every setting; an interrupted campaign of the same scene goes on from its journal beside `place`."""
    began, todo = time.perf_counter(), [*settings(plan.scene), *soft_settings(plan.scene)]
    definition = {"study": "cost", "scene": plan.scene.model_dump(), "settings": [s.key for s in todo]}
    with Journal(place, definition) as journal:
        if SOFT_PLATE not in journal.records:
            journal.add(SOFT_PLATE, soft_changes(plan))
        changes = journal.records[SOFT_PLATE]
        soft_scene, soft = vary(plan.source, changes)
        parts = {s.key: (soft if s.soft else plan.source, s) for s in todo}
        # One after the other: they are timed.
        run_parts(measure, parts, journal, f"{plan.scene.name}: {len(todo)} settings", workers=1)
        records = {setting.key: journal.records[setting.key] for setting in todo}
    soft_truth = CornerCase(soft_scene, soft).tail_slap
    return summed_up(plan, todo, records, shown(changes), soft_truth, time.perf_counter() - began)


def summed_up(
    plan: CornerCase,
    todo: list[Setting],
    records: dict[str, Record],
    soft: tuple[str, ...],
    soft_truth: dict[str, float],
    seconds: float,
) -> CostResults:
    """What the records say; soft_truth: the rigid motion of the soft plate's scene."""
    limit = limit_of([records[s.key] for s in todo if in_group(s, LIMIT)])
    steps = [records[s.key] for s in todo if in_group(s, SOFT_STEP)]
    mesh_limit = limit_of(steps if _halved(steps) else [])
    rigid = Limit(plan.tail_slap, ROUNDING)
    return CostResults(
        plan=plan,
        points=tuple(point_of(s, records[s.key], limit if s.soft else rigid, mesh_limit) for s in todo),
        convergence=_convergence(todo, records),
        soft=soft,
        limit=limit,
        mesh_limit=mesh_limit,
        flexibility=largest_relative(limit.values, soft_truth),
        seconds=seconds,
    )


def _convergence(todo: list[Setting], records: dict[str, Record]) -> dict[str, dict[str, GridConvergence]]:
    """By group, the three finest meshes or steps of each quantity."""
    found = {}
    for group in (MESH, STEP, SOFT_QUAD4, LIMIT, SOFT_STEP):
        chosen = [records[setting.key] for setting in todo if in_group(setting, group)]
        chosen = [r for r in chosen if "values" in r and all(map(math.isfinite, r["values"].values()))][-3:]
        if len(chosen) < 3 or (group in (STEP, SOFT_STEP) and not _halved(chosen)):
            continue
        coarse, medium, fine = (record["values"] for record in chosen)
        found[group] = {
            name: grid_convergence((fine[name], medium[name], coarse[name]), (2.0, 2.0)) for name in KEYS
        }
    return found


def in_group(setting: Setting, group: str) -> bool:
    """Whether a setting is one of those that a grid convergence is read off."""
    if group in (SOFT_QUAD4, LIMIT, SOFT_STEP):
        return setting.soft and group == f"{SOFT_PLATE}, {setting.group}"
    if setting.soft:
        return False
    if group == STEP:  # the scene's own step, and those that are halves of it
        return setting.group == STEP or (setting.group == MESH and setting.refinement == 1.0)
    return setting.group == group and setting.refinement >= 0.5


def _halved(records: list[Record]) -> bool:
    """Whether of the last three each has twice the steps of the one before; on soft plates the least number of steps
    may stand against it."""
    steps = [record.get("steps", 0) for record in records[-3:]]
    return all(earlier and abs(later / earlier - 2.0) < 0.02 for earlier, later in pairwise(steps))
