"""Comparison of results with a reference."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import tailslap
from postprocess.comparison.quantities import LIMITS, QUANTITIES, Beside, beside
from postprocess.figures.histories import COMPARED, Curve, draw_overlay
from postprocess.report.page import Column, Headline, Page, Section, Table, columns
from postprocess.report.report import Report
from postprocess.svg.chart import FULL, PART, Chart
from postprocess.units import SI, percent
from tailslap.case.report import footer
from tailslap.comparing.source import TIME, Item, parse_mapping, read_item
from tailslap.errors import InputError, Verbatim, one_of

USUAL = (
    *("theta", "omega", "v_gx", "v_gy", "slide", "reaction_normal", "reaction_tangential"),
    *("x_g", "y_g", "force_normal", "force_tangential"),
)
"""Columns compared by default."""

FORCES = ("force_normal", "reaction_normal")
"""Forces across the wall, one of which takes the width of the page."""

HEADS = {"magnitude": "M", "phase": "P", "combined": "C", "mean_residual": "Mean", "deviation": "SD"}
METRICS = (
    *columns({"item": "Result", "name": "Column"}),
    *columns({**HEADS, "largest": "Largest"}, form=lambda ratio: percent(ratio).removesuffix(" %")),
    Column("within", "Within", form=lambda within: "yes" if within else "NO"),
)
WORDS = {panel.name: (panel.symbol, panel.caption) for panel in COMPARED} | {
    "x_g": ("x_G", "Position of the centre of mass along the wall"),
    "y_g": ("y_G", "Distance of the centre of mass from the wall"),
    "force_normal": ("force", "Normal force of the wall on the vehicle"),
    "force_tangential": ("force", "Tangential force of the wall on the vehicle"),
}
"""Symbol and caption of the curves, by column."""

NOTE = (
    "M, P, C: Sprague-Geers magnitude, phase and comprehensive metrics. Mean, standard deviation (SD) and largest "
    "value of the differences, relative to the peak of the reference, as in NCHRP W179. Limits: "
    f"{100 * LIMITS.magnitude:.0f} % for M, P and C, {100 * LIMITS.mean_residual:.0f} % for the mean, "
    f"{100 * LIMITS.deviation:.0f} % for SD."
)


@dataclass(frozen=True)
class Comparison:
    """Items, of which the first is the reference; pairs: label of another item and a common column."""

    items: tuple[Item, ...]
    pairs: tuple[tuple[str, Beside], ...]

    @property
    def reference(self) -> Item:
        """Item that the others are compared with."""
        return self.items[0]

    @property
    def within(self) -> bool:
        """True if all metrics are within the limits."""
        return all(each.within for _, each in self.pairs)


def compare_items(
    given: Sequence[object],
    columns: Mapping[str, str] | str | None = None,
    only: Sequence[str] = (),
    force: bool = False,
) -> Comparison:
    """Compare results, folders and files with the first one; force: include damaged ones. Raises InputError."""
    if len(given) < 2:
        allowed = "two or more results are required; the first is the reference"
        raise InputError("RESULT", Verbatim(len(given)), allowed)
    mapping = parse_mapping(columns) if isinstance(columns, str) else dict(columns or {})
    items = [read_item(each, mapping, force) for each in given]
    labels = [item.label for item in items]
    items = [
        replace(item, label=f"{item.label} ({k})") if labels.count(item.label) > 1 else item
        for k, item in enumerate(items, 1)
    ]
    pairs = [(item.label, each) for item in items[1:] for each in _in_common(item, items[0], only)]
    return Comparison(tuple(items), tuple(pairs))


def _in_common(item: Item, reference: Item, only: Sequence[str]) -> list[Beside]:
    common = [name for name in reference.columns if name in item.columns and name != TIME]
    for name in only:
        if name not in common:
            raise InputError("--only", name, one_of(name, common, "allowed are the common columns,"))
    chosen = only or [name for name in USUAL if name in common] or common
    found = [each for name in chosen if (each := beside(name, item.columns, reference.columns))]
    if not found:
        allowed = f"it has no column and time range in common with {reference.label}; see --columns"
        raise InputError("RESULT", item.label, allowed)
    return found


def compare_report(found: Comparison) -> Report:
    """Report of a comparison."""
    table, opening = metrics_table(found), headline(found)
    notes = [note for item in found.items for note in item.notes]
    compared: dict[str, Any] = {item.label: {} for item in found.items[1:]}
    for label, each in found.pairs:
        compared[label][each.name] = _numbers(each)
    summary = {
        "version": tailslap.__version__,
        "reference": found.reference.label,
        "passed": found.within,
        "limits": asdict(LIMITS),
        "compared": compared,
        "notes": notes,
    }
    sections = (
        Section("Metrics", tables=(table,), sentences=notes),
        Section("Results at the tail-slap", tables=tuple(_quantities(found))),
        Section("Curves", figures=[*_curves(found)]),
        Section("Differences from the reference", figures=[*_curves(found, True)]),
    )
    below = footer("summary.json, these numbers; metrics.csv, the table; validation.html")
    page = Page("Histories side by side", opening, sections, below, passed=found.within)
    return Report(page, summary, (table, *notes), tables={"metrics.csv": table})


def headline(found: Comparison) -> Headline:
    """Comparison with the limits of the metrics, the results, and the largest difference."""
    sizes = [abs(each.largest[0]) for _, each in found.pairs]
    most = max(range(len(sizes)), key=lambda k: sizes[k] if math.isfinite(sizes[k]) else math.inf)
    label, worst = found.pairs[most]
    outside = [f"{each.name} of {label}" for label, each in found.pairs if not each.within]
    answer = f"All {len(sizes)} histories are within the limits of NCHRP W179."
    if outside:
        answer = f"Failed: beyond the limits of NCHRP W179: {', '.join(outside)}."
    difference = (
        f"Largest difference: {worst.name} of {label}, {percent(worst.largest[0])} of the peak, at "
        f"{worst.largest[1]:.4g} s."
    )
    labels = ", ".join(item.label for item in found.items[1:])
    set_up = f"Compared: {labels}; reference: {found.reference.label}."
    return Headline(f"Comparison of {labels} with {found.reference.label}", answer, set_up, difference)


def metrics_table(found: Comparison) -> Table:
    """Table of metrics, one row per item and column."""
    rows = [{"item": label, **_numbers(each)} for label, each in found.pairs]
    marks = {k: "failed" for k, row in enumerate(rows) if not row["within"]}
    return Table(METRICS, rows, f"Differences from {found.reference.label}, in %", notes=(NOTE,), marks=marks)


def _numbers(each: Beside) -> dict[str, Any]:
    largest, at = each.largest
    found = {"name": each.name, **asdict(each.metrics), "largest": largest, "at": at, "at_end": each.at_end}
    return found | {"from": float(each.t[0]), "to": float(each.t[-1]), "within": each.within}


def _quantities(found: Comparison) -> Iterator[Table]:
    """Table of the quantities at the tail-slap."""
    summaries = {item.label: item.summary or {} for item in found.items}
    results = {
        label: {**its["fe"], "peak_force": its.get("peak_force", {}).get("fe")}
        for label, its in summaries.items()
        if "t" in its.get("fe", {})
    }
    if len(results) < 2:
        return
    heads = (
        Column("title", "At the tail-slap, FE"),
        Column("unit", "Unit", is_unit=True),
        *(Column(str(k), label, form=".7g", unit_key="unit") for k, label in enumerate(results)),
    )
    numbered = [(str(k), fe) for k, fe in enumerate(results.values())]
    rows = [
        *map(vars, QUANTITIES.values()),
        {"key": "peak_force", "title": "Peak lateral force", "unit": "N"},
    ]
    yield Table(heads, [{**row, **{k: fe[row["key"]] for k, fe in numbered}} for row in rows])


def _curves(found: Comparison, less: bool = False) -> Iterator[Chart]:
    """Charts of the compared columns, the force first; less: of the differences from the reference."""
    names = [*dict.fromkeys(each.name for _, each in found.pairs)]
    main = next((name for name in FORCES if name in names), names[0])
    for name in sorted(names, key=lambda name: name != main):
        symbol, caption = WORDS.get(name, (name, f"Column `{name}`"))
        if less:
            curves = [Curve(label, x.t, x.difference) for label, x in found.pairs if x.name == name]
            file, title = f"difference_{name}", f"difference of {symbol}"
            caption = f"{caption.partition(',')[0]}, difference from {found.reference.label}"
        else:
            curves = [
                Curve(i.label, i.columns[TIME], i.columns[name]) for i in found.items if name in i.columns
            ]
            file, title = name, symbol
        unit = found.reference.units.get(name)
        heading = f"{title} [{unit}]" if unit else title
        width = FULL if name == main and not less else PART
        yield draw_overlay(file, heading, curves, caption, width).in_units(SI)
