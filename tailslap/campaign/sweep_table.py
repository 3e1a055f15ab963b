"""Rows of a sweep and their table `sweep.parquet`."""

from __future__ import annotations

import functools
import itertools
import time
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

import tailslap
from postprocess.report import data_files
from tailslap.campaign import engine, records
from tailslap.campaign.records import Record
from tailslap.campaign.sweep_definition import Definition, plain
from tailslap.case import case_of
from tailslap.case.resources import demand_affordable
from tailslap.errors import InputError
from tailslap.scene import vary

if TYPE_CHECKING:
    import pyarrow as pa

    from postprocess.report.command_report import Report

TABLE = "sweep.parquet"
CHUNK = 20_000
"""Number of rows in memory at a time."""
PASSED, FAILED, REFUSED, ERROR = STATUSES = ("passed", "failed", "refused", "error")
"""Statuses of a row: all checks passed, a check failed, the theory or the model has no solution, or the run broke down.
"""
KILLS = "its worker process died in every attempt"
CIRCUMSTANCES = ("cost.run_s", "cost.setup_s", "cost.time_loop_s")
"""Columns that differ between repetitions of a run. All others are identical to the bit."""


@dataclass(frozen=True)
class FinishedSweep:
    """A complete sweep, with the number of rows by status.

    `effort` is that of the last call, and `report` its page.
    """

    definition: Definition
    statuses: dict[str, int]
    effort: engine.CampaignEffort
    report: Report | None = None

    @property
    def failures(self) -> int:
        """Return the number of failed runs.

        They failed a check or ended in an error.
        """
        return self.statuses[FAILED] + self.statuses[ERROR]


def compute_row(run: int, source: vary.Source, changes: vary.Changes) -> Record:
    """Run the scene with these changes and return its row.

    Errors become the status and reason of the row.
    """
    began = time.perf_counter()
    try:
        case = case_of(*vary.vary(source, changes))
        demand_affordable(case.scene, case.duration)
        outcome = case.row(case.run() if case.scene.plate else None)
    except InputError as refusal:
        outcome = {"status": REFUSED, "reason": str(refusal)}
    except MemoryError:
        outcome = {"status": ERROR, "reason": "insufficient memory for this mesh"}
    except Exception as error:  # a failed run does not end the sweep
        outcome = {"status": ERROR, "reason": f"{type(error).__name__}: {error}"}
    inputs = {key: plain(value) for key, value in changes.items()}
    return {"run": run, **inputs, **outcome, **versions(), "cost.run_s": time.perf_counter() - began}


@functools.cache
def versions() -> Mapping[str, str]:
    """Return the columns of program and library versions."""
    libraries = {name: version(name) for name in ("llvmlite", "numpy", "scipy")}
    numbers = {"tailslap": tailslap.__version__, **libraries}
    return {f"version.{name}": number for name, number in numbers.items()}


def write_table(folder: Path, definition: Definition, rows: records.Records) -> Path:
    """Write the table of all recorded rows."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    schema = table_schema(definition, sorted(name for name in rows.columns if name.startswith("check.")))
    path, plain_rows = folder / TABLE, map(data_files.plain, rows.in_order())
    with path.open("wb") as file, pq.ParquetWriter(file, schema, compression="zstd") as writer:
        while chunk := list(itertools.islice(plain_rows, CHUNK)):
            writer.write_table(pa.Table.from_pylist(chunk, schema=schema))
    return path


def table_schema(definition: Definition, checks: list[str]) -> pa.Schema:
    """Return the table's columns and their types.

    `checks` are the columns of the checks, which depend on the runs.
    """
    import pyarrow as pa

    real, whole, text = pa.float64(), pa.int64(), pa.string()
    arrow_types = {float: real, int: whole, str: text}
    columns: Record = {"run": whole, "status": text, "reason": text}
    for item in definition.variations:
        is_whole = all(isinstance(value, int) for value in item.values)
        columns[item.key] = (whole if is_whole else real) if item.numeric else text
    types = {name: arrow_types[type_] for name, type_ in definition.column_types.items()}
    columns |= {name: type_ for name, type_ in types.items() if not name.startswith("cost.")}
    columns |= dict.fromkeys(checks, real) | types
    columns |= dict.fromkeys(CIRCUMSTANCES, real) | dict.fromkeys(versions(), text)
    return pa.schema(list(columns.items()))
