"""The study of flexibility on whole impacts: both strikes of the plate against those of the rigid vehicle."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import Any

from tailslap.case.impact.case import ImpactCase
from tailslap.errors import InputError
from tailslap.execution.journal import Journal
from tailslap.execution.run_parts import run_parts
from tailslap.impact.checks import failed_but_mesh
from tailslap.impact.fe_plan import make_impact_fe_plan
from tailslap.impact.outcome import COMPARED
from tailslap.impact.run import run_impact
from tailslap.scene.vary import Changes, Source, vary
from tailslap.studies.flexibility.levels import Level, Sample, lowest_frequency
from tailslap.studies.study import Call

IMPACT_LEVELS = (1e-2, 5e-2, 1e-1)
"""Differences for which the lowest first frequency is sought."""

NAMES = tuple(f"strike_{k}.{name}" for k in (1, 2) for name in COMPARED)
"""What is measured, as `tailslap.impact.outcome` names it."""

PATCH = 0.1
"""Length of side that a corner's crush is spread over, over the vehicle's length, where the scene has none: a point has
no finite compliance, and meshes would not converge."""


@dataclass(frozen=True)
class ImpactPoint:
    """A plate: first frequency [Hz], FE/rigid - 1 and mesh error by `NAMES`, NaN where other corners strike; why:
    checks that failed, or what refused it."""

    frequency: float
    difference: dict[str, float]
    error: dict[str, float]
    why: str

    @property
    def passed(self) -> bool:
        """Whether its checks passed."""
        return not self.why

    def sample(self, name: str) -> Sample:
        """One of `NAMES` as the levels take it."""
        size, error = abs(self.difference[name]), abs(self.error[name])
        return Sample(self.frequency, size, error, self.passed and math.isfinite(size))

    @property
    def row(self) -> dict[str, Any]:
        """Its numbers by name."""
        differences = {f"difference.{name}": self.difference[name] for name in NAMES}
        errors = {f"error.{name}": self.error[name] for name in NAMES}
        return {"frequency": self.frequency, **differences, **errors, "failed": self.why}


@dataclass(frozen=True)
class ImpactFlexibility:
    """The finished study: plates from stiff to soft, levels by `NAMES`, the scene's own first frequency [Hz] and the
    length that a corner's crush is spread over [m]."""

    plan: ImpactCase
    points: tuple[ImpactPoint, ...]
    levels: dict[str, tuple[Level, ...]]
    own_frequency: float
    patch: float
    seconds: float

    @property
    def passed(self) -> bool:
        """Whether any plate passed its checks."""
        return any(point.passed for point in self.points)


def impact_flexibility(call: Call, frequencies: tuple[float, ...], workers: int | None) -> ImpactFlexibility:
    """Run every plate; an interrupted study of the same scene goes on from its journal. frequencies: falling [Hz]."""
    began, plan = time.perf_counter(), call.plan
    own = make_impact_fe_plan(plan)
    patch = patch_length(plan)
    fixed = {"plate.youngs_modulus": None, "contact.patch_length": patch, "plate.elements": own.plate.counts}
    definition = {"study": "flexibility", "scene": plan.scene.model_dump(), "frequencies": frequencies}
    with Journal(call.place, definition) as journal:
        parts = {f"{f!r} Hz": (plan.source, {**fixed, "plate.first_frequency": f}) for f in frequencies}
        run_parts(measure_impact, parts, journal, f"{plan.scene.name}: {len(parts)} plates", workers)
        records = [journal.records[key] for key in parts]
    points = tuple(ImpactPoint(f, **record) for f, record in zip(frequencies, records, strict=True))
    levels = {name: levels_of(points, name) for name in NAMES}
    return ImpactFlexibility(plan, points, levels, own.first_frequency, patch, time.perf_counter() - began)


def patch_length(plan: ImpactCase) -> float:
    """Length of side that a corner's crush is spread over [m]: the scene's, or the study's."""
    contact = plan.scene.contact
    return (contact.patch_length if contact else None) or PATCH * plan.vehicle.length


def levels_of(points: tuple[ImpactPoint, ...], name: str) -> tuple[Level, ...]:
    """What is known of each level of one of `NAMES`; points from stiff to soft."""
    samples = [point.sample(name) for point in points]
    return tuple(lowest_frequency(samples, level) for level in IMPACT_LEVELS)


def measure_impact(source: Source, changes: Changes) -> dict[str, Any]:
    """A plate's run as a record of the journal."""
    nothing = dict.fromkeys(NAMES, math.nan)
    try:
        outcome = run_impact(ImpactCase(*vary(source, changes)))
    except InputError as error:
        return {"difference": nothing, "error": nothing, "why": str(error)}
    return {
        "difference": nothing | outcome.difference,
        "error": nothing | outcome.mesh_error,
        "why": ", ".join(failed_but_mesh(outcome)),
    }
