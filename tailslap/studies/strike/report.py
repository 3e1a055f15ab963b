"""What the study of strikes reports."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

from postprocess.figures.uncertainty_plots import draw_sensitivity
from postprocess.report.numbers import grouped, percent
from postprocess.report.page import Section
from postprocess.report.report import Report
from tailslap.report.common import study_page, study_summary
from tailslap.studies.strike.campaign import StrikeResults
from tailslap.studies.strike.diagrams import band_figure, curve_figures, plate_figures
from tailslap.studies.strike.plates import PlatePoint
from tailslap.studies.strike.quantities import COLUMNS
from tailslap.studies.strike.rows import RowBeside
from tailslap.studies.strike.tables import (
    NOT_TL_4,
    bands_table,
    curves_table,
    inputs_table,
    plates_table,
    rows_table,
    short_inputs_table,
)
from tailslap.studies.uncertainty.sampling import SEED
from tailslap.studies.uncertainty.spread import PERCENTILES

MAIN, TABLES_4_AND_5 = "strike_2.mean_50ms", "Beside Tables 4 and 5 of the paper"
FILES = "summary.json, these numbers in SI; samples.csv, the impacts of the bands; curves.csv, those of the curves"
PLATES = (
    "FE runs, soft to rigid, the corner's crush spread over a tenth of the length so that meshes converge; contacts of "
    "a corner within 50 ms are one strike, filtered by itself. Mesh: the largest difference to a mesh half as fine; "
    "above 5 %, or with a failed check, a plate is not to be relied on."
)


def strike_report(found: StrikeResults) -> Report:
    """Page, summary, impacts, and what the terminal says."""
    page = study_page(
        found.plan,
        "Both strikes of the whole impact: against each input, as bands, and against the plate's flexibility",
        headline(found),
        _sections(found),
        FILES,
    )
    samples = {**found.bands.inputs, **found.bands.columns}
    table = {"curves.csv": curves_table(found)}
    return Report(page, summary(found), _terminal(found), table, {"samples.csv": samples})


def _sections(found: StrikeResults) -> list[Section]:
    inputs, bands = found.bands.sources_of(MAIN), bands_table(found.bands, found.own)
    sensitivity = [draw_sensitivity(inputs, "the second strike's 50 ms mean")] if inputs else []
    return [
        Section("Bands", figures=[band_figure(found)], tables=[bands]),
        Section("Inputs, and their shares of the variance", tables=[inputs_table(found.bands)]),
        Section("Where the second strike's spread comes from", figures=sensitivity, layout="half"),
        Section("What was computed, and what it means", sentences=_sentences(found), layout="half"),
        Section(TABLES_4_AND_5, "" if found.rows else NOT_TL_4, tables=[rows_table(found.rows)]),
        Section("Each input alone", figures=curve_figures(found)),
        Section(
            "From 2 Hz to rigid",
            PLATES if found.plates else "",
            figures=plate_figures(found),
            tables=[plates_table(found)],
            sentences=[f"{p.frequency:g} Hz: {', '.join(p.failed)}." for p in found.plates if p.failed],
        ),
    ]


def headline(found: StrikeResults) -> str:
    """The second strike's force, where its spread comes from, the rows, and flexibility."""
    band = found.bands.band(MAIN)
    low, _, high = (force / 1e3 for force in band.percentiles)
    said = (
        f"The second strike's 50 ms mean is {found.own[MAIN] / 1e3:.0f} kN with the scene's own values; nine in ten "
        f"combinations lie between {low:.0f} and {high:.0f} kN."
    )
    sources = found.bands.sources_of(MAIN)
    if sources:
        said += f" Most of the variance comes from {sources[0].key}, with an index of {sources[0].total:.2f}."
    return " ".join([said, *_of_rows(found.rows), *_of_plates(found.plates)])


def _of_rows(rows: tuple[RowBeside, ...]) -> list[str]:
    if not rows:
        return []
    shown = [row for row in rows if not row.projected]
    inside = [row for row in shown if row.ends[0] <= row.measured <= row.ends[2]]
    within = [row for row in shown if row.within]
    return [
        f"Of {len(shown)} forces of Tables 4 and 5 that were not projected, {len(inside)} lie in the band, and "
        f"{len(within)} within u_val with u_D unknown."
    ]


def _of_plates(points: tuple[PlatePoint, ...]) -> list[str]:
    good = [point for point in points if point.passed and math.isfinite(point.frequency)]
    if not good:
        return []
    soft, rigid = good[0], points[-1]
    changes = {
        name: soft.values[f"strike_2.{name}"] / rigid.values[f"strike_2.{name}"] - 1.0
        for name in ("impulse", "duration", "mean_50ms")
    }
    return [
        f"A plate of {soft.frequency:g} Hz changes the second strike's impulse by {percent(changes['impulse'], 0)}, "
        f"its duration by {percent(changes['duration'], 0)} and its 50 ms mean by {percent(changes['mean_50ms'], 0)}."
    ]


def _sentences(found: StrikeResults) -> list[str]:
    bands = found.bands
    rows = bands.columns["strike_1.impulse"].size
    sentences = [
        f"{grouped(bands.computed)} impacts of the rigid vehicle: {grouped(rows)} for the bands, Sobol points "
        f"scrambled with the seed {SEED}, the rest for the indices. Inputs vary evenly, independently of each "
        "other. The same call gives the same numbers.",
        "Raw: the force at the corner that strikes. Filtered: the total force on the wall; of 50 ms means those that "
        "lie in the strike.",
        "Nothing here is a duration that was read off a test: it follows from mass, crush and friction.",
        "A band says what these ranges do, and nothing of what the model lacks: roll and pitch, load that shifts, a "
        "wall that gives, wheels and suspension.",
    ]
    if bands.single:
        sentences.append(
            f"{grouped(bands.single)} impacts have no second strike; they are not in the second strike's numbers, and "
            "their rows not in the indices."
        )
    return sentences


def _terminal(found: StrikeResults) -> tuple[Any, ...]:
    name, seconds = found.plan.scene.name, found.seconds
    soft_to_rigid = "The plate from soft to rigid"
    times = f"with curves {seconds['rigid']:.1f} s; plates {seconds['plates']:.1f} s"
    return (
        bands_table(found.bands, found.own, f"{name}: both strikes"),
        short_inputs_table(found.bands),
        rows_table(found.rows, "Beside Tables 4 and 5 (* projected); u_D is unknown", short=True),
        plates_table(found, soft_to_rigid, short=True),
        headline(found),
        f"Cost:   {found.bands.computed} impacts, {times}",
    )


def summary(found: StrikeResults) -> dict[str, Any]:
    """The numbers of the study, SI."""
    bands = found.bands
    return {
        **study_summary("strike", found.plan),
        "seed": SEED,
        "impacts": bands.computed,
        "without_second_strike": bands.single,
        "own": found.own,
        "bands": {name: _band_numbers(found, name) for name in COLUMNS},
        "inputs": [asdict(item) for item in bands.ranges],
        "rows": [_row_numbers(row) for row in found.rows],
        "plates": [_plate_numbers(point) for point in found.plates],
        "cost": {f"{name}_s": seconds for name, seconds in found.seconds.items()},
    }


def _band_numbers(found: StrikeResults, name: str) -> dict[str, Any]:
    band = found.bands.band(name)
    return {
        **{f"percentile_{p}": x for p, x in zip(PERCENTILES, band.percentiles, strict=True)},
        "mean": band.mean,
        "standard_deviation": band.standard_deviation,
        "indices": {
            item.key: {"first_order": item.first_order, "total": item.total}
            for item in found.bands.sources.get(name, ())
        },
    }


def _row_numbers(row: RowBeside) -> dict[str, Any]:
    own = {name: value for name, value in vars(row).items() if name != "band"}
    derived = {
        name: getattr(row, name) for name in ("error", "within", "u_d_needed", "verdict", "share_below")
    }
    return {**own, **derived, "u_d": None, "band": row.ends}


def _plate_numbers(point: PlatePoint) -> dict[str, Any]:
    frequency = point.frequency if math.isfinite(point.frequency) else None
    return {**asdict(point), "frequency": frequency, "error": point.error, "passed": point.passed}
