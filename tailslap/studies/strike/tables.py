"""The tables of the study, declared on its records."""

from __future__ import annotations

import math
from typing import Any

from postprocess.report.numbers import known, percent
from postprocess.report.table import Column, Table
from tailslap.studies.strike.bands import Bands
from tailslap.studies.strike.campaign import StrikeResults
from tailslap.studies.strike.quantities import COLUMNS, QUANTITIES, STRIKES, column
from tailslap.studies.strike.rows import LEVEL, RowBeside
from tailslap.studies.uncertainty.spread import PERCENTILES

SHARE = known(".2f")
BANDS = (
    Column("strike", "Strike"),
    Column("quantity", "Quantity"),
    Column("own", "Scene", form=".1f", style="strong", unit_key="unit"),
    *(
        Column(f"percentiles.{k}", f"{p} %", form=".1f", group="Band", unit_key="unit")
        for k, p in enumerate(PERCENTILES)
    ),
    Column("unit", "Unit", is_unit=True),
    Column("source", "Most of the variance from"),
    Column("share", "Index", form=SHARE),
)
INPUTS = (
    Column("key", "Input"),
    Column("range", "Range", form=str),
    Column("origin", "From"),
    Column("value", "Scene", form=str),
)
SHOWN = {"mean_50ms": "50 ms", "impulse": "impulse", "duration": "duration"}
SOURCES = {column(k, name): (f"Strike {k}", label) for k in STRIKES for name, label in SHOWN.items()}
"""Quantities whose indices are shown."""

ROW = (
    Column("label", "Row"),
    Column("kind", "By"),
    Column("measured", "D", "N", form=".0f", style="strong"),
    Column("simulated", "S", "N", form=".0f", style="strong"),
    Column("ends.0", "5 %", "N", form=".0f", group="Band of S"),
    Column("ends.2", "95 %", "N", form=".0f", group="Band of S"),
    Column("error", "E", "N", form="+.0f"),
)
UNCERTAINTY = (
    Column("share_below", "Below D", form=".2f"),
    Column("u_num", "u_num", "N", form=".2g"),
    Column("u_input", "u_input", "N", form=".0f"),
)
VERDICT = Column("verdict", "|E| against u_val")
ROW_NOTES = (
    "D: measured, by crash test or finite elements, as Tables 4 and 5 of the paper have it; * projected by its "
    "authors, 1.33 times the 50 ms mean. S: the second strike of the rigid vehicle. E = S - D; as in ASME V&V 20, "
    "u_val^2 = u_num^2 + u_input^2 + u_D^2. u_num: the many impacts' solution against the one from event to event. "
    "u_input: the band's standard deviation. u_D: unknown; no source gives it, and the last column says how large it "
    "would have to be for |E| to be within u_val.",
    "Of the rows' impacts only row b's 57.4 mph and 15.4 deg are known, and put in; mass and length of the vehicles, "
    "their crush and restitution are not. The walls of rows a and b are rails on posts or with a batter, no plain "
    "walls. No range was set by these rows, and no row is fitted.",
)


def curves_table(found: StrikeResults) -> Table:
    """A row an impact of the curves, SI, for a file."""
    heads = (Column("input", "Input"), Column("value", "Value"), *(Column(name, name) for name in COLUMNS))
    rows = [
        {"input": each.input.key, "value": value, **{name: float(each.columns[name][i]) for name in COLUMNS}}
        for each in found.curves
        for i, value in enumerate(each.input.values.tolist())
    ]
    return Table(heads, rows)


def bands_table(bands: Bands, own: Any, title: str = "") -> Table:
    """All quantities of both strikes: the scene's own values, bands, and the first source of the variance."""
    rows = [_band_row(bands, own, strike, name) for strike in STRIKES for name in range(len(QUANTITIES))]
    return Table(BANDS, rows, title)


def _band_row(bands: Bands, own: Any, strike: int, number: int) -> dict[str, Any]:
    quantity = QUANTITIES[number]
    name = column(strike, quantity.name)
    sources = bands.sources_of(name)
    return {
        "strike": strike,
        "quantity": quantity.label,
        "own": own[name] / quantity.scale,
        "percentiles": [x / quantity.scale for x in bands.band(name).percentiles],
        "unit": quantity.unit,
        "source": sources[0].key if sources else "–",
        "share": sources[0].total if sources else math.nan,
    }


def inputs_table(bands: Bands) -> Table:
    """Ranges of the bands, and the total indices of the main quantities."""
    shown = {name: labels for name, labels in SOURCES.items() if name in bands.sources}
    heads = [Column(name, label, form=SHARE, group=group) for name, (group, label) in shown.items()]
    note = (
        "Sobol indices, with interactions: the share of the variance that would stay if all else were known."
    )
    return Table((*INPUTS, *heads), _indexed(bands, shown), notes=(note,))


def short_inputs_table(bands: Bands) -> Table:
    """The same for a terminal: the second strike alone."""
    shown = {name: labels for name, labels in SOURCES.items() if name in bands.sources and "2" in name}
    heads = [Column(name, label, form=SHARE) for name, (_, label) in shown.items()]
    return Table(
        (INPUTS[0], INPUTS[1], *heads), _indexed(bands, shown), "Inputs, and their shares of strike 2"
    )


def _indexed(bands: Bands, shown: Any) -> list[dict[str, Any]]:
    rows = []
    for number in range(len(bands.ranges)):
        each = {name: bands.sources[name][number] for name in shown}
        first = next(iter(each.values()))
        words = {"key": first.key, "range": first.range, "origin": first.origin, "value": first.value}
        rows.append(words | {name: item.total for name, item in each.items()})
    return rows


def rows_table(rows: tuple[RowBeside, ...], title: str = "", short: bool = False) -> Table:
    """Rows a to f beside the bands."""
    columns = (*ROW, *(() if short else UNCERTAINTY), VERDICT)
    return Table(columns, rows, title, () if short else ROW_NOTES)


def plates_table(found: StrikeResults, title: str = "", short: bool = False) -> Table:
    """Both strikes against the first frequency; short: without the raw peaks."""
    names = ("mean_50ms", "impulse", "duration")
    chosen = [q for q in QUANTITIES if q.name in names or not short]
    heads = [
        Column(
            column(s, q.name),
            q.label.replace(" mean", ""),
            q.unit,
            form=known(".1f"),
            group=f"Strike {s}",
        )
        for s in STRIKES
        for q in chosen
    ]
    first = Column("frequency", "f_1", "Hz", form=lambda f: f"{f:g}" if math.isfinite(f) else "rigid")
    last = Column("error", "Mesh", form=lambda e: percent(e, 1).lstrip("+") if math.isfinite(e) else "–")
    failed = {n: "failed" for n, point in enumerate(found.plates) if not point.passed}
    rows = [
        {"frequency": point.frequency, "error": point.error}
        | {
            column(s, q.name): point.values.get(column(s, q.name), math.nan) / q.scale
            for s in STRIKES
            for q in chosen
        }
        for point in found.plates
    ]
    return Table((first, *heads, last), rows, title, marks=failed)


NOT_TL_4 = f"Tables 4 and 5 of the paper are of {LEVEL}: a scene with another impact.test_level has no rows beside it."
