"""What `tailslap compare` reports."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

import tailslap
from postprocess.comparison.comparison import QUANTITIES
from postprocess.comparison.side_by_side import LIMITS, Beside
from postprocess.figures.overlay import Line, Overlay, overlay_curve
from postprocess.figures.panels import COMPARED
from postprocess.figures.svg.chart import Chart
from postprocess.report.numbers import percent
from postprocess.report.page import Page, Section
from postprocess.report.report import Report
from postprocess.report.table import Column, Table
from postprocess.report.units import SI
from tailslap.comparing.compared import Comparison
from tailslap.report.common import footer


def _hundredths(share: float) -> str:
    """A share in per cent, its sign and no unit."""
    return percent(share).removesuffix(" %")


METRICS = (
    Column("item", "Result"),
    Column("name", "Column"),
    Column("magnitude", "M", form=_hundredths),
    Column("phase", "P", form=_hundredths),
    Column("combined", "C", form=_hundredths),
    Column("mean_residual", "Mean", form=_hundredths),
    Column("deviation", "SD", form=_hundredths),
    Column("largest", "Largest", form=_hundredths),
    Column("within", "Within", form=lambda within: "yes" if within else "NO"),
)
WORDS = {panel.name: (panel.symbol, panel.caption) for panel in COMPARED} | {
    "x_g": ("x_G", "Centre of mass along the wall"),
    "y_g": ("y_G", "Centre of mass across the wall"),
    "force_normal": ("force", "Force of the wall on the vehicle across it"),
    "force_tangential": ("force", "Force of the wall on the vehicle along it"),
}
"""Symbol and caption of what is drawn, by column."""

NOTE = (
    "M, P, C: magnitude, phase and comprehensive metric of Sprague and Geers. Mean and standard deviation (SD) of the "
    "differences over the reference's peak, as in the analysis of variance of NCHRP W179, and the largest difference. "
    f"Within: M, P, C at most {100 * LIMITS.magnitude:.0f} %, mean {100 * LIMITS.mean_residual:.0f} %, SD "
    f"{100 * LIMITS.deviation:.0f} %."
)


def compare_report(found: Comparison) -> Report:
    """Page, summary, and what the terminal says."""
    table, notes = metrics_table(found), [note for item in found.items for note in item.notes]
    page = Page(
        kicker="Histories side by side",
        title=" · ".join(item.label for item in found.items),
        headline=headline(found),
        sections=(
            Section("Metrics", tables=(table,), sentences=notes),
            Section("Numbers of the results", tables=tuple(_quantities(found))),
            Section("Curves", figures=_curves(found), layout="wide"),
            Section("Differences from the reference", figures=_differences(found), layout="wide"),
        ),
        footer=footer("summary.json, these numbers; metrics.csv, the table"),
        passed=found.within,
    )
    said: tuple[Table | str, ...] = (table, *notes, headline(found))
    return Report(page, summary(found), said, tables={"metrics.csv": table})


def headline(found: Comparison) -> str:
    """Whether all is within the limits, and what is furthest off."""
    every = [(label, each) for label, columns in found.beside.items() for each in columns]
    label, worst = max(every, key=lambda pair: _size(pair[1]))
    outside = [f"{each.name} of {label}" for label, each in every if not each.within]
    verdict = (
        f"Beyond NCHRP W179's limits: {', '.join(outside)}."
        if outside
        else f"All {len(every)} histories are within NCHRP W179's limits."
    )
    return (
        f"{verdict} Against {found.reference.label}, {worst.name} of {label} differs most, by "
        f"{percent(worst.largest[0])} of its peak, at {worst.largest[1]:.4g} s."
    )


def _size(each: Beside) -> float:
    size = abs(each.largest[0])
    return size if math.isfinite(size) else math.inf


def metrics_table(found: Comparison) -> Table:
    """A row a column of each item but the reference."""
    rows = [{"item": label, **_numbers(each)} for label, columns in found.beside.items() for each in columns]
    marks = {k: "failed" for k, row in enumerate(rows) if not row["within"]}
    return Table(METRICS, rows, f"Against {found.reference.label}, in %", notes=(NOTE,), marks=marks)


def _numbers(each: Beside) -> dict[str, Any]:
    largest, at = each.largest
    return {
        "name": each.name,
        **asdict(each.metrics),
        "largest": largest,
        "at": at,
        "at_end": each.at_end,
        "from": float(each.t[0]),
        "to": float(each.t[-1]),
        "within": each.within,
    }


def summary(found: Comparison) -> dict[str, Any]:
    """All numbers; differences are relative to the reference."""
    return {
        "version": tailslap.__version__,
        "reference": found.reference.label,
        "passed": found.within,
        "limits": asdict(LIMITS),
        "compared": {
            label: {each.name: _numbers(each) for each in columns} for label, columns in found.beside.items()
        },
        "notes": [note for item in found.items for note in item.notes],
    }


def _quantities(found: Comparison) -> Iterator[Table]:
    """The five quantities of results with a tail-slap, side by side."""
    items = [item for item in found.items if item.summary and "t" in item.summary.get("fe", {})]
    if len(items) < 2:
        return
    columns = (
        Column("title", "At the tail-slap, FE"),
        Column("unit", "Unit", is_unit=True),
        *(Column(str(k), item.label, form=".7g", unit_key="unit") for k, item in enumerate(items)),
    )
    rows = [
        {"title": q.title, "unit": q.unit}
        | {str(k): (item.summary or {})["fe"][q.key] for k, item in enumerate(items)}
        for q in QUANTITIES.values()
    ]
    yield Table(columns, rows)


def _curves(found: Comparison) -> list[Chart]:
    """Each column of all results."""
    return [
        _curve(
            found,
            name,
            [Line(i.label, i.columns["t"], i.columns[name]) for i in found.items if name in i.columns],
        )
        for name in found.names
    ]


def _differences(found: Comparison) -> list[Chart]:
    """Each column less the reference's."""
    every = [(label, each) for label, columns in found.beside.items() for each in columns]
    return [
        _curve(
            found,
            name,
            [Line(label, x.t, x.difference) for label, x in every if x.name == name],
            "difference",
        )
        for name in found.names
    ]


def _curve(found: Comparison, name: str, lines: list[Line], what: str = "") -> Chart:
    symbol, caption = WORDS.get(name, (name, f"Column `{name}`"))
    title = f"{what} of {symbol}" if what else symbol
    if what:
        caption = f"{caption.partition(',')[0]}, less that of {found.reference.label}"
    overlay = Overlay(title, found.reference.units.get(name, ""), lines)
    return overlay_curve(f"{what}_{name}" if what else name, overlay, caption).in_units(SI)
