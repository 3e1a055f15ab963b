"""Compare results with a reference."""

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

import tailslap
from postprocess.comparison.metrics import COVERED, LIMITS, Beside, beside
from postprocess.comparison.quantities import FORCE, QUANTITIES
from postprocess.figures.histories import COMPARED, Curve, draw_overlay
from postprocess.report.command_report import Report
from postprocess.report.page import Headline, Page, Section
from postprocess.report.tables import Column, Table, columns
from postprocess.svg.chart import FULL, PART, Chart
from postprocess.units import SI, percent
from tailslap.case.report_parts import footer
from tailslap.comparing.source import TIME, Item, parse_mapping, read_items
from tailslap.errors import InputError, Verbatim, one_of, shortened
from tailslap.result.columns import column_units

DEFAULT_COLUMNS = (
    *("theta", "omega", "v_gx", "v_gy", "slide", "reaction_normal", "reaction_tangential"),
    *("x_g", "y_g", "force_normal", "force_tangential"),
)
"""Columns compared by default."""

FORCES = ("force_normal", "reaction_normal")
"""Forces normal to the wall, one of which is drawn at the width of the page."""

MOST_RATIO = 10.0
"""Ratio of the durations of two records above which an assumed unit of time is refused."""

WHOLE = 0.9
"""Part of the reference's time below which a remark states the compared part."""


def yes(within: bool) -> str:
    """Return the word for a criterion."""
    return "yes" if within else "NO"


HEADS = {"magnitude": "M", "phase": "P", "combined": "C", "mean_residual": "Mean", "deviation": "SD"}
METRICS = (
    *columns({"item": "Result", "name": "Column"}),
    *columns({**HEADS, "largest": "Largest"}, form=lambda ratio: percent(ratio).removesuffix(" %")),
    Column("covered", "Time", form=lambda part: f"{100.0 * part:.0f}"),
    Column("within", "Within", form=yes),
)
WORDS = {panel.name: (panel.symbol, panel.caption) for panel in COMPARED} | {
    "x_g": ("x_G", "Position of the centre of mass along the wall"),
    "y_g": ("y_G", "Distance of the centre of mass from the wall"),
    "force_normal": ("force", "Normal force of the wall on the vehicle"),
    "force_tangential": ("force", "Tangential force of the wall on the vehicle"),
}
"""Symbol and caption of the curves, by column."""

SIZE, MEAN, SD = (f"{100 * LIMITS[name]:.0f} %" for name in ("combined", "mean_residual", "deviation"))
NOTE = (
    "M, P, C: Sprague-Geers magnitude, phase and comprehensive metrics. Mean, standard deviation (SD) and largest "
    "value of the differences, relative to the peak of the reference, as in NCHRP W179. Limits: "
    f"{SIZE} for M, P and C, {MEAN} for the mean, {SD} for SD. Time: compared part of the time of the reference, at "
    f"least {100 * COVERED:.0f} %."
)
WEIGHTED = (
    "Weight: largest change of momentum in the reference (angular velocity: over the radius of gyration); weighted: "
    "mean of the sizes. Channels are velocities, where W179 uses accelerations."
)


NO_MAIN = "no main column, compared by --only"
"""Reason why most columns are not compared."""


@dataclass(frozen=True)
class Comparison:
    """Histories compared with the first one.

    pairs: label of another item and a common column; notes: remarks; not_compared: reasons by label and column.
    """

    items: tuple[Item, ...]
    pairs: tuple[tuple[str, Beside], ...]
    notes: tuple[str, ...] = ()
    not_compared: Mapping[str, Mapping[str, str]] = field(default_factory=dict)

    @property
    def reference(self) -> Item:
        """Item with which the others are compared."""
        return self.items[0]

    @property
    def labels(self) -> list[str]:
        """Labels of the others."""
        return [item.label for item in self.items[1:]]

    @property
    def remarks(self) -> tuple[str, ...]:
        """Notes, and the columns that are not compared."""
        return (*self.notes, *(sentence for sentence, _ in self._not_compared()))

    @property
    def missing(self) -> tuple[str, ...]:
        """Notes, and the main columns that are not compared."""
        return (*self.notes, *(sentence for sentence, why in self._not_compared() if why != NO_MAIN))

    def _not_compared(self) -> Iterator[tuple[str, str]]:
        """Yield sentences on columns that are not compared, with reasons."""
        for label, reasons in self.not_compared.items():
            for names, why in _by_value(reasons.items()):
                yield f"{label}, not compared: {names} ({why}).", why

    @property
    def within(self) -> bool:
        """True if all metrics are within the limits."""
        return all(pair.within for _, pair in self.pairs)


def compare_items(
    sources: Sequence[object],
    columns: Mapping[str, str] | str | None = None,
    only: Sequence[str] = (),
    force: bool = False,
    decimal_commas: Sequence[int] = (),
) -> Comparison:
    """Compare histories with the first one.

    force: include damaged ones; decimal_commas: numbers of files with such. Raises InputError.
    """
    if len(sources) < 2:
        allowed = "two or more results are required; the first is the reference"
        raise InputError("RESULT", Verbatim(len(sources)), allowed)
    mapping = parse_mapping(columns) if isinstance(columns, str) else dict(columns or {})
    items = read_items(sources, mapping, force, decimal_commas)
    labels = [item.label for item in items]
    unique = (f"{label} ({k})" if labels.count(label) > 1 else label for k, label in enumerate(labels, 1))
    items = [replace(item, label=label) for item, label in zip(items, unique, strict=True)]
    reference, pairs, not_compared = items[0], [], {}
    notes = [note for item in items for note in item.notes]
    mapped = {key.rpartition(":")[2].strip() for key in mapping}
    for k, item in enumerate(items[1:], 2):
        _demand_one_unit_of_time(reference, item, k)
        among = _pairs(item, reference, only, mapped)
        pairs += [(item.label, pair) for pair in among.values() if pair]
        notes += _remarks(item, reference, among)
        not_compared[item.label] = _not_compared(item, reference, {TIME, *among}, bool(only))
    return Comparison(tuple(items), tuple(pairs), tuple(dict.fromkeys(notes)), not_compared)


def _demand_one_unit_of_time(reference: Item, item: Item, number: int) -> None:
    """Refuse an implausible assumed unit of time.

    Durations then differ more than tenfold. number: of the item. Raises InputError.
    """
    records = {1: reference, number: item}
    spans = {k: float(np.ptp(record.columns[TIME])) for k, record in records.items()}
    is_of_all = all(record.unit_of_time == "columns" for record in records.values())  # one may have another
    guessed = [k for k, record in records.items() if is_of_all or record.unit_of_time == "assumed"]
    if not guessed or max(spans.values()) <= MOST_RATIO * min(spans.values()):
        return
    units = {k: "ms" if span == max(spans.values()) else "s" for k, span in spans.items()}
    advice = ",".join(f"{k}:time={records[k].time_name} [{units[k]}]" for k in guessed)
    allowed = (
        f"{item.label} lasts {spans[number]:.4g} s and {reference.label} {spans[1]:.4g} s if times without a unit are "
        f'seconds; allowed is a unit in the file, or by the number of the result, --columns "{advice}"'
    )
    raise InputError("RESULT", records[guessed[-1]].label, allowed)


def _not_compared(item: Item, reference: Item, finished: Collection[str], is_limited: bool) -> dict[str, str]:
    """Return why columns of two items are not compared, by name.

    finished: compared and excluded ones; is_limited: by --only.
    """
    limited = "not in --only" if is_limited else NO_MAIN
    reasons = dict.fromkeys((name for name in item.columns if name in reference.columns), limited)
    for record, other in ((item, reference), (reference, item)):
        for name in (*record.columns, *record.unread):
            remark = record.unread.get(name)
            reasons.setdefault(name, f"not in {other.label}" + (f"; {remark}" if remark else ""))
    return {name: why for name, why in reasons.items() if name not in finished}


def _pairs(item: Item, reference: Item, only: Sequence[str], mapped: set[str]) -> dict[str, Beside | None]:
    """Return compared columns by name, None for excluded ones.

    They are main columns, mapped ones, and those that this program does not have. Raises InputError where no column
    has any.
    """
    common = [name for name in reference.columns if name in item.columns and name != TIME]
    for name in only:
        if name not in common:
            raise InputError("--only", name, one_of(name, common, "allowed are the common columns,"))
    main = [name for name in common if name in mapped or not column_units([name])]
    chosen = only or dict.fromkeys([name for name in DEFAULT_COLUMNS if name in common] + main) or common
    pairs = {name: beside(name, item.columns, reference.columns) for name in chosen}
    excluded = ", ".join(name for name, pair in pairs.items() if not pair)
    if not any(pairs.values()) or (only and excluded):
        label, names = reference.label, shortened(", ".join([*item.columns, *item.unread]))
        why = f"it has no {excluded or 'column'} with two values at times in common with {label}"
        raise InputError("RESULT", item.label, f"{why}; see --columns; its columns are {names}")
    return pairs


def _remarks(item: Item, reference: Item, pairs: Mapping[str, Beside | None]) -> Iterator[str]:
    """Yield remarks on excluded data and local differences."""
    compared, excluded = [x for x in pairs.values() if x], [name for name, pair in pairs.items() if not pair]
    if excluded:
        yield f"{item.label}: no values at times of {reference.label}, not compared: {', '.join(excluded)}."
    for record in (item, reference):
        missing = {x.name: int(np.isnan(record.columns[x.name]).sum()) for x in compared}
        for names, rows in _by_value((name, rows) for name, rows in missing.items() if rows):
            count = record.columns[TIME].size
            yield f"{record.label}: {names} without a value in {rows} of {count} rows, interpolated or excluded."
    for names, (begin, end) in _by_value((x.name, gap) for x in compared for gap in x.gaps):
        yield f"{item.label}: {names} not compared from {begin:.4g} to {end:.4g} s, a gap of one of both."
    short, span = (x for x in compared if x.covered < WHOLE), float(np.ptp(reference.columns[TIME]))
    for names, covered in _by_value((x.name, round(100.0 * x.covered, 1)) for x in short):
        yield f"{item.label}: {names} compared for {covered:g} % of the {span:.4g} s of {reference.label}."
    for pair in compared:
        size, at = abs(pair.largest[0]), pair.largest[1]
        if pair.metrics.within and size > LIMITS["deviation"]:
            where = f"{item.label}: {pair.name} differs by {100.0 * size:.0f} % of the peak at {at:.4g} s"
            yield f"{where}; the metrics, means over time, are within their limits."


def _by_value(pairs: Iterable[tuple[str, Any]]) -> Iterator[tuple[str, Any]]:
    """Yield names with the same value, separated by commas, and the value."""
    names: dict[Any, list[str]] = {}
    for name, value in pairs:
        names.setdefault(value, []).append(name)
    return ((", ".join(same), value) for value, same in names.items())


def compare_report(comparison: Comparison) -> Report:
    """Report a comparison."""
    table, opening = metrics_table(comparison), headline(comparison)
    compared: dict[str, dict[str, object]] = {label: {} for label in comparison.labels}
    for label, pair in comparison.pairs:
        compared[label][pair.name] = _numbers(pair)
    verdict = {"reference": comparison.reference.label, "passed": comparison.within, "limits": LIMITS}
    remarks = {"notes": list(comparison.notes), "not_compared": comparison.not_compared}
    summary = {"version": tailslap.__version__, **verdict, "compared": compared, **remarks}
    sections = (
        Section("Metrics", tables=(table,), sentences=comparison.remarks),
        Section("Results at the tail-slap", tables=tuple(_quantities(comparison))),
        Section("Curves", figures=[*_curves(comparison)]),
        Section("Differences from the reference", figures=[*_curves(comparison, True)]),
    )
    below = footer("summary.json, these numbers; metrics.csv, the table; validation.html")
    page = Page("Histories side by side", opening, sections, below, passed=comparison.within)
    return Report(page, summary, (table, *comparison.remarks), tables={"metrics.csv": table})


def headline(comparison: Comparison) -> Headline:
    """Return the verdict and the largest difference."""
    sizes = [abs(pair.largest[0]) for _, pair in comparison.pairs]
    position = max(range(len(sizes)), key=lambda k: sizes[k] if math.isfinite(sizes[k]) else math.inf)
    label, worst = comparison.pairs[position]
    of = {f"{pair.name} of {label}": pair for label, pair in comparison.pairs}
    outside = ", ".join(name for name, pair in of.items() if not pair.metrics.within)
    short = ", ".join(name for name, pair in of.items() if pair.covered < COVERED)
    part = f"compared for less than {100 * COVERED:.0f} % of the time of the reference"
    faults = [f"beyond the limits of NCHRP W179: {outside}"] if outside else []
    faults += [f"{part}: {short}"] if short else []
    within = f"All {len(sizes)} histories are within the limits of NCHRP W179."
    answer = f"Failed: {'; '.join(faults)}." if faults else within
    size = f"{percent(worst.largest[0])} of the peak, at {worst.largest[1]:.4g} s"
    labels, reference = ", ".join(comparison.labels), comparison.reference.label
    set_up, largest = f"Compared: {labels}; reference: {reference}.", f"{worst.name} of {label}, {size}"
    title = f"Comparison of {labels} with {reference}"
    return Headline(title, answer, set_up, f"Largest difference: {largest}.")


def metrics_table(comparison: Comparison, weighted: Mapping[str, Mapping[str, Any]] | None = None) -> Table:
    """Return the table of metrics, one row per item and column.

    weighted: weights and metrics of all columns together by label, which then have a row.
    """
    rows: list[dict[str, Any]] = []
    for label in comparison.labels:
        together = (weighted or {}).get(label, {})
        weights = together.get("weights", {})
        compared = [pair for name, pair in comparison.pairs if name == label]
        rows += [{"item": label, "weight": weights.get(pair.name), **_numbers(pair)} for pair in compared]
        if weights:
            row = {"item": label, "name": "weighted", "weight": 1.0, "largest": None, "covered": None}
            rows.append({**row, **together})
    title, marks = f"Differences from {comparison.reference.label}, in %", failed(rows, "within")
    if weighted is None:
        return Table(METRICS, rows, title, (NOTE,), marks)
    heads = (*METRICS[:2], Column("weight", "Weight", form=".3f"), *METRICS[2:])
    return Table(heads, rows, title, (f"{NOTE} {WEIGHTED}",), marks)


def failed(rows: Sequence[Mapping[str, object]], key: str) -> dict[int, str]:
    """Return marks of the rows beyond a limit."""
    return {k: "failed" for k, row in enumerate(rows) if not row[key]}


def _numbers(pair: Beside) -> dict[str, object]:
    """Return the metrics of a column and its largest difference."""
    largest, at = pair.largest
    numbers = {"name": pair.name, **asdict(pair.metrics), "largest": largest, "at": at, "at_end": pair.at_end}
    numbers |= {"from": float(pair.t[0]), "to": float(pair.t[-1]), "covered": pair.covered}
    return {**numbers, "within": pair.within}


def _quantities(comparison: Comparison) -> Iterator[Table]:
    """Yield the table of tail-slap quantities."""
    summaries = {f"of {item.label}": item.summary or {} for item in comparison.items}
    runs = {key: summary for key, summary in summaries.items() if "t" in summary.get("fe", {})}
    if len(runs) > 1:
        texts = (Column("title", "At the tail-slap, FE"), Column("unit", "Unit", is_unit=True))
        labels = {key: key.removeprefix("of ") for key in runs}
        rows: list[dict[str, Any]] = [vars(quantity).copy() for quantity in (QUANTITIES | FORCE).values()]
        for key, run in runs.items():
            values = {**run["fe"], "peak_force": run.get("peak_force", {}).get("fe")}
            for row in rows:
                row[key] = values[row["key"]]
        yield Table((*texts, *columns(labels, form=".7g", unit_key="unit")), rows)


def _curves(comparison: Comparison, less: bool = False) -> Iterator[Chart]:
    """Yield charts of the compared columns.

    less: of the differences from the reference.
    """
    names = [*dict.fromkeys(pair.name for _, pair in comparison.pairs)]
    main = next((name for name in FORCES if name in names), names[0])
    for name in sorted(names, key=lambda name: name != main):
        symbol, caption = WORDS.get(name, (name, f"Column `{name}`"))
        if less:
            curves = [Curve(label, x.t, x.difference) for label, x in comparison.pairs if x.name == name]
            caption = f"{caption.partition(',')[0]}, difference from {comparison.reference.label}"
        else:
            items = [item for item in comparison.items if name in item.columns]
            curves = [Curve(item.label, item.columns[TIME], item.columns[name]) for item in items]
        unit = comparison.reference.units.get(name)
        heading = ("difference of " if less else "") + symbol + (f" [{unit}]" if unit else "")
        file, width = f"difference_{name}" if less else name, FULL if name == main and not less else PART
        yield draw_overlay(file, heading, curves, caption, width).in_units(SI)
