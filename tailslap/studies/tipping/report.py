"""Report of the study `tipping`."""

from dataclasses import asdict
from typing import Any

from postprocess.figures import studies
from postprocess.figures import tipping as figures
from postprocess.report.command_report import Report
from postprocess.report.page import Headline, Section
from postprocess.report.tables import Column, Table
from postprocess.units import grouped, measure, percent_up
from tailslap.campaign import sampling
from tailslap.case.impact.tipping import LIMIT_COLUMNS, LIMITS
from tailslap.case.report import study_page, study_summary
from tailslap.studies.tipping.compute import ABRUPT, FINE_STEP, INCH, STEP, WALLS, RolledOver
from tailslap.studies.uncertainty.report import INDEX_METHOD, INDICES, main_source, with_intervals

HELD = (
    Column("inches", "Wall [in]", form=".1f"),
    Column("height", "Wall", "m", form=".3f"),
    Column("roll", "Largest roll", form=str),
    Column("holds", "No rollover", form=lambda part: f"{100.0 * part:.1f} %", style="strong"),
)
INPUTS = (
    Column("key", "Input"),
    Column("range", "Range", form=str),
    Column("origin", "Source"),
)
MEANING = (
    "No rollover: fraction of the samples without rollover at this wall height, for the ranges below. Omitted "
    "effects are not included."
)


def report(found: RolledOver) -> Report:
    """Report with map and samples."""
    scene, own = found.case.scene, found.answer
    assert scene.tipping
    boundary = figures.Boundary(found.centres, found.line, found.band_centres, found.band)
    place = scene.tipping.centre_height, scene.tipping.wall_height
    drawn = figures.draw_map(found.centres, found.walls, found.rolls, boundary, place)
    words = {item.key: item.in_words()[0] for item in found.ranges}
    sources = [
        row | {"range": words[row["key"]]} for row in sorted(found.sources, key=lambda row: -row["total"])
    ]
    held, inputs = Table(HELD, walls_held(found), notes=(MEANING,)), Table((*INPUTS, *INDICES), sources)
    drawn_indices = [studies.draw_sensitivity(sources, "the lowest wall")] if sources else []
    if found.refusal:
        rows = [{"key": item.key, "range": words[item.key], "origin": item.origin} for item in found.ranges]
        inputs = Table(INPUTS, rows, notes=(found.refusal,))
    said = headline(found)
    sections = (
        Section("Heights of wall and centre of mass", own.verdict, (drawn,), layout="tall"),
        Section("Walls", tables=(held,)),
        Section(
            "Sensitivity of the lowest wall",
            found.refusal,
            drawn_indices,
        ),
        Section("Inputs and Sobol indices", tables=(inputs,)),
        Section("Method", sentences=_sentences(found)),
        Section("Omitted effects", tables=(Table(LIMIT_COLUMNS, LIMITS),)),
    )
    kicker = "Roll over the wall and lowest wall without rollover"
    files = "summary.json (in SI); map.csv (largest rolls); samples.csv (vehicles and lowest walls)"
    cost = f"Cost:   {grouped(found.lowest.size)} impacts and the map in {found.seconds:.1f} s"
    return Report(
        study_page(found.case, kicker, said, sections, files),
        study_summary("tipping", found.case) | _summary(found),
        (
            Table(HELD, held.rows, f"{scene.name}: walls"),
            found.refusal
            or Table(with_intervals((INPUTS[0], *INDICES)), sources, "Lowest wall without rollover"),
            cost,
        ),
        {},
        {"map.csv": _map(found), "samples.csv": found.samples},
    )


def walls_held(found: RolledOver) -> list[dict[str, Any]]:
    """Rows of common walls and of the scene: roll of the nominal vehicle, fraction of the samples without rollover."""
    from solver.tipping import TIPPED, largest_rolls

    tipping, answer = found.case.scene.tipping, found.case.answer
    assert tipping
    heights = sorted({*WALLS, tipping.wall_height})
    rolls = [
        float(largest_rolls(found.answer.vehicle, h, answer.history["force_normal"][1:], answer.interval))
        for h in heights
    ]
    said = ["tips" if roll >= TIPPED else measure(roll, "rad", ".1f") for roll in rolls]
    rows = zip(heights, said, strict=True)
    return [{"inches": h / INCH, "height": h, "roll": roll, "holds": found.holds(h)} for h, roll in rows]


def headline(found: RolledOver) -> Headline:
    """Lowest wall, its uncertainty and the main source of variance."""
    low, _, high = sampling.band_of(found.lowest).percentiles
    own = f"{measure(found.answer.lowest_wall, 'm', '.3f')} ({found.answer.lowest_wall / INCH:.1f} in)"
    ends = f"{measure(low, 'm', '.2f', named=False)} and {measure(high, 'm', '.2f')}"
    certainty = f"90 % of the samples lie between {ends}"
    if found.sources:
        certainty += (
            f"; main source of variance {main_source(max(found.sources, key=lambda row: row['total']))}"
        )
    answer = f"Lowest wall without rollover: {own}."
    return Headline(f"Roll over the wall: {found.case.subject}", answer, found.case.set_up, f"{certainty}.")


def _sentences(found: RolledOver) -> list[str]:
    """Description of the method."""
    return [
        f"Map and line: nominal impact with {found.centres.size} heights of the centre of mass and {found.walls.size} "
        "of the wall. Band of the line: all inputs above except speed, angle, mass and longitudinal position of the "
        "centre of mass, at fixed heights of the centre of mass.",
        f"{grouped(found.lowest.size)} impacts of the rigid vehicle: {grouped(found.lowest[:2].size)} points of "
        f"{sampling.points_in_words(len(found.ranges), found.lowest.shape[1])} (seed {sampling.SEED}) for the "
        "distribution, the others for the indices. The inputs are independent and uniformly distributed. Results are "
        "reproducible.",
        INDEX_METHOD,
        f"The time step of the impacts is {1e3 * STEP:g} ms, and {1e3 * FINE_STEP:g} ms for restitutions below "
        f"{ABRUPT:g}. With a step of 0.1 ms, the lowest wall changes by less than 2 mm in 95 % of the samples. With "
        "twice the step, peak forces, impulses and angular velocities change by at most "
        f"{percent_up(found.error)} in 95 % of the samples. The lowest wall has a resolution of 1 mm.",
    ]


def _summary(found: RolledOver) -> dict[str, Any]:
    own = found.answer.numbers()
    return {
        "seed": sampling.SEED,
        "tipping": own,
        "impacts": found.lowest.size,
        "error": found.error,
        "lowest_safe_wall": sampling.band_of(found.lowest).numbers(),
        "walls": [{"height": row["height"], "holds": row["holds"]} for row in walls_held(found)],
        "line": {"centre_height": found.centres, "lowest_safe_wall": found.line},
        "band": {"centre_height": found.band_centres, "percentiles": found.band},
        "inputs": found.sources or [asdict(item) for item in found.ranges],
        "indices_refused": found.refusal or None,
        "cost": {"seconds": found.seconds},
    }


def _map(found: RolledOver) -> dict[str, Any]:
    """Columns of the map, one row per wall and centre height, in SI."""
    import numpy as np

    walls, centres = np.meshgrid(found.walls, found.centres, indexing="ij")
    return {
        "wall_height": walls.ravel(),
        "centre_height": centres.ravel(),
        "largest_roll": found.rolls.ravel(),
    }
