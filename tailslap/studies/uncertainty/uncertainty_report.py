"""Report of the study `uncertainty`."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict

import numpy as np

from postprocess.figures import studies as figures
from postprocess.report.command_report import Report
from postprocess.report.page import Headline, Section
from postprocess.report.tables import Column, Table, columns, pairs
from postprocess.report.terminal import Part
from postprocess.svg.chart import Chart
from postprocess.units import force, grouped
from tailslap.campaign.planar_ranges import used_keys
from tailslap.campaign.records import Record
from tailslap.campaign.sampling import SEED, points_in_words
from tailslap.case.force_band import PERCENTILES, central_part
from tailslap.case.impact.strike_columns import LARGEST, QUANTITIES
from tailslap.case.report_parts import design_forces_of, short, study_page, study_summary
from tailslap.scene.write import scene_inputs
from tailslap.studies import sobol_tables
from tailslap.studies.uncertainty.uncertainty_study import Spread

BINS = 60
FILES = "summary.json (results in SI); samples.csv (samples)"
SCENE = Column("value", "Scene", form=str)
LEVELS = (
    Column("name", "Design force", style="whole"),
    Column("force", "Lateral", "N", form="#.4g", style="strong"),
    Column("above", "Impacts above it", form=lambda part: f"{100.0 * part:.1f} %"),
    Column("source", "Source", style="soft"),
)
BANDS = (
    *columns({"strike": "Strike", "quantity": "Quantity"}),
    Column("own", "Scene", form=".1f", style="strong", unit_key="unit"),
    *(Column(f"{p} %", f"{p} %", form=".1f", group="Band", unit_key="unit") for p in PERCENTILES),
    Column("unit", "Unit", is_unit=True),
    Column("source", "Main source of variance"),
    sobol_tables.index_column("total", "Total index", ".2f"),
)
SHOWN = {"mean_50ms": "50 ms", "impulse": "impulse", "duration": "duration"}
"""Quantities whose indices are displayed."""

INDEX_NOTE = (
    "Total Sobol indices: fraction of the variance that remains if all other inputs are known, with 95 % intervals. "
    "Dashes: not determined."
)


def report(result: Spread) -> Report:
    """Return the report of the study."""
    return impact_report(result) if result.case.scene.contact else corner_report(result)


def _report(
    result: Spread,
    kicker: str,
    sentences: tuple[str, str],
    sections: Sequence[Section],
    numbers: Mapping[str, object],
    terminal: Sequence[Part],
) -> Report:
    """Return page, summary and files.

    `sentences` are answer and certainty.
    """
    headline = Headline(f"Uncertainty: {result.case.subject}", sentences[0], result.case.set_up, sentences[1])
    head, cost = study_summary("uncertainty", result.case), {"seconds": result.seconds}
    return Report(
        study_page(result.case, kicker, headline, sections, FILES),
        {**head, "seed": SEED, **numbers, "cost": cost},
        tuple(terminal),
        histories={"samples.csv": result.samples},
    )


def corner_report(result: Spread) -> Report:
    """Return the report on the peak force of a tail-slap."""
    inputs = sobol_tables.input_rows(result.ranges, result.sources["peak_force"])
    sentences, refusals = _corner_answer(result), _refusals(result)
    refused = result.refused_sources.get("peak_force", "")
    counts, edges = np.histogram(result.band("peak_force").values, BINS)
    nominal, used = result.nominal["peak_force"], used_keys(result.case.scene)
    keys = [row.key for row in scene_inputs(result.case.scene, result.case.source)]
    fixed = tuple(key for key in keys if key in used and key not in result.inputs)
    percentiles = list(zip(PERCENTILES, result.band("peak_force").percentiles, strict=True))
    histogram = figures.draw_histogram(edges, counts, percentiles, nominal)
    indices = () if refused else sobol_tables.index_columns()
    note = refused or "95 % confidence intervals are below the indices."
    table = Table((*sobol_tables.INPUTS, SCENE, *indices), inputs, notes=(note,))
    index_charts = [] if refused else [figures.draw_sensitivity(inputs)]
    method = _corner_sentences(result, refusals, fixed)
    sections = (
        Section("Distribution", figures=(histogram,), layout="half"),
        Section("Sensitivity", refused, index_charts, layout="half"),
        Section("Inputs and Sobol indices", tables=(table,)),
        Section("Peak force", tables=(_forces_table(result),), layout="half"),
        Section("Method", sentences=method, layout="half"),
    )
    title = f"{result.case.scene.name}: Sobol indices of the peak force"
    listed = refused or Table(
        sobol_tables.with_intervals((sobol_tables.INPUTS[0], *indices)), inputs, title=title
    )
    terminal = listed, refusals, f"Cost:   {result.computed} combinations in {result.seconds:.2f} s"
    kicker = "Uncertainty of the peak force of the tail-slap, by the rigid-body method"
    distribution = {"of_the_scene": nominal, "histogram": {"edges": edges, "counts": counts}}
    numbers = _corner_summary(result, distribution, fixed)
    return _report(result, kicker, sentences, sections, numbers, terminal)


def _corner_summary(result: Spread, drawn: Record, held: tuple[str, ...]) -> Record:
    """Return the summary with histogram and fixed keys."""
    refused, left_out = result.refused
    return {
        "rows": result.rows,
        "combinations": result.computed,
        "refused": refused,
        "rows_left_out": left_out,
        "first_refusal": result.refusal or None,
        "peak_force": {**result.band("peak_force").numbers(), **drawn},
        "inputs": result.sources["peak_force"] or [asdict(item) for item in result.ranges],
        "indices_refused": result.refused_sources.get("peak_force"),
        "held": held,
    }


def _corner_answer(result: Spread) -> tuple[str, str]:
    """Return answer and certainty on the peak force."""
    band, nominal = result.band("peak_force"), result.nominal["peak_force"]
    low, _, high = band.percentiles
    answer = (
        f"Peak lateral force at the tail-slap: mean {force(band.mean)}, standard deviation "
        f"{force(band.standard_deviation)}; {central_part()} of the samples lie between {force(low)} and "
        f"{force(high)}. The nominal case ({force(nominal)}) exceeds "
        f"{100.0 * band.fraction_below(nominal):.0f} % of the samples."
    )
    certainty, sources = f"{grouped(result.computed)} samples", result.sources_of("peak_force")
    certainty += (
        f"; largest part of the variance from {sobol_tables.main_source(sources[0])}." if sources else "."
    )
    return answer, certainty


def _refusals(result: Spread) -> str:
    """Describe the samples without a solution."""
    refused, left_out = result.refused
    if not refused:
        return "All samples have a solution."
    return (
        f"{grouped(refused)} of {grouped(result.computed)} samples ({100.0 * refused / result.computed:.2g} %) have no "
        f"solution and are excluded from the distribution. {grouped(left_out)} of {grouped(result.rows)} rows contain "
        "such samples and are excluded from the indices, which are therefore approximate. First reason: "
        f"{result.refusal}."
    )


def _corner_sentences(result: Spread, refusals: str, held: tuple[str, ...]) -> list[str]:
    """Describe the method."""
    return [
        f"The inputs are independent and uniformly distributed over their ranges. {grouped(result.rows)} points of "
        f"{points_in_words(len(result.ranges), result.rows)} (seed {SEED}) define {grouped(result.computed)} samples, "
        "each solved exactly by Stages 1 to 3. Results are reproducible.",
        refusals,
        *([f"Fixed inputs: {', '.join(held)} (varied by --range)."] if held else []),
        sobol_tables.INDEX_METHOD,
        "The duration of the triangular force pulse is an input; the rigid-body method does not predict it.",
    ]


def _forces_table(result: Spread) -> Table:
    """Return the table of the peak force's distribution."""
    band = result.band("peak_force")
    forces = {"mean": band.mean, "standard deviation": band.standard_deviation}
    forces |= {f"{p} % percentile": x for p, x in zip(PERCENTILES, band.percentiles, strict=True)}
    forces |= {"nominal case": result.nominal["peak_force"]}
    return pairs([(name, force / 1e3, "kN") for name, force in forces.items()])


def impact_report(result: Spread) -> Report:
    """Return the report on both strikes of a whole impact."""
    inputs, sentences, levels = result.sources_of(LARGEST), _impact_answer(result), _levels(result)
    sensitivity = [figures.draw_sensitivity(inputs, "the largest 50 ms mean")] if inputs else []
    single = int(np.count_nonzero(np.isnan(result.samples["strike_2.impulse"])))
    sections = (
        Section("Bands", figures=[_band_figure(result)], tables=[_bands_table(result)]),
        Section("Largest 50 ms mean and design forces", tables=[levels]),
        Section("Inputs and Sobol indices", tables=[_inputs_table(result)]),
        Section("Sensitivity of the largest 50 ms mean", figures=sensitivity, layout="half"),
        Section("Method", "", (), (), _impact_sentences(result, single), "half"),
    )
    kinds, numbers = ("first_order", "first_order_interval", "total", "total_interval"), {}
    for name in result.tables:
        indices = {row["key"]: {kind: row[kind] for kind in kinds} for row in result.sources.get(name, ())}
        refused = result.refused_sources.get(name)
        numbers[name] = {**result.band(name).numbers(), "indices": indices, "indices_refused": refused}
    summary = {
        **{"impacts": result.computed, "without_second_strike": single},
        **{"own": result.nominal, "bands": numbers},
        "inputs": [asdict(item) for item in result.ranges],
        **({"levels": levels.rows} if levels.rows else {}),
    }
    terminal: list[Part] = [
        _bands_table(result, f"{result.case.scene.name}: both strikes"),
        short(levels),
        _inputs_table(result, short=True),
        *_refused_indices(result),
        f"Cost:   {result.computed} impacts in {result.seconds:.1f} s",
    ]
    kicker = "Uncertainty of both strikes of a whole impact"
    return _report(result, kicker, sentences, sections, summary, terminal)


def _levels(result: Spread) -> Table:
    """Return the table of design forces."""
    rows = [
        {"name": name, "force": design.force, "source": design.source}
        | {"above": 1.0 - result.band(LARGEST).fraction_below(design.force)}
        for name, design in design_forces_of(result.case.scene).items()
    ]
    return Table(LEVELS, rows)


def _impact_answer(result: Spread) -> tuple[str, str]:
    """Return answer and certainty on the largest 50 ms mean."""
    low, _, high = result.band(LARGEST).percentiles
    answer = (
        f"Largest 50 ms mean: {central_part()} of the samples lie between {force(low)} and {force(high)}; nominal "
        f"case {force(result.nominal[LARGEST])}."
    )
    certainty = f"{grouped(result.computed)} impacts of the rigid vehicle."
    if sources := result.sources_of(LARGEST):
        certainty += f" Largest part of the variance from {sobol_tables.main_source(sources[0])}."
    return answer, certainty


def _impact_sentences(result: Spread, single: int) -> list[str]:
    """Describe the method."""
    sentences = [
        f"The inputs are independent and uniformly distributed over their ranges. {grouped(result.computed)} impacts "
        f"of the rigid vehicle: {grouped(2 * result.rows)} points of "
        f"{points_in_words(len(result.ranges), result.rows)} "
        f"(seed {SEED}) for the distribution, the others for the indices. Results are reproducible.",
        sobol_tables.INDEX_METHOD,
        "Raw and filtered forces are those of the total force on the wall during the strike.",
        "The duration of the strikes follows from mass, crush and friction.",
        "Published forces beside such bands, like with like: `tailslap validate`.",
        "The distribution reflects these ranges only. The model excludes roll and pitch, shifting load, deflection of "
        f"the wall{'' if result.case.axles else ', tyres'} and suspension.",
    ]
    if result.case.trailers:
        sentences.append("Strike 1 is that of the first unit's front, strike 2 that of the last unit's rear.")
    if single:
        sentences.append(
            f"{grouped(single)} impacts have no second strike; they are excluded from its distribution and indices."
        )
    return sentences


def _bands_table(result: Spread, title: str = "") -> Table:
    """Return the table of all quantities."""
    rows = []
    for name in result.tables:
        strike, quantity = name.removeprefix("strike_").split(".")
        label, unit, scale = QUANTITIES[quantity]
        ends = zip(PERCENTILES, result.band(name).percentiles, strict=True)
        first = next(iter(result.sources_of(name)), {"key": "–", "total": None, "total_interval": None})
        strikes = int(strike) if strike.isdigit() else "largest"
        row: Record = {"strike": strikes, "quantity": label, "unit": unit}
        row |= {"own": result.nominal[name] / scale, **{f"{p} %": value / scale for p, value in ends}}
        rows.append(row | {"source": first["key"], **{k: first[k] for k in ("total", "total_interval")}})
    return Table(sobol_tables.with_intervals(BANDS) if title else BANDS, rows, title)


def _inputs_table(result: Spread, short: bool = False) -> Table:
    """Return ranges and total indices of the main quantities.

    The short table has the second strike only.
    """
    strikes, inputs = (2,) if short else (1, 2), sobol_tables.input_rows(result.ranges, ())
    heads = [
        sobol_tables.index_column(f"strike_{k}.{name}", label, ".2f", "" if short else f"Strike {k}")
        for k in strikes
        for name, label in SHOWN.items()
        if f"strike_{k}.{name}" in result.sources
    ]
    if LARGEST in result.sources:
        heads.insert(0, sobol_tables.index_column(LARGEST, "Largest 50 ms", ".2f"))
    for head in heads:
        sources = result.sources[head.key] or [{"total": None, "total_interval": None}] * len(inputs)
        for row, source in zip(inputs, sources, strict=True):
            row |= {head.key: source["total"], f"{head.key}_interval": source["total_interval"]}
    if short:
        heads = list(sobol_tables.with_intervals(heads))
        return Table((*sobol_tables.INPUTS[:2], *heads), inputs, "Inputs and total Sobol indices of strike 2")
    return Table((*sobol_tables.INPUTS, SCENE, *heads), inputs, notes=(INDEX_NOTE, *_refused_indices(result)))


def _refused_indices(result: Spread) -> list[str]:
    """Return the quantities with refused indices, and the reasons."""
    return [f"{name}: {why}" for name, why in result.refused_sources.items()]


def _band_figure(result: Spread) -> Chart:
    """Return the chart of peak forces."""
    bars = []
    for name in ("raw", "mean_50ms", "cfc60"):
        for strike in (1, 2):
            column, label = f"strike_{strike}.{name}", f"{QUANTITIES[name][0]}, strike {strike}"
            low, middle, high = (force / 1e3 for force in result.band(column).percentiles)
            ends, nominal = (low, middle, high), result.nominal[column] / 1e3
            bars.append(figures.BandBar(label, strike, ends, nominal))
    return figures.draw_bands(bars)
