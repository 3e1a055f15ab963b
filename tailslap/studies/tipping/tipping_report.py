"""Report of the study `tipping`."""

from dataclasses import asdict

from postprocess.figures import studies
from postprocess.figures import tipping as figures
from postprocess.report.command_report import Report
from postprocess.report.page import Headline, Section
from postprocess.report.tables import Column, Table
from postprocess.units import grouped, measure, percent_up
from tailslap.campaign import sampling
from tailslap.campaign.records import Record
from tailslap.case.impact.tipping import LIMIT_COLUMNS, LIMITS
from tailslap.case.report_parts import study_page, study_summary
from tailslap.studies.sobol_tables import INDEX_METHOD, index_columns, main_source, with_intervals
from tailslap.studies.tipping.tipping_study import ABRUPT, FINE_STEP, INCH, STEP, WALLS, TippingResult

HELD = (
    Column("inches", "Wall [in]", form=".1f"),
    Column("height", "Wall", "m", form=".3f"),
    Column("roll", "Largest roll", form=str),
    Column("holds", "No rollover", form=lambda part: f"{100.0 * part:.1f} %", style="strong"),
)
INPUTS = (Column("key", "Input"), Column("range", "Range", form=str), Column("origin", "Source"))
MEANING = (
    "No rollover: fraction of the samples without rollover at this wall height, for the ranges below. Omitted "
    "effects are not included."
)


def report(result: TippingResult) -> Report:
    """Return the report with map and samples."""
    scene, answer = result.case.scene, result.answer
    assert scene.tipping
    boundary = figures.Boundary(result.centres, result.line, result.band_centres, result.band)
    nominal = scene.tipping.centre_height, scene.tipping.wall_height
    map_chart = figures.draw_map(result.centres, result.walls, result.rolls, boundary, nominal)
    words = {item.key: item.in_words()[0] for item in result.ranges}
    sources = [
        row | {"range": words[row["key"]]} for row in sorted(result.sources, key=lambda row: -row["total"])
    ]
    held, inputs = (
        Table(HELD, walls_held(result), notes=(MEANING,)),
        Table((*INPUTS, *index_columns()), sources),
    )
    index_charts = [studies.draw_sensitivity(sources, "the lowest wall")] if sources else []
    if result.refusal:
        rows = [{"key": item.key, "range": words[item.key], "origin": item.origin} for item in result.ranges]
        inputs = Table(INPUTS, rows, notes=(result.refusal,))
    opening = headline(result)
    sections = (
        Section("Heights of wall and centre of mass", answer.verdict, (map_chart,), layout="tall"),
        Section("Walls", tables=(held,)),
        Section("Sensitivity of the lowest wall", result.refusal, index_charts),
        Section("Inputs and Sobol indices", tables=(inputs,)),
        Section("Method", sentences=_sentences(result)),
        Section("Omitted effects", tables=(Table(LIMIT_COLUMNS, LIMITS),)),
    )
    kicker = "Roll over the wall and lowest wall without rollover"
    files = "summary.json (in SI); map.csv (largest rolls); samples.csv (vehicles and lowest walls)"
    cost = f"Cost:   {grouped(result.lowest.size)} impacts and the map in {result.seconds:.1f} s"
    return Report(
        study_page(result.case, kicker, opening, sections, files),
        study_summary("tipping", result.case) | _summary(result),
        (
            Table(HELD, held.rows, f"{scene.name}: walls"),
            result.refusal
            or Table(with_intervals((INPUTS[0], *index_columns())), sources, "Lowest wall without rollover"),
            cost,
        ),
        {},
        {"map.csv": _map(result), "samples.csv": result.samples},
    )


def walls_held(result: TippingResult) -> list[Record]:
    """Return roll and fraction without rollover for common walls.

    The wall of the scene is one of them. The roll is that of the nominal vehicle.
    """
    from solver.tipping import TIPPED, largest_rolls

    tipping, answer = result.case.scene.tipping, result.case.answer
    assert tipping
    heights = sorted({*WALLS, tipping.wall_height})
    rolls = [
        float(largest_rolls(result.answer.vehicle, h, answer.history["force_normal"][1:], answer.interval))
        for h in heights
    ]
    words = ["tips" if roll >= TIPPED else measure(roll, "rad", ".1f") for roll in rolls]
    rows = zip(heights, words, strict=True)
    return [{"inches": h / INCH, "height": h, "roll": roll, "holds": result.holds(h)} for h, roll in rows]


def headline(result: TippingResult) -> Headline:
    """Return the headline with the lowest wall."""
    low, _, high = sampling.band_of(result.lowest).percentiles
    nominal = f"{measure(result.answer.lowest_wall, 'm', '.3f')} ({result.answer.lowest_wall / INCH:.1f} in)"
    ends = f"{measure(low, 'm', '.2f', named=False)} and {measure(high, 'm', '.2f')}"
    certainty = f"90 % of the samples lie between {ends}"
    if result.sources:
        certainty += (
            f"; main source of variance {main_source(max(result.sources, key=lambda row: row['total']))}"
        )
    answer = f"Lowest wall without rollover: {nominal}."
    return Headline(f"Roll over the wall: {result.case.subject}", answer, result.case.set_up, f"{certainty}.")


def _sentences(result: TippingResult) -> list[str]:
    """Describe the method."""
    return [
        f"Map and line: nominal impact with {result.centres.size} heights of the centre of mass and "
        f"{result.walls.size} of the wall. Band of the line: all inputs above except speed, angle, mass and "
        "longitudinal position of the centre of mass, at fixed heights of the centre of mass.",
        f"{grouped(result.lowest.size)} impacts of the rigid vehicle: {grouped(result.lowest[:2].size)} points of "
        f"{sampling.points_in_words(len(result.ranges), result.lowest.shape[1])} (seed {sampling.SEED}) for the "
        "distribution, the others for the indices. The inputs are independent and uniformly distributed. Results are "
        "reproducible.",
        INDEX_METHOD,
        f"The time step of the impacts is {1e3 * STEP:g} ms, and {1e3 * FINE_STEP:g} ms for restitutions below "
        f"{ABRUPT:g}. With a step of 0.1 ms, the lowest wall changes by less than 2 mm in 95 % of the samples. With "
        "twice the step, peak forces, impulses and angular velocities change by at most "
        f"{percent_up(result.error)} in 95 % of the samples. The lowest wall has a resolution of 1 mm.",
    ]


def _summary(result: TippingResult) -> Record:
    """Return the numbers of the study, SI."""
    nominal = result.answer.numbers()
    return {
        "seed": sampling.SEED,
        "tipping": nominal,
        "impacts": result.lowest.size,
        "error": result.error,
        "lowest_safe_wall": sampling.band_of(result.lowest).numbers(),
        "walls": [{"height": row["height"], "holds": row["holds"]} for row in walls_held(result)],
        "line": {"centre_height": result.centres, "lowest_safe_wall": result.line},
        "band": {"centre_height": result.band_centres, "percentiles": result.band},
        "inputs": result.sources or [asdict(item) for item in result.ranges],
        "indices_refused": result.refusal or None,
        "cost": {"seconds": result.seconds},
    }


def _map(result: TippingResult) -> Record:
    """Return the columns of the map."""
    import numpy as np

    walls, centres = np.meshgrid(result.walls, result.centres, indexing="ij")
    return {
        "wall_height": walls.ravel(),
        "centre_height": centres.ravel(),
        "largest_roll": result.rolls.ravel(),
    }
