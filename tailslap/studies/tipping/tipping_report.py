"""Report of the study `tipping`."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict

import numpy as np

from postprocess.figures import studies
from postprocess.figures import tipping as figures
from postprocess.report.command_report import Report
from postprocess.report.page import Headline, Section
from postprocess.report.tables import Column, Table, columns
from postprocess.signals.design_forces import DesignForce
from postprocess.svg.chart import Chart
from postprocess.units import INCH, grouped, measure
from solver.space import OUTCOMES
from tailslap.campaign import sampling
from tailslap.campaign.records import Record
from tailslap.campaign.sampling import Array
from tailslap.case.force_band import PERCENTILES, binomial_interval, fraction_in_words
from tailslap.case.impact.space.answer import LIMIT_COLUMNS, LIMITS
from tailslap.case.report_parts import design_forces_of, study_page, study_summary
from tailslap.studies import sobol_tables
from tailslap.studies.tipping.tipping_study import (
    LEVELS,
    LINE_SAMPLES,
    OUTPUTS,
    WALLS,
    TippingResult,
    highest_centre,
)
from tailslap.validation.outcomes import ALWAYS, OURS, OutcomeRow, scores

BANDS = {
    "mean_50ms": ("50 ms mean", "N", ".0f"),
    "height": ("Resultant", "m", ".2f"),
    "length": ("Length", "m", ".2f"),
    "moment": ("Moment", "N m", ".0f"),
    "moment_height": ("At", "m", ".2f"),
}
"""Label, unit and form of the answers in tables."""

ANSWERS = (
    Column("words", "Upright", style="strong"),
    *(
        column
        for name, (label, unit, form) in BANDS.items()
        for column in (
            Column(f"{name}.1", label, unit, form=form, style="strong"),
            *columns({f"{name}.0": "5 %", f"{name}.2": "95 %"}, unit=unit, form=form),
        )
        if name == "mean_50ms" or column.key.endswith(".1")
    ),
)  # fmt: skip
"""Columns of fractions and bands."""

WALL_COLUMNS = (
    Column("inches", "Wall [in]", form=".1f"),
    Column("height_of_wall", "Wall", "m", form=".3f"),
    *ANSWERS,
)
PROFILES = (Column("profile", "Profile"), *ANSWERS)
LOWEST_WALLS = (
    Column("level", "Upright", form=lambda level: f"{100.0 * level:g} %"),
    Column("wall", "Lowest wall", form=str, style="strong"),
    Column("interval", "By the number of samples", form=str),
)
LOADS = (
    Column("name", "Published load"),
    Column("force", "Lateral", "N", form="#.4g", style="strong"),
    *columns({"height": "Height", "length": "Length"}, unit="m", form=".2f"),
    Column("source", "Source", style="soft"),
)
MEANING = (
    "Upright: fraction of the samples, with its 95 % interval due to their number, one-sided for all and none. "
    "Resultant: height of the lateral force at the largest 50 ms mean; length: of the uniform force with the same "
    "standard deviation along the wall. Moment: largest 50 ms mean about the foot of the wall, with the height of the "
    "force then."
)

COMMON_WALL = 36 * INCH
"""Height of the lowest wall that is recommended for MASH TL-4 (TTI 9-1002-5) [m]."""


def report(result: TippingResult) -> Report:
    """Return the report with map, walls and samples."""
    scene = result.case.scene
    loads = design_forces_of(scene)
    load_rows = [vars(load) | {"name": name, "force": load.force} for name, load in loads.items()]
    lowest, profiles = Table(LOWEST_WALLS, lowest_wall_rows(result)), Table(PROFILES, profile_rows(result))
    walls = Table(WALL_COLUMNS, wall_rows(result), notes=(MEANING,))
    map_chart, tables = _map_chart(result), (lowest, walls, Table(LOADS, load_rows))
    sections = (
        Section("Heights of wall and centre of mass", result.nominal.verdict, (map_chart,), layout="tall"),
        Section("Walls", "", _wall_charts(result, loads), tables, layout="wide"),
        Section(f"Profiles of a wall of {_height(result.height)}", tables=(profiles,)),
        *(_sensitivity(result, name) for name in OUTPUTS),
        Section("Method", sentences=_sentences(result)),
        Section("Omitted effects", tables=(Table(LIMIT_COLUMNS, LIMITS),)),
    )
    files = (
        "summary.json (in SI); map.csv (largest rolls); walls.csv (distributions); samples.csv (samples, outcome 0 "
        "upright, 1 on its side, 2 over the wall)"
    )
    cost = f"{result.seconds:.1f} s, {result.processor:.1f} s of processor time"
    return Report(
        study_page(result.case, "Roll over the wall", headline(result), sections, files),
        study_summary("tipping", result.case) | _summary(result),
        (
            Table(LOWEST_WALLS, lowest.rows, f"{scene.name}: lowest walls that keep the samples upright"),
            Table(WALL_COLUMNS, walls.rows, "Walls"),
            Table(PROFILES, profiles.rows, "Profiles"),
            *(_index_text(result, name) for name in OUTPUTS),
            f"Cost:   {grouped(result.motions)} motions in {cost}",
        ),
        {},
        {"map.csv": _map(result), "walls.csv": _walls(result), "samples.csv": _samples(result)},
    )


def headline(result: TippingResult) -> Headline:
    """Return the headline with the wall that keeps 95 % upright."""
    lowest, *ends = result.keeps(LEVELS[-1])
    middle, error = result.keeps(LEVELS[1])[0], result.nominal.lowest_wall_error
    answer = (
        f"Lowest wall that keeps 95 % of the samples upright, profile {result.profile}: {_height(lowest, result)}; "
        f"50 %: {_height(middle, result)}; all values nominal: {_height(result.nominal.lowest_wall)}"
        f"{f', error at most {1e3 * error:.0f} mm' if 0.0 < error < math.inf else ''}. At {_height(COMMON_WALL)} "
        f"{_at(result, COMMON_WALL)['words']} remain upright. {published_in_words(result.published)}"
    )
    certainty = f"By the number of samples, {result.count}, the wall lies {_between(ends, result)}."
    certainty += _decrease(result)
    if rows := result.sources.get("roll"):
        main = max(rows, key=lambda row: row["total"])
        certainty += f" Main source of variance of the roll: {sobol_tables.main_source(main)}."
    return Headline(f"Roll over the wall: {result.case.subject}", answer, result.case.set_up, certainty)


def published_in_words(rows: Sequence[OutcomeRow]) -> str:
    """Return how many published outcomes the model gives, in words."""
    scored = {score.name: score.right for score in scores(rows)}
    least = min(rows, key=lambda row: row.stated)
    return (
        f"Published outcomes of {len(rows)} crash tests: {scored[OURS]} are given a probability above one half, "
        f'{scored[ALWAYS]} by "{ALWAYS}"; the least has {least.stated:.2f}: {least.case}, {least.published}.'
    )


def _height(height: float, result: TippingResult | None = None) -> str:
    """Return a height with inches.

    NaN is above the highest wall.
    """
    if height != height:
        return "not stated" if result is None else f"above {_height(float(result.walls[-1]))}"
    if result is not None and height == result.walls[0]:
        return f"at most {_height(height)}"
    return f"{measure(height, 'm', '.2f')} ({height / INCH:.1f} in)"


def _between(ends: Sequence[float], result: TippingResult) -> str:
    """Return an interval of heights in words."""
    low, high = ends
    if low != low or high == result.walls[0]:
        return _height(high, result)
    return f"above {_height(low)}" if high != high else f"between {_height(low)} and {_height(high)}"


def lowest_wall_rows(result: TippingResult) -> list[Record]:
    """Return the lowest walls by fraction upright."""
    rows = []
    for level in LEVELS:
        wall, *ends = result.keeps(level)
        rows.append({"level": level, "wall": _height(wall, result), "interval": _between(ends, result)})
    return rows


def wall_rows(result: TippingResult) -> list[Record]:
    """Return fractions and bands of common walls and the scene's."""
    heights = sorted({*WALLS, result.height})
    return [{"inches": height / INCH, "height_of_wall": height} | _at(result, height) for height in heights]


def _at(result: TippingResult, height: float) -> Record:
    """Return fraction and bands of a wall of this height [m]."""
    number = int(np.argmin(np.abs(result.walls - height)))
    return distribution({name: values[number] for name, values in result.answers.items()})


def profile_rows(result: TippingResult) -> list[Record]:
    """Return fractions and bands of the named profiles."""
    return [{"profile": name} | distribution(columns) for name, columns in result.profiles.items()]


def distribution(columns: Mapping[str, Array]) -> Record:
    """Return fraction upright with interval, and percentiles of the answers."""
    upright = int((columns["outcome"] == 0.0).sum())
    low, high = binomial_interval(np.array([upright]), columns["outcome"].size)[:, 0].tolist()
    bands = {name: np.percentile(columns[name], PERCENTILES).tolist() for name in BANDS}
    fraction = upright / columns["outcome"].size
    words = fraction_in_words(fraction, columns["outcome"].size)
    return {"upright": fraction, "words": words, "interval": [low, high], **bands}


def _map_chart(result: TippingResult) -> Chart:
    """Draw the map."""
    lines, (_, centre) = figures.Lines(result.line_centres, result.lines), highest_centre(result.case)
    return figures.draw_map(result.centres, result.map_walls, result.rolls, lines, (centre, result.height))


def _wall_charts(result: TippingResult, loads: Mapping[str, DesignForce]) -> list[Chart]:
    """Draw outcomes, force and resultant over the height of the wall."""
    wall, outcome = result.height, result.answers["outcome"]
    side = (outcome == float(OUTCOMES.index("on its side"))).mean(axis=1)
    fractions = np.array([result.upright, side, 1.0 - result.upright - side])
    forces = {name: load.force for name, load in loads.items()}
    heights = {name: load.height for name, load in loads.items() if load.height is not None}
    return [
        figures.draw_upright(result.walls, fractions, result.intervals, wall, LEVELS[-1]),
        figures.draw_force(result.walls, result.band("mean_50ms"), forces, wall),
        figures.draw_resultant(result.walls, result.band("height"), heights, wall),
    ]


def _sensitivity(result: TippingResult, name: str) -> Section:
    """Return the section of the indices of an output."""
    rows = sobol_tables.input_rows(result.ranges, result.sources.get(name, ()))
    refusal = result.refusals.get(name, "")
    title = f"Inputs and sensitivity of {OUTPUTS[name]}"
    if refusal:
        return Section(title, refusal, tables=(Table(sobol_tables.INPUTS, rows),))
    figure = studies.draw_sensitivity(rows, OUTPUTS[name])
    heads = (*sobol_tables.INPUTS, *sobol_tables.index_columns())
    return Section(title, "", (figure,), (Table(heads, rows),))


def _index_text(result: TippingResult, name: str) -> Table | str:
    """Return the indices of an output for a terminal."""
    columns = sobol_tables.with_intervals((sobol_tables.INPUTS[0], *sobol_tables.index_columns()))
    title = f"Sobol indices of {OUTPUTS[name]}"
    rows = sobol_tables.input_rows(result.ranges, result.sources.get(name, ()))
    return result.refusals.get(name) or Table(columns, rows, title)


def _sentences(result: TippingResult) -> list[str]:
    """Describe the method."""
    count, rows = result.count, result.count // 2
    return [
        f"Profile of the wall: {result.profile}. The same {grouped(count)} samples strike {result.walls.size} walls; "
        "lowest walls are interpolated between these. From the lowest wall on, all walls keep the fraction upright.",
        f"Samples: {grouped(count)} points of {sampling.points_in_words(len(result.ranges), rows)} (seed "
        f"{sampling.SEED}); inputs are independent and uniformly distributed. Results are reproducible.",
        f"Map: nominal vehicle; lines: {LINE_SAMPLES} samples at each of {result.line_centres.size} heights of the "
        f"centre of mass ({result.centre_key}).",
        "Keys with * are factors of the scene's values of all axles or strips, which vary together. The heights of "
        "strips are at most twice that of the centre of mass.",
        f"Indices: at the scene's wall, of {' and of '.join(OUTPUTS.values())}; a vehicle "
        f"that does not remain upright has a roll of 90 deg. {sobol_tables.INDEX_METHOD}",
        f"{grouped(result.motions)} motions in space with the step of many motions; "
        f"{int((result.answers['outcome'] == 3.0).sum())} of the samples had no result and count as not upright.",
    ]


def _decrease(result: TippingResult) -> str:
    """Return a sentence if the upright fraction decreases with height."""
    highest = np.maximum.accumulate(result.upright)
    lower = int(np.argmax(highest - result.upright))
    if highest[lower] == result.upright[lower]:
        return ""
    before = int(np.argmax(result.upright[:lower]))
    at = [f"{100.0 * result.upright[n]:.1f} % at {_height(float(result.walls[n]))}" for n in (before, lower)]
    return f" The fraction does not always grow with the height: {', '.join(at)}."


def _summary(result: TippingResult) -> Record:
    """Return the numbers of the study, SI."""
    lowest = {f"{100 * level:g}": result.keeps(level) for level in LEVELS}
    return {
        "seed": sampling.SEED,
        "space": result.nominal.numbers(),
        "motions": result.motions,
        "samples": result.count,
        "lowest_walls": {level: {"wall": wall, "interval": ends} for level, (wall, *ends) in lowest.items()},
        "walls": wall_rows(result),
        "profiles": profile_rows(result),
        "lines": {"centre_height": result.line_centres, "lowest_wall": result.lines, "levels": LEVELS},
        "inputs": [asdict(item) for item in result.ranges],
        "indices": dict(result.sources),
        "indices_refused": dict(result.refusals),
        "published": [row._asdict() for row in result.published],
        "cost": {"seconds": result.seconds, "processor_seconds": result.processor},
    }


def _map(result: TippingResult) -> Record:
    """Return the columns of the map."""
    walls, centres = np.meshgrid(result.map_walls, result.centres, indexing="ij")
    columns = {"wall_height": walls, "centre_height": centres, "largest_roll": result.rolls}
    return {name: values.ravel() for name, values in columns.items()}


def _walls(result: TippingResult) -> Record:
    """Return the distributions over the wall's height."""
    low, high = result.intervals
    columns = {
        "wall_height": result.walls,
        "upright": result.upright,
        "upright_low": low,
        "upright_high": high,
    }
    for name in BANDS:
        ends = zip(PERCENTILES, result.band(name), strict=True)
        columns |= {f"{name}_{percent}": values for percent, values in ends}
    return columns


def _samples(result: TippingResult) -> Record:
    """Return the samples with their answers at the scene's wall.

    Outcomes are numbers of `solver.space.OUTCOMES`.
    """
    number = int(np.argmin(np.abs(result.walls - result.height)))
    return {**result.inputs, **{name: values[number] for name, values in result.answers.items()}}
