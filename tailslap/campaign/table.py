"""A run of a sweep as a row, and the table of all rows, `sweep.parquet`, in the order of the runs."""

from __future__ import annotations

import functools
import itertools
import time
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import tailslap
from fem import lazy
from postprocess.report import table
from tailslap.campaign import engine, records
from tailslap.campaign.definition import Definition, plain
from tailslap.case import case_of
from tailslap.case.cost import demand_affordable
from tailslap.errors import InputError
from tailslap.scene.vary import Changes, Source, vary

if TYPE_CHECKING:
    import pyarrow as pa

TABLE = "sweep.parquet"
CHUNK = 20_000
"""Rows that are in memory at a time."""

PASSED, FAILED, REFUSED, ERROR = STATUSES = ("passed", "failed", "refused", "error")
"""All checks passed; a check failed; the theory or the model refuses the combination; the run broke down."""

KILLS = "its worker died each time that it was computed, alone at last"

TIMES = ("cost.run_s", "cost.setup_s", "cost.time_loop_s")
REUSED = "cost.reused"
"""Column with the parts of the model that were there already, from runs that this worker has made before."""

CIRCUMSTANCES = (*TIMES, REUSED)
"""Columns that differ when the same run is made again; all others are the same to the bit."""


@dataclass(frozen=True)
class FinishedSweep:
    """A sweep that is complete: how many rows have each status, and what the last call's runs took."""

    definition: Definition
    statuses: dict[str, int]
    effort: engine.CampaignEffort

    @property
    def failures(self) -> int:
        """Runs that failed a check or ended in an error."""
        return self.statuses[FAILED] + self.statuses[ERROR]


def compute_row(run: int, source: Source, changes: Changes) -> dict[str, Any]:
    """Make a run of the scene with these changes. Whatever goes wrong is the row's status and reason."""
    began, before = time.perf_counter(), lazy.looks()
    try:
        case = case_of(*vary(source, changes))
        demand_affordable(case.scene, case.duration)
        found = case.row(case.run() if case.scene.plate else None)
    except InputError as refusal:
        found = {"status": REFUSED, "reason": str(refusal)}
    except MemoryError:
        found = {"status": ERROR, "reason": "the memory of the machine does not hold this mesh"}
    except Exception as error:  # a sweep goes on, whatever one of its runs does
        found = {"status": ERROR, "reason": f"{type(error).__name__}: {error}"}
    inputs = {key: plain(value) for key, value in changes.items()}
    spent = {REUSED: ", ".join(lazy.reused(before)), "cost.run_s": time.perf_counter() - began}
    return {"run": run, **inputs, **found, **versions(), **spent}


@functools.cache
def versions() -> Mapping[str, str]:
    """Columns with the versions that a row was computed with."""
    libraries = {name: version(name) for name in ("numba", "numpy", "scipy")}
    return {
        f"version.{name}": given for name, given in {"tailslap": tailslap.__version__, **libraries}.items()
    }


def write_table(folder: Path, definition: Definition, rows: records.Records) -> Path:
    """Write the table of all rows that there are."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    schema = table_schema(definition, sorted(name for name in rows.columns if name.startswith("check.")))
    path, found = folder / TABLE, map(table.plain, rows.in_order())
    with pq.ParquetWriter(path, schema, compression="zstd") as writer:
        while chunk := list(itertools.islice(found, CHUNK)):
            writer.write_table(pa.Table.from_pylist(chunk, schema=schema))
    return path


def table_schema(definition: Definition, checks: list[str]) -> pa.Schema:
    """Columns of the table and their types; checks: their columns, which depend on the runs."""
    import pyarrow as pa

    real, whole, text = pa.float64(), pa.int64(), pa.string()
    kinds = {float: real, int: whole, str: text}
    columns: dict[str, Any] = {"run": whole, "status": text, "reason": text}
    for item in definition.variations:
        is_whole = all(isinstance(value, int) for value in item.values)
        columns[item.key] = (whole if is_whole else real) if item.numeric else text
    types = {name: kinds[kind] for name, kind in definition.kinds.items()}
    columns |= {name: kind for name, kind in types.items() if not name.startswith("cost.")}
    columns |= dict.fromkeys(checks, real) | types
    columns |= dict.fromkeys(TIMES, real) | {REUSED: text} | dict.fromkeys(versions(), text)
    return pa.schema(list(columns.items()))
