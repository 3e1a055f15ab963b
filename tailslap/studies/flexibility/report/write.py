"""Writes the study's result folder: page, table of points, summary."""

from __future__ import annotations

import csv
from dataclasses import asdict
from pathlib import Path
from typing import Any

import tailslap
from postprocess.files.summary import write_summary
from postprocess.pages.study_page import write_study_page
from tailslap.planning.rigid import COMPARED, stage_two_numbers
from tailslap.studies.flexibility.measure import KEPT
from tailslap.studies.flexibility.points import MEASURED, Point
from tailslap.studies.flexibility.report.page import content
from tailslap.studies.flexibility.report.words import headline
from tailslap.studies.flexibility.survey import Survey
from tailslap.studies.flexibility.sweep import STARTS


def write_flexibility(found: Survey, folder: Path) -> None:
    """Fill the folder: `report.html`, `points.csv`, `summary.json`."""
    write_study_page(folder / "report.html", content(found))
    rows = [_numbers(point) for point in found.points]
    with (folder / "points.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    write_summary(folder / "summary.json", summary(found))


def summary(found: Survey) -> dict[str, Any]:
    """The numbers of the study, SI; what is not known is None."""
    sweep = found.sweep
    return {
        "study": "flexibility",
        "scene": sweep.plan.scene.name,
        "version": tailslap.__version__,
        "passed": any(point.passed for point in found.points),
        "headline": headline(found),
        "rigid": stage_two_numbers(sweep.plan),
        "own_frequency": sweep.own_frequency,
        "corner": asdict(sweep.held),
        "meshes": sweep.meshes,
        "levels_v_gy": {name: list(map(asdict, levels)) for name, levels in found.starts.items()},
        "levels_v_gy_any_start": list(map(asdict, found.band)),
        "levels": {name: list(map(asdict, levels)) for name, levels in found.others.items()},
        "power_laws": {name: asdict(law) if law else None for name, law in found.laws.items()},
        "points": [_numbers(point) for point in found.points],
        "cost": {"seconds": found.seconds},
    }


def _numbers(point: Point) -> dict[str, Any]:
    """A point as a flat row."""
    pairs = {
        **{f"difference_{name}": point.difference[name] for name in COMPARED},
        "reaction_deviation": point.reaction,
        "stored_share": point.stored,
        **{f"error_{name}": point.errors[name] for name in MEASURED},
        **{f"modal_{name}": point.modal[name] for name in COMPARED},
    }
    thickness = point.thickness
    return {
        "first_frequency": point.frequency,
        "youngs_modulus": point.youngs_modulus,
        "passed": point.passed,
        "why": point.why,
        **pairs,
        "modal_estimate": point.modal_estimate,
        "modal_apart": point.modal_apart,
        "modal_why": point.modal_why,
        "damping_rate": point.damping,
        "give": point.give,
        "steps": point.steps,
        "half_patch_v_gy": point.half_patch,
        "thickness": thickness.thickness if thickness else None,
        "thickness_apart": thickness.apart if thickness else None,
        **{key: value for name in STARTS for key, value in _start_numbers(point, name).items()},
    }


def _start_numbers(point: Point, name: str) -> dict[str, Any]:
    """A start's v_GY and its departures, by column."""
    start = point.starts[name]
    numbers = {
        "v_gy": start.difference,
        "v_gy_largest": start.largest,
        "v_gy_error": start.error,
        **{f"{quantity}_at_start": start.departure[quantity] for quantity in KEPT},
        "damping_rate": start.damping,
        "passed": start.passed,
        "why": start.why,
    }
    return {f"{name}:{column}": number for column, number in numbers.items()}
