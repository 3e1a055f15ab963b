"""Writes the study's result folder: page, table of cells, summary."""

from __future__ import annotations

import csv
from dataclasses import asdict, fields
from itertools import combinations
from pathlib import Path
from typing import Any

import tailslap
from postprocess.figures.map_plots import MapAxis, draw_legend, draw_map
from postprocess.figures.style import Curve
from postprocess.files.summary import write_summary
from postprocess.pages.study_page import StudyContent, StudySection, StudyTable, write_study_page
from tailslap.studies.stability.axes import Axis, Cell
from tailslap.studies.stability.report.words import MEANINGS, caught_alone, failed_checks, headline, refusals
from tailslap.studies.stability.survey import Survey
from tailslap.studies.stability.verdict import CAUGHT, WRONG, Verdict
from tailslap.verification.checks import advice

COLOUR_MEANINGS = {
    "right": "as the rigid motion",
    "flexible": "not rigid, confirmed by refinement",
    "refused": "wrong input, no run",
    "caught": "failed a check of its own",
    "wrong": "passed every check, and is not right",
}
"""What the colours of the maps mean, in few words."""

COLUMNS = tuple(field.name for field in fields(Verdict))
ADVISED = "what could be changed"


def write_map(found: Survey, folder: Path) -> None:
    """Fill the folder: `report.html`, `cells.csv`, `summary.json`."""
    write_study_page(folder / "report.html", _content(found))
    _write_cells(found, folder / "cells.csv")
    write_summary(folder / "summary.json", summary(found))


def summary(found: Survey) -> dict[str, Any]:
    """The numbers of the study."""
    wrong = [(cell, verdict) for cell, verdict in found.verdicts.items() if verdict.kind == WRONG]
    return {
        "study": "stability",
        "scene": found.plan.scene.name,
        "version": tailslap.__version__,
        "passed": not wrong,
        "tolerance": found.tolerance,
        "cells": len(found.verdicts),
        "counts": found.counts,
        "axes": [{"name": a.name, "meaning": a.meaning, "values": a.values} for a in found.axes],
        "caught_by": dict(failed_checks(found)),
        "wrong": [{"cell": cell.key, **asdict(verdict)} for cell, verdict in wrong],
        "cost": {"seconds": found.seconds},
    }


def _write_cells(found: Survey, path: Path) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(("first", "first_value", "second", "second_value", *COLUMNS, ADVISED))
        for cell, verdict in found.verdicts.items():
            x, y = cell.values
            told = advice(verdict.reason.split(", ")) if verdict.kind == CAUGHT else ""
            writer.writerow((cell.first, repr(x), cell.second, repr(y), *asdict(verdict).values(), told))


def _content(found: Survey) -> StudyContent:
    plan = found.plan
    return StudyContent(
        kicker="Stability on stiff and extreme cases: where the program is right, and where it says that it is not",
        scene=plan.scene.name,
        version=tailslap.__version__,
        headline=headline(found),
        sections=(_verdicts(found), _maps(found), _causes(found)),
        scene_text=plan.source.text,
        files="cells.csv, every cell with its verdict; summary.json.",
        passed=not found.counts[WRONG],
    )


def _verdicts(found: Survey) -> StudySection:
    rows = tuple((kind, MEANINGS[kind], str(count)) for kind, count in found.counts.items())
    axes = tuple((a.name, a.meaning, f"{a.values[0]:.3g} to {a.values[-1]:.3g}") for a in found.axes)
    tables = (
        StudyTable(("verdict", "meaning", "cells"), rows, texts=2),
        StudyTable(("axis", "what it is", "range"), axes, texts=2),
    )
    return StudySection("Verdicts", tables=tables)


def _maps(found: Survey) -> StudySection:
    legend = draw_legend(COLOUR_MEANINGS, "What the colours mean, in every picture.")
    figures = (legend, *(_map(found, *pair) for pair in combinations(found.axes, 2)))
    lead = "In each picture two quantities vary and the others are the scene's."
    return StudySection("A picture per pair of axes", lead, figures, narrow=True)


def _map(found: Survey, across: Axis, up: Axis) -> Curve:
    verdicts = [
        [found.verdicts[Cell(across.name, up.name, (x, y))].kind for x in across.values] for y in up.values
    ]
    columns, rows = (MapAxis(axis.meaning, axis.values) for axis in (across, up))
    name = f"map-{across.name}-{up.name}".replace(" ", "-")
    return draw_map(name, columns, rows, verdicts, f"{up.name} over {across.name}".capitalize())


def _causes(found: Survey) -> StudySection:
    alone = caught_alone(found)
    caught = tuple(
        (name, advice([name]), str(count), str(alone.get(name, 0))) for name, count in failed_checks(found)
    )
    refused = tuple((words, str(count)) for words, count in refusals(found))
    wrong = tuple((c.key, v.reason) for c, v in found.verdicts.items() if v.kind == WRONG)
    tables = (
        StudyTable(
            ("check", ADVISED, "cells", "alone"),
            caught,
            texts=2,
            title="Caught by",
            note="A cell may fail several checks.",
        ),
        StudyTable(("refused by", "cells"), refused, title="Refused by"),
        StudyTable(("cell", "why"), wrong, texts=2, title="Wrong and not caught"),
    )
    return StudySection("Why", tables=tuple(table for table in tables if table.rows))
