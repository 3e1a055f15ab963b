"""What is written beside the table when a sweep is complete: summary and page."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import tailslap
from postprocess.comparison.comparison import KEYS, QUANTITIES
from postprocess.figures.sweep_plots import SweepRows, Varied, draw_sweep
from postprocess.files.summary import write_summary
from postprocess.pages.sweep_page import Spread, SweepContent, Trouble, VariedKey, write_sweep_page
from tailslap.results.manifest import listed_file
from tailslap.sweep.complete import Sweep
from tailslap.sweep.definition import Definition
from tailslap.sweep.folder import REPORT, SUMMARY, TABLE
from tailslap.sweep.report.words import headline, shown, statements, values_words
from tailslap.sweep.row import PASSED
from tailslap.sweep.table import read_columns
from tailslap.sweep.variation import Variation

MOST_TROUBLES = 15
"""Rows that did not pass which the page lists."""


def write_sweep(sweep: Sweep, folder: Path) -> None:
    """Write `report.html` and `summary.json` from the table in the folder."""
    rows = _rows(sweep.definition, folder / TABLE)
    with listed_file(folder / REPORT) as page:
        write_sweep_page(page, _content(sweep, rows, folder / TABLE))
    with listed_file(folder / SUMMARY) as numbers:
        write_summary(numbers, summary(sweep, rows))


def summary(sweep: Sweep, rows: SweepRows) -> dict[str, Any]:
    """The numbers of the sweep, SI; `effort` is that of the last call, which may have had few runs left to make."""
    definition, effort = sweep.definition.as_written(), sweep.effort
    return {
        "scene": sweep.definition.scene,
        "version": tailslap.__version__,
        "passed": sweep.failures == 0,
        "runs": sweep.definition.runs,
        "statuses": dict(sweep.statuses),
        "largest_difference": {key: item.difference for key, item in zip(KEYS, _spreads(rows), strict=False)},
        "effort": {
            "runs": effort.runs,
            "threads": effort.threads,
            "wall_s": effort.wall_s,
            "runs_a_second": effort.rate,
            "overhead_a_run_s": effort.overhead_s,
        },
        "definition": {name: value for name, value in definition.items() if name != "text"},
    }


def _rows(definition: Definition, table: Path) -> SweepRows:
    groups = ("fe", "rigid", "difference")
    keys = [item.key for item in definition.variations]
    columns = read_columns(table, ["status", *keys, *(f"{group}.{key}" for group in groups for key in KEYS)])
    fe, rigid, difference = ({key: columns[f"{group}.{key}"] for key in KEYS} for group in groups)
    varied = tuple(_varied(item, columns[item.key]) for item in definition.variations)
    return SweepRows(varied, columns["status"], fe, rigid, difference)


def _varied(item: Variation, values: np.ndarray) -> Varied:
    """The key as people read it: angles in degrees."""
    if item.unit == "rad":
        return Varied(item.key, "deg", np.degrees(values), item.logarithmic)
    return Varied(item.key, item.unit, values, item.logarithmic)


def _content(sweep: Sweep, rows: SweepRows, table: Path) -> SweepContent:
    definition = sweep.definition
    keys = tuple(
        VariedKey(item.key, values_words(item), len(set(item.texts))) for item in definition.variations
    )
    changes = "".join(f"# changed by --set {change}\n" for change in definition.changes)
    return SweepContent(
        scene=definition.scene,
        version=tailslap.__version__,
        headline=headline(sweep, rows),
        keys=keys,
        spreads=_spreads(rows),
        troubles=_troubles(definition, rows, table),
        trouble_count=int(np.count_nonzero(rows.status != PASSED)),
        curves=draw_sweep(rows),
        statements=statements(sweep),
        scene_text=definition.text.rstrip("\n") + "\n" + changes,
    )


def _spreads(rows: SweepRows) -> tuple[Spread, ...]:
    """The compared quantities over the rows that passed."""
    passed = np.flatnonzero(rows.status == PASSED)
    return tuple(_spread(rows, key, passed) for key in KEYS) if passed.size else ()


def _spread(rows: SweepRows, key: str, passed: np.ndarray) -> Spread:
    difference, fe, quantity = rows.difference[key][passed], rows.fe[key][passed], QUANTITIES[key]
    worst = int(np.argmax(np.abs(difference)))
    values = (float(fe.min()), float(fe.max()), float(difference[worst]))
    return Spread(quantity.symbol, quantity.unit, *values, int(passed[worst]))


def _troubles(definition: Definition, rows: SweepRows, table: Path) -> tuple[Trouble, ...]:
    """The first rows that did not pass: those that failed or broke down before those that were refused."""
    reasons = read_columns(table, ["reason"])["reason"]
    runs = sorted(np.flatnonzero(rows.status != PASSED), key=lambda run: (rows.status[run] == "refused", run))
    return tuple(
        Trouble(int(run), _inputs(definition, int(run)), str(rows.status[run]), str(reasons[run]))
        for run in runs[:MOST_TROUBLES]
    )


def _inputs(definition: Definition, run: int) -> str:
    units = {item.key: item.unit for item in definition.variations}
    return ", ".join(
        f"{key} = {shown(value, units[key])}" for key, value in definition.inputs_of(run).items()
    )
