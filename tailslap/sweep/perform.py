"""Makes the runs of a sweep that have no row yet, and writes its table, pictures and page."""

from __future__ import annotations

import math
import time
from pathlib import Path

from tailslap.sweep.cluster import connected
from tailslap.sweep.complete import Effort, Sweep
from tailslap.sweep.definition import Definition
from tailslap.sweep.dispatch import Compute, Dispatcher, SchedulerLostError, WorkersLostError
from tailslap.sweep.folder import sweep_folder
from tailslap.sweep.journal import Journal, open_journal
from tailslap.sweep.progress import sweep_progress
from tailslap.sweep.row import ERROR, FAILED, STATUSES
from tailslap.sweep.table import write_table
from tailslap.sweep.worker import Finished, Task, run_batch

LOST, INTERRUPTED = 3, 130

PATIENCE_S = 60.0
"""Seconds without any worker of this machine after which a sweep ends: Dask restarts one in two or three."""


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
    compute: Compute = run_batch,
) -> Sweep:
    """Make the runs that are missing in the folder `place`, and write what belongs there.

    cluster: address of a Dask scheduler; None: `workers` processes here. compute: what a worker does with a batch.
    Raises InputError, and StoppedError for an interruption or the loss of the scheduler: the rows so far are then kept.
    """
    with sweep_folder(place, definition) as folder:
        try:
            with open_journal(folder, definition.runs) as journal:
                effort = _make_missing(definition, journal, cluster, workers, compute)
                write_table(folder, definition, journal)
            done = Sweep(definition, {name: journal.statuses[name] for name in STATUSES}, effort)
            from tailslap.sweep.report import write_sweep

            write_sweep(done, folder)
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
    with open_journal(folder, definition.runs) as journal:
        kept = len(journal.begins)
        if kept:
            write_table(folder, definition, journal)
    return StoppedError(why, kept, definition.runs, status)


def _make_missing(
    definition: Definition, journal: Journal, cluster: str | None, workers: int | None, compute: Compute
) -> Effort:
    tasks = [Task(run, definition.changes_of(run)) for run in journal.missing(definition.runs)]
    if not tasks:
        return Effort()
    own, most = 0.0, 0

    def take(rows: list[Finished]) -> None:
        nonlocal own
        journal.add(rows)
        own += sum(row.seconds for row in rows)

    def look(threads: int) -> None:
        nonlocal most
        most = max(most, threads)
        failed = journal.statuses[FAILED] + journal.statuses[ERROR]
        show(len(journal.begins), failed, threads)

    with connected(cluster, workers) as client:
        patience = math.inf if cluster else PATIENCE_S  # a cluster's workers may come when others leave
        dispatcher = Dispatcher(client, definition.text, tasks, take, compute, patience)
        began = time.perf_counter()
        with sweep_progress(definition.runs, len(journal.begins)) as show:
            try:
                dispatcher.run(look)
            except KeyboardInterrupt:
                dispatcher.collect_now()
                raise
        return Effort(len(tasks), most, time.perf_counter() - began, own)
