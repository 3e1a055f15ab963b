"""What the study of cost reports of a whole impact."""

from __future__ import annotations

import math
from typing import Any

from postprocess.figures.precision_plots import Diagram, Series, draw_precision
from postprocess.report.numbers import duration, known
from postprocess.report.page import Page, Section
from postprocess.report.report import Report
from postprocess.report.table import Column, Table, listed
from tailslap.report.footer import footer, study_summary
from tailslap.studies.cost.impacts import DAMPED, QUAD4, QUAD9, RIGID, ImpactCost
from tailslap.studies.cost.points import LEVELS, Point, cheapest, front, quickest
from tailslap.studies.cost.settings import ELEMENTS, STEP

LINES = {RIGID: RIGID, QUAD4: "meshes of quad4", QUAD9: "meshes of quad9", STEP: "time steps", DAMPED: DAMPED}
"""Groups that are lines; other elements are marks of one name."""

ERROR = known(".1e")
SETTINGS = (
    Column("setting.name", "setting"),
    Column("checks", "checks"),
    Column("error", "error", form=ERROR),
    Column("seconds", "time", form=duration),
    Column("loop_s", "of which loop", form=duration),
    Column("steps", "steps", form="d"),
)
BEST = (
    Column("level", "error at most", form=ERROR),
    Column("point.setting.name", "cheapest setting"),
    Column("point.error", "error", form=ERROR),
    Column("point.seconds", "time", form=duration),
)


def impact_cost_report(found: ImpactCost) -> Report:
    """Page, summary, points, and what the terminal says."""
    best = Table(BEST, _cheapest(found), "The cheapest setting")
    reading = (
        f"Error: largest of impulse, peak and duration of the first two strikes, from Richardson's extrapolation of "
        f"quad9, known to {found.limit.known:.0e}; smaller ones are shown as that. A corner's crush is spread over "
        f"{found.patch:g} m of its side. Times: the fastest of several, all compiled and loaded."
    )
    marks = {i: "marked" for i, point in enumerate(found.points) if point in front(found.points)}
    page = Page(
        kicker="Error against run time: settings of a whole impact",
        title=found.plan.scene.name,
        headline=headline(found),
        sections=(
            Section("Error against run time", "", draw_precision(diagram(found)), (best,), (reading,)),
            Section("Every setting", tables=(Table(SETTINGS, found.points, marks=marks),)),
        ),
        footer=footer("points.csv, every setting with its numbers in SI; summary.json"),
        scene_text=found.plan.source.text,
    )
    cost = f"Cost:   {len(found.points)} settings in {found.seconds:.0f} s"
    points = {"points.csv": listed([point.row for point in found.points])}
    return Report(page, summary(found), (best, page.headline, reading, cost), points)


def headline(found: ImpactCost) -> str:
    """What an error costs, and what the rigid vehicle's is."""
    rigid, best = found.points[0], quickest(found.points)
    spent = (
        f"within {best.error:.1e} in {duration(best.seconds)} ({best.setting.name})"
        if best
        else "to no limit"
    )
    return (
        f"Both strikes of the plate, by finite elements: {spent}. "
        f"The rigid vehicle is {rigid.error:.1e} off in {duration(rigid.seconds)}."
    )


def summary(found: ImpactCost) -> dict[str, Any]:
    """The numbers of the study, SI."""
    return {
        **study_summary("cost", found.plan),
        "points": [point.row for point in found.points],
        "front": [point.setting.key for point in front(found.points)],
        "cheapest": {f"{row['level']:.0e}": row["point"].setting.key for row in _cheapest(found)},
        "known": found.limit.known,
        "limit": found.limit.values,
        "patch_length": found.patch,
        "cost": {"seconds": found.seconds},
    }


def _cheapest(found: ImpactCost) -> list[dict[str, Any]]:
    """For each level of error that is reached, the cheapest setting."""
    rows = ({"level": level, "point": cheapest(found.points, level)} for level in LEVELS)
    return [row for row in rows if row["point"]]


def diagram(found: ImpactCost) -> Diagram:
    """Error against run time, by group."""
    others = [p for p in found.points if p.setting.group not in LINES]
    lines = [
        _series(label, [p for p in found.points if p.setting.group == group])
        for group, label in LINES.items()
    ]
    return Diagram(
        name="precision",
        title="How far from the plate's own limit",
        series=[*lines, _series(ELEMENTS, others, joined=False)],
        front=[(point.seconds, point.error) for point in front(found.points)],
        front_label="Pareto front",
        floor=found.limit.known,
        floor_label=f"the limit is known to {found.limit.known:.0e}",
        error_label="error of both strikes from the plate's limit",
    )


def _series(label: str, points: list[Point], joined: bool = True) -> Series:
    good = [point for point in points if math.isfinite(point.error)]
    passed = [point.valid for point in good]
    return Series(label, [p.seconds for p in good], [p.error for p in good], passed, joined)
