"""Tables, sections and pages of reports of runs and studies."""

from __future__ import annotations

import datetime
import math
from collections.abc import Mapping, Sequence
from typing import Any

import tailslap
from postprocess.report.page import Headline, Page, Section
from postprocess.report.tables import Column, Table, columns
from postprocess.signals.design_forces import BY_ACCELERATION, LRFD, DesignForce, design_forces
from postprocess.units import milliseconds, percent_up
from tailslap.case.case import Case
from tailslap.case.check import Check, printed_check
from tailslap.case.force_band import PERCENTILES, ForceBand, central_part
from tailslap.case.impact.answers import WEIGHT
from tailslap.errors import typed_command
from tailslap.scene.schema import Scene
from tailslap.scene.write import scene_text

DESIGN = (
    Column("name", "Design load", style="whole"),
    Column("force", "Lateral", "N", form="#.4g", style="strong"),
    Column("ratio", "50 ms mean / design", form=".2f"),
    *columns({"longitudinal": "Along", "vertical": "Vertical"}, unit="N", form="#.3g"),
    *columns({"height": "Height", "length": "Length"}, "m", form=".2f"),
    Column("moment", "Force times height", "N m", form="#.4g"),
    Column("source", "Source", style="soft"),
)
OF_SPACE = (
    "Ratios: the force in space over the design load. Its height is that of the resultant, its length that of a "
    "uniform force with the same standard deviation along the wall, as seen from the vehicle: without its travel "
    "in the 50 ms, and small for one upright strip. Along and vertical forces are at the same instant. "
    "Force, height and length are one load, as in Section 13 of AASHTO LRFD; force times height is its moment about "
    "the foot of the wall, and the largest moment governs the base."
)
INERTIAL = f"{BY_ACCELERATION} is mass times acceleration, and compares with the inertial estimate."
OUTSIDE_THE_PLANE = "Height, length and vertical force of this impact are outside the planar model."
CHECKS = (
    Column("name", "Check"),
    *columns({"value": "Value", "limit": "Limit"}, form=str),
    Column("passed", "Result", form=lambda passed: "passed" if passed else "failed", style="badge"),
    Column("meaning", "Meaning"),
)
FAILED = (
    Column("name", "Failed check"),
    Column("value", "Value", form=str, style="strong"),
    Column("limit", "Limit", form=str),
    Column("advice", "Remedy"),
)
TAIL_SLAP = (
    *columns({"quantity.title": "Quantity", "quantity.symbol": ""}),
    *columns({"fe": "FE", "rigid": "Rigid, exact"}, form="#.5g", unit_key="quantity.unit"),
    Column("quantity.unit", "Unit", is_unit=True),
    Column("difference", "FE/rigid − 1", form="+.1e", style="strong"),
)
"""Columns of the rows of `comparison_rows`."""

CALIBRATION = (
    Column("name", "Class"),
    *columns({"rows": "Values", "studies": "Studies"}, form="d"),
    *columns({"least": "Published over predicted, from", "most": "to", "factor": "Factor"}, form=".2f"),
    *columns({"rows_held": "Left-out values held", "studies_held": "Studies held"}, form="d"),
)
CALIBRATED = (
    f"Factor: on the logarithms of the band of the inputs, by split conformal prediction for {central_part()}, "
    "from nine values on. Left-out: each study in turn, by the factor of the others, or their largest score where they "
    "are fewer than nine; a study is held with all of its values. The 80 kip of TL-4 count twice, in the plane and in "
    "space.",
)
PUBLISHED = (
    Column("case", "Case", below=Column("source", "Source")),
    *columns({"label": "Quantity", "kind": "Compared"}),
    Column("space", "Motion", form=lambda space: "in space" if space else "in the plane"),
    Column("published", "Published", "N", form=".0f", style="strong"),
    Column("predicted", "Predicted", "N", form=".0f"),
    *columns({"lower": f"{PERCENTILES[0]:g} %", "upper": f"{PERCENTILES[-1]:g} %"}, "N", form=".0f"),
    Column("ratio", "Predicted over published", form=".2f"),
    Column("inside", "In the band", form=lambda inside: "yes" if inside else "no"),
)
STRIKES = (
    *columns({"title": "Strike", "model": "Model"}),
    *columns({"start": "Start", "duration": "Duration"}, unit="ms", form=milliseconds),
    Column("peak_force", "Peak", "N", form=".1f", style="strong"),
    Column("impulse", "Impulse", "N s", form=".2f"),
    Column("point_of_attack", "Resultant", "m", form="z.2f"),
)
OF_STRIKES = tuple(
    Column(f"error.{key}", label, form=percent_up, group="Stated error")
    for key, label in (("duration", "Duration"), ("peak_force", "Peak"), ("impulse", "Impulse"))
)
"""Columns of strikes in space in place of the last one."""
LIGHT = f"No error is stated of strikes below {100 * WEIGHT:g} % of the largest impulse."
ATTACK = "Resultant: distance of the resultant force behind the front bumper."
CUT = " (cut)"
AT_LEAST = "Cut: the strike continues beyond the end; its duration, peak force and impulse are lower bounds."
OF_TRACTORS = ("TL-5", "TL-6")
"""Test levels of tractors with trailers, whose design forces are listed together."""


def footer(files: str = "") -> str:
    """Return a page's version, date and command line.

    files: those beside the page.
    """
    command_line = typed_command()
    command = f"`{command_line}`" if command_line else "from Python"
    beside = f" Files beside this page: {files}." if files else ""
    return f"tailslap {tailslap.__version__}, {datetime.date.today().isoformat()}, {command}.{beside}"


def study_page(
    case: Case,
    kicker: str,
    headline: Headline,
    sections: Sequence[Section],
    files: str,
    passed: bool | None = None,
) -> Page:
    """Make the page of a case's study.

    files: those beside it; passed: None where nothing is checked.
    """
    sections = [Section("Set-up", figures=[case.drawing()]), *sections]
    return Page(kicker, headline, sections, footer(files), scene_text(case.source), passed)


def study_summary(study: str, case: Case) -> dict[str, object]:
    """Return the first entries of a study's summary."""
    return {"study": study, "scene": case.scene.name, "version": tailslap.__version__}


def design_forces_of(scene: Scene) -> dict[str, DesignForce]:
    """Return the design forces of a scene's test level by name.

    A tractor with trailer has those of both of its levels.
    """
    level, top = scene.impact and scene.impact.test_level, scene.wall.height if scene.wall else None
    levels = OF_TRACTORS if level in OF_TRACTORS else (level,) if level else ()
    return {
        f"{force.name}, {name}" if name in LRFD else force.name: force
        for name in levels
        for force in design_forces(name, top)
    }


def design_ratios(case: Case, lateral: float) -> list[dict[str, object]]:
    """Return a lateral force [N] over design forces.

    Over that by acceleration the inertial estimate, None without one.
    """
    computed = {False: lateral, True: case.inertial and case.inertial["mean_50ms"]}
    return [
        {
            **{"name": name, "force": design.force, "source": design.source},
            "ratio": (force := computed[design.is_inertial]) and force / design.force,
            **{
                key: getattr(design, key)
                for key in ("longitudinal", "vertical", "height", "length", "moment")
            },
        }
        for name, design in design_forces_of(case.scene).items()
    ]


def design_table(
    case: Case,
    lateral: float = math.nan,
    longitudinal: float | None = None,
    in_space: Mapping[str, Any] | None = None,
) -> Table:
    """Return a force [N] above the design loads of the test level.

    lateral, longitudinal: of a motion in the plane [N]; in_space: numbers of the vehicle in space, see
    `SpaceAnswer.numbers`.
    """
    computed = dict.fromkeys(column.key for column in DESIGN) | {
        "name": "This impact, 50 ms mean",
        "force": lateral,
        "longitudinal": longitudinal,
    }
    rows, loads = [computed], design_ratios(case, lateral)
    if in_space:
        largest, moment = in_space["force"], in_space["moment"]
        mean = largest["mean_50ms"]
        at_force = largest | {
            "force": mean,
            "moment": mean * largest["height"],
            "name": "In space, 50 ms mean",
        }
        at_moment = moment | {
            "moment": moment["mean_50ms"],
            "longitudinal": None,
            "name": "In space, largest moment",
        }
        companion = [] if math.isnan(lateral) else [computed | {"name": "Companion in the plane, 50 ms mean"}]
        rows = [computed | at_force, computed | at_moment, *companion]
        loads = design_ratios(case, mean)
    notes = [OF_SPACE if in_space else OUTSIDE_THE_PLANE]
    if any(BY_ACCELERATION in str(load["name"]) for load in loads):
        notes.append(INERTIAL)
        if case.inertial:
            place = ", assumed place" if case.inertial["assumed"] else ""
            row = {"name": f"Inertial estimate{place}", "force": case.inertial["mean_50ms"]}
            rows.append(dict.fromkeys(computed) | row)
    return Table(DESIGN, [*rows, *loads] if loads or in_space else [], notes=tuple(notes))


def published_section(band: ForceBand) -> Section:
    """Return the published values of a band's class, empty without any."""
    rows, of = band.published, band.calibration
    if not rows or not of:
        return Section("")
    inside = sum(row["inside"] for row in rows)
    lead = f"{inside} of {of.rows} published values of this class lie in the {central_part()} band of the inputs."
    lead += "" if of.factor else " They are too few for a calibrated band."
    tables = [Table(PUBLISHED, rows), Table(CALIBRATION, [of], notes=CALIBRATED)]
    return Section("Published values of this class", lead, tables=tables, is_folded=True, is_of_band=True)


def strikes_table(strikes: Mapping[str, Sequence[Mapping[str, Any]]]) -> Table:
    """Return the strikes of each model in order of time.

    strikes: by name of the model, as in the summary.
    """
    rows: list[dict[str, object]] = [
        {"point_of_attack": None, **strike, "model": model, "number": n}
        | {"title": f"{n} {strike['corner']}{CUT if strike.get('cut') else ''}"}
        for model, of_model in strikes.items()
        for n, strike in enumerate(of_model, 1)
    ]
    in_space = any("error" in row for row in rows)
    table = (*STRIKES[:-1], *OF_STRIKES) if in_space else STRIKES
    notes = (LIGHT if in_space else ATTACK, *([AT_LEAST] if any(row.get("cut") for row in rows) else []))
    return Table(table, sorted(rows, key=lambda row: row["number"]), notes=notes)


def short(table: Table) -> Table:
    """Return a table without moments and sources, too long for a terminal."""
    return Table(tuple(c for c in table.columns if c.key not in ("moment", "source")), table.rows)


def failed_section(checks: Sequence[Check], diagnosis: Sequence[str]) -> Section:
    """Return failed checks with remedies and diagnosis, empty without any."""
    rows = [printed_check(vars(check)) for check in checks if not check.passed]
    title, sentences = "Failed checks and remedies", diagnosis if rows else ()
    return Section(title, tables=[Table(FAILED, rows)], sentences=sentences)


def passed_text(checks: Sequence[Check]) -> str:
    """State the number of checks that passed."""
    return f"Checks: {sum(check.passed for check in checks)} of {len(checks)} passed"


def checks_section(checks: Sequence[Check], groups: Mapping[str, str]) -> Section:
    """Return all checks in tables by group.

    groups: title of the table of each check, by its name.
    """
    tables = []
    for title in dict.fromkeys(groups.get(check.name, "Others") for check in checks):
        group = [check for check in checks if groups.get(check.name, "Others") == title]
        marks = {number: "failed" for number, check in enumerate(group) if not check.passed}
        tables.append(Table(CHECKS, [printed_check(vars(check)) for check in group], title, marks=marks))
    return Section(passed_text(checks), tables=tables, is_folded=True)
