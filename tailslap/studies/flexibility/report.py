"""What the study of flexibility reports."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from postprocess.report.numbers import known
from postprocess.report.page import Section
from postprocess.report.report import Report
from postprocess.report.table import Column, Table, columns, listed
from tailslap.report.common import study_page, study_summary
from tailslap.studies.flexibility.campaign import LEVELS, FlexibilityResults
from tailslap.studies.flexibility.diagrams import START_NAMES, SYMBOLS, figures
from tailslap.studies.flexibility.levels import hertz
from tailslap.studies.flexibility.measure import KEPT
from tailslap.studies.flexibility.points import MEASURED
from tailslap.studies.flexibility.sweep import STARTS

if TYPE_CHECKING:
    from tailslap.studies.flexibility.impacts import ImpactFlexibility

MAIN = LEVELS.index(1e-2)
SIZE, DEPARTURE = known(".2e"), known(".2e", negligible=1e-9)
F1 = Column("frequency", "f_1", form=hertz)
GOOD = (
    Column("what", "Off by at most"),
    *columns({f"levels.{i}.text": f"{100.0 * level:g} %" for i, level in enumerate(LEVELS)}, form=str),
)
LAWS = (
    Column("law.exponent", "Exponent of f_1", form=".3f"),
    *columns({"law.highest": "From", "law.lowest": "Down to"}, form=hertz),
)
ERRORS = {name: Column(f"errors.{name}", "", form=SIZE) for name in MEASURED}
POINTS = [Column(f"seven.{name}", SYMBOLS[name], form=SIZE, below=error) for name, error in ERRORS.items()]
PARTS = {"difference": "At the strike", "largest": "Largest", "error": "Error"}
STARTED = [
    Column(f"good.{start}.{key}", label, form=SIZE, group=group)
    for start, group in START_NAMES.items()
    for key, label in PARTS.items()
]
KEPT_BY = [
    Column(f"good.{start}.departure.{name}", SYMBOLS[name], form=DEPARTURE, group=START_NAMES[start])
    for start in STARTS[:2]
    for name in KEPT
]
PLATES = {"deflection_ratio": "Static deflection ratio", "half_change": "Half the patch changes v_GY by"}
PLATES |= {"thickness.apart": "Thickness for E, apart"}
STIFF = (Column("youngs_modulus", "E", "Pa", form=SIZE), Column("damping", "Damping", "1/s", form=SIZE))
MODAL = {"modal.v_gy": "v_GY", "modal_apart": "Largest of five from FE", "modal_estimate": "Own estimate"}
READING = (
    "Inertia relief begins in the elastic state of the rigid acceleration, with the rigid body's spin and corner speed "
    "or, by Stage 1's momenta, its v_GX and v_GY; unstressed, the plate has all four, oscillates and strikes in any "
    "phase. Levels of v_GY are of the largest difference until then; not known: the error is above a third of them.",
    "Errors, below the values: the grid convergence index of three meshes, and what damping and ringing may do. Plates "
    "set off failed a check.",
)


def flexibility_report(found: FlexibilityResults | ImpactFlexibility) -> Report:
    """Page, summary, points, and what the terminal says."""
    if not isinstance(found, FlexibilityResults):
        from tailslap.studies.flexibility.impact_report import impact_flexibility_report

        return impact_flexibility_report(found)
    three, five, reaction, stored, modes = figures(found)
    starts = found.starts | {"any of the three": found.band}
    rows = [{"what": START_NAMES.get(name, name), "levels": its} for name, its in starts.items()]
    v_gy = Table(GOOD, rows, "v_GY is good down to a first frequency of", marks={len(STARTS): "marked"})
    laws = [{"what": SYMBOLS[n], "levels": found.others.get(n), "law": law} for n, law in found.laws.items()]
    marks = {i: "failed" for i, point in enumerate(found.points) if not point.passed}
    said = plates(found)
    tables = [
        Table(
            (F1, Column("checks", "Checks"), *POINTS),
            found.points,
            "At the strike, with inertia relief",
            marks=marks,
        ),
        Table((F1, *STARTED), found.points, "v_GY from each start"),
        Table((F1, *KEPT_BY), found.points, "What each start departs from at t = 0"),
        Table((F1, *STIFF, *columns(PLATES, form=SIZE)), found.points, "The plates"),
    ]
    modal = Table((F1, Column("modal_why", "Checks failed"), *columns(MODAL, form=SIZE)), found.points)
    page = study_page(
        found.sweep.plan,
        "Flexibility: how soft the vehicle may be for the rigid-body method to hold",
        headline(found),
        (
            Section("Three starts", "", (three,), (v_gy,), (said, *READING)),
            Section("With inertia relief", "", (five,), (Table((*GOOD, *LAWS), laws),)),
            Section("Reaction and stored energy", "", (reaction, stored)),
            Section("Modal model against finite elements", "", (modes,), (modal,)),
            Section("Every plate", tables=tables),
        ),
        "points.csv, every plate with its numbers in SI; summary.json",
        found.passed,
    )
    cost = f"Cost:   {len(found.points)} plates in {found.seconds:.0f} s"
    points = {"points.csv": listed([point.row for point in found.points])}
    return Report(page, summary(found), (page.headline, v_gy, said, cost), points)


def summary(found: FlexibilityResults) -> dict[str, Any]:
    """The numbers of the study, SI; what is not known is None."""
    sweep = found.sweep
    return {
        **study_summary("flexibility", sweep.plan),
        "passed": found.passed,
        "headline": headline(found),
        "rigid": sweep.plan.tail_slap,
        "own_frequency": sweep.own_frequency,
        "corner": sweep.support,
        "meshes": sweep.meshes,
        "levels_v_gy": found.starts,
        "levels_v_gy_any_start": found.band,
        "levels": found.others,
        "power_laws": found.laws,
        "points": [point.row for point in found.points],
        "cost": {"seconds": found.seconds},
    }


def headline(found: FlexibilityResults) -> str:
    """Down to which first frequency the rigid body's v_GY is good, and where this scene's own plate lies."""
    own = f"The scene's own plate has {hertz(found.sweep.own_frequency)}."
    if not any(math.isfinite(its[MAIN].frequency) for its in found.starts.values()):
        return f"How good rigid-body v_GY is for a soft plate is not known: no run passed its checks. {own}"
    each = ", ".join(f"{its[MAIN].text} ({START_NAMES[name]})" for name, its in found.starts.items())
    return (
        f"Rigid-body v_GY is good to {100.0 * LEVELS[MAIN]:g} %, at the strike and before, down to a first frequency "
        f"of {each}; from any of the three starts, {found.band[MAIN].text}. {own}"
    )


def plates(found: FlexibilityResults) -> str:
    """How the plates are modelled, and which failed."""
    support, (along, across) = found.sweep.support, found.sweep.meshes[-1]
    failed = "; ".join(f"{hertz(p.frequency)}: {p.why}" for p in found.points if not p.passed)
    return (
        f"Numbers are those of {along} x {across} elements, the corner with the {support.constraint} constraint over "
        f"{support.patch:g} m{'' if support.own_patch else ', which the study adds'}. Failed: {failed or 'none'}."
    )
