"""What the study of flexibility reports of whole impacts."""

from __future__ import annotations

import math
from typing import Any

from postprocess.figures.flexibility_plots import SweepAxis, SweepLine, draw_sweep
from postprocess.report.numbers import known
from postprocess.report.page import Section
from postprocess.report.report import Report
from postprocess.report.table import Column, Table, columns, listed
from postprocess.svg.chart import Chart
from tailslap.impact.rigid_text import rigid_numbers
from tailslap.report.common import study_page, study_summary
from tailslap.studies.flexibility.impacts import IMPACT_LEVELS, NAMES, ImpactFlexibility
from tailslap.studies.flexibility.levels import hertz

MAIN = "strike_2.impulse"
"""What the headline tells."""

SIZE = known("+.2e")
F1 = Column("frequency", "f_1", form=hertz)
WORDS = {
    f"strike_{k}.{name}": f"{which} strike's {word}"
    for k, which in ((1, "first"), (2, "second"))
    for name, word in (("impulse", "impulse"), ("peak_force", "peak"), ("duration", "duration"))
}
GOOD = (
    Column("what", "Off by at most"),
    *columns({f"levels.{i}.text": f"{100.0 * level:g} %" for i, level in enumerate(IMPACT_LEVELS)}, form=str),
)
POINTS = [
    Column(f"difference.{name}", WORDS[name], form=SIZE, below=Column(f"error.{name}", "", form=SIZE))
    for name in NAMES
]
READING = (
    "FE/rigid - 1 of each strike, the mesh's error below it: what elements of twice the order change. A plate whose "
    "first two strikes are not of the rigid vehicle's corners has no numbers. Levels: lowest first frequency down to "
    "which the difference stays below; <: at least down to there, >: not even there."
)


def impact_flexibility_report(found: ImpactFlexibility) -> Report:
    """Page, summary, points, and what the terminal says."""
    rows = [{"what": WORDS[name], "levels": found.levels[name]} for name in NAMES]
    good = Table(GOOD, rows, "The rigid vehicle is good down to a first frequency of")
    marks = {i: "failed" for i, point in enumerate(found.points) if not point.passed}
    numbers = [point.row for point in found.points]
    all_points = Table(
        (F1, *POINTS, Column("failed", "Checks failed")),
        numbers,
        "Differences of the two strikes",
        marks=marks,
    )
    page = study_page(
        found.plan,
        "Flexibility: how soft the vehicle may be for the rigid vehicle's strikes to hold",
        headline(found),
        (
            Section("Both strikes", "", (_figure(found),), (good,), (said(found), READING)),
            Section("Every plate", tables=(all_points,)),
        ),
        "points.csv, every plate with its numbers in SI; summary.json",
        found.passed,
    )
    cost = f"Cost:   {len(found.points)} plates in {found.seconds:.0f} s"
    tables = {"points.csv": listed(numbers)}
    return Report(page, summary(found), (page.headline, good, said(found), cost), tables)


def headline(found: ImpactFlexibility) -> str:
    """Down to which first frequency the second strike's impulse is the rigid vehicle's, and where the scene lies."""
    levels = found.levels[MAIN]
    each = ", ".join(f"to {100 * level.level:g} % down to {level.text}" for level in levels)
    return (
        f"The rigid vehicle's {WORDS[MAIN]} is that of the plate {each}. "
        f"The scene's own plate has {hertz(found.own_frequency)}."
    )


def said(found: ImpactFlexibility) -> str:
    """How the plates are modelled, and which failed."""
    failed = "; ".join(f"{hertz(point.frequency)}: {point.why}" for point in found.points if not point.passed)
    return f"A corner's crush is spread over {found.patch:g} m of its side. Failed: {failed or 'none'}."


def summary(found: ImpactFlexibility) -> dict[str, Any]:
    """The numbers of the study, SI; what is not known is None."""
    return {
        **study_summary("flexibility", found.plan),
        "passed": found.passed,
        "headline": headline(found),
        "rigid": rigid_numbers(found.plan),
        "own_frequency": found.own_frequency,
        "patch_length": found.patch,
        "levels": found.levels,
        "points": [point.row for point in found.points],
        "cost": {"seconds": found.seconds},
    }


def _figure(found: ImpactFlexibility) -> Chart:
    frequencies, passed = zip(*((point.frequency, point.passed) for point in found.points), strict=True)
    lines = [
        SweepLine(
            WORDS[name],
            [abs(point.difference[name]) for point in found.points],
            [abs(point.error[name]) for point in found.points],
        )
        for name in NAMES
    ]
    axis = SweepAxis(frequencies, passed, found.own_frequency if math.isfinite(found.own_frequency) else 0.0)
    caption = "Difference of plate and rigid vehicle in both strikes, over the plate's first frequency"
    return draw_sweep("flexibility-strikes", axis, lines, "|FE/rigid - 1|", caption, IMPACT_LEVELS)
