"""Writes the random survey's result folder: page, table of cells, summary, and scenes of the cells that matter."""

from __future__ import annotations

import csv
from collections import Counter
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import tailslap
from postprocess.files.summary import write_summary
from postprocess.pages.study_page import StudyContent, StudySection, StudyTable, write_study_page
from tailslap.studies.stability.axes import Tables
from tailslap.studies.stability.random_survey import RandomSurvey
from tailslap.studies.stability.random_verdict import CAUGHT, GOOD, WRONG, RandomVerdict
from tailslap.studies.stability.report.random_words import MEANINGS, SHOWN, headline, sentence
from tailslap.studies.stability.report.write import ADVISED
from tailslap.studies.stability.toml_text import toml_text
from tailslap.verification.checks import advice

VERDICT_COLUMNS = tuple(field.name for field in fields(RandomVerdict))


def write_random(found: RandomSurvey, folder: Path) -> None:
    """Fill the folder: `report.html`, `cells.csv`, `summary.json`, and `cell-NUMBER.toml` to run again."""
    write_study_page(folder / "report.html", _content(found))
    _write_cells(found, folder / "cells.csv")
    write_summary(folder / "summary.json", summary(found))
    for number, verdict in found.of_kind(WRONG, GOOD).items():
        write_cell(found, number, verdict, folder)


def write_cell(found: RandomSurvey, number: int, verdict: RandomVerdict, folder: Path) -> Path:
    """Write a cell as a scene file; returns its path."""
    path = folder / f"cell-{number:04d}.toml"
    title = f"Cell {number} of seed {found.seed} from {found.plan.scene.name}: {verdict.kind}, {sentence(verdict)}"
    path.write_text(toml_text(found.tables[number], title), encoding="utf-8")
    return path


def summary(found: RandomSurvey) -> dict[str, Any]:
    """The numbers of the survey."""
    listed = found.of_kind(*SHOWN)
    return {
        "study": "stability, random",
        "scene": found.plan.scene.name,
        "version": tailslap.__version__,
        "passed": not found.counts[WRONG],
        "seed": found.seed,
        "cells": len(found.verdicts),
        "counts": found.counts,
        "caught_by": dict(caught_by(found)),
        "listed": [{"cell": number, **asdict(verdict)} for number, verdict in listed.items()],
        "cost": {"seconds": found.seconds},
    }


def caught_by(found: RandomSurvey) -> list[tuple[str, int]]:
    """How many cells each check caught, the most first."""
    caught = found.of_kind(CAUGHT).values()
    return Counter(name for verdict in caught for name in verdict.failed.split(", ")).most_common()


def flat(tables: Tables) -> dict[str, Any]:
    """Keys of a scene with their table's name, and their values."""
    inner = {name: table for name, table in tables.items() if isinstance(table, dict)}
    return {f"{name}.{key}": value for name, table in inner.items() for key, value in table.items()}


def _write_cells(found: RandomSurvey, path: Path) -> None:
    drawn = {number: flat(tables) for number, tables in found.tables.items()}
    keys = sorted({key for row in drawn.values() for key in row})
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(("number", *VERDICT_COLUMNS, ADVISED, *keys))
        for number, verdict in found.verdicts.items():
            values = [drawn[number].get(key, "") for key in keys]
            writer.writerow((number, *asdict(verdict).values(), _advised(verdict), *values))


def _advised(verdict: RandomVerdict) -> str:
    return advice(verdict.failed.split(", ")) if verdict.kind == CAUGHT else ""


def _content(found: RandomSurvey) -> StudyContent:
    return StudyContent(
        kicker="Stability on scenes drawn at random: every quantity and every choice of the scene at once",
        scene=found.plan.scene.name,
        version=tailslap.__version__,
        headline=headline(found),
        sections=(_verdicts(found), _cells(found), _causes(found)),
        scene_text=found.plan.source.text,
        files="cells.csv, every draw with its verdict; cell-NUMBER.toml, scenes to run again; summary.json.",
        passed=not found.counts[WRONG],
    )


def _verdicts(found: RandomSurvey) -> StudySection:
    rows = tuple((kind, MEANINGS[kind], str(count)) for kind, count in found.counts.items())
    return StudySection("Verdicts", tables=(StudyTable(("verdict", "meaning", "cells"), rows, texts=2),))


def _cells(found: RandomSurvey) -> StudySection:
    columns = (
        "cell",
        "verdict",
        "failed checks, or refused by",
        "distance",
        "wrong from",
        "own estimate",
        "flexibility",
    )
    rows = tuple(
        (f"{number:04d}", verdict.kind, verdict.failed or "none", *_numbers(verdict))
        for number, verdict in found.of_kind(*SHOWN).items()
    )
    lead = "" if rows else "There are none."
    tables = (StudyTable(columns, rows, texts=3),) if rows else ()
    return StudySection("Cells that are wrong, good but failed, unjudged, or refused", lead, tables=tables)


def _numbers(verdict: RandomVerdict) -> tuple[str, ...]:
    values = (verdict.distance, verdict.allowed, verdict.error, verdict.reference)
    return tuple(f"{value:.1e}" for value in values)


def _causes(found: RandomSurvey) -> StudySection:
    rows = tuple((name, advice([name]), str(count)) for name, count in caught_by(found))
    columns = ("check", ADVISED, "cells")
    tables = (StudyTable(columns, rows, texts=2, note="A cell may fail several checks."),) if rows else ()
    return StudySection("Caught by", tables=tables)
