"""Page, summary and tables of the study of tipping."""

from typing import Any

from postprocess.figures import studies
from postprocess.figures import tipping as figures
from postprocess.report.page import Column, Headline, Section, Table
from postprocess.report.report import Report
from postprocess.units import grouped, measure, percent
from tailslap.campaign import sampling
from tailslap.case.impact.tipping import LIMIT_COLUMNS, LIMITS
from tailslap.case.report import study_page, study_summary
from tailslap.studies.tipping.compute import INCH, STEP, WALLS, Tipping

HELD = (
    Column("inches", "Wall [in]", form=".1f"),
    Column("height", "Wall", "m", form=".3f"),
    Column("roll", "Largest roll", form=str),
    Column("holds", "Vehicles held", form=lambda part: f"{100.0 * part:.1f} %", style="strong"),
)
INPUTS = (
    Column("key", "Input"),
    Column("range", "Range", form=str),
    Column("origin", "From"),
    *(
        Column(name, label, form=".3f")
        for name, label in (("first_order", "Alone"), ("total", "With interactions"))
    ),
)
MEANING = (
    "Vehicles held: the part of the samples that a wall of this height holds, a probability over the ranges below and "
    "nothing else; what the model leaves out is not in it."
)


def report(found: Tipping) -> Report:
    """Page, summary, map and samples, and what the terminal says."""
    scene, own = found.case.scene, found.answer
    assert scene.tipping
    boundary = figures.Boundary(found.centres, found.line, found.band_centres, found.band)
    place = scene.tipping.centre_height, scene.tipping.wall_height
    drawn = figures.draw_map(found.centres, found.walls, found.rolls, boundary, place)
    words = {item.key: item.in_words()[0] for item in found.ranges}
    sources = [
        row | {"range": words[row["key"]]} for row in sorted(found.sources, key=lambda row: -row["total"])
    ]
    held, inputs = Table(HELD, walls_held(found), notes=(MEANING,)), Table(INPUTS, sources)
    said = headline(found)
    sections = (
        Section("Over walls and centres of mass", own.verdict, (drawn,), layout="tall"),
        Section("Walls", tables=(held,)),
        Section(
            "Where the spread of the lowest wall comes from",
            "",
            (studies.draw_sensitivity(sources, "the lowest wall"),),
        ),
        Section("Inputs, and the share of the variance that comes from each", tables=(inputs,)),
        Section("What was computed", sentences=_sentences(found)),
        Section("What the model leaves out", tables=(Table(LIMIT_COLUMNS, LIMITS),)),
    )
    kicker = "Tipping over walls: largest roll, the lowest wall that holds, and how sure that is"
    files = "summary.json, these numbers in SI; map.csv, largest rolls; samples.csv, vehicles and their lowest walls"
    cost = f"Cost:   {grouped(found.lowest.size)} impacts and the map in {found.seconds:.1f} s"
    return Report(
        study_page(found.case, kicker, said, sections, files),
        study_summary("tipping", found.case) | _summary(found),
        (
            Table(HELD, held.rows, f"{scene.name}: walls"),
            Table(INPUTS, sources, "Lowest wall that holds"),
            cost,
        ),
        {},
        {"map.csv": _map(found), "samples.csv": found.samples},
    )


def walls_held(found: Tipping) -> list[dict[str, Any]]:
    """Rows of common walls and the scene's own: roll of the scene's vehicle, and part of the samples that they hold."""
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


def headline(found: Tipping) -> Headline:
    """The lowest wall, its band and where that comes from."""
    low, _, high = sampling.band_of(found.lowest).percentiles
    first = max(found.sources, key=lambda row: row["total"])
    own = f"{measure(found.answer.lowest_wall, 'm', '.3f')} ({found.answer.lowest_wall / INCH:.1f} in)"
    ends = f"{measure(low, 'm', '.2f', named=False)} to {measure(high, 'm', '.2f')}"
    certainty = (
        f"The lowest wall that holds nine in ten vehicles of the ranges has {ends}; most of the variance comes from "
        f"{first['key']}, with an index of {first['total']:.2f}."
    )
    answer = f"The lowest wall that holds the vehicle has {own}."
    return Headline(f"Tipping over walls: {found.case.subject}", answer, found.case.set_up, certainty)


def _sentences(found: Tipping) -> list[str]:
    """Sentences that a reader needs beside the numbers."""
    drawn = f"{grouped(found.lowest.size)} vehicles and impacts, Sobol points scrambled with the seed {sampling.SEED}"
    return [
        f"Map and line: the scene's own impact, with {found.centres.size} heights of the centre of mass and "
        f"{found.walls.size} of the wall. Band of the line: over the inputs above but speed, angle, mass and the place "
        "of the centre of mass, at fixed heights of the centre.",
        f"{drawn}; inputs vary evenly, independently of each other. The same call gives the same numbers.",
        f"Impacts of the samples have steps of {STEP:g} s: with twice the step peaks, impulses and spin of 95 in 100 "
        f"change by at most {percent(found.error)}. Lowest walls are found to 1 mm.",
    ]


def _summary(found: Tipping) -> dict[str, Any]:
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
        "inputs": found.sources,
        "cost": {"seconds": found.seconds},
    }


def _map(found: Tipping) -> dict[str, Any]:
    """Columns of the map, a row a wall and a centre, SI."""
    import numpy as np

    walls, centres = np.meshgrid(found.walls, found.centres, indexing="ij")
    return {
        "wall_height": walls.ravel(),
        "centre_height": centres.ravel(),
        "largest_roll": found.rolls.ravel(),
    }
