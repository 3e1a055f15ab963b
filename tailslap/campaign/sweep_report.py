"""Report a sweep by page, charts and summary."""

import contextlib
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

import tailslap
from postprocess.comparison.quantities import ComparedQuantity
from postprocess.figures.sweeps import SweepRows, Varied, draw_sweep
from postprocess.report.command_report import PAGE, Report, write_report
from postprocess.report.page import Headline, Page, Section
from postprocess.report.tables import Column, Table, columns
from postprocess.report.terminal import concluded, place_line
from postprocess.svg.chart import Chart
from postprocess.units import SYSTEMS, Units, force, measure, percent_up
from tailslap.campaign.records import Record
from tailslap.campaign.sweep_definition import Definition, Variation
from tailslap.campaign.sweep_table import ERROR, FAILED, PASSED, REFUSED, TABLE, FinishedSweep
from tailslap.case import case_of
from tailslap.case.case import Case
from tailslap.case.report_parts import footer
from tailslap.errors import InputError
from tailslap.progress import clock
from tailslap.result.columns import read_columns
from tailslap.scene import vary
from tailslap.scene.write import scene_text

MAX_LISTED = 15
"""Most rows that the page lists among those that did not pass."""

FILES = "sweep.parquet (one row per run, in SI); summary.json; sweep.json (definition)"
STATUS_WORDS = {
    PASSED: "passed all checks",
    FAILED: "failed a check",
    REFUSED: "refused",
    ERROR: "with an error",
}
VARIED = (Column("key", "Key"), Column("values", "Values"), Column("count", "Number", form="d"))
SPREAD = (
    Column("quantity.label", ""),
    *columns({"least": "FE, least", "most": "FE, most"}, form=".5g"),
    Column("difference", "Largest FE/rigid - 1", form="+.2e", style="strong"),
    Column("run", "Run", form="d"),
)
RIGID_SPREAD = (
    Column("quantity.label", ""),
    *columns({"least": "Rigid, least", "most": "Rigid, most"}, form=".5g"),
)
NOT_PASSED = columns({"run": "Run", "inputs": "Inputs", "status": "Status", "reason": "Reason"})


def write_sweep(sweep: FinishedSweep, folder: Path, units: str = "si") -> Report:
    """Write page, charts and summary of a sweep.

    Returns the report in these units.
    """
    rows = _rows(sweep.definition, folder / TABLE, SYSTEMS[units])
    reasons = read_columns(folder / TABLE, ["reason"])["reason"]
    case, forces = base_case(sweep.definition), None
    if case:
        column = f"{'fe' if rows.fe else 'rigid'}.{case.force_column}"
        forces = read_columns(folder / TABLE, [column])[column]
    opening, drawing = headline(sweep, rows, case, forces), (case.drawing(),) if case else ()
    page = sweep_page(sweep, rows, reasons, opening, drawing)
    tables = (replace(table, title=part.title) for part in page.sections[1:3] for table in part.tables)
    report = Report(page, summary(sweep, rows), tuple(tables)).in_units(SYSTEMS[units])
    write_report(report, folder)
    return report


def base_case(definition: Definition) -> Case | None:
    """Return the case of the scene or the first run.

    It is None where the rigid body has no solution in either.
    """
    for changes in ({}, definition.changes_of(0)):
        with contextlib.suppress(InputError):
            return case_of(*vary.vary(definition.source, changes))
    return None


def sweep_text(sweep: FinishedSweep, place: Path | None) -> str:
    """Return headline, cost and places of files, if any."""
    effort, cost = sweep.effort, "no runs remained"
    if effort.runs:
        cost = (
            f"{effort.runs} runs in {clock(effort.wall_s)}, workers: {effort.threads}, {effort.rate:.3g} runs/s, "
            f"{1e3 * effort.overhead_s:.1f} ms overhead per run"
        )
    files = place and (place_line("Table: ", place / TABLE), place_line("Report:", place / PAGE))
    assert sweep.report
    return concluded(sweep.report.page.headline, f"Cost:   {cost}", places=files or ())


def sweep_page(
    sweep: FinishedSweep,
    rows: SweepRows,
    reasons: np.ndarray,
    opening: Headline,
    drawing: Sequence[Chart] = (),
) -> Page:
    """Return the page of a sweep.

    `reasons` are those of the rows that did not pass, shape (rows,), and `drawing` shows the set-up.
    """
    definition, curves = sweep.definition, draw_sweep(rows)
    spread, where = SPREAD if rows.fe else RIGID_SPREAD, rows.compared.where.capitalize()
    varied = [
        {"key": item.key, "values": values_words(item), "count": len(set(item.settings))}
        for item in definition.variations
    ]
    groups: dict[str, list[Chart]] = {}
    for curve in curves:
        groups.setdefault(curve.group, []).append(curve)
    sections = (
        Section("Set-up", figures=drawing),
        Section("Varied keys", tables=(Table(VARIED, varied),)),
        Section(f"{where}, runs that passed", tables=(Table(spread, spreads(rows)),)),
        *(Section(group, figures=charts) for group, charts in groups.items()),
        Section("Runs that did not pass", tables=(_not_passed(definition, rows, reasons),)),
        Section("Method", sentences=_sentences(sweep)),
    )
    kind = "finite elements and exact rigid solution" if rows.fe else "rigid vehicle"
    return Page(f"Sweep: {kind}", opening, sections, footer(FILES), scene_text(definition.source))


def summary(sweep: FinishedSweep, rows: SweepRows) -> Record:
    """Return the numbers of the sweep, SI.

    `effort` is that of the last call, which may have computed a few runs only.
    """
    definition, effort = sweep.definition.as_written(), sweep.effort
    return {
        "scene": sweep.definition.scene,
        "version": tailslap.__version__,
        "passed": sweep.failures == 0,
        "runs": sweep.definition.runs,
        "statuses": dict(sweep.statuses),
        "largest_difference": {i["quantity"].key: i["difference"] for i in spreads(rows) if rows.fe},
        "effort": {**vars(effort), "runs_a_second": effort.rate, "overhead_a_run_s": effort.overhead_s},
        "definition": {name: value for name, value in definition.items() if name != "text"},
    }


def spreads(rows: SweepRows) -> list[Record]:
    """Return each quantity's range in rows that passed.

    The values are those of finite elements where there are any, with the largest difference and its run.
    """
    return [spread for quantity in rows.compared.quantities.values() if (spread := _spread(rows, quantity))]


def _spread(rows: SweepRows, quantity: ComparedQuantity) -> Record:
    """Return the range of one quantity, or {}."""
    values = rows.best[quantity.key]
    passed = np.flatnonzero((rows.status == PASSED) & np.isfinite(values))
    if not passed.size:
        return {}
    spread = {"quantity": quantity, "least": float(values[passed].min()), "most": float(values[passed].max())}
    if not rows.fe:
        return spread
    difference = rows.difference[quantity.key][passed]
    if not np.isfinite(difference).any():
        return {**spread, "difference": math.nan, "run": int(passed[0])}
    worst = int(np.nanargmax(np.abs(difference)))
    return {**spread, "difference": float(difference[worst]), "run": int(passed[worst])}


def _not_passed(definition: Definition, rows: SweepRows, reasons: np.ndarray) -> Table:
    """Return the table of failed and refused rows."""
    runs = sorted(np.flatnonzero(rows.status != PASSED), key=lambda run: (rows.status[run] == REFUSED, run))
    units = {item.key: item.unit for item in definition.variations}
    listed = []
    for run in map(int, runs[:MAX_LISTED]):
        inputs = ", ".join(f"{k} = {shown(x, units[k])}" for k, x in definition.inputs_of(run).items())
        listed.append({"run": run, "inputs": inputs, "status": rows.status[run], "reason": reasons[run]})
    marks = {place: "failed" for place, item in enumerate(listed) if item["status"] != REFUSED}
    note = f"First {len(listed)} of {len(runs)}; sweep.parquet contains all."
    return Table(NOT_PASSED, listed, notes=(note,) if len(runs) > len(listed) else (), marks=marks)


def _rows(definition: Definition, table: Path, units: Units) -> SweepRows:
    """Read the rows of the table in displayed units."""
    compared, keys = definition.compared, [item.key for item in definition.variations]
    types = definition.column_types
    groups = {
        group: {key: f"{group}.{key}" for key in compared.quantities if f"{group}.{key}" in types}
        for group in ("fe", "rigid", "difference")
    }
    names = [name for group in groups.values() for name in group.values()]
    columns = read_columns(table, ["status", *keys, *names])
    fe, rigid, difference = ({key: columns[name] for key, name in groups[group].items()} for group in groups)
    varied = tuple(_varied(item, columns[item.key], units) for item in definition.variations)
    difference = {key: difference.get(key, fe[key] / rigid[key] - 1.0) for key in fe}
    factors = {key: units.of(quantity.unit)[0] for key, quantity in compared.quantities.items()}
    fe, rigid = ({key: factors[key] * values for key, values in model.items()} for model in (fe, rigid))
    quantities = {key: replace(q, unit=units.of(q.unit)[1]) for key, q in compared.quantities.items()}
    compared = replace(compared, quantities=quantities)
    return SweepRows(varied, columns["status"], fe, rigid, difference, compared)


def _varied(item: Variation, values: np.ndarray, units: Units) -> Varied:
    """Return a key with its values in displayed units."""
    factor, unit = units.of(item.unit) if item.unit else (1.0, "")
    return Varied(item.key, unit, values if factor == 1.0 else factor * values, item.logarithmic)


def counts(sweep: FinishedSweep) -> str:
    """Describe the number of rows of each status."""
    return ", ".join(f"{n} {STATUS_WORDS[status]}" for status, n in sweep.statuses.items() if n)


def headline(
    sweep: FinishedSweep, rows: SweepRows, case: Case | None = None, forces: np.ndarray | None = None
) -> Headline:
    """Return the headline of a sweep.

    It states the range of the forces [N], shape (rows,), the varied keys, and the difference of finite elements and
    rigid body. `case` is the scene where the rigid body has a solution.
    """
    definition, passed = sweep.definition, rows.status == PASSED
    varied = "; ".join(f"{item.key} {values_words(item)}" for item in definition.variations)
    answer, set_up, certainty = "", f"Varied: {varied}.", f"{definition.runs} runs: {counts(sweep)}."
    if case:
        set_up = f"{case.set_up} {set_up}"
    passed_forces = np.zeros(0) if forces is None else forces[passed & np.isfinite(forces)]
    if case and passed_forces.size:
        span = " to ".join(dict.fromkeys((force(passed_forces.min()), force(passed_forces.max()))))
        counted = "runs" if passed_forces.size == definition.runs else f"of {definition.runs} runs"
        answer = f"{case.force_words}: {span} over {passed_forces.size} {counted}."
    if sweep.failures:
        answer = f"Failed: {sweep.failures} of {definition.runs} runs. {answer}".rstrip()
    differences = rows.worst[passed & np.isfinite(rows.worst)]
    if differences.size:
        largest = percent_up(differences.max())
        certainty += f" Finite elements and rigid body differ by at most {largest} in those that passed."
    keys = ", ".join(item.key for item in definition.variations)
    title = f"Sweep of {keys}: {case.subject if case else definition.scene}"
    return Headline(title, answer or certainty, set_up, certainty if answer else "")


def _sentences(sweep: FinishedSweep) -> list[str]:
    """Describe the method."""
    definition = sweep.definition
    latin = f"The runs are a Latin hypercube of {definition.sample} samples (seed {definition.seed})."
    sentences = [latin if definition.sample else "The runs are all combinations of the values."]
    if any(name.startswith("fe.") for name in definition.column_types):
        sentences.append(
            "Each row contains the exact rigid solution of its inputs, the differences, and the values of all checks."
        )
    if sweep.statuses[REFUSED]:
        sentences.append(
            "Refused: the rigid-body theory has no solution for the inputs, or the model is invalid."
        )
    if sweep.statuses[FAILED]:
        sentences.append(
            "Results of runs that failed a check are included in the table and the plots; they are not reliable."
        )
    return sentences


def values_words(item: Variation) -> str:
    """Return the values of a key in words."""
    values = list(dict.fromkeys(item.values))
    if not item.numeric or len(values) <= 4:
        return ", ".join(shown(value, item.unit) for value in values)
    low, high = (shown(end, item.unit) for end in (min(values), max(values)))
    return f"{low} to {high}" + (", in equal ratios" if item.logarithmic else "")


def shown(value: float | int | str, unit: str) -> str:
    """Return a value with its unit, angles in degrees."""
    if isinstance(value, str):
        return value
    return measure(value, unit, ".5g", named=bool(unit))
