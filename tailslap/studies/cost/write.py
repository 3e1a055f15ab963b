"""Writes the study's result folder: page, table of settings, summary."""

from __future__ import annotations

import csv
import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

import tailslap
from postprocess.curves import Curve
from postprocess.precision_plots import Diagram, draw_precision
from postprocess.study_page import StudyContent, StudySection, write_study_page
from postprocess.summary import write_summary
from tailslap.studies.cost.settings import FE
from tailslap.studies.cost.survey import CostSurvey, Point, cheapest, front
from tailslap.studies.cost.words import (
    LEVELS,
    all_table,
    convergence_sentences,
    convergence_tables,
    headline,
    level_table,
)

COLUMNS = (
    *("setting", "kind", "error", "from_limit", "setup_s", "loop_s", "median_s", "compile_s"),
    *("steps", "failed", "refused"),
)


def write_cost(found: CostSurvey, folder: Path) -> None:
    """Fill the folder: `report.html`, `settings.csv`, `summary.json`."""
    write_study_page(folder / "report.html", _content(found))
    with (folder / "settings.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        writer.writerows([_numbers(point)[name] for name in COLUMNS] for point in found.points)
    write_summary(folder / "summary.json", summary(found))


def summary(found: CostSurvey) -> dict[str, Any]:
    """The numbers of the study, SI."""
    fe = tuple(p for p in found.points if p.setting.kind == FE)
    return {
        "study": "cost",
        "scene": found.plan.scene.name,
        "version": tailslap.__version__,
        "points": [_numbers(point) for point in found.points],
        "front": [point.setting.key for point in front(found.points, "error")],
        "front_fe": [point.setting.key for point in front(fe, "error")],
        "front_from_limit": [point.setting.key for point in front(fe, "from_limit")],
        "cheapest": {f"{level:.0e}": _key(cheapest(found.points, level, "error")) for level in LEVELS},
        "limit": found.limit,
        "has_limit": found.has_limit,
        "convergence": {
            group: {name: asdict(grid) for name, grid in by_name.items()}
            for group, by_name in found.convergence.items()
        },
        "cost": {"seconds": found.seconds},
    }


def _numbers(point: Point) -> dict[str, Any]:
    return {
        **{name: getattr(point, name) for name in COLUMNS if hasattr(point, name)},
        "setting": point.setting.key,
        "kind": point.setting.kind,
        "failed": ", ".join(point.failed),
    }


def _key(point: Point | None) -> str | None:
    return point.setting.key if point else None


def _content(found: CostSurvey) -> StudyContent:
    plan = found.plan
    return StudyContent(
        kicker="Error against run time: every method and setting that the program has",
        scene=plan.scene.name,
        version=tailslap.__version__,
        headline=headline(found),
        sections=(
            StudySection(
                "Against the exact rigid motion",
                "Error: the largest relative difference of the five quantities at the tail-slap. The grey band is the "
                "Pareto front. Settings that failed a check are left out.",
                (_diagram(found, "error"),),
                (level_table(found, "error"),),
            ),
            StudySection(
                "Finite elements against their own limit",
                "The flexible plate's answer, extrapolated from three meshes with the exact constraint: what is left "
                "here is discretisation, not flexibility.",
                (_diagram(found, "from_limit"),),
                (level_table(found, "from_limit"),),
            ),
            StudySection(
                "Discretisation error",
                tables=convergence_tables(found),
                sentences=convergence_sentences(found),
            ),
            StudySection("Every setting", tables=(all_table(found),)),
        ),
        scene_text=plan.source.text,
        files="settings.csv, every setting with its numbers in SI; summary.json.",
    )


def _diagram(found: CostSurvey, by: str) -> Curve:
    """Rigid methods and all: whole time to the answer. Finite elements and modes among themselves: without set-up."""
    whole = by == "error"
    groups: dict[str, list[tuple[float, float, float]]] = {}
    for point in found.points:
        error, setup = getattr(point, by), point.setup_s if whole else 0.0
        if point.valid and math.isfinite(error) and error > 0.0:
            times = (setup + point.loop_s, setup + point.median_s)
            groups.setdefault(point.setting.group, []).append((*times, error))
    diagram = Diagram(
        name=f"precision-{by}",
        groups=groups,
        front=[(point.seconds, point.error) for point in front(found.points, by)] if whole else (),
        order=list(dict.fromkeys(point.setting.group for point in found.points)),
        time_label="Time to the answer, set-up included" if whole else "Time of integration",
        error_label="Error from the exact rigid motion" if whole else "Error from the FE's own limit",
    )
    return draw_precision(diagram)
