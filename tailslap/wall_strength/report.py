"""Report of the strength of a parapet beside the force."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np

import tailslap
from postprocess.report.command_report import Report
from postprocess.report.page import Headline, Page, Section
from postprocess.report.tables import Column, Table, columns
from postprocess.units import force as force_text
from postprocess.units import measure
from solver.parapet import Strengths, overhang_tension, punching
from tailslap.arguments import checked_arguments
from tailslap.case.case import Case
from tailslap.case.force_band import ForceBand, fraction_in_words
from tailslap.case.of_arguments import Changes, Scene, case_of_scene
from tailslap.case.report_parts import design_forces_of, footer, published_section
from tailslap.result.result import Result, filled_by, of_report
from tailslap.scene.parapet_keys import load_length_of, parapet_of, strengths_of
from tailslap.scene.write import scene_text
from tailslap.validation.calibration import calibrated_band
from tailslap.wall_strength.pictures import with_pictures
from tailslap.wall_strength.strength import TOLERANCE, Computed, Load, bounds_of

PATCH_HEIGHT = 0.3048
"""Height of the patch of the load for punching, assumed [m]."""

ALLOWED = {"code": TOLERANCE, "this impact": 2.0 * TOLERANCE}
"""Largest difference of the bounds by load; the force of the impact is less certain [-]."""

LEFT_OUT = (
    "Omitted: anchorage of the bars, the interface to the deck, membrane action, ductility, rate and inertia."
)
MEANING = (
    "All values are the flexural strength of the wall as a plate fixed at the deck. A13.3.1 is the load of one "
    "mechanism for a load at the top, an upper bound of that plate with one strength for both signs. AASHTO's loads "
    "and procedures are calibrated together: a value of A13.3.1 above the bounds does not mean that the code is unsafe."
)
STRENGTH = (
    *columns({"load_name": "Load", "place": "Place"}),
    *columns({"length": "Length", "height": "Height"}, unit="m", form=".3f"),
    *columns({"lower": "Lower bound", "upper": "Upper bound"}, unit="N", form="#.4g", style="strong"),
    Column(
        "width",
        "Difference",
        form=lambda width: f"{100.0 * width:.2f} %" if math.isfinite(width) else "no proof",
    ),
    Column("force", "A13.3.1", "N", form="#.4g"),
    Column("critical_length", "L_c", "m", form=".2f"),
)
DEMAND = (
    *columns({"load": "Demand", "place": "Place"}),
    Column("force", "Force", "N", form="#.4g", style="strong"),
    *columns(
        {"lower": "over lower bound", "upper": "over upper bound", "aashto": "over A13.3.1"}, form=".2f"
    ),
)
SIMPLE = (
    Column("name", "Simple formula"),
    Column("value", "Value", form="#.4g", unit_key="unit", style="strong"),
    Column("unit", "Unit", is_unit=True),
    Column("source", "Formula and source", style="soft"),
)


@checked_arguments
def parapet(scene: Scene, changes: Changes | None = None, *, band: bool = True) -> Result:
    """Compute the strength of the parapet beside the force.

    Parameters
    ----------
    scene : str, path or mapping
        Name of a scene of the program, path of a TOML file, or tables of a scene, with [parapet].
    changes : mapping or sequence of str, optional
        Values by dotted key, or texts KEY=VALUE.
    band : bool
        Compute the band of the force over varied inputs.

    Returns
    -------
    Result
        `summary["parapet"]` contains A13.3.1, both bounds and the demand over capacity [N, m].

    Raises
    ------
    InputError
        For an invalid scene, key or value, and a scene without [parapet].

    Examples
    --------
    >>> import tailslap
    >>> result = tailslap.parapet("impact-parapet-tl4-sut", band=False)
    >>> result.passed, result.summary["parapet"]["lower"]["interior"] > 2.9e5
    (True, True)
    """
    case, began = case_of_scene(scene, changes), time.perf_counter()
    rows = strengths_of_loads(case)
    distribution = calibrated_band(case) if band else ForceBand(refusal="not requested")
    report = _report(case, rows, distribution, began)

    def drawn(folder: Path, pictures: bool, units: str) -> Report:
        return with_pictures(report, rows, folder) if pictures else report

    result = of_report("parapet", report, changes=case.changes)
    return result.__class__(**{**vars(result), "fill": filled_by(drawn)})


def strengths_of_loads(case: Case) -> list[Computed]:
    """Return strengths under the code's load and that of this impact."""
    table = parapet_of(case.scene)
    strengths, length = strengths_of(table), table.length or math.inf
    loads = {"code": (load_length_of(case.scene, table), table.load_height or table.height)}
    if impact := _impact(case)[1:]:
        loads["this impact"] = impact[0], impact[1]
    places = {"interior": None, "end": 0.0} if table.end_distance is None else {"impact": table.end_distance}
    rows = []
    for name, (load_length, height) in loads.items():
        for place, distance in places.items():
            room = length - 2.0 * (distance or 0.0)
            load = Load(min(load_length, room), min(height, table.height), distance)
            bounds = bounds_of(strengths, load, length, ALLOWED[name])
            formula = strengths.resistance(load.length, "end" if distance == 0.0 else "interior")
            rows.append(Computed(name, place, load, bounds, formula))
    return rows


def _impact(case: Any) -> tuple[float, ...]:
    """Return the force [N], and in space its length and height [m]."""
    if case.scene.contact is None:
        return (float(case.rigid_numbers()["stage3"]["peak_force"]),)
    if case.space is None:
        return (float(case.answer.peaks["mean_50ms"]),)
    numbers = case.space.numbers()["force"]
    return (
        float(numbers["mean_50ms"]),
        max(float(numbers["length"]), 0.05),
        max(float(numbers["height"]), 0.05),
    )


def nominal_force(case: Case) -> float:
    """Return the force of the impact [N]."""
    return _impact(case)[0]


def _report(case: Case, rows: list[Computed], band: ForceBand, began: float) -> Report:
    """Return the report without pictures."""
    table = parapet_of(case.scene)
    strengths, demand = strengths_of(table), nominal_force(case)
    of_impact = [row for row in rows if row.load_name != "code"] or rows
    ratio = _ratio(of_impact[0].lower, demand, band)
    passed = all(row.bounds.width <= ALLOWED[row.load_name] for row in rows)
    shortest = _turning_length(strengths, rows[0], table.length or math.inf)
    numbers = {"turning_length": shortest or None} | _numbers(rows, strengths, demand, ratio)
    bands = tuple(
        f"This impact, {row.where}, over the lower bound: {_band_words(_ratio(row.lower, demand, band), band)}."
        for row in of_impact
        if band.percentiles and row.lower
    )
    tables = [
        Table(STRENGTH, [_strength_row(row) for row in rows], "Strength", notes=(MEANING,)),
        Table(DEMAND, _demand_rows(case, rows, of_impact, demand), "Demand over capacity", notes=bands),
        Table(SIMPLE, _simple_rows(case, strengths, rows, shortest), "Beside it"),
    ]
    headline = _headline(case, rows, of_impact, demand, ratio, band)
    residual = max(row.bounds.lower.residual for row in rows)
    method = [
        "Lower bound: linear moments in equilibrium, within Johansen's criterion of both signs and directions; "
        f"residual of equilibrium {residual:.1e} of the strength, no excess. Upper bound: cubic mechanism, its "
        f"dissipation computed again. Up to {max(row.bounds.upper_mesh.t.shape[1] for row in rows)} triangles, refined "
        f"until both differ by at most {100.0 * TOLERANCE:g} %, {100.0 * ALLOWED['this impact']:g} % of this impact; "
        f"{time.perf_counter() - began:.1f} s.",
        "Place: interior, the middle of the wall; end, the load begins at the end or joint. "
        "The capacity of this impact is that at the height and length of the nominal force; its band is that of "
        "the force.",
        LEFT_OUT,
    ]
    sections = (
        Section("Strength and demand", tables=tables),
        published_section(band),
        Section("Method and omitted effects", sentences=method),
    )
    kicker = "Flexural strength of the plate between proven bounds"
    page = Page(kicker, headline, sections, footer("summary.json (SI)"), scene_text(case.source), passed)
    summary = {
        "scene": case.scene.name,
        "version": tailslap.__version__,
        "passed": passed,
        "parapet": numbers,
    }
    return Report(page, summary, (*tables, LEFT_OUT))


def _strength_row(row: Computed) -> dict[str, object]:
    """Return a row of the table of strengths."""
    bounds = {"lower": row.lower, "upper": row.upper, "width": row.bounds.width}
    return row._asdict() | row.load._asdict() | row.formula._asdict() | bounds


def _demand_rows(
    case: Case, rows: list[Computed], of_impact: list[Computed], demand: float
) -> list[dict[str, object]]:
    """Return the rows of this impact and of the design loads."""
    demands = [("this impact", demand, row) for row in of_impact]
    code = [row for row in rows if row.load_name == "code"]
    demands += [
        (name, design.force, row) for name, design in design_forces_of(case.scene).items() for row in code
    ]
    return [
        {
            "load": name,
            "place": row.where,
            "force": force,
            "lower": force / row.lower if row.lower else None,
            "upper": force / row.upper if row.upper else None,
            "aashto": force / row.formula.force,
        }
        for name, force, row in demands
    ]


def _ratio(capacity: float | None, demand: float, band: ForceBand) -> dict[str, float | None]:
    """Return the demand over capacity with its band."""
    values: list[float] = []
    if capacity is not None:
        above = [float(np.mean(np.array(band.calibrated(band.forces)) > capacity))] if band.forces else []
        values = [force / capacity for force in (demand, *band.limits)] + above
    return dict(zip_longest(("nominal", "lower", "median", "upper", "exceeded"), values))


def _band_words(ratio: dict[str, float | None], band: ForceBand) -> str:
    """Return a band and the fraction above capacity in words."""
    exceeded = fraction_in_words(ratio["exceeded"] or 0.0, band.samples)
    return (
        f"{ratio['lower']:.2f} to {ratio['upper']:.2f}, median {ratio['median']:.2f}: exceeded in {exceeded}"
    )


def _headline(
    case: Case,
    rows: list[Computed],
    of_impact: list[Computed],
    demand: float,
    ratio: dict[str, Any],
    band: ForceBand,
) -> Headline:
    """Return strength, demand and proof in sentences."""
    code = [row for row in rows if row.load_name == "code"]
    parts = []
    for row in code:
        proven = "not proven"
        if row.lower and row.upper:
            proven = f"{force_text(row.lower)} to {force_text(row.upper)}"
        parts.append(f"{row.where} {proven} (A13.3.1: {force_text(row.formula.force)})")
    first = of_impact[0]
    nominal = (
        f"{ratio['nominal']:.2f} of the lower bound, {first.where}"
        if ratio["nominal"]
        else "without proven capacity"
    )
    varied = f"; {band.name}: {_band_words(ratio, band)}" if ratio["median"] else ""
    answer = (
        f"Flexural strength of the plate, load at {measure(code[0].load.height, 'm', '.2f')}: {', '.join(parts)}. "
        f"Force of this impact {force_text(demand)}, at {measure(first.load.height, 'm', '.2f')}: {nominal}{varied}."
    )
    wide = [row for row in rows if not row.bounds.width <= ALLOWED[row.load_name]]
    certainty = (
        f"Both bounds are proven and differ by at most {100.0 * max(row.bounds.width for row in rows):.2f} %."
    )
    if wide:
        certainty = f"Failed check: the bounds of {len(wide)} loads are without proof or too far apart."
    return Headline(f"Strength of the parapet: {case.subject}", answer, case.set_up, certainty, band.sentence)


def _turning_length(strengths: Strengths, row: Computed, length: float) -> float:
    """Return the length below which a wall turns over [m].

    The load is in its middle. row: strength of a wall of `length`; 0 without proof.
    """
    per_length, bounds = float(strengths.moments[2, 0]) / row.load.height, row.bounds
    if row.place != "interior" or bounds.lower.value > (1.0 - TOLERANCE) * per_length * length:
        bounds = bounds_of(strengths, row.load._replace(end_distance=None), tolerance=2.0 * TOLERANCE)
    return bounds.lower.value / per_length


def _simple_rows(
    case: Any, strengths: Strengths, rows: list[Computed], shortest: float
) -> list[dict[str, object]]:
    """Return punching, deck overhang and moment of the impact by simple formulas."""
    table, first = parapet_of(case.scene), rows[0]
    governing = [row.lower for row in rows if row.load_name == "code" and row.lower]
    tension = overhang_tension(first.formula.force, first.formula.critical_length, strengths.height)
    items: list[tuple[str, float, str, str]] = [
        ("M_c, moment of the deck overhang", strengths.base, "N m/m", "mean over the height; A13.4.2"),
        ("T, tension of the deck overhang", tension / 1e3, "kN/m", "R_w/(L_c + 2 H); Eq. A13.4.2-1"),
    ]
    if shortest:
        formula = "lower bound of a long wall times height over M_c at the base"
        items.append(("length below which the wall turns over", shortest, "m", formula))
    if case.scene.body:
        moment = case.space.numbers()["moment"]
        at = f"{moment['force'] / 1e3:.4g} kN at {moment['height']:.2f} m over {moment['length']:.2f} m"
        items.append(
            ("moment of this impact at the foot", moment["mean_50ms"], "N m", f"largest 50 ms mean: {at}")
        )
    if table.section:
        depth = table.section.thickness[-1][1] - table.section.cover
        shear = punching(table.section.concrete_strength, depth, first.load.length, PATCH_HEIGHT)
        formula = f"v_c b_0 d, b_0 = L_t + d + 2 (h + d/2), h = {PATCH_HEIGHT:.3f} m assumed; v_c of Eq. A13.4.3.2-3"
        items.append(("punching at the top", shear, "N", formula))
        if governing:
            items.append(("smaller of punching and lower bound", min(shear, *governing), "N", "governs"))
    return [dict(zip(("name", "value", "unit", "source"), item, strict=True)) for item in items]


def _numbers(
    rows: list[Computed], strengths: Strengths, demand: float, ratio: dict[str, Any]
) -> dict[str, Any]:
    """Return the part `parapet` of the summary, SI."""
    impact = [row for row in rows if row.load_name != "code"]
    formulas = {place: strengths.resistance(rows[0].load.length, place) for place in ("interior", "end")}
    numbers = {
        "aashto": {place: formula.force for place, formula in formulas.items()}
        | {
            "critical_length": formulas["interior"].critical_length,
            "critical_length_end": formulas["end"].critical_length,
        },
        **_of_load(row for row in rows if row.load_name == "code"),
        "demand": demand,
        "demand_over_capacity": ratio,
        "load": {"length": rows[0].load.length, "height": rows[0].load.height},
        "residual": max(row.bounds.lower.residual for row in rows),
        "excess": max(0.0, *(row.bounds.lower.excess for row in rows)),
    }
    if impact:
        load = impact[0].load
        numbers["impact"] = {"length": load.length, "height": load.height} | _of_load(impact)
    return numbers


def _of_load(rows: Iterable[Computed]) -> dict[str, Any]:
    """Return both bounds by place."""
    bounds = [(row.place, row.lower, row.upper) for row in rows]
    return {name: {row[0]: row[k] for row in bounds} for k, name in ((1, "lower"), (2, "upper"))}
