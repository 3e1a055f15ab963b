"""All points of the sweep, run on several processes, and what follows from them."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from postprocess.comparison.comparison import KEYS
from tailslap.case.corner.case import CornerCase
from tailslap.execution.journal import Journal
from tailslap.execution.run_parts import run_parts
from tailslap.planning.fe_plan import FePlan
from tailslap.scene.vary import Changes
from tailslap.studies.flexibility.levels import Level, PowerLaw, Sample, jointly, lowest_frequency, power_law
from tailslap.studies.flexibility.measure import measure
from tailslap.studies.flexibility.points import MEASURED, Point, make_point
from tailslap.studies.flexibility.sweep import (
    STARTS,
    TOO_LONG,
    Sweep,
    define,
    expected_seconds,
    frequencies,
    run_changes,
    thickness_places,
)
from tailslap.studies.study import Call

if TYPE_CHECKING:
    from tailslap.studies.flexibility.impacts import ImpactFlexibility

LOWEST, IMPACT_LOWEST = "0.1 Hz", "2 Hz"
"""The softest plate of a constrained corner and of a whole impact."""

LEVELS = (1e-3, 1e-2, 5e-2, 1e-1)
"""Differences for which the lowest first frequency is sought."""

OTHERS = (*(name for name in KEYS if name != "v_gy"), "reaction")
"""Quantities beside v_GY whose levels are sought, of the first start."""


@dataclass(frozen=True)
class FlexibilityResults:
    """The study: its definition and points from stiff to soft.

    starts: the levels of v_GY's largest difference for each start; band: the same for all of them. others: the levels
    of the other quantities at the strike, and laws: the power law of each quantity, of the first start.
    """

    sweep: Sweep
    points: tuple[Point, ...]
    starts: dict[str, tuple[Level, ...]]
    band: tuple[Level, ...]
    others: dict[str, tuple[Level, ...]]
    laws: dict[str, PowerLaw | None]
    seconds: float

    @property
    def passed(self) -> bool:
        """Whether any plate passed its checks."""
        return any(point.passed for point in self.points)


def study_flexibility(
    call: Call, points: int, lowest: str | None, highest: str, workers: int | None
) -> FlexibilityResults | ImpactFlexibility:
    """The study as the command line asks for it."""
    if call.plan.scene.contact is not None:
        from tailslap.studies.flexibility.impacts import impact_flexibility

        return impact_flexibility(call, frequencies(lowest or IMPACT_LOWEST, highest, points), workers)
    return campaign(call.plan, frequencies(lowest or LOWEST, highest, points), call.place, workers)


def campaign(
    plan: CornerCase, frequencies: tuple[float, ...], place: Path, workers: int | None
) -> FlexibilityResults:
    """Run every point; an interrupted campaign of the same scene goes on from its journal beside `place`."""
    began = time.perf_counter()
    sweep, fe_plan = define(plan, frequencies)
    scene = plan.scene.model_dump()
    definition = {"study": "flexibility", "scene": scene, "frequencies": frequencies, "starts": STARTS}
    with Journal(place, definition) as journal:
        parts = _parts(sweep, fe_plan)
        run_parts(measure, parts, journal, f"{plan.scene.name}: {len(parts)} plates", workers)
        records = [journal.records[key] for key in parts]
    rigid = plan.tail_slap
    points = tuple(make_point(f, record, rigid) for f, record in zip(frequencies, records, strict=True))
    return summed_up(sweep, points, time.perf_counter() - began)


def _parts(sweep: Sweep, fe_plan: FePlan) -> dict[str, tuple[Any, ...]]:
    """Arguments of `measure` by key."""
    thin, middle = thickness_places(len(sweep.frequencies)), len(sweep.frequencies) // 2
    parts = {}
    for number, frequency in enumerate(sweep.frequencies):
        starts = {name: _runs(sweep, fe_plan, frequency, name) for name in STARTS}
        modal = {**run_changes(sweep, frequency, sweep.meshes[-1]), "damping": None}
        own = sweep.own if number in thin else None
        parts[f"{frequency!r} Hz"] = (sweep.plan.source, starts, modal, own, number == middle)
    return parts


def _runs(sweep: Sweep, fe_plan: FePlan, frequency: float, start: str) -> list[Changes | None]:
    """What a start's runs change, coarse to fine; one that would take too long is left out."""
    return [
        run_changes(sweep, frequency, mesh, start)
        if expected_seconds(sweep, fe_plan, frequency, mesh) <= TOO_LONG
        else None
        for mesh in sweep.meshes
    ]


def samples(points: tuple[Point, ...], name: str) -> list[Sample]:
    """The points of one quantity, at the strike of the first start, as levels and power law take them."""
    return [Sample(p.frequency, p.size(name), p.errors[name], p.passed) for p in points]


def start_samples(points: tuple[Point, ...], name: str) -> list[Sample]:
    """The largest difference of v_GY of one start, whatever the phase in which it strikes.

    Never less than that of a stiffer plate: where it changes its sign it is small for no reason that holds nearby.
    """
    found, largest = [], 0.0
    for point in points:
        start = point.starts[name]
        if start.passed:
            largest = max(largest, start.largest)
        found.append(Sample(point.frequency, largest, start.error, start.passed))
    return found


def summed_up(sweep: Sweep, points: tuple[Point, ...], seconds: float) -> FlexibilityResults:
    """Levels and power laws of these points."""
    starts = {name: _levels(start_samples(points, name)) for name in STARTS}
    band = tuple(jointly(each) for each in zip(*starts.values(), strict=True))
    others = {name: _levels(samples(points, name)) for name in OTHERS}
    laws = {name: power_law(samples(points, name)) for name in MEASURED}
    return FlexibilityResults(sweep, points, starts, band, others, laws, seconds)


def _levels(found: list[Sample]) -> tuple[Level, ...]:
    return tuple(lowest_frequency(found, level) for level in LEVELS)
