"""Report of the study `uncertainty`."""

from collections.abc import Iterable, Mapping
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from postprocess.figures import studies as figures
from postprocess.report.command_report import Report
from postprocess.report.page import Headline, Section
from postprocess.report.tables import Column, Table, columns, pairs
from postprocess.units import force, grouped
from tailslap.campaign.sampling import GROUPS, PERCENTILES, SEED, points_in_words
from tailslap.case.impact.answers import COLUMNS, LARGEST, QUANTITIES
from tailslap.case.report import known_forces, short, study_page, study_summary
from tailslap.scene.write import scene_inputs
from tailslap.studies.uncertainty.compute import LEVEL, TAKEN, Spread, used_keys

BINS = 60
INPUTS = (
    Column("key", "Input"),
    Column("range", "Range", form=str),
    Column("origin", "Source"),
    Column("value", "Scene", form=str),
)


# What stands for the 95 % interval of an index.
INTERVAL = "95 %"


def _index(key: str, label: str, form: str = ".3f", group: str = "") -> Column:
    """A Sobol index, its confidence interval below it."""
    interval = Column(f"{key}_interval", "", form=lambda ends: interval_in_words(ends, form))
    return Column(key, label, form=form, below=interval, group=group)


def interval_in_words(ends: tuple[float, float], form: str) -> str:
    """The ends of an interval."""
    return " to ".join(format(end, form) for end in ends)


def with_intervals(heads: Iterable[Column]) -> tuple[Column, ...]:
    """Columns whose intervals stand beside them, for a terminal."""
    both = ((head, head.below and replace(head.below, label=INTERVAL, group=head.group)) for head in heads)
    return tuple(column for pair in both for column in pair if column)


def main_source(source: Mapping[str, Any]) -> str:
    """The input with the largest total index, for a headline."""
    return (
        f"{source['key']} (total Sobol index {source['total']:.2f}, 95 % interval "
        f"{interval_in_words(source['total_interval'], '.2f')})"
    )


INDICES = (_index("first_order", "First-order index"), _index("total", "Total index"))
MAIN = "strike_2.mean_50ms"
LEVELS = (
    Column("name", "Design force", style="whole"),
    Column("force", "Lateral", "N", form="#.4g", style="strong"),
    Column("above", "Impacts above it", form=lambda part: f"{100.0 * part:.1f} %"),
    Column("source", "Source", style="soft"),
)
# Inputs of the curves: label, displayed unit and its value in SI; last those of trailers.
CURVES = {
    "contact.stiffness": ("crush stiffness", "MN/m", 1e6),
    "contact.restitution": ("restitution", "", 1.0),
    "contact.friction": ("friction", "", 1.0),
    "vehicle.mass": ("mass", "t", 1e3),
    "impact.speed": ("speed", "m/s", 1.0),
    "impact.angle": ("angle", "deg", np.pi / 180.0),
    "vehicle.centre_of_mass": ("centre of mass behind the front", "m", 1.0),
    "stiffness": ("crush stiffness", "MN/m", 1e6),
    "yaw_inertia": ("yaw inertia", "t m^2", 1e3),
}

CURVE_AXES: dict[str, tuple[str, ...]] = {"peak [kN]": ("mean_50ms", "raw", "cfc60")}
CURVE_AXES |= {"impulse [kN s]": ("impulse",), "duration [ms]": ("duration",)}
BANDS = (
    *columns({"strike": "Strike", "quantity": "Quantity"}),
    Column("own", "Scene", form=".1f", style="strong", unit_key="unit"),
    *(Column(f"{p} %", f"{p} %", form=".1f", group="Band", unit_key="unit") for p in PERCENTILES),
    Column("unit", "Unit", is_unit=True),
    Column("source", "Main source of variance"),
    _index("total", "Total index", ".2f"),
)
# Quantities whose indices are shown.
SHOWN = {"mean_50ms": "50 ms", "impulse": "impulse", "duration": "duration"}

ROWS = (
    *columns({"label": "Row", "kind": "Quantity"}),
    *columns({"measured": "D", "simulated": "S"}, unit="N", form=".0f", style="strong"),
    *columns({"band.0": "5 %", "band.2": "95 %"}, unit="N", form=".0f", group="Band of S"),
    Column("error", "E", "N", form="+.0f"),
)
UNCERTAINTY = (
    Column("share_below", "Below D", form=".2f"),
    Column("u_num", "u_num", "N", form=".2g"),
    Column("u_input", "u_input", "N", form=".0f"),
)
VERDICT = Column("verdict", "|E| and u_val")
ROW_NOTES = (
    "D: force of Tables 4 and 5 of the paper, from crash tests or finite elements; * projected by the authors as 1.33 "
    "times the 50 ms mean. S: second strike of the rigid vehicle. E = S - D. As in ASME V&V 20, u_val^2 = u_num^2 + "
    "u_input^2 + u_D^2. u_num: time-step error. u_input: standard deviation of the samples. u_D: unknown measurement "
    "uncertainty; the last column states the u_D at which |E| = u_val.",
    "Speed and angle are those of the scene, except in row b (57.4 mph, 15.4 deg); mass, length, crush and restitution "
    "of the tested vehicles are unknown. The barriers of rows a and b are not plain vertical walls. Neither ranges nor "
    "results are fitted to these rows.",
)
NOT_TL_4 = f"Tables 4 and 5 of the paper contain {LEVEL} only; impact.test_level of this scene differs."
INDEX_NOTE = (
    "Total Sobol indices: fraction of the variance that remains if all other inputs are known, with 95 % intervals. "
    "Dashes: not determined."
)
INDEX_METHOD = (
    "Sobol indices are fractions of the variance due to an input: without (first order) and with its interactions "
    f"(total). The 95 % confidence intervals are from {GROUPS} groups of samples (jackknife, Student's t)."
)


def report(found: Spread) -> Report:
    """Report of the study."""
    return impact_report(found) if found.case.scene.contact else corner_report(found)


def _report(
    found: Spread,
    kicker: str,
    sentences: tuple[str, str],
    sections: Any,
    numbers: Any,
    terminal: Any,
    **curves: Table,
) -> Report:
    """Page, summary and files; sentences: answer and certainty."""
    headline = Headline(f"Uncertainty: {found.case.subject}", sentences[0], found.case.set_up, sentences[1])
    files = ["summary.json (results in SI)", "samples.csv (samples)"]
    if curves:
        files[1:] = ["samples.csv (samples)", "curves.csv (curves)"]
    head, cost = study_summary("uncertainty", found.case), {"seconds": found.seconds}
    return Report(
        study_page(found.case, kicker, headline, sections, "; ".join(files)),
        {**head, "seed": SEED, **numbers, "cost": cost},
        terminal,
        {f"{name}.csv": table for name, table in curves.items()},
        {"samples.csv": found.samples},
    )


def _input_rows(found: Spread) -> list[dict[str, Any]]:
    """Inputs in the order of the scene, with their ranges as text."""
    words = ((item, *item.in_words()) for item in found.ranges)
    return [{"key": i.key, "range": ends, "origin": i.origin, "value": own} for i, ends, own in words]


def corner_report(found: Spread) -> Report:
    """Report on the peak force of a tail-slap."""
    words = {row["key"]: row for row in _input_rows(found)}
    inputs = [words[row["key"]] | row for row in found.sources_of("peak_force")]
    sentences, refusals = _corner_answer(found, inputs), _refusals(found)
    refused = found.refused_sources.get("peak_force", "")
    counts, edges = np.histogram(found.band("peak_force").values, BINS)
    own, used = found.own["peak_force"], used_keys(found.case.scene)
    keys = [row.key for row in scene_inputs(found.case.scene, found.case.source)]
    held = tuple(key for key in keys if key in used and key not in words)
    percentiles = list(zip(PERCENTILES, found.band("peak_force").percentiles, strict=True))
    histogram = figures.draw_histogram(edges, counts, percentiles, own)
    table = Table((*INPUTS, *INDICES), inputs, notes=("95 % confidence intervals are below the indices.",))
    drawn_indices = [figures.draw_sensitivity(inputs)]
    if refused:
        table, drawn_indices = Table(INPUTS, list(words.values()), notes=(refused,)), []
    explained = _corner_sentences(found, refusals, held)
    sections = (
        Section("Distribution", figures=(histogram,), layout="half"),
        Section("Sensitivity", refused, drawn_indices, layout="half"),
        Section("Inputs and Sobol indices", tables=(table,)),
        Section("Peak force", tables=(_forces_table(found),), layout="half"),
        Section("Method", sentences=explained, layout="half"),
    )
    title = f"{found.case.scene.name}: Sobol indices of the peak force"
    cost = f"Cost:   {found.computed} combinations in {found.seconds:.2f} s"
    terminal = (
        refused or Table(with_intervals((INPUTS[0], *INDICES)), inputs, title=title),
        refusals,
        cost,
    )
    kicker = "Uncertainty of the peak force of the tail-slap, by the rigid-body method"
    drawn = {"of_the_scene": own, "histogram": {"edges": edges, "counts": counts}}
    return _report(found, kicker, sentences, sections, _corner_summary(found, drawn, held), terminal)


def _corner_summary(found: Spread, drawn: dict[str, Any], held: tuple[str, ...]) -> dict[str, Any]:
    """Summary; drawn: the histogram; held: fixed keys."""
    refused, left_out = found.refused
    return {
        **{"rows": found.rows, "combinations": found.computed, "refused": refused, "rows_left_out": left_out},
        "first_refusal": found.refusal or None,
        "peak_force": {**found.band("peak_force").numbers(), **drawn},
        "inputs": found.sources["peak_force"] or [asdict(item) for item in found.ranges],
        "indices_refused": found.refused_sources.get("peak_force"),
        "held": held,
    }


def _corner_answer(found: Spread, inputs: list[dict[str, Any]]) -> tuple[str, str]:
    """Mean and spread of the peak force; its largest source, and the combinations without an answer."""
    band, own, (refused, _) = found.band("peak_force"), found.own["peak_force"], found.refused
    low, _, high = band.percentiles
    answer = (
        f"Peak lateral force at the tail-slap: mean {force(band.mean)}, standard deviation "
        f"{force(band.standard_deviation)}; 90 % of the samples lie between {force(low)} and {force(high)}. "
        f"The nominal case ({force(own)}) exceeds {100.0 * band.fraction_below(own):.0f} % of the samples."
    )
    certainty = f"{grouped(found.computed)} samples"
    certainty += f"; largest part of the variance from {main_source(inputs[0])}." if inputs else "."
    if refused:
        certainty += (
            f" {100.0 * refused / found.computed:.2g} % of them have no solution and are not included."
        )
    return answer, certainty


def _refusals(found: Spread) -> str:
    """Number of samples without a solution, and its effect on the indices."""
    refused, left_out = found.refused
    if not refused:
        return "All samples have a solution."
    return (
        f"{grouped(refused)} of {grouped(found.computed)} samples ({100.0 * refused / found.computed:.2g} %) have no "
        f"solution and are excluded from the distribution. {grouped(left_out)} of {grouped(found.rows)} rows contain "
        "such samples and are excluded from the indices, which are therefore approximate. First reason: "
        f"{found.refusal}."
    )


def _corner_sentences(found: Spread, refusals: str, held: tuple[str, ...]) -> list[str]:
    """Description of the method."""
    return [
        f"The inputs are independent and uniformly distributed over their ranges. {grouped(found.rows)} points of "
        f"{points_in_words(len(found.ranges), found.rows)} (seed {SEED}) define {grouped(found.computed)} samples, "
        "each solved exactly by Stages 1 to 3. Results are reproducible.",
        refusals,
        *([f"Fixed inputs: {', '.join(held)} (varied by --range)."] if held else []),
        INDEX_METHOD,
        "The duration of the triangular force pulse is an input; the rigid-body method does not predict it.",
    ]


def _forces_table(found: Spread) -> Table:
    """Mean, standard deviation, percentiles and nominal value of the peak force."""
    band = found.band("peak_force")
    forces = {"mean": band.mean, "standard deviation": band.standard_deviation}
    forces |= {f"{p} % percentile": x for p, x in zip(PERCENTILES, band.percentiles, strict=True)}
    forces |= {"nominal case": found.own["peak_force"]}
    return pairs([(name, force / 1e3, "kN") for name, force in forces.items()])


def impact_report(found: Spread) -> Report:
    """Report on both strikes of a whole impact."""
    main, of = _main(found)
    inputs, sentences, levels = found.sources_of(main), _impact_answer(found), _levels(found)
    of = of[0].lower() + of[1:]
    sensitivity = [figures.draw_sensitivity(inputs, f"the {of}")] if inputs else []
    beside = [row | {"label": row["row"] + "*" * row["projected"]} for row in found.beside]
    rows = Table((*ROWS, *UNCERTAINTY, VERDICT), beside, "", ROW_NOTES)
    single = int(np.count_nonzero(np.isnan(found.samples["strike_2.impulse"])))
    sections = (
        Section("Bands", figures=[_band_figure(found)], tables=[_bands_table(found)]),
        Section("Largest 50 ms mean and design forces", tables=[levels]),
        Section("Inputs and Sobol indices", tables=[_inputs_table(found)]),
        Section(f"Sensitivity of the {of}", figures=sensitivity, layout="half"),
        Section("Method", "", (), (), _impact_sentences(found, single), "half"),
        Section("Comparison with Tables 4 and 5 of the paper", "" if beside else NOT_TL_4, tables=[rows]),
        Section("Variation of single inputs", figures=_curve_figures(found)),
    )
    kinds, numbers = ("first_order", "first_order_interval", "total", "total_interval"), {}
    for name in found.tables:
        indices = {row["key"]: {kind: row[kind] for kind in kinds} for row in found.sources.get(name, ())}
        refused = found.refused_sources.get(name)
        numbers[name] = {**found.band(name).numbers(), "indices": indices, "indices_refused": refused}
    summary = {
        **{"impacts": found.computed, "without_second_strike": single, "own": found.own, "bands": numbers},
        "inputs": [asdict(item) for item in found.ranges],
        "rows": found.beside,
        **({"levels": levels.rows} if levels.rows else {}),
    }
    terminal = (
        _bands_table(found, f"{found.case.scene.name}: both strikes"),
        short(levels),
        _inputs_table(found, short=True),
        *_refused_indices(found),
        Table((*ROWS, VERDICT), beside, "Comparison with Tables 4 and 5 (* projected); u_D is unknown"),
        f"Cost:   {found.computed} impacts in {found.seconds:.1f} s",
    )
    kicker = "Uncertainty of both strikes of a whole impact"
    return _report(found, kicker, sentences, sections, summary, terminal, curves=_curves_table(found))


def _main(found: Spread) -> tuple[str, str]:
    """The quantity of the headline, and what it is called: of a train the largest mean, whichever strike brings it."""
    if LARGEST in found.tables:
        return LARGEST, "Largest 50 ms mean"
    return MAIN, "50 ms mean of the second strike"


def _levels(found: Spread) -> Table:
    """The largest 50 ms mean of a train beside the design forces of its test level; empty without."""
    level = found.case.scene.impact.test_level if LARGEST in found.tables else None
    rows = [
        {"name": name, "force": each.force, "source": each.source}
        | {"above": 1.0 - found.band(LARGEST).fraction_below(each.force)}
        for name, each in known_forces(level).items()
    ]
    return Table(LEVELS, rows)


def _impact_answer(found: Spread) -> tuple[str, str]:
    """The main quantity; its largest source, and the rows of the paper."""
    main, of = _main(found)
    low, _, high = found.band(main).percentiles
    answer = (
        f"{of}: 90 % of the samples lie between {force(low)} and {force(high)}; nominal "
        f"case {force(found.own[main])}."
    )
    certainty = f"{grouped(found.computed)} impacts of the rigid vehicle."
    if sources := found.sources_of(main):
        first = sources[0]
        certainty += f" Largest part of the variance from {main_source(first)}."
    if shown := [row for row in found.beside if not row["projected"]]:
        inside = sum(row["band"][0] <= row["measured"] <= row["band"][2] for row in shown)
        within = sum(row["within"] for row in shown)
        certainty += (
            f" Of {len(shown)} forces of Tables 4 and 5 that were not projected, {inside} lie in the band, and "
            f"{within} within u_val with u_D unknown."
        )
    return answer, certainty


def _impact_sentences(found: Spread, single: int) -> list[str]:
    """Description of the method."""
    sentences = [
        f"The inputs are independent and uniformly distributed over their ranges. {grouped(found.computed)} impacts of "
        f"the rigid vehicle: {grouped(2 * found.rows)} points of {points_in_words(len(found.ranges), found.rows)} "
        f"(seed {SEED}) for the distribution, the others for the indices. Results are reproducible.",
        INDEX_METHOD,
        "Raw: force at the striking corner. Filtered and 50 ms mean forces: total force on the wall during the strike.",
        "The duration of the strikes follows from mass, crush and friction.",
        "The distribution reflects these ranges only. The model excludes roll and pitch, shifting load, deflection of "
        "the wall, wheels and suspension.",
    ]
    if LARGEST in found.tables:
        sentences.append("Strike 1 is that of the first unit's front, strike 2 that of the last unit's rear.")
    if single:
        sentences.append(
            f"{grouped(single)} impacts have no second strike; they are excluded from its distribution and indices."
        )
    return sentences


def _bands_table(found: Spread, title: str = "") -> Table:
    """Nominal value, percentiles and main source of variance of all quantities of both strikes."""
    rows = []
    for name in found.tables:
        strike, quantity = name.removeprefix("strike_").split(".")
        label, unit, scale = QUANTITIES[quantity]
        ends = zip(PERCENTILES, found.band(name).percentiles, strict=True)
        first = next(iter(found.sources_of(name)), {"key": "–", "total": None, "total_interval": None})
        row = {
            "strike": int(strike) if strike.isdigit() else "largest",
            "quantity": label,
            "own": found.own[name] / scale,
            "unit": unit,
        }
        row |= {f"{p} %": value / scale for p, value in ends}
        rows.append(
            row | {"source": first["key"], **{key: first[key] for key in ("total", "total_interval")}}
        )
    return Table(with_intervals(BANDS) if title else BANDS, rows, title)


def _inputs_table(found: Spread, short: bool = False) -> Table:
    """Ranges of the inputs and total indices of the main quantities; short: of the second strike only."""
    strikes, inputs = (2,) if short else (1, 2), _input_rows(found)
    heads = [
        _index(f"strike_{k}.{name}", label, ".2f", "" if short else f"Strike {k}")
        for k in strikes
        for name, label in SHOWN.items()
        if f"strike_{k}.{name}" in found.sources
    ]
    if LARGEST in found.sources:
        heads.insert(0, _index(LARGEST, "Largest 50 ms", ".2f"))
    for head in heads:
        sources = found.sources[head.key] or [{"total": None, "total_interval": None}] * len(inputs)
        for row, source in zip(inputs, sources, strict=True):
            row |= {head.key: source["total"], f"{head.key}_interval": source["total_interval"]}
    if short:
        heads = list(with_intervals(heads))
        return Table((*INPUTS[:2], *heads), inputs, "Inputs and total Sobol indices of strike 2")
    return Table((*INPUTS, *heads), inputs, notes=(INDEX_NOTE, *_refused_indices(found)))


def _refused_indices(found: Spread) -> list[str]:
    """Quantities whose indices are refused, and why."""
    return [f"{name}: {why}" for name, why in found.refused_sources.items()]


def _curves_table(found: Spread) -> Table:
    """Impacts of the curves, in SI."""
    heads = columns({"input": "Input", "value": "Value"} | {name: name for name in COLUMNS})
    rows = [
        {"input": curve["key"], "value": value, **{n: float(curve["columns"][n][i]) for n in COLUMNS}}
        for curve in found.curves
        for i, value in enumerate(curve["values"].tolist())
    ]
    return Table(heads, rows)


def _curve_figures(found: Spread) -> list[Any]:
    """Peak forces, impulses and durations over each input."""
    panels = []
    for curve in found.curves:
        key = curve["key"]
        label, unit, scale = CURVES.get(key) or CURVES[key.rpartition(".")[2]]
        if key.startswith("trailer"):
            label = f"trailer {int(key.split('.')[1]) + 1}: {label}"
        lines = {
            axis: {k: dict(_curve(curve, f"strike_{k}.{name}") for name in names) for k in (1, 2)}
            for axis, names in CURVE_AXES.items()
        }
        name = "against-" + key.replace(".", "-").replace("_", "-")
        heading = f"{label} [{unit}]" if unit else label
        values, own, logarithmic = curve["values"] / scale, curve["own"] / scale, key.endswith("stiffness")
        panels.append(figures.InputPanel(name, heading, values, own, logarithmic, lines))
    return figures.draw_inputs("Both strikes over", panels)


def _curve(curve: Mapping[str, Any], column: str) -> tuple[str, Any]:
    """Label and displayed values of a quantity."""
    label, _, scale = QUANTITIES[column.split(".")[1]]
    return label, curve["columns"][column] / scale


def _band_figure(found: Spread) -> Any:
    """Percentiles of the peak forces, with the rows of the paper."""
    bars = []
    for name in ("raw", "mean_50ms", "cfc60"):
        kind = TAKEN.get(name, ("",))[0]
        rows = [row for row in found.beside if row["kind"] == kind]
        dots = [(row["row"], row["measured"] / 1e3, row["projected"]) for row in rows]
        for strike in (1, 2):
            column, label = f"strike_{strike}.{name}", f"{QUANTITIES[name][0]}, strike {strike}"
            low, middle, high = (force / 1e3 for force in found.band(column).percentiles)
            ends, own = (low, middle, high), found.own[column] / 1e3
            bars.append(figures.BandBar(label, strike, ends, own, dots if strike == 2 else ()))
    return figures.draw_bands(bars)
