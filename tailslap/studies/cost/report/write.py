"""Writes the study's result folder: page, table of points, summary."""

from __future__ import annotations

import csv
from dataclasses import asdict
from pathlib import Path
from typing import Any

import tailslap
from postprocess.figures.precision_plots import draw_precision
from postprocess.files.summary import write_summary
from postprocess.pages.study_page import StudyContent, StudySection, write_study_page
from tailslap.studies.cost.points import CostSurvey, Point, cheapest, front
from tailslap.studies.cost.report.all_settings import all_table
from tailslap.studies.cost.report.diagrams import flexible_diagram, rigid_diagram
from tailslap.studies.cost.report.words import (
    LEVELS,
    convergence_sentences,
    convergence_tables,
    headline,
    level_table,
    order_table,
    soft_sentences,
)
from tailslap.studies.cost.survey import ROUNDING

SETTING_COLUMNS = ("kind", "group", "label", "refinement", "soft", "choice")
COLUMNS = (
    *("setting", *SETTING_COLUMNS, "error", "added", "seconds", "setup_s", "loop_s", "median_s", "compile_s"),
    *("steps", "failed", "refused"),
)


def write_cost(found: CostSurvey, folder: Path) -> None:
    """Fill the folder: `report.html`, `points.csv`, `summary.json`."""
    write_study_page(folder / "report.html", _content(found))
    with (folder / "points.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerows(_numbers(point) for point in found.points)
    write_summary(folder / "summary.json", summary(found))


def summary(found: CostSurvey) -> dict[str, Any]:
    """The numbers of the study, SI."""
    questions = {"rigid": found.rigid, "flexible": found.flexible}
    return {
        "study": "cost",
        "scene": found.plan.scene.name,
        "version": tailslap.__version__,
        "points": [_numbers(point) for point in found.points],
        "front": {name: [point.setting.key for point in front(points)] for name, points in questions.items()},
        "cheapest": {
            name: {f"{level:.0e}": _key(cheapest(points, level)) for level in LEVELS}
            for name, points in questions.items()
        },
        "known": {"rigid": ROUNDING, "flexible": found.limit.known, "choices": found.mesh_limit.known},
        "soft_plate": {"changes": found.soft, "flexibility": found.flexibility, "limit": found.limit.values},
        "convergence": {
            group: {name: asdict(grid) for name, grid in by_name.items()}
            for group, by_name in found.convergence.items()
        },
        "cost": {"seconds": found.seconds},
    }


def _numbers(point: Point) -> dict[str, Any]:
    own = {name: getattr(point, name) for name in COLUMNS if hasattr(point, name)}
    return {
        **own,
        **{name: getattr(point.setting, name) for name in SETTING_COLUMNS},
        "setting": point.setting.key,
        "failed": ", ".join(point.failed),
    }


def _key(point: Point | None) -> str | None:
    return point.setting.key if point else None


def _content(found: CostSurvey) -> StudyContent:
    return StudyContent(
        kicker="Error against run time: every method and setting that the program has",
        scene=found.plan.scene.name,
        version=tailslap.__version__,
        headline=headline(found),
        sections=(
            _rigid(found),
            _flexible(found),
            StudySection(
                "Grid convergence",
                tables=convergence_tables(found),
                sentences=convergence_sentences(found),
            ),
            StudySection("Every setting", tables=(all_table(found),)),
        ),
        scene_text=found.plan.source.text,
        files="points.csv, every setting with its numbers in SI; summary.json.",
    )


def _rigid(found: CostSurvey) -> StudySection:
    lead = (
        "The scene as it is. Error: the largest relative difference of the five quantities at the tail-slap. Finite "
        "elements end on the plate's own flexibility, which no mesh takes away; panel (b) asks for that."
    )
    figure = draw_precision(rigid_diagram(found.points, ROUNDING))
    return StudySection("The rigid question", lead, (figure,), (level_table(found, soft=False),))


def _flexible(found: CostSurvey) -> StudySection:
    lead = (
        "A plate so soft that its flexibility is far above the errors of meshes, steps and springs: what is left here "
        "is discretisation, and falls with refinement."
    )
    figure = draw_precision(flexible_diagram(found.points, found.limit.known, found.mesh_limit.known))
    tables = (order_table(found), level_table(found, soft=True))
    return StudySection("The flexible question", lead, (figure,), tables, soft_sentences(found))
