"""The campaign: cells, run on several processes and noted in a journal, and their verdicts."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from tailslap.errors import InputError
from tailslap.execution.journal import Journal
from tailslap.execution.run_parts import run_parts
from tailslap.studies.stability import against_reference, against_rigid
from tailslap.studies.stability.axes import (
    Axis,
    Cell,
    base_source,
    cell_key,
    impact_axes,
    map_cells,
    stability_axes,
)
from tailslap.studies.stability.draw import random_cells
from tailslap.studies.stability.verdict import CAUGHT, CORNERS, REFUSED, WRONG, Verdict, verdict_on
from tailslap.studies.study import Call

DEFAULTS, IMPACT_DEFAULTS = (10, 1e-3), (6, 1e-2)
"""Values of each axis, and tolerance, of a constrained corner and of a whole impact."""


@dataclass(frozen=True)
class Campaign:
    """Cells by key, and the verdict on each.

    Parameters
    ----------
    plan : Case
        The scene that they come from.
    axes : tuple of Axis
        Of the map; none where the cells are drawn at random.
    settings : mapping
        Points and tolerance of the map, or seed of the draws.
    kinds : mapping
        Kinds of verdicts and what they mean.
    cells, verdicts : mapping
        By key, in the same order.
    seconds : float
        Wall-clock time that it took [s].
    """

    plan: Any
    axes: tuple[Axis, ...]
    settings: Mapping[str, float]
    kinds: Mapping[str, str]
    cells: Mapping[str, Cell]
    verdicts: Mapping[str, Verdict]
    seconds: float

    @property
    def counts(self) -> dict[str, int]:
        """Number of cells by verdict."""
        found = Counter(verdict.kind for verdict in self.verdicts.values())
        return {kind: found[kind] for kind in self.kinds}

    @property
    def listed(self) -> tuple[str, ...]:
        """Kinds whose cells are listed; what is drawn is valid by itself, so that a refusal needs its reason."""
        kinds = (WRONG, against_reference.GOOD, against_reference.UNJUDGED)
        return kinds if self.axes else (*kinds, REFUSED)

    @property
    def caught_by(self) -> dict[str, int]:
        """How many cells each check caught, the most first."""
        caught = self.of_kind(CAUGHT).values()
        return dict(Counter(name for verdict in caught for name in verdict.failed.split(", ")).most_common())

    @property
    def refused_by(self) -> dict[str, int]:
        """How many cells were refused for what, the most first: the key and, unless it has numbers, what is allowed."""
        reasons = (verdict.reason.partition(": given ") for verdict in self.of_kind(REFUSED).values())
        pairs = ((key, rest.partition("; ")[2]) for key, _, rest in reasons)
        names = (key if any(map(str.isdigit, rest[:60])) else f"{key}: {rest}" for key, rest in pairs)
        return dict(Counter(names).most_common())

    def map_of(self, across: Axis, up: Axis) -> list[list[str]]:
        """Kinds of verdicts over two axes, rows up."""
        points = [[{across.name: x, up.name: y} for x in across.values] for y in up.values]
        return [[self.verdicts[cell_key(point)].kind for point in row] for row in points]

    def of_kind(self, *kinds: str) -> dict[str, Verdict]:
        """The cells with one of these verdicts."""
        return {key: verdict for key, verdict in self.verdicts.items() if verdict.kind in kinds}


def run_campaign(
    call: Call,
    points: int | None,
    tolerance: float | None,
    count: int | None,
    seed: int,
    workers: int | None,
) -> Campaign:
    """The map, or so many random cells; an interrupted campaign of the same scene goes on from its journal."""
    began, scene = time.perf_counter(), call.plan.scene
    impact = scene.contact is not None
    if impact and count:
        raise InputError("--random", count, "a whole impact has the map alone; leave it out")
    default = IMPACT_DEFAULTS if impact else DEFAULTS
    points, tolerance = points or default[0], tolerance or default[1]
    axes = () if count else (impact_axes if impact else stability_axes)(scene, points)
    verify: Callable[..., Verdict]
    settings: dict[str, Any]
    calculation = CORNERS
    if count:
        cells, kinds, verify = (
            random_cells(scene, seed, count),
            against_reference.KINDS,
            against_reference.against_reference,
        )
        settings = {"seed": seed}  # their number is left out: more cells go on from those there are
    else:
        cells, kinds = map_cells(scene, axes), against_rigid.KINDS
        verify = partial(against_rigid.against_rigid, tolerance=tolerance)
        if impact:
            from tailslap.studies.stability import impact_against_rigid

            verify = partial(impact_against_rigid.impact_against_rigid, tolerance=tolerance)
            calculation = impact_against_rigid.IMPACTS
        settings = {"points": points, "tolerance": tolerance}
    with Journal(
        call.place, {"study": "stability", "scene": base_source(scene).given, **settings}
    ) as journal:
        parts = {cell.key: (cell.base, cell.changes, verify, calculation) for cell in cells}
        run_parts(verdict_on, parts, journal, f"{scene.name}: {len(cells)} cells", workers)
        verdicts = {cell.key: Verdict(**journal.records[cell.key]) for cell in cells}
    seconds = time.perf_counter() - began
    return Campaign(call.plan, axes, settings, kinds, {cell.key: cell for cell in cells}, verdicts, seconds)
