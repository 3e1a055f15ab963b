"""All points of the sweep, run on several processes, and what follows from them."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from postprocess.comparison import relative_difference
from postprocess.grid_convergence import SAFETY_FACTOR, grid_convergence
from tailslap.fe_plan import FePlan
from tailslap.plan import Plan
from tailslap.rigid import COMPARED, stage_two_numbers
from tailslap.studies.flexibility.levels import Level, PowerLaw, Sample, lowest_frequency, power_law
from tailslap.studies.flexibility.measure import Record, farthest, measure
from tailslap.studies.flexibility.sweep import (
    TOO_LONG,
    Calming,
    Sweep,
    define,
    expected_seconds,
    foretell,
    half_patch_tables,
    run_tables,
    thickness_places,
)
from tailslap.studies.journal import Journal
from tailslap.studies.parallel import run_parts

LEVELS = (1e-3, 1e-2, 5e-2, 1e-1)
"""Differences for which the lowest first frequency is sought."""

MOST_ORDER = 2.0
"""Order of convergence of linear elements and central differences."""

FLUTTER = "flutter"


@dataclass(frozen=True)
class Thickness:
    """The point once more by its thickness [m], at the scene's modulus: largest difference of the five quantities."""

    thickness: float
    apart: float


@dataclass(frozen=True)
class Point:
    """A plate of this first frequency [Hz]; E [Pa] and all numbers are of the finest mesh.

    difference: of the five quantities from the rigid ones; reaction, stored: see `measure`. errors: discretisation
    error of each of the seven, in their units, NaN where it is not known. modal: the modal model's differences.
    why: the checks that failed, or why there was no run. half_patch: the difference of v_GY with half the patch, NaN
    where that was not run.
    """

    frequency: float
    youngs_modulus: float
    difference: dict[str, float]
    reaction: float
    stored: float
    errors: dict[str, float]
    passed: bool
    why: str
    damping: float
    give: float
    modal: dict[str, float]
    modal_estimate: float
    modal_apart: float
    modal_why: str
    thickness: Thickness | None
    half_patch: float
    steps: int

    def size(self, name: str) -> float:
        """The difference from the rigid value: of the five quantities the relative one's size, else itself."""
        return getattr(self, name) if name in ("reaction", "stored") else abs(self.difference[name])


@dataclass(frozen=True)
class Survey:
    """The study: its definition, points from stiff to soft, and by quantity the levels and the power law."""

    sweep: Sweep
    points: tuple[Point, ...]
    levels: dict[str, tuple[Level, ...]]
    laws: dict[str, PowerLaw | None]
    calming: Calming
    seconds: float


def survey(plan: Plan, frequencies: tuple[float, ...], place: Path, workers: int | None) -> Survey:
    """Run every point; an interrupted survey of the same scene goes on from its journal beside `place`."""
    began = time.perf_counter()
    sweep, fe_plan = define(plan, frequencies)
    definition = {"study": "flexibility", "scene": plan.scene.model_dump(), "frequencies": frequencies}
    with Journal(place, definition) as journal:
        if FLUTTER not in journal.records:
            journal.add(FLUTTER, foretell(sweep))
        calming = Calming(**journal.records[FLUTTER])
        todo = _parts(sweep, fe_plan, calming)
        kept = {FLUTTER: (), **todo}  # known already, and counted as done
        run_parts(measure, kept, journal, f"{plan.scene.name}: {len(todo)} plates", workers)
        records = [journal.records[key] for key in todo]
    rigid = stage_two_numbers(plan)
    points = tuple(make_point(f, record, rigid) for f, record in zip(frequencies, records, strict=True))
    return summed_up(sweep, points, calming, time.perf_counter() - began)


def _parts(sweep: Sweep, fe_plan: FePlan, calming: Calming) -> dict[str, tuple[Any, ...]]:
    """Arguments of `measure` by key; a run that would take too long is left out."""
    own_damping, thin = sweep.plan.scene.damping, thickness_places(len(sweep.frequencies))
    parts, middle = {}, len(sweep.frequencies) // 2
    for number, frequency in enumerate(sweep.frequencies):
        tables = []
        for mesh in sweep.meshes:
            ratio = 0.0 if own_damping else calming.ratio(frequency, mesh[0])
            short = expected_seconds(sweep, fe_plan, frequency, mesh) <= TOO_LONG
            tables.append(run_tables(sweep, frequency, mesh, ratio) if short else None)
        modal = run_tables(sweep, frequency, sweep.meshes[-1])
        modal.pop("damping", None)
        finest = tables[-1]
        half = half_patch_tables(finest) if finest is not None and number == middle else None
        parts[f"{frequency!r} Hz"] = (tables, modal, sweep.own if number in thin else None, half)
    return parts


def make_point(frequency: float, record: Record, rigid: dict[str, float]) -> Point:
    """The point that a record of `measure` describes; rigid: the five quantities."""
    fine, modal = record["meshes"][-1], record["modal"]
    values, modal_values = fine.get("values", {}), modal.get("values", {})
    failed = fine.get("failed", [])
    nothing = dict.fromkeys(COMPARED, math.nan)
    return Point(
        frequency=frequency,
        youngs_modulus=fine.get("youngs_modulus", math.nan),
        difference=relative_difference(values, rigid) if values else nothing,
        reaction=fine.get("reaction", math.nan),
        stored=fine.get("stored", math.nan),
        errors=_errors(record["meshes"]),
        passed="refused" not in fine and not failed,
        why=fine.get("refused", ", ".join(failed)),
        damping=fine.get("damping", 0.0),
        give=fine.get("give", math.nan),
        modal=relative_difference(modal_values, rigid) if modal_values else nothing,
        modal_estimate=modal.get("estimate", math.nan),
        modal_apart=farthest(modal_values, values),
        modal_why=modal.get("refused", ", ".join(modal.get("failed", []))),
        thickness=_thickness(record),
        half_patch=_half_patch(record, rigid),
        steps=fine.get("steps", 0),
    )


def _errors(meshes: list[Record]) -> dict[str, float]:
    """Discretisation error of the finest mesh: its grid convergence index, of the quantity's own size.

    The five quantities' indices are relative, as their differences are; reaction and stored energy are shares already.
    """
    found = {}
    for name in (*COMPARED, "reaction", "stored"):
        values = [_value(mesh, name) for mesh in meshes]
        if not all(map(math.isfinite, values)) or 0.0 in values:
            found[name] = math.nan
            continue
        coarse, medium, fine = values
        index = convergence_index(fine, medium, coarse)
        found[name] = index * (1.0 if name in COMPARED else abs(fine))
    return found


def convergence_index(fine: float, medium: float, coarse: float) -> float:
    """Grid convergence index of the fine mesh; an observed order above that of the elements is luck, and not used."""
    found = grid_convergence((fine, medium, coarse), (2.0, 2.0))
    if found.behaviour != "converging" or found.order <= MOST_ORDER:
        return found.gci_fine
    return SAFETY_FACTOR * abs((fine - medium) / fine) / (2.0**MOST_ORDER - 1.0)


def _value(mesh: Record, name: str) -> float:
    values = mesh.get("values", {}) if name in COMPARED else mesh
    return float(values.get(name, math.nan))


def _thickness(record: Record) -> Thickness | None:
    found = record.get("thickness", {})
    if "thickness" not in found:
        return None
    return Thickness(found["thickness"], farthest(found["values"], record["meshes"][1]["values"]))


def _half_patch(record: Record, rigid: dict[str, float]) -> float:
    found = record.get("half_patch", {})
    good = found.get("values") and not found["failed"]
    return relative_difference(found["values"], rigid)["v_gy"] if good else math.nan


def samples(points: tuple[Point, ...], name: str) -> list[Sample]:
    """The points of one quantity as levels and power law take them."""
    return [Sample(p.frequency, p.size(name), p.errors[name], p.passed) for p in points]


def summed_up(sweep: Sweep, points: tuple[Point, ...], calming: Calming, seconds: float) -> Survey:
    """Levels and power laws of these points."""
    by_name = {name: samples(points, name) for name in (*COMPARED, "reaction", "stored")}
    levels = {
        name: tuple(lowest_frequency(by_name[name], level) for level in LEVELS)
        for name in (*COMPARED, "reaction")
    }
    laws = {name: power_law(found) for name, found in by_name.items()}
    return Survey(sweep, points, levels, laws, calming, seconds)
