"""The study's page: sections with their figures and tables."""

from __future__ import annotations

import tailslap
from postprocess.figures.flexibility_plots import DOTS, RINGS, SweepAxis, SweepLine, draw_sweep
from postprocess.figures.style import Curve
from postprocess.pages.study_page import StudyContent, StudySection
from tailslap.planning.rigid import COMPARED
from tailslap.studies.flexibility.report.tabulate import (
    kept_table,
    level_table,
    modal_table,
    motion_table,
    point_table,
    start_level_table,
    start_table,
    thickness_table,
)
from tailslap.studies.flexibility.report.words import MAIN, NAMES, START_NAMES, headline
from tailslap.studies.flexibility.statements import law_sentence, soft_sentence, statements
from tailslap.studies.flexibility.survey import LEVELS, Survey
from tailslap.studies.flexibility.sweep import STARTS

SIZE_LABEL = "size of the relative difference"


def content(found: Survey) -> StudyContent:
    """The page of the study."""
    plan = found.sweep.plan
    return StudyContent(
        kicker="Flexibility: how soft the vehicle may be for the rigid-body method to hold",
        scene=plan.scene.name,
        version=tailslap.__version__,
        headline=headline(found),
        sections=(
            _starts(found),
            _answer(found),
            _reading(found),
            _reaction(found),
            _modal(found),
            _points(found),
        ),
        scene_text=plan.source.text,
        files="points.csv, every plate with its numbers in SI; summary.json.",
        passed=any(point.passed for point in found.points),
    )


def _starts(found: Survey) -> StudySection:
    lead = (
        "What a soft plate keeps of the rigid body when Stage 2 begins is a choice, and part of the answer. The "
        "largest difference in v_GY until the strike, relative to v_GY at the strike, for three starts; dashed: the "
        "numerical error of each. Only what holds for all three is flexibility alone."
    )
    starts = {name: [point.starts[name] for point in found.points] for name in STARTS}
    lines = [
        SweepLine(
            START_NAMES[name],
            [start.largest for start in each],
            [start.error for start in each],
            passed=[start.passed for start in each],
        )
        for name, each in starts.items()
    ]
    caption = "v_GY from three starts: largest difference from the rigid body"
    passed = [any(start.passed for start in point.starts.values()) for point in found.points]
    figure = _draw(found, "starts", lines, SIZE_LABEL, caption, LEVELS, passed)
    return StudySection("Three starts", lead, (figure,), (start_level_table(found),))


def _answer(found: Survey) -> StudySection:
    lead = (
        "With inertia relief: relative difference of the flexible plate from the rigid body at the tail-slap. A solid "
        "line that lies well above its dashed one is no numerical error. A dip is a change of sign."
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
        "the ripple of the start, of the size of its numerical error, and no flexibility."
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
    tables = (
        start_table(found),
        kept_table(found),
        point_table(found),
        motion_table(found),
        thickness_table(found),
    )
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
    passed: list[bool] | None = None,
) -> Curve:
    """passed: of the points, where not those of the first start."""
    points = found.points
    passed = passed or [p.passed for p in points]
    axis = SweepAxis([p.frequency for p in points], passed, found.sweep.own_frequency)
    return draw_sweep(f"flexibility-{name}", axis, lines, label, caption, levels)
