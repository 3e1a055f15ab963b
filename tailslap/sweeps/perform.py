"""Makes the runs of a sweep that have no row yet, and writes its table, pictures and page."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from tailslap.execution.cluster import connected
from tailslap.execution.dispatch import PATIENCE_S, Dispatcher, SchedulerLostError, Work, WorkersLostError
from tailslap.progress import counted
from tailslap.sweeps.complete import Effort, Sweep
from tailslap.sweeps.definition import Definition
from tailslap.sweeps.folder import sweep_folder
from tailslap.sweeps.journal import Rows, open_rows
from tailslap.sweeps.row import ERROR, FAILED, STATUSES, compute_row, killing_row
from tailslap.sweeps.table import write_table

LOST, INTERRUPTED = 3, 130

Compute = Callable[..., dict[str, Any]]


class StoppedError(Exception):
    """A sweep that ended before it was complete; `status` is the command's exit status."""

    def __init__(self, why: str, kept: int, runs: int, status: int) -> None:
        rows = f"{kept} of {runs} rows are kept; the same command resumes" if kept else "no run was finished"
        super().__init__(f"{why}; {rows}")
        self.status = status


def perform(
    definition: Definition,
    place: Path,
    cluster: str | None = None,
    workers: int | None = None,
    compute: Compute = compute_row,
    units: str = "si",
) -> Sweep:
    """Make the runs that are missing in the folder `place`, and write what belongs there.

    cluster: address of a Dask scheduler; None: `workers` processes here. compute: the row of a run;
    units: of the page, "si" or "us".
    Raises InputError, and StoppedError for an interruption or the loss of the scheduler: the rows so far are then kept.
    """
    with sweep_folder(place, definition) as folder:
        try:
            with open_rows(folder, definition) as rows:
                effort = _make_missing(definition, rows, cluster, workers, compute)
                write_table(folder, definition, rows)
            done = Sweep(definition, {name: rows.statuses[name] for name in STATUSES}, effort)
            from tailslap.sweeps.report import write_sweep

            write_sweep(done, folder, units)
            return done
        except KeyboardInterrupt:
            raise _stopped("interrupted", folder, definition, INTERRUPTED) from None
        except SchedulerLostError:
            why = f"the scheduler at {cluster} is gone" if cluster else "the scheduler is gone"
            raise _stopped(why, folder, definition, LOST) from None
        except WorkersLostError:
            raise _stopped("no worker is left", folder, definition, LOST) from None


def _stopped(why: str, folder: Path, definition: Definition, status: int) -> StoppedError:
    """The error to raise, when what the journal on disk has is in the table."""
    with open_rows(folder, definition) as rows:
        kept = len(rows.records)
        if kept:
            write_table(folder, definition, rows)
    return StoppedError(why, kept, definition.runs, status)


def _make_missing(
    definition: Definition, rows: Rows, cluster: str | None, workers: int | None, compute: Compute
) -> Effort:
    missing = rows.missing(definition.runs)
    if not missing:
        return Effort()
    own, most = 0.0, 0

    def take(records: Mapping[Any, Any]) -> None:
        nonlocal own
        rows.records.add(records)
        own += sum(row.get("cost.run_s", 0.0) for row in records.values())

    def look(threads: int) -> None:
        nonlocal most
        most = max(most, threads)
        idle = "" if threads else "; no worker is there, waiting for one"
        show(len(rows.records), f", {rows.statuses[FAILED] + rows.statuses[ERROR]} failed{idle}")

    def arguments(run: Any) -> tuple[Any, ...]:
        return run, definition.source, definition.changes_of(run)

    with connected(cluster, workers) as client:
        patience = math.inf if cluster else PATIENCE_S  # a cluster's workers may come when others leave
        work = Work(compute, missing, arguments, killing_row)
        began = time.perf_counter()
        with counted(definition.scene, definition.runs, len(rows.records)) as show:
            Dispatcher(client, work, take, patience).run(look)
        return Effort(len(missing), most, time.perf_counter() - began, own)
