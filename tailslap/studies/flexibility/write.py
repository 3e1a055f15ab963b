"""Writes the study's result folder: page, table of points, summary."""

from __future__ import annotations

import csv
from dataclasses import asdict
from pathlib import Path
from typing import Any

import tailslap
from postprocess.curves import Curve
from postprocess.flexibility_plots import DOTS, RINGS, SweepAxis, SweepLine, draw_sweep
from postprocess.study_page import StudyContent, StudySection, write_study_page
from postprocess.summary import write_summary
from tailslap.rigid import COMPARED, stage_two_numbers
from tailslap.studies.flexibility.survey import LEVELS, Point, Survey
from tailslap.studies.flexibility.tabulate import (
    level_table,
    modal_table,
    motion_table,
    point_table,
    thickness_table,
)
from tailslap.studies.flexibility.words import MAIN, NAMES, headline, law_sentence, soft_sentence, statements

SIZE_LABEL = "size of the relative difference"

MEASURED = (*COMPARED, "reaction", "stored")


def write_flexibility(found: Survey, folder: Path) -> None:
    """Fill the folder: `report.html`, `points.csv`, `summary.json`."""
    write_study_page(folder / "report.html", _content(found))
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
        "levels": {name: [asdict(level) for level in levels] for name, levels in found.levels.items()},
        "power_laws": {name: asdict(law) if law else None for name, law in found.laws.items()},
        "flutter": asdict(found.calming),
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
        "damping_ratio": point.damping,
        "give": point.give,
        "steps": point.steps,
        "half_patch_v_gy": point.half_patch,
        "thickness": thickness.thickness if thickness else None,
        "thickness_apart": thickness.apart if thickness else None,
    }


def _content(found: Survey) -> StudyContent:
    plan = found.sweep.plan
    return StudyContent(
        kicker="Flexibility: how soft the vehicle may be for the rigid-body method to hold",
        scene=plan.scene.name,
        version=tailslap.__version__,
        headline=headline(found),
        sections=(_answer(found), _reading(found), _reaction(found), _modal(found), _points(found)),
        scene_text=plan.source.text,
        files="points.csv, every plate with its numbers in SI; summary.json.",
        passed=any(point.passed for point in found.points),
    )


def _answer(found: Survey) -> StudySection:
    lead = (
        "Relative difference of the flexible plate from the rigid body at the tail-slap, over the plate's first "
        "frequency in its plane. A solid line that lies well above its dashed one is flexibility; where they meet it "
        "would be the mesh. A dip is a change of sign."
    )
    caption = "Time of the strike, velocities of the centre of mass, angular velocity and slide"
    lines = [_line(found, name) for name in COMPARED]
    figure = _draw(found, "difference", lines, SIZE_LABEL, caption, LEVELS)
    return StudySection("Flexible against rigid", lead, (figure,), (level_table(found),))


def _reading(found: Survey) -> StudySection:
    return StudySection("What stands behind it", sentences=statements(found))


def _reaction(found: Survey) -> StudySection:
    lead = (
        "The reaction rings with the plate and is far more sensitive than the motion. On stiff plates what is left is "
        "the ripple of the start, of the size of its discretisation error, and no flexibility."
    )
    figures = (
        _draw(
            found,
            "reaction",
            [_line(found, "reaction")],
            "largest deviation over the rigid reaction",
            "Normal reaction of the wall",
        ),
        _draw(
            found,
            "stored",
            [_line(found, "stored")],
            "elastic over kinetic energy",
            "Largest elastic energy of the plate over its kinetic energy at the start",
        ),
    )
    return StudySection("Reaction and stored energy", lead, figures)


def _modal(found: Survey) -> StudySection:
    points = found.points
    lines = [
        SweepLine("v_GY, FE", [p.size(MAIN) for p in points], [p.errors[MAIN] for p in points]),
        SweepLine("v_GY, modal", [abs(p.modal[MAIN]) for p in points], form=RINGS),
        SweepLine("apart, largest of five", [p.modal_apart for p in points], form=DOTS),
        SweepLine("modal estimate", [p.modal_estimate for p in points], form=DOTS),
    ]
    lead = (
        "A second opinion, by another method: the same plate as a floating frame with its four lowest modes, whose "
        "geometry is linear, and which says itself how far it may be off."
    )
    caption = "v_GY by both methods, and how far the methods are apart"
    figure = _draw(found, "modal", lines, SIZE_LABEL, caption, LEVELS[:2])
    return StudySection("Modal model against finite elements", lead, (figure,), (modal_table(found),))


def _points(found: Survey) -> StudySection:
    tables = (point_table(found), motion_table(found), thickness_table(found))
    lead = f"{soft_sentence(found)} {law_sentence(found)} Plates set off failed a check."
    return StudySection("Every plate", lead, tables=tuple(table for table in tables if table.rows))


def _line(found: Survey, name: str) -> SweepLine:
    return SweepLine(
        NAMES[name], [p.size(name) for p in found.points], [p.errors[name] for p in found.points]
    )


def _draw(
    found: Survey,
    name: str,
    lines: list[SweepLine],
    label: str,
    caption: str,
    levels: tuple[float, ...] = (),
) -> Curve:
    points = found.points
    axis = SweepAxis([p.frequency for p in points], [p.passed for p in points], found.sweep.own_frequency)
    return draw_sweep(f"flexibility-{name}", axis, lines, label, caption, levels)
